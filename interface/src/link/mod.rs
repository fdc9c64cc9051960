//! Two ends of a link. In memory or through shared memory, behind the same traits.
//!
//! Every call has a deadline and notices a dead partner; none waits for ever.

mod bell;
pub mod direct;
mod end;
pub mod memory;
#[cfg(feature = "shm")]
pub mod shm;
mod waiting;

pub use end::End;
pub use waiting::Patience;

use crate::{
    Tick,
    control::{Checkpoints, Reply, Request},
    frame::{Samples, Updates},
};

/// Why a link call failed.
#[derive(Debug, thiserror::Error)]
pub enum LinkFault {
    #[error("{side} is gone (last frame {frame}): {detail}")]
    PartnerDied { side: &'static str, frame: u64, detail: String },
    #[error("{side} did not answer within {waited_s:.1} s (frame {frame})")]
    Deadline { side: &'static str, frame: u64, waited_s: f64 },
    #[error("{side} was stopped by a signal and does not go on (frame {frame})")]
    Stopped { side: &'static str, frame: u64 },
    /// A law that misses a frame computes another run.
    #[error("samples {found} came where {frame} were due: this side fell too far behind")]
    LostFrames { frame: u64, found: u64 },
    #[error("protocol violation at frame {frame}: {detail}")]
    Protocol { frame: u64, detail: String },
    #[error("interrupted at frame {frame}")]
    Interrupted { frame: u64 },
    #[error("the link failed while {doing}: {detail}")]
    Transport { doing: &'static str, detail: String },
}

impl LinkFault {
    /// The same fault, told of another frame (a wire does not know its frame).
    pub(crate) fn at_frame(mut self, number: u64) -> LinkFault {
        if let LinkFault::PartnerDied { frame, .. }
        | LinkFault::Deadline { frame, .. }
        | LinkFault::Stopped { frame, .. }
        | LinkFault::LostFrames { frame, .. }
        | LinkFault::Protocol { frame, .. }
        | LinkFault::Interrupted { frame } = &mut self
        {
            *frame = number;
        }
        self
    }
}

/// What a frame cycle needs of the other side.
pub trait FramePort {
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault>;
    /// Waits for updates n.
    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault>;
    /// Takes updates n if they have arrived already (free-running sessions). There an
    /// update of an earlier frame that comes late is given too; its number tells.
    fn poll_updates(&mut self, frame: u64) -> Result<Option<Updates>, LinkFault>;
    /// Looks whether somebody still waits for this side, which is computing; cheap enough
    /// to be asked every few microseconds.
    fn attend(&mut self) -> Result<(), LinkFault>;
    /// Gives the state of the analog side, where a checkpoint is due, before the frame's samples;
    /// an empty one where the run ends there.
    fn give_state(&mut self, frame: u64, state: Vec<u8>) -> Result<(), LinkFault>;
}

/// The analog processor's end.
pub trait AnalogPort: FramePort {
    /// Waits for the next request, as long as the partner lives.
    fn await_request(&mut self) -> Result<Request, LinkFault>;
    /// Answers the last request.
    fn reply(&mut self, reply: &Reply) -> Result<(), LinkFault>;
}

/// What the digital side does in each frame of a run; a closure is a law without an `after`.
///
/// A law that cannot go on says [`ModeCommand::End`](crate::frame::ModeCommand::End) and keeps
/// its reason, so that the run ends in good order and the session can go on.
pub trait Law {
    /// Fills the empty updates n from samples n; in the last frame (state `Ended`) they go nowhere.
    fn frame(&mut self, samples: &Samples, updates: &mut Updates);

    /// Once updates n are on their way, so that keeping records delays no transfer.
    fn after(&mut self, _samples: &Samples) {}

    /// At a checkpoint, before samples `frame`: the state of the analog side, to be kept with this
    /// one's.
    fn checkpoint(&mut self, _frame: u64, _analog: Vec<u8>) {}
}

impl<F: FnMut(&Samples, &mut Updates)> Law for F {
    fn frame(&mut self, samples: &Samples, updates: &mut Updates) {
        self(samples, updates);
    }
}

/// The digital processor's end.
pub trait DigitalPort {
    /// Sends a request and waits for its reply.
    fn request(&mut self, request: &Request) -> Result<Reply, LinkFault>;
    /// Once OPERATE was accepted: runs `law` frame by frame, its updates to take effect `latency`
    /// after their samples, and gives the samples at the end (`Ended` or `Faulted`). The
    /// `checkpoints` are those that were accepted.
    fn operate(
        &mut self,
        latency: Tick,
        checkpoints: Option<&Checkpoints>,
        law: &mut dyn Law,
    ) -> Result<Samples, LinkFault>;
    /// Looks whether this side is wanted still and the partner lives, while nothing is asked of it.
    fn attend(&mut self) -> Result<(), LinkFault>;
}

/// A digital end that hands out single frames.
pub trait DigitalFrames: DigitalPort {
    /// Waits for samples n. In a free-running session that overran, the samples that
    /// come may bear a later number; in lock-step never.
    fn await_samples(&mut self, frame: u64) -> Result<Samples, LinkFault>;
    /// Sends updates n.
    fn send_updates(&mut self, updates: &Updates) -> Result<(), LinkFault>;
}
