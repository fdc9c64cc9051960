//! The two ends of a link, over any transport.
//!
//! An end owns the protocol state, the patience and the order of things; a
//! *wire* only carries messages and can tell whether the partner is there.
//! Both links share these ends, so they cannot differ in behaviour.

use super::{
    AnalogPort, DigitalPort, FramePort, LinkFault,
    waiting::{Limit, Patience, Watch, wait},
};
use crate::{
    Side, Tick,
    control::{Reply, Request},
    frame::{RunState, Samples, Updates},
    protocol::{self, Protocol},
};
use std::time::{Duration, Instant};

/// Time between two looks at the partner while this side computes.
const LOOK: Duration = Duration::from_millis(10);

/// What a transport does for the analog end. Nothing here blocks.
pub trait AnalogWire: Watch {
    /// Sends samples; `lossy` allows to lose a frame that finds no room.
    fn put_samples(&mut self, samples: &Samples, lossy: bool) -> Result<(), LinkFault>;
    /// Takes the next updates in order of sending, if there are any.
    fn take_updates(&mut self, into: &mut Updates) -> Result<bool, LinkFault>;
    /// Takes the next request once all of it has come.
    fn take_request(&mut self) -> Result<Option<Request>, LinkFault>;
    /// Answers it.
    fn put_reply(&mut self, reply: &Reply) -> Result<(), LinkFault>;
    /// Moves what is left of a long reply; true when all of it has gone.
    fn reply_gone(&mut self) -> Result<bool, LinkFault>;
}

/// What a transport does for the digital end. Nothing here blocks.
pub trait DigitalWire: Watch {
    /// Takes the next samples in order of sending, if there are any.
    fn take_samples(&mut self, into: &mut Samples) -> Result<bool, LinkFault>;
    /// Sends updates; `lossy` allows to lose a frame that finds no room.
    fn put_updates(&mut self, updates: &Updates, lossy: bool) -> Result<(), LinkFault>;
    /// Begins to send a request.
    fn put_request(&mut self, request: &Request) -> Result<(), LinkFault>;
    /// Sends what is left of it and takes the reply once all of it has come.
    fn take_reply(&mut self) -> Result<Option<Reply>, LinkFault>;
}

/// The analog processor's end over wire `W`.
#[derive(Debug)]
pub struct AnalogEnd<W> {
    wire: W,
    protocol: Protocol,
    patience: Patience,
    /// Updates that came before their frame was asked for (wall clock only).
    early: Option<Updates>,
    /// When it was last looked whether the partner lives, while computing.
    looked: Option<Instant>,
}

/// The digital processor's end over wire `W`.
#[derive(Debug)]
pub struct DigitalEnd<W> {
    wire: W,
    protocol: Protocol,
    patience: Patience,
}

impl<W> AnalogEnd<W> {
    pub(super) fn wire(&self) -> &W {
        &self.wire
    }

    pub(super) fn new(wire: W, protocol: Protocol, patience: &Patience) -> AnalogEnd<W> {
        AnalogEnd { wire, protocol, patience: patience.clone(), early: None, looked: None }
    }

    /// What the protocol knows of the session.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }
}

impl<W> DigitalEnd<W> {
    pub(super) fn wire(&self) -> &W {
        &self.wire
    }

    pub(super) fn new(wire: W, protocol: Protocol, patience: &Patience) -> DigitalEnd<W> {
        DigitalEnd { wire, protocol, patience: patience.clone() }
    }

    /// What the protocol knows of the session.
    pub fn protocol(&self) -> &Protocol {
        &self.protocol
    }
}

impl<W: AnalogWire> AnalogEnd<W> {
    /// Waits for the partner's greeting and answers it.
    pub(super) fn greet(&mut self) -> Result<(), LinkFault> {
        let limit = self.patience.arrival.map_or(Limit::Unlimited, Limit::After);
        let request = wait(&self.patience, &mut self.wire, limit, 0, AnalogWire::take_request)?;
        if let Err(error) = self.protocol.request(&request) {
            // The other side is told why before this one gives up.
            self.wire.put_reply(&Reply::Refused(error.to_string()))?;
            let _ = self.flush();
            return Err(error.at(0));
        }
        self.reply(&protocol::hello_reply())
    }

    fn flush(&mut self) -> Result<(), LinkFault> {
        wait(&self.patience, &mut self.wire, Limit::Silence, self.protocol.frame(), |wire| {
            Ok(wire.reply_gone()?.then_some(()))
        })
    }

    fn admit(&mut self, updates: &Updates, frame: u64) -> Result<(), LinkFault> {
        let admitted = self.protocol.updates(updates.frame);
        admitted.map_err(|e| e.at(frame))
    }
}

