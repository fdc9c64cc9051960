//! The link inside one process: two ends in two threads.
//!
//! It carries the same frames under the same protocol as the shared-memory
//! link, so that a run is bit-identical over either. An end that is dropped
//! (or whose thread panics) is a dead partner. It refuses nothing that the
//! other link allows; a partner of another build cannot occur.

use super::{
    LinkFault,
    bell::Bell,
    end::{AnalogEnd, AnalogWire, DigitalEnd, DigitalWire, died},
    waiting::{Patience, Watch},
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

pub type MemoryAnalog = AnalogEnd<AnalogQueues>;
pub type MemoryDigital = DigitalEnd<DigitalQueues>;

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
    let (analog, digital) = Presence::pair();
    let analog = AnalogQueues {
        samples: samples_in,
        updates: updates_out,
        requests: requests_out,
        replies: replies_in,
        presence: analog,
    };
    let digital = DigitalQueues {
        samples: samples_out,
        updates: updates_in,
        requests: requests_in,
        replies: replies_out,
        presence: digital,
    };
    (
        AnalogEnd::new(analog, Protocol::greeted(), patience),
        DigitalEnd::new(digital, Protocol::greeted(), patience),
    )
}

/// The analog end's queues.
#[derive(Debug)]
pub struct AnalogQueues {
    samples: SyncSender<Samples>,
    updates: Receiver<Updates>,
    requests: Receiver<Request>,
    replies: SyncSender<Reply>,
    presence: Presence,
}

/// The digital end's queues.
#[derive(Debug)]
pub struct DigitalQueues {
    samples: Receiver<Samples>,
    updates: SyncSender<Updates>,
    requests: SyncSender<Request>,
    replies: Receiver<Reply>,
    presence: Presence,
}

/// Sees the other end go, and tells it of one's own end: by dropping the bell.
#[derive(Debug)]
struct Presence {
    partner: Side,
    bell: Bell,
    started: Instant,
}

impl Presence {
    /// The presences of the analog and of the digital end.
    fn pair() -> (Presence, Presence) {
        let (analog, digital) = Bell::pair();
        let end = |partner, bell| Presence { partner, bell, started: Instant::now() };
        (end(Side::Digital, analog), end(Side::Analog, digital))
    }
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

macro_rules! watch_by_presence {
    ($($queues:ty),*) => {$(
        impl Watch for $queues {
            fn side(&self) -> Side {
                self.presence.side()
            }
            fn bell(&self) -> &Bell {
                self.presence.bell()
            }
            fn gone(&self) -> bool {
                self.presence.gone()
            }
            fn left(&self) -> bool {
                self.presence.left()
            }
            fn epitaph(&self) -> String {
                self.presence.epitaph()
            }
            fn stopped(&self) -> bool {
                self.presence.stopped()
            }
            fn cpu_time(&self) -> Option<Duration> {
                self.presence.cpu_time()
            }
        }
    )*};
}
watch_by_presence!(AnalogQueues, DigitalQueues);

// A disconnected queue reads as empty: the presence tells of a death, after the
// last message has been taken.
impl AnalogWire for AnalogQueues {
    fn put_samples(&mut self, samples: &Samples, lossy: bool) -> Result<(), LinkFault> {
        put(&self.samples, *samples, &self.presence, lossy)
            .map_err(|fault| fault.at_frame(samples.frame))
    }

    fn take_updates(&mut self, into: &mut Updates) -> Result<bool, LinkFault> {
        Ok(self.updates.try_recv().map(|updates| *into = updates).is_ok())
    }

    fn take_request(&mut self) -> Result<Option<Request>, LinkFault> {
        Ok(self.requests.try_recv().ok())
    }

    fn put_reply(&mut self, reply: &Reply) -> Result<(), LinkFault> {
        put(&self.replies, reply.clone(), &self.presence, false)
    }

    fn reply_gone(&mut self) -> Result<bool, LinkFault> {
        Ok(true)
    }
}

impl DigitalWire for DigitalQueues {
    fn take_samples(&mut self, into: &mut Samples) -> Result<bool, LinkFault> {
        Ok(self.samples.try_recv().map(|samples| *into = samples).is_ok())
    }

    fn put_updates(&mut self, updates: &Updates, lossy: bool) -> Result<(), LinkFault> {
        put(&self.updates, *updates, &self.presence, lossy)
            .map_err(|fault| fault.at_frame(updates.frame))
    }

    fn put_request(&mut self, request: &Request) -> Result<(), LinkFault> {
        put(&self.requests, request.clone(), &self.presence, false)
    }

    fn take_reply(&mut self) -> Result<Option<Reply>, LinkFault> {
        Ok(self.replies.try_recv().ok())
    }
}
