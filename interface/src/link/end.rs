//! The two ends of a link, over any transport.
//!
//! An end owns the protocol state, the patience and the order of things; a
//! *wire* only carries messages and can tell whether the partner is there.
//! Both links share these ends, so they cannot differ in behaviour.

use super::{
    AnalogPort, DigitalFrames, DigitalPort, FramePort, Law, LinkFault,
    waiting::{Limit, Patience, Watch, Watched, wait},
};
use crate::{
    Tick,
    control::{Checkpoints, Reply, Request},
    frame::{RunState, Samples, Updates},
    protocol::{self, Protocol},
};
use std::time::{Duration, Instant};

/// Time between two looks at the partner while this side computes.
const LOOK: Duration = Duration::from_millis(10);

/// What a transport does for an end. Nothing here blocks.
pub trait Wire: Watched {
    type FrameOut;
    type FrameIn;
    type MessageOut;
    type MessageIn;
    /// Sends a frame; `lossy` allows to lose one that finds no room.
    fn put_frame(&mut self, frame: &Self::FrameOut, lossy: bool) -> Result<(), LinkFault>;
    /// Takes the next frame in order of sending, if there is any.
    fn take_frame(&mut self, into: &mut Self::FrameIn) -> Result<bool, LinkFault>;
    /// Begins to send a request, or the reply to the last one.
    fn put_message(&mut self, message: &Self::MessageOut) -> Result<(), LinkFault>;
    /// Moves the exchange on; gives the message that comes once all of it has come.
    fn take_message(&mut self) -> Result<Option<Self::MessageIn>, LinkFault>;
    /// Moves what is left of a long reply; true when all of it has gone.
    fn message_gone(&mut self) -> Result<bool, LinkFault>;
}

/// The wire of the analog end.
pub trait AnalogWire:
    Wire<FrameOut = Samples, FrameIn = Updates, MessageOut = Reply, MessageIn = Request>
{
}
impl<W> AnalogWire for W where
    W: Wire<FrameOut = Samples, FrameIn = Updates, MessageOut = Reply, MessageIn = Request>
{
}

/// The wire of the digital end.
pub trait DigitalWire:
    Wire<FrameOut = Updates, FrameIn = Samples, MessageOut = Request, MessageIn = Reply>
{
}
impl<W> DigitalWire for W where
    W: Wire<FrameOut = Updates, FrameIn = Samples, MessageOut = Request, MessageIn = Reply>
{
}

/// A processor's end over wire `W`, whose messages tell which processor it is.
#[derive(Debug)]
pub struct End<W> {
    wire: W,
    protocol: Protocol,
    patience: Patience,
    /// Updates that came before their frame was asked for (wall clock only).
    early: Option<Updates>,
    /// When it was last looked whether the partner lives, while computing.
    looked: Option<Instant>,
}

impl<W: Wire> End<W> {
    pub(super) fn wire(&self) -> &W {
        &self.wire
    }

    pub(super) fn new(wire: W, protocol: Protocol, patience: &Patience) -> End<W> {
        End { wire, protocol, patience: patience.clone(), early: None, looked: None }
    }

    /// Waits for a message.
    fn message(&mut self, limit: Limit) -> Result<W::MessageIn, LinkFault> {
        wait(&self.patience, &mut self.wire, limit, self.protocol.frame(), W::take_message)
    }

    /// Waits for a frame: on the wall clock it must not be noticed late.
    fn frame(&mut self, into: &mut W::FrameIn, frame: u64) -> Result<(), LinkFault> {
        let limit = if self.protocol.may_skip() { Limit::Prompt } else { Limit::Silence };
        wait(&self.patience, &mut self.wire, limit, frame, |wire| {
            Ok(wire.take_frame(into)?.then_some(()))
        })
    }

    /// The partner may still be starting: it has as long as it has to arrive.
    fn arrival(&self) -> Limit {
        self.patience.arrival.map_or(Limit::Unlimited, Limit::After)
    }
}

impl<W: AnalogWire> End<W> {
    /// Waits for the partner's greeting and answers it.
    pub(super) fn await_greeting(&mut self) -> Result<(), LinkFault> {
        let request = self.message(self.arrival())?;
        if let Err(error) = self.protocol.request(&request) {
            // The other side is told why before this one gives up.
            self.wire.put_message(&Reply::Refused(error.to_string()))?;
            let _ = self.flush();
            return Err(error.at(0));
        }
        self.reply(&protocol::hello_reply())
    }

