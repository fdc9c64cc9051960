//! The protocol between the two processors as a pure state machine.
//!
//! Four kinds of message cross a link: requests and updates from the digital
//! to the analog side, replies and samples the other way. Both ends feed every
//! message that they send or receive to a [`Protocol`], which refuses what is
//! out of order. It does no I/O, reads no clock and knows no transport, so both
//! links behave alike and the rules are tested without either.
//!
//! ```text
//! Greeting -Hello-> Idle -request-> Answering -reply-> Idle
//!                                      | Operate accepted
//!                                      v
//!                    Operating: samples 0, updates 0, samples 1, … samples n (Ended | Faulted) -> Idle
//!                    (between updates and samples, Checkpoint and its reply)
//! ```

mod error;
mod greeting;

pub use error::ProtocolError;
pub use greeting::{VERSION, check_hello, hello, hello_reply, layout_hash};

use crate::{
    control::{Clock, Reply, Request},
    frame::RunState,
};
use error::{reply_name, request_name};

/// One end of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The analog processor.
    Analog,
    /// The digital processor.
    Digital,
}

impl Side {
    /// Name of the process, as errors print it.
    pub fn name(self) -> &'static str {
        match self {
            Side::Analog => "analog-proc",
            Side::Digital => "digital-proc",
        }
    }

    /// The other end.
    pub fn partner(self) -> Side {
        match self {
            Side::Analog => Side::Digital,
            Side::Digital => Side::Analog,
        }
    }
}

/// Mode of the machine as the protocol knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// No patch is loaded.
    PotSet,
    /// Integrators at their initial conditions.
    InitialCondition,
    /// Integrating.
    Operate,
    /// Integrators hold their values.
    Hold,
}

#[derive(Clone, Debug, PartialEq)]
enum Phase {
    Greeting,
    Idle,
    Answering(Pending),
    Operating(Run),
    Closed,
}

/// What a reply must match.
#[derive(Clone, Debug, PartialEq)]
enum Pending {
    Hello,
    Load { hash: String },
    Set,
    Read(usize),
    StaticCheck,
    Sweep(usize),
    Linearise,
    Operate(Clock),
    Diagnose,
    Bye,
}

/// Frame numbers of one OPERATE period.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Run {
    clock: Clock,
    /// Number of the last samples.
    samples: Option<u64>,
    /// Number of the last updates.
    updates: Option<u64>,
    /// Whether a checkpoint was asked for and not given yet.
    asked: bool,
}

/// The state of one session, as either end sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Protocol {
    phase: Phase,
    mode: Mode,
    frame: u64,
}

impl Default for Protocol {
    fn default() -> Protocol {
        Protocol::new()
    }
}

impl Protocol {
    /// A session whose two sides have not met: only a greeting has a place.
    pub fn new() -> Protocol {
        Protocol { phase: Phase::Greeting, mode: Mode::PotSet, frame: 0 }
    }

    /// A session between two ends of one build, which need no greeting.
    pub fn greeted() -> Protocol {
        Protocol { phase: Phase::Idle, ..Protocol::new() }
    }

    /// The last frame that was begun.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Mode of the machine.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Whether frames flow (as against requests).
    pub fn operating(&self) -> bool {
        matches!(self.phase, Phase::Operating(_))
    }

    /// Whether frame numbers may skip: in a session paced by the wall clock an
    /// overrun loses frames, in lock-step nothing ever is.
    pub fn may_skip(&self) -> bool {
        matches!(&self.phase, Phase::Operating(run) if matches!(run.clock, Clock::Wall { .. }))
    }

    /// Whether the session ended by `Bye`.
    pub fn closed(&self) -> bool {
        self.phase == Phase::Closed
    }

