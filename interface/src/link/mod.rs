//! Two ends of a link. In memory or through shared memory, behind the same traits.
//!
//! Every call has a deadline and notices a dead partner; none waits for ever.

mod bell;
mod end;
pub mod memory;
#[cfg(feature = "shm")]
pub mod shm;
mod waiting;

pub use end::{AnalogEnd, DigitalEnd};
pub use waiting::Patience;

use crate::{
    control::{Reply, Request},
    frame::{Samples, Updates},
};

/// Why a link call failed.
#[derive(Debug, thiserror::Error)]
pub enum LinkFault {
    /// The other process is gone.
    #[error("{side} is gone (last frame {frame}): {detail}")]
    PartnerDied {
        /// `analog-proc` or `digital-proc`.
        side: &'static str,
        /// Last frame that was complete.
        frame: u64,
        /// How it was noticed, exit status if known.
        detail: String,
    },
    /// The other side lives but did not answer in time.
    #[error("{side} did not answer within {waited_s:.1} s (frame {frame})")]
    Deadline {
        /// `analog-proc` or `digital-proc`.
        side: &'static str,
        /// Frame waited for.
        frame: u64,
        /// Seconds waited.
        waited_s: f64,
    },
    /// The other process was stopped, as by Ctrl-Z, and not continued.
    #[error("{side} was stopped by a signal and does not go on (frame {frame})")]
    Stopped {
        /// `analog-proc` or `digital-proc`.
        side: &'static str,
        /// Frame waited for.
        frame: u64,
    },
    /// A frame or message out of order.
    #[error("protocol violation at frame {frame}: {detail}")]
    Protocol {
        /// Frame expected.
        frame: u64,
        /// What came instead.
        detail: String,
    },
    /// The user interrupted this process.
    #[error("interrupted at frame {frame}")]
    Interrupted {
        /// Last frame that was complete.
        frame: u64,
    },
    /// The transport itself failed.
    #[error("the link failed while {doing}: {detail}")]
    Transport {
        /// What was being done.
        doing: &'static str,
        /// The transport's own words.
        detail: String,
    },
}

impl LinkFault {
    /// The same fault, told of another frame (a wire does not know its frame).
    pub(crate) fn at_frame(mut self, number: u64) -> LinkFault {
        if let LinkFault::PartnerDied { frame, .. }
        | LinkFault::Deadline { frame, .. }
        | LinkFault::Stopped { frame, .. }
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
    /// Sends samples n.
    fn send_samples(&mut self, samples: &Samples) -> Result<(), LinkFault>;
    /// Waits for updates n.
    fn await_updates(&mut self, frame: u64) -> Result<Updates, LinkFault>;
    /// Takes updates n if they have arrived already (free-running sessions). There an
    /// update of an earlier frame that comes late is given too; its number tells.
    fn poll_updates(&mut self, frame: u64) -> Result<Option<Updates>, LinkFault>;
    /// Looks whether somebody still waits for this side, which is computing; cheap enough
    /// to be asked every few microseconds.
    fn attend(&mut self) -> Result<(), LinkFault>;
}

/// The analog processor's end.
pub trait AnalogPort: FramePort {
    /// Waits for the next request, as long as the partner lives.
    fn await_request(&mut self) -> Result<Request, LinkFault>;
    /// Answers the last request.
    fn reply(&mut self, reply: &Reply) -> Result<(), LinkFault>;
}

/// The digital processor's end.
pub trait DigitalPort {
    /// Waits for samples n. In a free-running session that overran, the samples that
    /// come may bear a later number; in lock-step never.
    fn await_samples(&mut self, frame: u64) -> Result<Samples, LinkFault>;
    /// Sends updates n.
    fn send_updates(&mut self, updates: &Updates) -> Result<(), LinkFault>;
    /// Sends a request and waits for its reply.
    fn request(&mut self, request: &Request) -> Result<Reply, LinkFault>;
}