impl<W: AnalogWire> FramePort for AnalogEnd<W> {
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault> {
        self.patience.check_interrupt(self.protocol.frame())?;
        let lossy = self.protocol.may_skip();
        self.protocol
            .samples(samples.frame, samples.run_state())
            .map_err(|e| e.at(samples.frame))?;
        // The frame that ends a run is never the one to be lost.
        let last = !self.protocol.operating();
        self.wire.put_samples(samples, lossy && !last)
    }

    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault> {
        let mut updates = Updates::new(frame, Tick::ZERO);
        loop {
            match self.early.take() {
                Some(early) => updates = early,
                None => wait(
                    &self.patience,
                    &mut self.wire,
                    frame_limit(&self.protocol),
                    frame,
                    |wire| Ok(wire.take_updates(&mut updates)?.then_some(())),
                )?,
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
            None => self.wire.take_updates(&mut updates)?,
        };
        if !came {
            let gone = self.wire.gone();
            return if gone { Err(died(&self.wire, frame)) } else { Ok(None) };
        }
        if updates.frame > frame && self.protocol.may_skip() {
            self.early = Some(updates);
            return Ok(None);
        }
        self.admit(&updates, frame)?;
        Ok(Some(updates))
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        let frame = self.protocol.frame();
        self.patience.check_interrupt(frame)?;
        if self.looked.is_some_and(|at| at.elapsed() < LOOK) {
            return Ok(());
        }
        self.looked = Some(Instant::now());
        if self.wire.gone() {
            return Err(died(&self.wire, frame));
        }
        Ok(())
    }
}

impl<W: AnalogWire> AnalogPort for AnalogEnd<W> {
    fn await_request(&mut self) -> Result<Request, LinkFault> {
        let frame = self.protocol.frame();
        let request = wait(
            &self.patience,
            &mut self.wire,
            Limit::Unlimited,
            frame,
            AnalogWire::take_request,
        )?;
        self.protocol.request(&request).map_err(|e| e.at(frame))?;
        if let Request::Operate(_) = request {
            // Late updates of an earlier run on the wall clock; in lock-step there are none.
            self.early = None;
            let mut late = Updates::new(0, Tick::ZERO);
            while self.wire.take_updates(&mut late)? {}
        }
        Ok(request)
    }

    fn reply(&mut self, reply: &Reply) -> Result<(), LinkFault> {
        let frame = self.protocol.frame();
        self.protocol.reply(reply).map_err(|e| e.at(frame))?;
        self.wire.put_reply(reply)?;
        self.flush()
    }
}

impl<W: DigitalWire> DigitalEnd<W> {
    /// Greets the partner, which has the same build or is refused.
    pub(super) fn greet(&mut self) -> Result<(), LinkFault> {
        // The partner may still be starting: it has as long as it has to arrive.
        let limit = self.patience.arrival.map_or(Limit::Unlimited, Limit::After);
        match self.request_within(&protocol::hello(), limit)? {
            Reply::Refused(detail) => Err(LinkFault::Protocol { frame: 0, detail }),
            _ => Ok(()),
        }
    }

    fn request_within(&mut self, request: &Request, limit: Limit) -> Result<Reply, LinkFault> {
        let frame = self.protocol.frame();
        self.protocol.request(request).map_err(|e| e.at(frame))?;
        // Samples of an earlier run that nobody asked for.
        let mut stray = Samples::new(0, Tick::ZERO, RunState::Operate);
        while self.wire.take_samples(&mut stray)? {}
        self.wire.put_request(request)?;
        let reply = wait(&self.patience, &mut self.wire, limit, frame, DigitalWire::take_reply)?;
        self.protocol.reply(&reply).map_err(|e| e.at(frame))?;
        Ok(reply)
    }
}

impl<W: DigitalWire> DigitalPort for DigitalEnd<W> {
    fn await_samples(&mut self, frame: u64) -> Result<Samples, LinkFault> {
        let mut samples = Samples::new(frame, Tick::ZERO, RunState::Operate);
        loop {
            wait(&self.patience, &mut self.wire, frame_limit(&self.protocol), frame, |wire| {
                Ok(wire.take_samples(&mut samples)?.then_some(()))
            })?;
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
        self.wire.put_updates(updates, self.protocol.may_skip())
    }

    fn request(&mut self, request: &Request) -> Result<Reply, LinkFault> {
        self.request_within(request, Limit::Silence)
    }
}

/// How a frame is waited for: on the wall clock it must not be noticed late.
fn frame_limit(protocol: &Protocol) -> Limit {
    if protocol.may_skip() { Limit::Prompt } else { Limit::Silence }
}

/// The partner's death, as this end tells it.
pub(super) fn died(watch: &impl Watch, frame: u64) -> LinkFault {
    let side: Side = watch.side();
    LinkFault::PartnerDied { side: side.name(), frame, detail: watch.epitaph() }
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
            digital.wire.put_request(&Request::Hello { version, layout_hash }).unwrap();
            let fault = analog.greet().unwrap_err();
            assert!(matches!(fault, LinkFault::Protocol { .. }));
            assert!(fault.to_string().contains(word), "{fault}");
            let told = digital.wire.take_reply().unwrap();
            assert!(matches!(told, Some(Reply::Refused(text)) if text.contains(word)));
        }
    }
}