    fn phase_name(&self) -> &'static str {
        match &self.phase {
            Phase::Greeting => "the two sides have not greeted each other",
            Phase::Idle => "the machine waits for a request",
            Phase::Answering(_) => "a request waits for its reply",
            Phase::Operating(_) => "frames flow",
            Phase::Closed => "the session is closed",
        }
    }

    fn out_of_order<T>(&self, message: &'static str) -> Result<T, ProtocolError> {
        Err(ProtocolError::OutOfOrder { message, phase: self.phase_name() })
    }

    /// A request crosses.
    pub fn request(&mut self, request: &Request) -> Result<(), ProtocolError> {
        match (&mut self.phase, request) {
            (Phase::Operating(run), Request::Checkpoint)
                if run.samples.is_some() && run.samples == run.updates && !run.asked =>
            {
                run.asked = true;
                return Ok(());
            }
            (Phase::Greeting | Phase::Idle, Request::Hello { version, layout_hash }) => {
                check_hello(*version, *layout_hash)?
            }
            (Phase::Idle, _) => {}
            _ => return self.out_of_order(request_name(request)),
        }
        self.phase = Phase::Answering(match request {
            Request::Hello { .. } => Pending::Hello,
            Request::Load { bundle, .. } => Pending::Load { hash: bundle.hash() },
            Request::SetParams(_) | Request::SetIcs(_) | Request::Preset(_) => Pending::Set,
            Request::Read(nets) => Pending::Read(nets.len()),
            Request::StaticCheck => Pending::StaticCheck,
            Request::Operate(spec) | Request::OperateKept(spec, _) => Pending::Operate(spec.clock),
            Request::Sweep(sweep) => Pending::Sweep(sweep.cases.len()),
            Request::Linearise { .. } => Pending::Linearise,
            Request::Diagnose => Pending::Diagnose,
            Request::Bye => Pending::Bye,
            Request::Checkpoint => return self.out_of_order(request_name(request)),
        });
        Ok(())
    }

    /// A reply crosses.
    pub fn reply(&mut self, reply: &Reply) -> Result<(), ProtocolError> {
        if let (Phase::Operating(run @ Run { asked: true, .. }), Reply::Checkpoint(_)) =
            (&mut self.phase, reply)
        {
            run.asked = false;
            return Ok(());
        }
        let Phase::Answering(pending) = &self.phase else {
            return self.out_of_order(reply_name(reply));
        };
        if let Reply::Refused(_) = reply {
            self.phase = match pending {
                Pending::Hello if self.mode == Mode::PotSet => Phase::Greeting,
                _ => Phase::Idle,
            };
            return Ok(());
        }
        let next = match (pending, reply) {
            (Pending::Hello, Reply::Hello { version, layout_hash }) => {
                check_hello(*version, *layout_hash)?;
                Phase::Idle
            }
            (Pending::Load { hash }, Reply::Loaded { patch_hash, .. }) => {
                if hash != patch_hash {
                    return Err(ProtocolError::PatchHash {
                        sent: hash.clone(),
                        loaded: patch_hash.clone(),
                    });
                }
                self.mode = Mode::InitialCondition;
                Phase::Idle
            }
            (Pending::Set, Reply::Done)
            | (Pending::StaticCheck, Reply::StaticCheck(_))
            | (Pending::Linearise, Reply::Linear(_))
            | (Pending::Diagnose, Reply::Diagnosis { .. }) => Phase::Idle,
            (Pending::Read(count), Reply::Values(values)) if values.len() == *count => Phase::Idle,
            (Pending::Sweep(count), Reply::Swept(runs)) if runs.len() == *count => Phase::Idle,
            (Pending::Operate(clock), Reply::Done) => {
                if self.mode == Mode::PotSet {
                    return Err(ProtocolError::OutOfOrder {
                        message: "OPERATE",
                        phase: "no patch is loaded",
                    });
                }
                self.mode = Mode::Operate;
                Phase::Operating(Run { clock: *clock, samples: None, updates: None, asked: false })
            }
            (Pending::Bye, Reply::Done) => Phase::Closed,
            (pending, reply) => {
                return Err(ProtocolError::ReplyKind {
                    request: pending.name(),
                    reply: reply_name(reply),
                });
            }
        };
        self.phase = next;
        Ok(())
    }

    /// Samples cross. `Ended` and `Faulted` lead back to requests; the machine then holds.
    pub fn samples(&mut self, frame: u64, state: RunState) -> Result<(), ProtocolError> {
        let skip = self.may_skip();
        let Phase::Operating(run) = &mut self.phase else {
            return self.out_of_order("samples");
        };
        if let Some(last) = run.samples {
            if !skip && (run.updates != Some(last) || run.asked) {
                return Err(ProtocolError::OutOfOrder {
                    message: "samples",
                    phase: "updates of the last frame are due",
                });
            }
            if frame <= last || (!skip && frame != last + 1) {
                return Err(ProtocolError::FrameNumber {
                    message: "samples",
                    expected: last.saturating_add(1),
                    found: frame,
                });
            }
        }
        run.samples = Some(frame);
        self.frame = frame;
        match state {
            RunState::Operate => self.mode = Mode::Operate,
            RunState::Hold => self.mode = Mode::Hold,
            RunState::Ended | RunState::Faulted => {
                self.mode = Mode::Hold;
                self.phase = Phase::Idle;
            }
        }
        Ok(())
    }

    /// Updates cross.
    pub fn updates(&mut self, frame: u64) -> Result<(), ProtocolError> {
        let skip = self.may_skip();
        let Phase::Operating(run) = &mut self.phase else {
            return self.out_of_order("updates");
        };
        let Some(samples) = run.samples else {
            return Err(ProtocolError::OutOfOrder {
                message: "updates",
                phase: "the first samples are due",
            });
        };
        let late = run.updates.is_some_and(|last| frame <= last);
        if late || frame > samples || (!skip && frame != samples) {
            return Err(ProtocolError::FrameNumber {
                message: "updates",
                expected: samples,
                found: frame,
            });
        }
        run.updates = Some(frame);
        Ok(())
    }
}

impl Pending {
    fn name(&self) -> &'static str {
        match self {
            Pending::Hello => "Hello",
            Pending::Load { .. } => "Load",
            Pending::Set => "SetParams, SetIcs or Preset",
            Pending::Read(_) => "Read",
            Pending::StaticCheck => "StaticCheck",
            Pending::Sweep(_) => "Sweep",
            Pending::Linearise => "Linearise",
            Pending::Operate(_) => "Operate",
            Pending::Diagnose => "Diagnose",
            Pending::Bye => "Bye",
        }
    }
}

#[cfg(test)]
mod tests;
