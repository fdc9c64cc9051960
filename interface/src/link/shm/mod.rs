//! The link between two processes: iceoryx2 shared memory.
//!
//! This folder alone names iceoryx2. Frames go by publish-subscribe, one
//! service a direction, so that an observer may subscribe too and can never
//! stall the session (safe overflow: who falls behind loses frames and sees it
//! in their numbers). The control plane goes by request-response (`control`).
//!
//! All shared memory of a session lies under the session's own prefix and
//! directory, and the session removes it: after a kill -9 iceoryx2's own
//! clean-up is neither needed nor trusted.

mod control;
mod counter;
mod opening;
mod wire;

use self::{
    control::{Client, Server},
    opening::{Progress, supervised},
    wire::{SamplesWire, UpdatesWire},
};
use super::{
    LinkFault,
    bell::Bell,
    end::{AnalogEnd, AnalogWire, DigitalEnd, DigitalWire, died},
    waiting::{Limit, Patience, Watch, wait},
};
use crate::{
    Side,
    control::{Reply, Request},
    frame::{Samples, Updates},
    protocol::Protocol,
    session::{Partner, SHARED_MEMORY, Session},
};
use iceoryx2::{
    node::Node,
    port::{
        publisher::Publisher, subscriber::Subscriber, update_connections::UpdateConnections as _,
    },
    prelude::{
        Config, FileName, LogLevel, NodeBuilder, SemanticString, ServiceName, SignalHandlingMode,
        ZeroCopySend, ipc, set_log_level,
    },
    service::port_factory::publish_subscribe,
};
use std::{
    os::unix::ffi::OsStrExt,
    path::Path,
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

/// Frames that a subscriber holds before the oldest is lost. Lock-step needs one;
/// on the wall clock this is the slack of a side that is late.
const FRAME_BUFFER: usize = 16;
/// One partner and a few observers.
const SUBSCRIBERS: usize = 8;
/// Processes that may open a service.
const NODES: usize = 16;
/// A service half made by a process that was killed stays so for ever; this long
/// one waits to see whether it is merely slow. Below the second in which an end
/// must notice its partner's death.
const CREATION_TIMEOUT: Duration = Duration::from_millis(50);

/// The analog processor's end.
pub type ShmAnalog = AnalogEnd<AnalogPorts>;
/// The digital processor's end.
pub type ShmDigital = DigitalEnd<DigitalPorts>;

impl ShmAnalog {
    /// Opens the analog end and waits until a digital side has come and greeted.
    ///
    /// `child` is the pid of a partner that the caller has started (and not
    /// reaped); without it the partner is whoever joins the session.
    ///
    /// # Errors
    /// [`LinkFault`] when the partner dies, does not come within
    /// [`Patience::arrival`] or is another build, or the transport fails.
    pub fn open(
        session: &Session,
        child: Option<u32>,
        patience: &Patience,
    ) -> Result<ShmAnalog, LinkFault> {
        expect_side(session, Side::Analog)?;
        let peer = Peer::new(session, child)?;
        supervised(peer, patience, |mut peer, patience| {
            let (node, (samples, updates, server)) = peer.build(patience, |node| {
                Ok((
                    publisher(&samples_service(node)?)?,
                    subscriber(&updates_service(node)?)?,
                    Server::open(node)?,
                ))
            })?;
            peer.meet(patience)?;
            let ports = AnalogPorts { samples, updates, server, _node: node, goodbye: false, peer };
            let mut end = AnalogEnd::new(ports, Protocol::new(), patience);
            end.greet()?;
            // All connections are made here, under supervision, and none in a frame.
            let made = end.wire().samples.update_connections();
            made.map_err(fault("connecting"))?;
            let made = end.wire().updates.update_connections();
            made.map_err(fault("connecting"))?;
            Ok(end)
        })
    }
}

impl ShmDigital {
    /// Opens the digital end and greets the analog side.
    ///
    /// `child` is the pid of a partner that the caller has started (and not
    /// reaped); without it the partner is whoever has joined the session.
    ///
    /// # Errors
    /// As [`ShmAnalog::open`].
    pub fn open(
        session: &Session,
        child: Option<u32>,
        patience: &Patience,
    ) -> Result<ShmDigital, LinkFault> {
        expect_side(session, Side::Digital)?;
        let peer = Peer::new(session, child)?;
        supervised(peer, patience, |mut peer, patience| {
            let (node, (samples, updates, client)) = peer.build(patience, |node| {
                Ok((
                    subscriber(&samples_service(node)?)?,
                    publisher(&updates_service(node)?)?,
                    Client::open(node)?,
                ))
            })?;
            peer.meet(patience)?;
            let ports = DigitalPorts { samples, updates, client, _node: node, peer };
            let mut end = DigitalEnd::new(ports, Protocol::new(), patience);
            end.greet()?;
            let made = end.wire().updates.update_connections();
            made.map_err(fault("connecting"))?;
            let made = end.wire().samples.update_connections();
            made.map_err(fault("connecting"))?;
            Ok(end)
        })
    }
}

/// Ports of the analog end. Fields drop in order: the session, which removes all
/// shared memory, comes last.
#[derive(Debug)]
pub struct AnalogPorts {
    samples: Publisher<ipc::Service, SamplesWire, ()>,
    updates: Subscriber<ipc::Service, UpdatesWire, ()>,
    server: Server,
    _node: Node<ipc::Service>,
    /// Whether the digital side has said that it will end.
    goodbye: bool,
    peer: Peer,
}

/// How long the analog side waits for the digital one to close its end. That one closes
/// as soon as the other is done, unless it computes just then.
const LAST_OUT: Duration = Duration::from_secs(1);

impl Drop for AnalogPorts {
    /// After a goodbye the analog side leaves last: should its partner be killed while it
    /// leaves, somebody is there to remove the traces. The digital side, where it started
    /// this one, in turn waits for this process to end and removes what a kill of this one
    /// leaves.
    fn drop(&mut self) {
        let bell = &self.peer.bell;
        bell.close();
        let started = Instant::now();
        while !bell.partner_closed() && !self.peer.gone() {
            if !self.goodbye || started.elapsed() > LAST_OUT {
                return;
            }
            let heard = bell.listen();
            if !bell.partner_closed() {
                bell.sleep(heard, Duration::from_millis(5));
            }
        }
        self.peer.session.inherit();
    }
}

/// Ports of the digital end.
#[derive(Debug)]
pub struct DigitalPorts {
    samples: Subscriber<ipc::Service, SamplesWire, ()>,
    updates: Publisher<ipc::Service, UpdatesWire, ()>,
    client: Client,
    _node: Node<ipc::Service>,
    peer: Peer,
}

impl AnalogWire for AnalogPorts {
    fn put_samples(&mut self, samples: &Samples, _lossy: bool) -> Result<(), LinkFault> {
        publish(&self.samples, SamplesWire(*samples))?;
        self.peer.bell.ring();
        Ok(())
    }

    fn take_updates(&mut self, into: &mut Updates) -> Result<bool, LinkFault> {
        let sample = self.updates.receive();
        let sample = sample.map_err(fault("receiving updates"))?;
        Ok(sample.map(|sample| *into = sample.0).is_some())
    }

    fn take_request(&mut self) -> Result<Option<Request>, LinkFault> {
        let request = self.server.take(&self.peer.bell)?;
        self.goodbye |= matches!(request, Some(Request::Bye));
        Ok(request)
    }

    fn put_reply(&mut self, reply: &Reply) -> Result<(), LinkFault> {
        self.server.reply(reply, &self.peer.bell)
    }

    fn reply_gone(&mut self) -> Result<bool, LinkFault> {
        self.server.reply_gone(&self.peer.bell)
    }
}

impl DigitalWire for DigitalPorts {
    fn take_samples(&mut self, into: &mut Samples) -> Result<bool, LinkFault> {
        let sample = self.samples.receive();
        let sample = sample.map_err(fault("receiving samples"))?;
        Ok(sample.map(|sample| *into = sample.0).is_some())
    }

    fn put_updates(&mut self, updates: &Updates, _lossy: bool) -> Result<(), LinkFault> {
        publish(&self.updates, UpdatesWire(*updates))?;
        self.peer.bell.ring();
        Ok(())
    }

    fn put_request(&mut self, request: &Request) -> Result<(), LinkFault> {
        self.client.put(request, &self.peer.bell)
    }

    fn take_reply(&mut self) -> Result<Option<Reply>, LinkFault> {
        self.client.take(&self.peer.bell)
    }
}

/// The session, and the process at its other side as far as it is known.
#[derive(Debug)]
struct Peer {
    side: Side,
    progress: Progress,
    bell: Bell,
    session: Session,
}

impl Peer {
    fn new(session: &Session, child: Option<u32>) -> Result<Peer, LinkFault> {
        let partner = match child {
            Some(pid) => Some(session.child(pid).map_err(fault("watching the started partner"))?),
            None => session.partner().map_err(fault("looking for the partner"))?,
        };
        if partner.is_none() && session.joined() {
            // It was there when this side joined: it is not late, it is dead.
            return Err(LinkFault::PartnerDied {
                side: session.side().partner().name(),
                frame: 0,
                detail: "it ended before the link was open".to_owned(),
            });
        }
        let progress = Progress::default();
        if let Some(partner) = partner {
            let _ = progress.partner.set(partner);
        }
        let bell = Bell::mapped(&session.root().join("bell"), session.side())
            .map_err(fault("mapping the session's bell"))?;
        Ok(Peer { side: session.side().partner(), progress, bell, session: session.clone() })
    }

    /// Makes a node and ports on it, again and again while the partner is making
    /// the same services or has not come yet.
    fn build<P>(
        &self,
        patience: &Patience,
        ports: impl Fn(&Node<ipc::Service>) -> Result<P, LinkFault>,
    ) -> Result<(Node<ipc::Service>, P), LinkFault> {
        set_log_level(LogLevel::Fatal);
        let config = config(&self.session)?;
        counter::provide(Path::new(SHARED_MEMORY), self.session.prefix())?;
        let started = Instant::now();
        let limit = patience.arrival.unwrap_or(patience.silence);
        loop {
            patience.check_interrupt(0)?;
            let made = NodeBuilder::new()
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<ipc::Service>()
                .map_err(fault("joining the shared memory"))
                .and_then(|node| ports(&node).map(|ports| (node, ports)));
            match made {
                Ok(made) => {
                    self.progress.built.store(true, Ordering::Release);
                    return Ok(made);
                }
                Err(_) if self.gone() => return Err(died(self, 0)),
                Err(fault) if started.elapsed() > limit => return Err(fault),
                Err(_) => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }

    /// Waits until the partner has taken its place in the session.
    fn meet(&mut self, patience: &Patience) -> Result<(), LinkFault> {
        let limit = patience.arrival.map_or(Limit::Unlimited, Limit::After);
        let joined = wait(patience, self, limit, 0, |peer| {
            let partner = peer.session.partner();
            partner.map_err(fault("looking for the partner"))
        })?;
        // A child that was started and the partner that has joined are one process.
        let _ = self.progress.partner.set(joined);
        Ok(())
    }

    fn partner(&self) -> Option<&Partner> {
        self.progress.partner.get()
    }
}

impl Watch for Peer {
    fn side(&self) -> Side {
        self.side
    }

    fn bell(&self) -> &Bell {
        &self.bell
    }

    fn gone(&self) -> bool {
        self.partner().is_some_and(Partner::ended)
    }

    fn left(&self) -> bool {
        self.bell.partner_closed() || self.partner().is_some_and(Partner::left)
    }

    fn epitaph(&self) -> String {
        self.partner().map_or_else(|| "it never came".to_owned(), Partner::epitaph)
    }

    fn stopped(&self) -> bool {
        self.partner().is_some_and(Partner::stopped)
    }

    fn cpu_time(&self) -> Option<Duration> {
        self.partner().and_then(Partner::cpu_time)
    }
}

macro_rules! watch_by_peer {
    ($($ports:ty),*) => {$(
        impl Watch for $ports {
            fn side(&self) -> Side {
                self.peer.side()
            }
            fn bell(&self) -> &Bell {
                self.peer.bell()
            }
            fn gone(&self) -> bool {
                self.peer.gone()
            }
            fn left(&self) -> bool {
                self.peer.left()
            }
            fn epitaph(&self) -> String {
                self.peer.epitaph()
            }
            fn stopped(&self) -> bool {
                self.peer.stopped()
            }
            fn cpu_time(&self) -> Option<Duration> {
                self.peer.cpu_time()
            }
        }
    )*};
}
watch_by_peer!(AnalogPorts, DigitalPorts);

fn expect_side(session: &Session, side: Side) -> Result<(), LinkFault> {
    if session.side() == side {
        Ok(())
    } else {
        Err(fault("opening the link")(format!(
            "this process joined the session as {}, not as {}",
            session.side().name(),
            side.name()
        )))
    }
}

/// Wraps the transport's own words.
fn fault<E: std::fmt::Display>(doing: &'static str) -> impl FnOnce(E) -> LinkFault {
    move |error| LinkFault::Transport { doing, detail: error.to_string() }
}

fn config(session: &Session) -> Result<Config, LinkFault> {
    let doing = "naming the shared memory";
    let text = |e: iceoryx2::prelude::SemanticStringError| fault(doing)(format!("{e:?}"));
    let mut config = Config::default();
    config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(text)?;
    let root = session.root();
    config
        .global
        .set_root_path(&iceoryx2::prelude::Path::new(root.as_os_str().as_bytes()).map_err(text)?);
    config.global.creation_timeout = CREATION_TIMEOUT;
    // A session's leavings are removed as a whole, by the session.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

fn service_name(name: &str) -> Result<ServiceName, LinkFault> {
    ServiceName::new(name).map_err(fault("naming a service"))
}

type FrameService<F> = publish_subscribe::PortFactory<ipc::Service, F, ()>;

fn frame_service<F: ZeroCopySend + std::fmt::Debug + 'static>(
    node: &Node<ipc::Service>,
    name: &str,
) -> Result<FrameService<F>, LinkFault> {
    node.service_builder(&service_name(name)?)
        .publish_subscribe::<F>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(FRAME_BUFFER)
        .subscriber_max_borrowed_samples(2)
        .max_publishers(1)
        .max_subscribers(SUBSCRIBERS)
        .max_nodes(NODES)
        .open_or_create()
        .map_err(fault("opening a frame service"))
}

fn samples_service(node: &Node<ipc::Service>) -> Result<FrameService<SamplesWire>, LinkFault> {
    frame_service(node, "samples")
}

fn updates_service(node: &Node<ipc::Service>) -> Result<FrameService<UpdatesWire>, LinkFault> {
    frame_service(node, "updates")
}

fn publisher<F: ZeroCopySend + std::fmt::Debug + 'static>(
    service: &FrameService<F>,
) -> Result<Publisher<ipc::Service, F, ()>, LinkFault> {
    service
        .publisher_builder()
        .max_loaned_samples(1)
        .create()
        .map_err(fault("creating a publisher"))
}

fn subscriber<F: ZeroCopySend + std::fmt::Debug + 'static>(
    service: &FrameService<F>,
) -> Result<Subscriber<ipc::Service, F, ()>, LinkFault> {
    service.subscriber_builder().create().map_err(fault("creating a subscriber"))
}

fn publish<F: ZeroCopySend + std::fmt::Debug + 'static>(
    publisher: &Publisher<ipc::Service, F, ()>,
    frame: F,
) -> Result<(), LinkFault> {
    let sample = publisher.loan_uninit().map_err(fault("loaning a frame"))?.write_payload(frame);
    sample.send().map_err(fault("sending a frame"))?;
    Ok(())
}
