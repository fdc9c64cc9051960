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
mod peer;
mod service;
mod wire;

use self::{
    control::{Client, Server},
    opening::supervised,
    peer::{Peer, expect_side},
    service::{fault, publish, publisher, samples_service, subscriber, updates_service},
    wire::{SamplesWire, UpdatesWire},
};
use super::{
    LinkFault,
    bell::Bell,
    end::{AnalogEnd, AnalogWire, DigitalEnd, DigitalWire},
    waiting::{Patience, Watch},
};
use crate::{
    Side,
    control::{Reply, Request},
    frame::{Samples, Updates},
    protocol::Protocol,
    session::Session,
};
use iceoryx2::{
    node::Node,
    port::{
        publisher::Publisher, subscriber::Subscriber, update_connections::UpdateConnections as _,
    },
    prelude::ipc,
};
use std::time::{Duration, Instant};

pub type ShmAnalog = AnalogEnd<AnalogPorts>;
pub type ShmDigital = DigitalEnd<DigitalPorts>;

impl ShmAnalog {
    /// Opens the analog end and waits until a digital side has come and greeted.
    ///
    /// `child` is the pid of a partner that the caller has started (and not
    /// reaped); without it the partner is whoever joins the session.
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
