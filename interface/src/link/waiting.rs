//! How a side waits for the other: spin, then yield, then sleep by the bell.
//!
//! The answer to a frame comes within microseconds as long as both processes run, so a wait
//! first spins (20 µs where they may have a processor each, not at all on a shared one), then
//! yields the processor, then sleeps until the partner rings ([`Bell`]). A sleep lasts a slice
//! of time at most, after which the wait looks whether the partner is still there. Beside busy
//! programs, where a yield is dear, waits sleep at once ([`Bell::crowded`]).
//!
//! On the wall clock, where lateness counts, it yields for longer than a fast frame,
//! whoever else is busy.
//!
//! It refuses to wait for ever. A partner that lives but neither answers nor
//! computes for [`Patience::silence`] has hung; one that uses processor time is
//! working, and may for [`Patience::busy_limit`]; one that was stopped (Ctrl-Z, SIGSTOP)
//! may be so for [`STOPPED`]. Between runs the analog side alone
//! waits without a limit, for as long as its partner lives: somebody may be thinking
//! about the next request.

use super::{LinkFault, bell::Bell};
use crate::{Side, processor};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

/// A frame that is ready comes within this time when both sides have a core …
const SPIN: Duration = Duration::from_micros(2);
/// … and one that a study asks for within this: a side that yields meanwhile takes up the
/// other's work some microseconds late, frame by frame.
const SPIN_APART: Duration = Duration::from_micros(20);
/// Time given to the partner on a shared core before the wait sleeps.
const YIELD: Duration = Duration::from_micros(200);
/// The same in a wait for a frame on the wall clock, where lateness counts: longer than a fast
/// frame, since a processor that has gone to sleep may wake up milliseconds late.
const YIELD_PROMPT: Duration = Duration::from_millis(2);
/// Sleep in such a wait.
const SLICE_PROMPT: Duration = Duration::from_micros(100);
/// Shortest sleep; a message ends it earlier.
const SLICE_MIN: Duration = Duration::from_millis(1);
/// The same while a partner is awaited that may not ring yet; below it the timer's own
/// slack (50 µs) rules.
const SLICE_ARRIVAL: Duration = Duration::from_micros(50);
/// Longest sleep: a dead partner or an interrupt is noticed within it.
const SLICE_MAX: Duration = Duration::from_millis(20);
/// Longest time between two looks at the partner's place in the session.
const LOOK: Duration = Duration::from_millis(40);
/// A partner that was stopped is given up after this time: within two seconds of its stop,
/// and not for a stop of one second. A process that is merely slow, or starved of the
/// processor, is not in that state, nor is one in a debugger.
const STOPPED: Duration = Duration::from_millis(1500);
/// A partner that uses more than this share of a core while it is silent is
/// computing. An idle wait with sleeps of [`SLICE_MAX`] uses about a thousandth.
const BUSY_SHARE: f64 = 0.01;

/// How long a link waits, and what ends a wait early.
#[derive(Clone, Debug)]
pub struct Patience {
    /// Set by the caller's signal handler; every wait looks at it.
    pub interrupted: Arc<AtomicBool>,
    /// A partner silent and idle for this long has hung.
    pub silence: Duration,
    /// A partner silent but computing may be so for this long.
    pub busy_limit: Duration,
    /// How long to wait for a partner to arrive; `None` waits until interrupted.
    pub arrival: Option<Duration>,
    /// Whether both sides can run at once: this thread may use more than one processor.
    pub apart: bool,
}

impl Default for Patience {
    /// 10 s of silence, 10 min of computing, 10 s to arrive, no interrupt.
    fn default() -> Patience {
        Patience {
            interrupted: Arc::new(AtomicBool::new(false)),
            silence: Duration::from_secs(10),
            busy_limit: Duration::from_secs(600),
            arrival: Some(Duration::from_secs(10)),
            apart: processor::allowed().len() > 1,
        }
    }
}

impl Patience {
    /// Default limits with the caller's interrupt flag.
    pub fn interrupted_by(flag: Arc<AtomicBool>) -> Patience {
        Patience { interrupted: flag, ..Patience::default() }
    }

    /// Fails when the user interrupted this process.
    pub(super) fn check_interrupt(&self, frame: u64) -> Result<(), LinkFault> {
        if self.interrupted.load(Ordering::Relaxed) {
            Err(LinkFault::Interrupted { frame })
        } else {
            Ok(())
        }
    }
}

/// What a wait can see of the other side.
pub trait Watch {
    fn side(&self) -> Side;
    /// Rung by the partner after each message.
    fn bell(&self) -> &Bell;
    /// Whether the partner has gone.
    fn gone(&self) -> bool;
    /// A slower look for a partner that lives but gave up the session.
    fn left(&self) -> bool;
    /// How it ended.
    fn epitaph(&self) -> String;
    /// Whether it was stopped and not continued, where that can be told.
    fn stopped(&self) -> bool;
    /// Processor time used so far, where it can be told.
    fn cpu_time(&self) -> Option<Duration>;
}

