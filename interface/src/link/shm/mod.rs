//! The link between two processes: iceoryx2 shared memory.
//!
//! This folder alone names iceoryx2. Frames go by publish-subscribe, one
//! service a direction, so that an observer may subscribe too and can never
//! stall the session (safe overflow: who falls behind loses frames and sees it
//! in their numbers). The control plane goes by request-response ([`control`]).
//!
//! All shared memory of a session lies under the session's own prefix and
//! directory, and the session removes it: after a kill -9 iceoryx2's own
//! clean-up is neither needed nor trusted.

mod control;
mod wire;

use self::{
    control::{Client, Server},
    wire::{SamplesWire, UpdatesWire},
};
use super::{
    LinkFault,
    end::{AnalogEnd, AnalogWire, DigitalEnd, DigitalWire, died},
    waiting::{Limit, Patience, Watch, wait},
};
use crate::{
    Side,
    control::{Reply, Request},
    frame::{Samples, Updates},
    protocol::Protocol,
    session::{Partner, Session},
};
use iceoryx2::{
    node::Node,
    port::{publisher::Publisher, subscriber::Subscriber},
    prelude::{
        Config, FileName, LogLevel, NodeBuilder, Path, SemanticString, ServiceName,
        SignalHandlingMode, ZeroCopySend, ipc, set_log_level,
    },
    service::port_factory::publish_subscribe,
};
use std::{
    os::unix::ffi::OsStrExt,
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
        let mut peer = Peer::new(session, child)?;
        let ports = peer.build(patience, |node| {
            Ok((
                publisher(&samples_service(node)?)?,
                subscriber(&updates_service(node)?)?,
                Server::open(node)?,
            ))
        })?;
        let (node, (samples, updates, server)) = ports;
        peer.meet(patience)?;
        let ports = AnalogPorts {
            samples,
            updates,
            server,
            _node: node,
            peer,
        };
        let mut end = AnalogEnd::new(ports, Protocol::new(), patience);
        end.greet()?;
        Ok(end)
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
        let mut peer = Peer::new(session, child)?;
        let (node, (samples, updates, client)) = peer.build(patience, |node| {
            Ok((
                subscriber(&samples_service(node)?)?,
                publisher(&updates_service(node)?)?,
                Client::open(node)?,
            ))
        })?;
        peer.meet(patience)?;
        let ports = DigitalPorts {
            samples,
            updates,
            client,
            _node: node,
            peer,
        };
        let mut end = DigitalEnd::new(ports, Protocol::new(), patience);
        end.greet()?;
        Ok(end)
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
    peer: Peer,
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
        publish(&self.samples, SamplesWire(*samples))
    }

    fn take_updates(&mut self) -> Result<Option<Updates>, LinkFault> {
        match self.updates.receive() {
            Ok(sample) => Ok(sample.map(|sample| sample.0)),
            Err(e) => Err(fault("receiving updates")(e)),
        }
    }

    fn take_request(&mut self) -> Result<Option<Request>, LinkFault> {
        self.server.take()
    }

    fn put_reply(&mut self, reply: &Reply) -> Result<(), LinkFault> {
        self.server.reply(reply)
    }

    fn reply_gone(&mut self) -> Result<bool, LinkFault> {
        self.server.reply_gone()
    }
}

impl DigitalWire for DigitalPorts {
    fn take_samples(&mut self) -> Result<Option<Samples>, LinkFault> {
        match self.samples.receive() {
            Ok(sample) => Ok(sample.map(|sample| sample.0)),
            Err(e) => Err(fault("receiving samples")(e)),
        }
    }

    fn put_updates(&mut self, updates: &Updates, _lossy: bool) -> Result<(), LinkFault> {
        publish(&self.updates, UpdatesWire(*updates))
    }

    fn put_request(&mut self, request: &Request) -> Result<(), LinkFault> {
        self.client.put(request)
    }

    fn take_reply(&mut self) -> Result<Option<Reply>, LinkFault> {
        self.client.take()
    }
}

/// The session, and the process at its other side as far as it is known.
#[derive(Debug)]
struct Peer {
    side: Side,
    partner: Option<Partner>,
    session: Session,
}

impl Peer {
    fn new(session: &Session, child: Option<u32>) -> Result<Peer, LinkFault> {
        let partner = match child {
            Some(pid) => Some(
                session
                    .child(pid)
                    .map_err(fault("watching the started partner"))?,
            ),
            None => session
                .partner()
                .map_err(fault("looking for the partner"))?,
        };
        if partner.is_none() && session.joined() {
            // It was there when this side joined: it is not late, it is dead.
            return Err(LinkFault::PartnerDied {
                side: session.side().partner().name(),
                frame: 0,
                detail: "it ended before the link was open".to_owned(),
            });
        }
        Ok(Peer {
            side: session.side().partner(),
            partner,
            session: session.clone(),
        })
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
                Ok(made) => return Ok(made),
                Err(_) if self.gone_within(Duration::from_millis(1)) => return Err(died(self, 0)),
                Err(fault) if started.elapsed() > limit => return Err(fault),
                Err(_) => {}
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
        self.partner = Some(joined);
        Ok(())
    }
}

impl Watch for Peer {
    fn side(&self) -> Side {
        self.side
    }

    fn gone_within(&self, slice: Duration) -> bool {
        match &self.partner {
            Some(partner) => partner.ended_within(slice),
            None => {
                std::thread::sleep(slice);
                false
            }
        }
    }

    fn left(&self) -> bool {
        self.partner.as_ref().is_some_and(Partner::left)
    }

    fn epitaph(&self) -> String {
        self.partner
            .as_ref()
            .map_or_else(|| "it never came".to_owned(), Partner::epitaph)
    }

    fn stopped(&self) -> bool {
        self.partner.as_ref().is_some_and(Partner::stopped)
    }

    fn cpu_time(&self) -> Option<Duration> {
        self.partner.as_ref().and_then(Partner::cpu_time)
    }
}

macro_rules! watch_by_peer {
    ($($ports:ty),*) => {$(
        impl Watch for $ports {
            fn side(&self) -> Side {
                self.peer.side()
            }
            fn gone_within(&self, slice: Duration) -> bool {
                self.peer.gone_within(slice)
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
    move |error| LinkFault::Transport {
        doing,
        detail: error.to_string(),
    }
}

fn config(session: &Session) -> Result<Config, LinkFault> {
    let doing = "naming the shared memory";
    let text = |e: iceoryx2::prelude::SemanticStringError| fault(doing)(format!("{e:?}"));
    let mut config = Config::default();
    config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(text)?;
    let root = session.root().join("iceoryx2");
    config
        .global
        .set_root_path(&Path::new(root.as_os_str().as_bytes()).map_err(text)?);
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
    service
        .subscriber_builder()
        .create()
        .map_err(fault("creating a subscriber"))
}

fn publish<F: ZeroCopySend + std::fmt::Debug + 'static>(
    publisher: &Publisher<ipc::Service, F, ()>,
    frame: F,
) -> Result<(), LinkFault> {
    let sample = publisher
        .loan_uninit()
        .map_err(fault("loaning a frame"))?
        .write_payload(frame);
    sample.send().map_err(fault("sending a frame"))?;
    Ok(())
}
