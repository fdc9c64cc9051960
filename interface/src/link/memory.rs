//! The link inside one process: two ends in two threads.
//!
//! It carries the same frames under the same protocol as the shared-memory
//! link, so that a run is bit-identical over either. An end that is dropped
//! (or whose thread panics) is a dead partner. It refuses nothing that the
//! other link allows; a partner of another build cannot occur.

use super::{
    LinkFault,
    bell::Bell,
    end::{End, Wire, died},
    waiting::{Patience, Watch, Watched},
};
use crate::{
    Side,
    control::{Reply, Request},
    frame::{Samples, Updates},
    protocol::Protocol,
};
use std::{
    sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel},
    time::{Duration, Instant},
};

/// Frames in flight at most, as on the shared-memory link; lock-step needs one.
const FRAMES: usize = 16;

/// The analog processor's end.
pub type MemoryAnalog = End<Queues<Samples, Updates, Reply, Request>>;
/// The digital processor's end.
pub type MemoryDigital = End<Queues<Updates, Samples, Request, Reply>>;

/// Two ends with the default patience.
pub fn pair() -> (MemoryAnalog, MemoryDigital) {
    pair_with(&Patience::default())
}

/// Two ends that share an interrupt flag and limits.
pub fn pair_with(patience: &Patience) -> (MemoryAnalog, MemoryDigital) {
    let (samples_in, samples_out) = sync_channel(FRAMES);
    let (updates_in, updates_out) = sync_channel(FRAMES);
    let (requests_in, requests_out) = sync_channel(1);
    let (replies_in, replies_out) = sync_channel(1);
    let (analog, digital) = Bell::pair();
    let presence = |partner, bell| Presence { partner, bell, started: Instant::now() };
    let analog = Queues {
        frames: (samples_in, updates_out),
        messages: (replies_in, requests_out),
        presence: presence(Side::Digital, analog),
    };
    let digital = Queues {
        frames: (updates_in, samples_out),
        messages: (requests_in, replies_out),
        presence: presence(Side::Analog, digital),
    };
    (
        End::new(analog, Protocol::greeted(), patience),
        End::new(digital, Protocol::greeted(), patience),
    )
}

/// The queues of an end: out and in, for frames and for messages.
#[derive(Debug)]
pub struct Queues<Fo, Fi, Mo, Mi> {
    frames: (SyncSender<Fo>, Receiver<Fi>),
    messages: (SyncSender<Mo>, Receiver<Mi>),
    presence: Presence,
}

/// Sees the other end go, and tells it of one's own end: by dropping the bell.
#[derive(Debug)]
pub struct Presence {
    partner: Side,
    bell: Bell,
    started: Instant,
}

impl Watch for Presence {
    fn side(&self) -> Side {
        self.partner
    }

    fn bell(&self) -> &Bell {
        &self.bell
    }

    fn gone(&self) -> bool {
        self.bell.partner_closed()
    }

    fn left(&self) -> bool {
        self.gone()
    }

    fn epitaph(&self) -> String {
        "its end of the link was dropped".to_owned()
    }

    /// The threads of a process stop together.
    fn stopped(&self) -> bool {
        false
    }

    /// A thread that still holds its end counts as computing: it cannot vanish
    /// unnoticed, so only the busy limit bounds a wait for it.
    fn cpu_time(&self) -> Option<Duration> {
        Some(self.started.elapsed())
    }
}

/// Sends without blocking. A queue full to the brim means that the partner stopped reading.
fn put<T>(
    queue: &SyncSender<T>,
    message: T,
    presence: &Presence,
    lossy: bool,
) -> Result<(), LinkFault> {
    match queue.try_send(message) {
        Ok(()) => {
            presence.bell.ring();
            Ok(())
        }
        // A reader that fell behind on the wall clock loses frames and sees the gap.
        Err(TrySendError::Full(_)) if lossy => Ok(()),
        Err(TrySendError::Full(_)) => Err(LinkFault::Transport {
            doing: "sending in memory",
            detail: format!("{} does not take its messages", presence.side().name()),
        }),
        Err(TrySendError::Disconnected(_)) => Err(died(presence, 0)),
    }
}

impl<Fo, Fi, Mo, Mi> Watched for Queues<Fo, Fi, Mo, Mi> {
    type Partner = Presence;

    fn partner(&self) -> &Presence {
        &self.presence
    }
}

// A disconnected queue reads as empty: the presence tells of a death, after the
// last message has been taken.
impl<Fo: Copy, Fi, Mo: Clone, Mi> Wire for Queues<Fo, Fi, Mo, Mi> {
    type FrameOut = Fo;
    type FrameIn = Fi;
    type MessageOut = Mo;
    type MessageIn = Mi;

    fn put_frame(&mut self, frame: &Fo, lossy: bool) -> Result<(), LinkFault> {
        put(&self.frames.0, *frame, &self.presence, lossy)
    }

    fn take_frame(&mut self, into: &mut Fi) -> Result<bool, LinkFault> {
        Ok(self.frames.1.try_recv().map(|frame| *into = frame).is_ok())
    }

    fn put_message(&mut self, message: &Mo) -> Result<(), LinkFault> {
        put(&self.messages.0, message.clone(), &self.presence, false)
    }

    fn take_message(&mut self) -> Result<Option<Mi>, LinkFault> {
        Ok(self.messages.1.try_recv().ok())
    }

    fn message_gone(&mut self) -> Result<bool, LinkFault> {
        Ok(true)
    }
}
