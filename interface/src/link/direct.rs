//! Both processors in one thread: a frame is a call.
//!
//! The analog side runs its frame cycle, and the digital side's law is called where that cycle sends
//! its samples; nothing waits, so that a processor carries a whole machine. Order and numbers of all
//! messages are held against the same [`Protocol`] as on the other link, and a run has the same bits.

use super::{DigitalPort, FramePort, Law, LinkFault, Patience};
use crate::{
    Tick,
    control::{Checkpoints, Reply, Request},
    frame::{RunState, Samples, Updates},
    protocol::Protocol,
};

/// The analog processor without a link of its own.
pub trait AnalogSide {
    /// Answers a request; `attend` fails when nobody waits for the answer any more. An accepted
    /// OPERATE is followed by [`AnalogSide::operate`].
    fn answer(
        &mut self,
        request: Request,
        attend: &mut dyn FnMut() -> Result<(), LinkFault>,
    ) -> Result<Reply, LinkFault>;
    /// Runs the period that was accepted last.
    fn operate(&mut self, port: &mut dyn FramePort) -> Result<(), LinkFault>;
}

/// Makes an analog side of this build.
pub type MakeAnalog = fn() -> Box<dyn AnalogSide>;

/// The digital end with the analog side behind it.
pub struct Direct {
    analog: Box<dyn AnalogSide>,
    protocol: Protocol,
    patience: Patience,
}

impl Direct {
    /// A session with an analog side of its own.
    pub fn new(make: MakeAnalog, patience: &Patience) -> Direct {
        let patience = patience.clone();
        Direct { analog: make(), protocol: Protocol::greeted(), patience }
    }
}

impl DigitalPort for Direct {
    fn request(&mut self, request: &Request) -> Result<Reply, LinkFault> {
        let frame = self.protocol.frame();
        let patience = &self.patience;
        patience.check_interrupt(frame)?;
        self.protocol.request(request).map_err(|e| e.at(frame))?;
        let mut attend = || patience.check_interrupt(frame);
        let reply = self.analog.answer(request.clone(), &mut attend)?;
        self.protocol.reply(&reply).map_err(|e| e.at(frame))?;
        Ok(reply)
    }

    fn operate(
        &mut self,
        latency: Tick,
        _checkpoints: Option<&Checkpoints>,
        law: &mut dyn Law,
    ) -> Result<Samples, LinkFault> {
        let Direct { analog, protocol, patience } = self;
        let mut frames = Frames { protocol, patience, law, latency, pending: None, last: None };
        analog.operate(&mut frames)?;
        frames.last.ok_or_else(|| LinkFault::Protocol {
            frame: frames.protocol.frame(),
            detail: "the run ended without a last frame".to_owned(),
        })
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        self.patience.check_interrupt(self.protocol.frame())
    }
}

/// The digital side as the frame cycle meets it.
struct Frames<'a> {
    protocol: &'a mut Protocol,
    patience: &'a Patience,
    law: &'a mut dyn Law,
    latency: Tick,
    /// Updates that the frame cycle has not asked for yet.
    pending: Option<Updates>,
    /// The samples that ended the run.
    last: Option<Samples>,
}

impl FramePort for Frames<'_> {
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault> {
        let (frame, state) = (samples.frame, samples.run_state());
        self.patience.check_interrupt(frame)?;
        self.protocol.samples(frame, state).map_err(|e| e.at(frame))?;
        if state == RunState::Faulted {
            self.last = Some(*samples);
            return Ok(());
        }
        let mut updates = Updates::new(frame, samples.tick + self.latency);
        self.law.frame(samples, &mut updates);
        if state == RunState::Ended {
            self.last = Some(*samples);
        } else {
            self.protocol.updates(frame).map_err(|e| e.at(frame))?;
            self.pending = Some(updates);
        }
        self.law.after(samples);
        Ok(())
    }

    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault> {
        self.poll_updates(frame)?.ok_or_else(|| LinkFault::Protocol {
            frame,
            detail: "updates were awaited before their samples".to_owned(),
        })
    }

    fn poll_updates(&mut self, frame: u64) -> Result<Option<Updates>, LinkFault> {
        self.patience.check_interrupt(frame)?;
        Ok(self.pending.take_if(|updates| updates.frame <= frame))
    }

    fn attend(&mut self) -> Result<(), LinkFault> {
        self.patience.check_interrupt(self.protocol.frame())
    }

    fn give_state(&mut self, frame: u64, state: Vec<u8>) -> Result<(), LinkFault> {
        if !state.is_empty() {
            self.law.checkpoint(frame, state);
        }
        Ok(())
    }
}
