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
    control::{Client, Control, Server},
    opening::supervised,
    peer::{Peer, expect_side},
    service::{FramesIn, FramesOut, fault, publish, publisher, subscriber},
    wire::Frame,
};
use super::{
    LinkFault,
    end::{End, Wire},
    waiting::{Patience, Watch, Watched},
};
use crate::{
    Side,
    frame::{Samples, Updates},
    protocol::Protocol,
    session::Session,
};
use iceoryx2::{node::Node, port::update_connections::UpdateConnections, prelude::ipc};
use std::time::{Duration, Instant};

/// The analog processor's end.
pub type ShmAnalog = End<Ports<Samples, Updates, Server>>;
/// The digital processor's end.
pub type ShmDigital = End<Ports<Updates, Samples, Client>>;

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
        open(session, child, patience, Server::open, End::await_greeting)
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
        open(session, child, patience, Client::open, End::greet)
    }
}

fn open<F: Frame, G: Frame, C: Control + 'static>(
    session: &Session,
    child: Option<u32>,
    patience: &Patience,
    control: fn(&Node<ipc::Service>) -> Result<C, LinkFault>,
    greet: fn(&mut End<Ports<F, G, C>>) -> Result<(), LinkFault>,
) -> Result<End<Ports<F, G, C>>, LinkFault> {
    supervised(Peer::new(session, child)?, patience, move |mut peer, patience| {
        let (node, (frames_out, frames_in, control)) =
            peer.build(patience, |node| Ok((publisher(node)?, subscriber(node)?, control(node)?)))?;
        peer.meet(patience)?;
        let ports = Ports { frames_out, frames_in, control, _node: node, peer };
        let mut end = End::new(ports, Protocol::new(), patience);
        greet(&mut end)?;
        // All connections are made here, under supervision, and none in a frame.
        let Ports { frames_out, frames_in, .. } = end.wire();
        frames_out.update_connections().map_err(fault("connecting"))?;
        frames_in.update_connections().map_err(fault("connecting"))?;
        Ok(end)
    })
}

/// Ports of an end. Fields drop in order: the session, which removes all shared memory, comes last.
#[derive(Debug)]
pub struct Ports<F: Frame, G: Frame, C: Control> {
    frames_out: FramesOut<F>,
    frames_in: FramesIn<G>,
    control: C,
    _node: Node<ipc::Service>,
    peer: Peer,
}

/// How long the analog side waits for the digital one to close its end. That one closes
/// as soon as the other is done, unless it computes just then.
const LAST_OUT: Duration = Duration::from_secs(1);

impl<F: Frame, G: Frame, C: Control> Drop for Ports<F, G, C> {
    /// After a goodbye the analog side leaves last: should its partner be killed while it
    /// leaves, somebody is there to remove the traces. The digital side, where it started
    /// this one, in turn waits for this process to end and removes what a kill of this one
    /// leaves.
    fn drop(&mut self) {
        let bell = &self.peer.bell;
        bell.close();
        if self.peer.side == Side::Analog {
            return;
        }
        let started = Instant::now();
        while !bell.partner_closed() && !self.peer.gone() {
            if !self.control.goodbye() || started.elapsed() > LAST_OUT {
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

impl<F: Frame, G: Frame, C: Control> Watched for Ports<F, G, C> {
    type Partner = Peer;

    fn partner(&self) -> &Peer {
        &self.peer
    }
}

impl<F: Frame, G: Frame, C: Control> Wire for Ports<F, G, C> {
    type FrameOut = F;
    type FrameIn = G;
    type MessageOut = C::Out;
    type MessageIn = C::In;

    fn put_frame(&mut self, frame: &F, _lossy: bool) -> Result<(), LinkFault> {
        publish(&self.frames_out, *frame)?;
        self.peer.bell.ring();
        Ok(())
    }

    fn take_frame(&mut self, into: &mut G) -> Result<bool, LinkFault> {
        let frame = self.frames_in.receive().map_err(fault("receiving a frame"))?;
        Ok(frame.map(|frame| *into = frame.0).is_some())
    }

    fn put_message(&mut self, message: &C::Out) -> Result<(), LinkFault> {
        self.control.put(message, &self.peer.bell)
    }

    fn take_message(&mut self) -> Result<Option<C::In>, LinkFault> {
        self.control.take(&self.peer.bell)
    }

    fn message_gone(&mut self) -> Result<bool, LinkFault> {
        self.control.gone(&self.peer.bell)
    }
}
