//! The wall clock of a free-running session.
//!
//! Samples n are published at `t_n · time scale` from the run's start, an absolute
//! deadline, so that lateness never adds up. Updates take effect at the instant
//! at which they arrive. Once every published frame is answered nothing more can
//! arrive before the next one, and the array may integrate ahead to it; as long
//! as an answer is out, it must wait for the clock.
//!
//! Problem time never skips: a machine that cannot keep up is late in wall time
//! only, and tells by how much. It then takes an answer for one that came at the
//! next instant to be sampled, and waits when [`FRAMES_AHEAD`] answers are out.
//! No wait is for ever and each looks at the partner every 20 ms.

use interface::{
    Tick,
    frame::{FRAMES_AHEAD, Updates},
    link::{FramePort, LinkFault},
    processor::Kept,
};
use rustix::{
    thread::{clock_nanosleep_absolute, sched_yield, set_current_timer_slack},
    time::{ClockId, Timespec, clock_gettime},
};
use std::num::NonZeroU64;

/// Before a deadline the wait ends its sleep by this, ns, and polls: a processor that has gone to
/// sleep may wake up by milliseconds late, on a virtual machine above all.
const AWAKE_BEFORE_NS: i64 = 2_000_000;
/// An answer that comes within this time, ns, is waited for by spinning …
const SPIN_AFTER_NS: i64 = 2_000;
/// … within this time by yielding the processor, later by naps.
const YIELD_AFTER_NS: i64 = 2_000_000;
/// A nap, ns.
const NAP_NS: i64 = 50_000;
/// Longest sleep, ns: a dead partner or an interrupt is noticed within it.
const LONGEST_SLEEP_NS: i64 = 20_000_000;
/// Timer slack of this thread while it runs, ns; the default of 50 µs is a tenth of a frame here.
const SLACK: Option<NonZeroU64> = NonZeroU64::new(1_000);

/// One run on the wall clock.
#[derive(Debug)]
pub struct FreeRun {
    time_scale: f64,
    /// Wall time of run time 0, ns of the monotonic clock.
    start_ns: i64,
    /// Wall time of the last publication, ns.
    published_ns: i64,
    /// Frames published so far.
    published: u64,
    /// The oldest frame that is not answered.
    unanswered: u64,
    _kept: Option<Kept>,
}

impl FreeRun {
    /// Starts the clock; a unit of problem time takes `time_scale` units of wall time.
    /// Both sides share `processor`, if there is one given.
    pub fn start(time_scale: f64, processor: Option<u32>) -> FreeRun {
        // Without it sleeps are coarser, which is told as lateness.
        let _ = set_current_timer_slack(SLACK);
        let now_ns = wall_ns();
        FreeRun {
            time_scale,
            start_ns: now_ns,
            published_ns: now_ns,
            published: 0,
            unanswered: 0,
            _kept: processor.and_then(Kept::on),
        }
    }

    /// The next updates to arrive before the clock reaches `until`, with the instant of
    /// their arrival; `None` when it has, or when none are out. Updates are waited for
    /// beyond it when too many are out.
    pub fn next_updates(
        &mut self,
        port: &mut dyn FramePort,
        until: Tick,
    ) -> Result<Option<(Tick, Updates)>, LinkFault> {
        while self.unanswered < self.published {
            let out = self.published - self.unanswered;
            let arrived = if out >= FRAMES_AHEAD {
                Some(port.await_updates(self.unanswered)?)
            } else {
                port.poll_updates(self.unanswered)?
            };
            let now = self.now();
            if let Some(updates) = arrived {
                self.unanswered = updates.frame + 1;
                return Ok(Some((now.min(until), updates)));
            }
            if now >= until {
                break;
            }
            let waited_ns = wall_ns() - self.published_ns;
            if waited_ns < SPIN_AFTER_NS {
                std::hint::spin_loop();
            } else if waited_ns < YIELD_AFTER_NS {
                sched_yield();
            } else {
                sleep_until(wall_ns() + NAP_NS.min(self.deadline_ns(until) - wall_ns()));
            }
        }
        Ok(None)
    }

