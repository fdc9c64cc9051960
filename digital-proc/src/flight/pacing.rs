//! How well a free-running flight kept to the wall clock.
//!
//! A frame overruns when its work is not done within it: its updates have not
//! taken effect when the next samples are due. Samples published a whole frame
//! late are told as such too, so that the last frame, which has no updates, is
//! judged as the others are. Nothing is lost by it: problem time never skips.
//!
//! Samples that go out late by less are no overrun, as their own instant is right
//! whatever the clock says; they shorten the time left for the updates. That
//! jitter is told beside the overruns.

use interface::{
    Tick,
    frame::{RunState, Samples},
};

/// Samples later than this part of a frame are counted as late in the account of the jitter.
const JITTER_PARTS: i64 = 10;

/// What was late, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Late {
    /// Samples, after their deadline by the wall clock.
    Samples(Tick),
    /// Updates, after the samples that they were to precede; `None` when they never took effect.
    Updates(Option<Tick>),
}

/// One overrun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrun {
    pub frame: u64,
    pub late: Late,
}

/// The pacing of one flight, frame by frame.
#[derive(Clone, Debug)]
pub struct Pacing {
    frame: Tick,
    /// Frames that expected updates, and those that did not (the last).
    frames: u64,
    /// The next frame whose transfer is to be told.
    unanswered: u64,
    latencies: Vec<Tick>,
    lateness: Vec<Tick>,
    overruns: Vec<Overrun>,
}

impl Pacing {
    pub fn new(frame: Tick) -> Pacing {
        Pacing {
            frame,
            frames: 0,
            unanswered: 0,
            latencies: Vec::new(),
            lateness: Vec::new(),
            overruns: Vec::new(),
        }
    }

    pub fn observe(&mut self, samples: &Samples) {
        self.frames += 1;
        for transfer in samples.transfers() {
            self.unanswered = transfer.frame + 1;
            let sampled = self.frame * transfer.frame as i64;
            let latency = transfer.tick - sampled;
            self.latencies.push(latency);
            if latency >= self.frame {
                let late = Late::Updates(Some(latency - self.frame));
                self.overruns.push(Overrun { frame: transfer.frame, late });
            }
        }
        self.lateness.push(samples.late);
        if samples.late >= self.frame {
            self.overruns.push(Overrun { frame: samples.frame, late: Late::Samples(samples.late) });
        }
        if samples.run_state() == RunState::Ended {
            // Updates of the last full frame may be cut off by the stop, within their time;
            // those of earlier ones came too late to take effect.
            let cut_off = samples.tick - self.frame;
            for frame in self.unanswered..samples.frame {
                if self.frame * frame as i64 <= cut_off {
                    let late = Late::Updates(None);
                    self.overruns.push(Overrun { frame, late });
                }
            }
        }
    }

    /// By how much samples went out after their deadline, a frame each, in order.
    pub fn lateness(&self) -> &[Tick] {
        &self.lateness
    }

    /// A tenth of a frame, and the frames whose samples were later than that.
    pub fn jitter(&self) -> (Tick, usize) {
        let margin = Tick(self.frame.0 / JITTER_PARTS);
        (margin, self.lateness.iter().filter(|by| **by > margin).count())
    }

    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// From sample to transfer, a frame each, in order.
    pub fn latencies(&self) -> &[Tick] {
        &self.latencies
    }

    /// Every overrun in the order in which it was told.
    pub fn overruns(&self) -> &[Overrun] {
        &self.overruns
    }

    /// Frames with an overrun of either kind.
    pub fn frames_overrun(&self) -> u64 {
        let mut frames: Vec<u64> = self.overruns.iter().map(|o| o.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        frames.len() as u64
    }
}

/// The time that `part` (0 to 1) of `times` do not exceed; `None` without any.
pub fn quantile(times: &[Tick], part: f64) -> Option<Tick> {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let last = sorted.len().checked_sub(1)?;
    sorted.get((part.clamp(0.0, 1.0) * last as f64).ceil() as usize).copied()
}

impl std::fmt::Display for Overrun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let frame = self.frame;
        match self.late {
            Late::Samples(by) => write!(f, "frame {frame}: samples {by} late"),
            Late::Updates(Some(Tick::ZERO)) => {
                write!(f, "frame {frame}: updates not before the next samples")
            }
            Late::Updates(Some(by)) => write!(f, "frame {frame}: updates {by} late"),
            Late::Updates(None) => write!(f, "frame {frame}: updates not there before the stop"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::frame::Transfer;

    #[test]
    fn overruns_of_both_kinds_are_told_once_each() {
        let period = Tick(1_000);
        let mut pacing = Pacing::new(period);
        let mut tell = |frame: u64, state, late: i64, transfers: &[(u64, i64)]| {
            let mut samples = Samples::new(frame, period * frame as i64, state);
            samples.late = Tick(late);
            for (slot, &(frame, tick)) in samples.transfers.iter_mut().zip(transfers) {
                let tick = Tick(tick);
                *slot = Transfer { frame, tick };
                samples.transfer_count += 1;
            }
            pacing.observe(&samples);
        };
        tell(0, RunState::Operate, 999, &[]);
        tell(1, RunState::Operate, 1_000, &[(0, 250)]);
        tell(2, RunState::Operate, 0, &[]);
        tell(3, RunState::Operate, 0, &[(1, 2_300), (2, 2_400)]);
        tell(4, RunState::Operate, 0, &[]);
        tell(5, RunState::Ended, 0, &[]);
        let frames: Vec<(u64, Late)> =
            pacing.overruns().iter().map(|o| (o.frame, o.late)).collect();
        assert_eq!(
            frames,
            [
                (1, Late::Samples(Tick(1_000))),
                (1, Late::Updates(Some(Tick(300)))),
                (3, Late::Updates(None)),
                (4, Late::Updates(None)),
            ]
        );
        assert_eq!(pacing.frames_overrun(), 3);
        assert_eq!(quantile(pacing.latencies(), 0.5), Some(Tick(400)));
        assert_eq!(quantile(pacing.latencies(), 1.0), Some(Tick(1_300)));
        assert_eq!(quantile(pacing.lateness(), 1.0), Some(Tick(1_000)));
        assert_eq!(pacing.jitter(), (Tick(100), 2));
    }
}