    fn flush(&mut self) -> Result<(), LinkFault> {
        wait(&self.patience, &mut self.wire, Limit::Silence, self.protocol.frame(), |wire| {
            Ok(wire.message_gone()?.then_some(()))
        })
    }

    fn admit(&mut self, updates: &Updates, frame: u64) -> Result<(), LinkFault> {
        let admitted = self.protocol.updates(updates.frame);
        admitted.map_err(|e| e.at(frame))
    }
}

impl<W: AnalogWire> FramePort for End<W> {
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault> {
        self.patience.check_interrupt(self.protocol.frame())?;
        let lossy = self.protocol.may_skip();
        self.protocol
            .samples(samples.frame, samples.run_state())
            .map_err(|e| e.at(samples.frame))?;
        // The frame that ends a run is never the one to be lost.
        let last = !self.protocol.operating();
        self.wire.put_frame(samples, lossy && !last).map_err(|fault| fault.at_frame(samples.frame))
    }

    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault> {
        let mut updates = Updates::new(frame, Tick::ZERO);
        loop {
            match self.early.take() {
                Some(early) => updates = early,
                None => self.frame(&mut updates, frame)?,
            }
            self.admit(&updates, frame)?;
            if updates.frame >= frame {
                return Ok(updates);
            }
        }
    }

    fn poll_updates(&mut self, frame: u64) -> Result<Option<Updates>, LinkFault> {
        self.patience.check_interrupt(frame)?;
        let mut updates = Updates::new(frame, Tick::ZERO);
        let came = match self.early.take() {
            Some(early) => {
                updates = early;
                true
            }
            None => self.wire.take_frame(&mut updates)?,
        };
        if !came {
            let partner = self.wire.partner();
            return if partner.gone() { Err(died(partner, frame)) } else { Ok(None) };
        }
        if updates.frame > frame && self.protocol.may_skip() {
            self.early = Some(updates);
            return Ok(None);
        }
        self.admit(&updates, frame)?;
        Ok(Some(updates))
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        self.look()
    }

    fn give_state(&mut self, _frame: u64, state: Vec<u8>) -> Result<(), LinkFault> {
        // Nothing else is in order here: the protocol refuses it.
        self.await_request()?;
        self.reply(&Reply::Checkpoint(state))
    }
}

impl<W: Watched> End<W> {
    /// Whether this side is wanted still and the partner lives, looked at once in a while.
    fn look(&mut self) -> Result<(), LinkFault> {
        let frame = self.protocol.frame();
        self.patience.check_interrupt(frame)?;
        if self.looked.is_some_and(|at| at.elapsed() < LOOK) {
            return Ok(());
        }
        self.looked = Some(Instant::now());
        let partner = self.wire.partner();
        if partner.gone() { Err(died(partner, frame)) } else { Ok(()) }
    }
}

impl<W: AnalogWire> AnalogPort for End<W> {
    fn await_request(&mut self) -> Result<Request, LinkFault> {
        let frame = self.protocol.frame();
        let request = self.message(Limit::Unlimited)?;
        self.protocol.request(&request).map_err(|e| e.at(frame))?;
        if let Request::Operate(_) | Request::OperateKept(..) = request {
            // Late updates of an earlier run on the wall clock; in lock-step there are none.
            self.early = None;
            let mut late = Updates::new(0, Tick::ZERO);
            while self.wire.take_frame(&mut late)? {}
        }
        Ok(request)
    }

    fn reply(&mut self, reply: &Reply) -> Result<(), LinkFault> {
        let frame = self.protocol.frame();
        self.protocol.reply(reply).map_err(|e| e.at(frame))?;
        self.wire.put_message(reply)?;
        self.flush()
    }
}

impl<W: DigitalWire> End<W> {
    /// Greets the partner, which has the same build or is refused.
    pub(super) fn greet(&mut self) -> Result<(), LinkFault> {
        match self.request_within(&protocol::hello(), self.arrival())? {
            Reply::Refused(detail) => Err(LinkFault::Protocol { frame: 0, detail }),
            _ => Ok(()),
        }
    }