    /// Waits until the clock reaches `instant`; gives updates that arrive meanwhile.
    pub fn await_instant(
        &mut self,
        port: &mut dyn FramePort,
        instant: Tick,
    ) -> Result<Option<Updates>, LinkFault> {
        let deadline_ns = self.deadline_ns(instant);
        loop {
            let now_ns = wall_ns();
            if now_ns >= deadline_ns {
                return Ok(None);
            }
            if let Some(updates) = port.poll_updates(self.unanswered)? {
                self.unanswered = updates.frame + 1;
                return Ok(Some(updates));
            }
            let sleep_ns = deadline_ns - AWAKE_BEFORE_NS - now_ns;
            if sleep_ns > 0 {
                sleep_until(now_ns + sleep_ns.min(LONGEST_SLEEP_NS));
            } else {
                sched_yield();
            }
        }
    }

    /// Notes that samples of `frame` go out now, due at `instant`; by how much they are late.
    pub fn published(&mut self, frame: u64, instant: Tick) -> Tick {
        self.published_ns = wall_ns();
        self.published = frame + 1;
        Tick((self.published_ns - self.deadline_ns(instant)).max(0))
    }

    /// Problem time now, to the nearest nanosecond.
    fn now(&self) -> Tick {
        let elapsed_ns = (wall_ns() - self.start_ns) as f64;
        // A float's cast saturates; a run would last 292 years.
        Tick((elapsed_ns / self.time_scale).round() as i64)
    }

    fn deadline_ns(&self, instant: Tick) -> i64 {
        let after_ns = (instant.0 as f64 * self.time_scale).round() as i64;
        self.start_ns.saturating_add(after_ns)
    }
}

impl Drop for FreeRun {
    fn drop(&mut self) {
        let _ = set_current_timer_slack(None);
    }
}

/// The monotonic clock, ns.
fn wall_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    // It counts from the start of the system.
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

/// Sleeps until an absolute time; a signal may end it early.
fn sleep_until(ns: i64) {
    let time =
        Timespec { tv_sec: ns.div_euclid(1_000_000_000), tv_nsec: ns.rem_euclid(1_000_000_000) };
    let _ = clock_nanosleep_absolute(ClockId::Monotonic, &time);
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::link::memory;

    #[test]
    fn the_clock_never_goes_before_its_deadline() {
        let (mut analog, _digital) = memory::pair();
        let mut free = FreeRun::start(2.0, None);
        let start_ns = wall_ns();
        let mut last = Tick::ZERO;
        for frame in 0..20 {
            let instant = Tick(500_000) * frame;
            assert_eq!(free.await_instant(&mut analog, instant).unwrap(), None);
            // Twice the problem time has passed; the clock was started before `start_ns`,
            // by less than it takes to come here.
            assert!(free.now() >= instant && free.now() >= last);
            last = free.now();
            assert!(free.published(frame as u64, instant) >= Tick::ZERO);
            free.unanswered = free.published;
        }
        assert!(wall_ns() - free.start_ns >= 2 * 19 * 500_000);
        assert!(start_ns >= free.start_ns);
        // Nothing is out: the array may integrate ahead.
        assert_eq!(free.next_updates(&mut analog, Tick(i64::MAX)).unwrap(), None);
    }

    #[test]
    fn a_partner_that_dies_ends_the_wait() {
        let (mut analog, digital) = memory::pair();
        drop(digital);
        let mut free = FreeRun::start(1.0, None);
        assert!(matches!(
            free.await_instant(&mut analog, Tick::SECOND * 3600),
            Err(LinkFault::PartnerDied { .. })
        ));
        free.published(0, Tick::ZERO);
        assert!(matches!(
            free.next_updates(&mut analog, Tick::SECOND * 3600),
            Err(LinkFault::PartnerDied { .. })
        ));
    }
}