/// What sees the other side.
pub trait Watched {
    type Partner: Watch;
    fn partner(&self) -> &Self::Partner;
}

/// When a wait for a live partner ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Limit {
    /// After the patience's silence, or busy limit while the partner computes.
    Silence,
    /// Likewise, but the message is noticed as soon as can be.
    Prompt,
    /// After this time, whatever the partner does.
    After(Duration),
    /// Only when it dies, or this side is interrupted.
    Unlimited,
}

/// Waits until `attempt` gives something.
pub(super) fn wait<W: Watched, T>(
    patience: &Patience,
    wire: &mut W,
    limit: Limit,
    frame: u64,
    mut attempt: impl FnMut(&mut W) -> Result<Option<T>, LinkFault>,
) -> Result<T, LinkFault> {
    patience.check_interrupt(frame)?;
    if let Some(found) = attempt(wire)? {
        return Ok(found);
    }
    let start = Instant::now();
    let prompt = limit == Limit::Prompt;
    let spin = match (prompt, patience.apart) {
        // Both sides may share a processor without being bound to it.
        (true, _) => SPIN,
        (false, true) => SPIN_APART,
        // Whoever is waited for needs this processor.
        (false, false) => Duration::ZERO,
    };
    while start.elapsed() < spin {
        std::hint::spin_loop();
        if let Some(found) = attempt(wire)? {
            return Ok(found);
        }
    }
    let awake = match (prompt, wire.partner().bell().crowded()) {
        (true, _) => YIELD_PROMPT,
        (false, false) => YIELD,
        (false, true) => Duration::ZERO,
    };
    let mut now = start.elapsed();
    while now < awake {
        rustix::thread::sched_yield();
        let before = std::mem::replace(&mut now, start.elapsed());
        let slow = wire.partner().bell().yielded_for(now - before);
        if let Some(found) = attempt(wire)? {
            return Ok(found);
        }
        if slow && !prompt {
            break;
        }
    }
    let mut looked = Instant::now();
    let mut stopped: Option<Instant> = None;
    let mut window: Option<Window> = None;
    loop {
        patience.check_interrupt(frame)?;
        let waited = start.elapsed();
        // At most an eighth of the time waited, so that what is not rung for (an arrival)
        // is not noticed much too late.
        let slice = match limit {
            Limit::Prompt => SLICE_PROMPT,
            Limit::After(_) => (waited / 8).clamp(SLICE_ARRIVAL, SLICE_MAX),
            _ => (waited / 8).clamp(SLICE_MIN, SLICE_MAX),
        };
        let heard = wire.partner().bell().listen();
        let found = attempt(wire);
        if !matches!(found, Ok(None)) {
            wire.partner().bell().stay_awake();
        }
        if let Some(found) = found? {
            return Ok(found);
        }
        wire.partner().bell().sleep(heard, slice);
        let mut gone = wire.partner().gone();
        if !gone && looked.elapsed() > LOOK {
            gone = wire.partner().left();
            looked = Instant::now();
            stopped = stopped.or(Some(looked)).filter(|_| wire.partner().stopped());
        }
        // Once more even when it is gone: its last message may have come first.
        if let Some(found) = attempt(wire)? {
            return Ok(found);
        }
        if gone {
            // In one process both sides hear of an interrupt, and either may leave first.
            patience.check_interrupt(frame)?;
            return Err(super::end::died(wire.partner(), frame));
        }
        if limit != Limit::Unlimited && stopped.is_some_and(|s| s.elapsed() > STOPPED) {
            return Err(LinkFault::Stopped { side: wire.partner().side().name(), frame });
        }
        let over = match limit {
            Limit::Unlimited => false,
            Limit::After(most) => waited > most,
            // Reading the partner's processor time costs more than most waits last.
            Limit::Silence | Limit::Prompt if waited < SLICE_MAX => false,
            Limit::Silence | Limit::Prompt => {
                let window = window.get_or_insert_with(|| Window::new(wire.partner()));
                window.start.elapsed() > patience.silence
                    && (waited > patience.busy_limit || !window.renew_if_busy(wire.partner()))
            }
        };
        if over {
            return Err(LinkFault::Deadline {
                side: wire.partner().side().name(),
                frame,
                waited_s: waited.as_secs_f64(),
            });
        }
    }
}

/// A span of silence, and the partner's processor time at its start.
struct Window {
    start: Instant,
    cpu: Option<Duration>,
}

impl Window {
    fn new(watch: &impl Watch) -> Window {
        Window { start: Instant::now(), cpu: watch.cpu_time() }
    }

    /// Starts a new window when the partner computed during this one.
    fn renew_if_busy(&mut self, watch: &impl Watch) -> bool {
        let now = Window::new(watch);
        let busy = match (self.cpu, now.cpu) {
            (Some(before), Some(after)) => {
                let share =
                    after.saturating_sub(before).as_secs_f64() / self.start.elapsed().as_secs_f64();
                share > BUSY_SHARE
            }
            _ => false,
        };
        if busy {
            *self = now;
        }
        busy
    }
}