    fn request_within(&mut self, request: &Request, limit: Limit) -> Result<Reply, LinkFault> {
        let frame = self.protocol.frame();
        self.protocol.request(request).map_err(|e| e.at(frame))?;
        // Samples of an earlier run that nobody asked for.
        let mut stray = Samples::new(0, Tick::ZERO, RunState::Operate);
        while self.wire.take_frame(&mut stray)? {}
        self.wire.put_message(request)?;
        let reply = self.message(limit)?;
        self.protocol.reply(&reply).map_err(|e| e.at(frame))?;
        Ok(reply)
    }
}

impl<W: DigitalWire> DigitalFrames for End<W> {
    fn await_samples(&mut self, frame: u64) -> Result<Samples, LinkFault> {
        let mut samples = Samples::new(frame, Tick::ZERO, RunState::Operate);
        loop {
            self.frame(&mut samples, frame)?;
            if samples.frame != frame && !self.protocol.may_skip() {
                let error = protocol::ProtocolError::FrameNumber {
                    message: "samples",
                    expected: frame,
                    found: samples.frame,
                };
                return Err(error.at(frame));
            }
            self.protocol.samples(samples.frame, samples.run_state()).map_err(|e| e.at(frame))?;
            if samples.frame >= frame || !self.protocol.operating() {
                return Ok(samples);
            }
        }
    }

    fn send_updates(&mut self, updates: &Updates) -> Result<(), LinkFault> {
        let frame = updates.frame;
        self.patience.check_interrupt(frame)?;
        self.protocol.updates(frame).map_err(|e| e.at(frame))?;
        self.wire
            .put_frame(updates, self.protocol.may_skip())
            .map_err(|fault| fault.at_frame(frame))
    }
}

impl<W: DigitalWire> DigitalPort for End<W> {
    fn request(&mut self, request: &Request) -> Result<Reply, LinkFault> {
        self.request_within(request, Limit::Silence)
    }

    fn operate(
        &mut self,
        latency: Tick,
        checkpoints: Option<&Checkpoints>,
        law: &mut dyn Law,
    ) -> Result<Samples, LinkFault> {
        for frame in checkpoints.map_or(0, Checkpoints::first).. {
            if checkpoints.is_some_and(|checkpoints| checkpoints.due(frame)) {
                // The protocol lets no other reply through.
                if let Reply::Checkpoint(state) = self.request(&Request::Checkpoint)?
                    && !state.is_empty()
                {
                    law.checkpoint(frame, state);
                }
            }
            let samples = self.await_samples(frame)?;
            let state = samples.run_state();
            if state == RunState::Faulted {
                return Ok(samples);
            }
            if samples.frame != frame {
                return Err(LinkFault::LostFrames { frame, found: samples.frame });
            }
            let mut updates = Updates::new(frame, samples.tick + latency);
            law.frame(&samples, &mut updates);
            if state != RunState::Ended {
                self.send_updates(&updates)?;
            }
            law.after(&samples);
            if state == RunState::Ended {
                return Ok(samples);
            }
        }
        unreachable!("frames are counted in u64")
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        self.look()
    }
}

/// The partner's death, as this end tells it.
pub(super) fn died(watch: &impl Watch, frame: u64) -> LinkFault {
    LinkFault::PartnerDied { side: watch.side().name(), frame, detail: watch.epitaph() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::memory;

    /// Two ends that have not met, as two processes have not.
    fn strangers() -> (memory::MemoryAnalog, memory::MemoryDigital) {
        let (mut analog, mut digital) = memory::pair();
        analog.protocol = Protocol::new();
        digital.protocol = Protocol::new();
        (analog, digital)
    }

    #[test]
    fn another_build_is_refused_and_both_sides_say_why() {
        let ours = protocol::layout_hash();
        for (version, layout_hash, word) in [
            (protocol::VERSION + 1, ours, "protocol version"),
            (protocol::VERSION, ours ^ 1, "frame layout"),
        ] {
            let (mut analog, mut digital) = strangers();
            digital.wire.put_message(&Request::Hello { version, layout_hash }).unwrap();
            let fault = analog.await_greeting().unwrap_err();
            assert!(matches!(fault, LinkFault::Protocol { .. }));
            assert!(fault.to_string().contains(word), "{fault}");
            let told = digital.wire.take_message().unwrap();
            assert!(matches!(told, Some(Reply::Refused(text)) if text.contains(word)));
        }
    }
}
