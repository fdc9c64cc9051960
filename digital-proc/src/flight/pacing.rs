//! How well a free-running flight kept to the wall clock.
//!
//! Two things can be late: samples, published after their deadline because the
//! array was not there yet, and updates, arriving after the next samples because
//! the digital side was not. Both are overruns, counted frame by frame. Neither
//! loses anything: problem time never skips.

use interface::{
    Tick,
    frame::{RunState, Samples},
};
use serde_json::{Value, json};

/// Samples published later than this part of a frame after their deadline are an
/// overrun: below a tenth of a frame, lateness is the timer's and the sample's
/// own instant is right whatever it is.
pub const MARGIN_PARTS: i64 = 10;

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
    /// Frame number.
    pub frame: u64,
    /// What was late.
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
    overruns: Vec<Overrun>,
}

impl Pacing {
    /// For frames of this period.
    #[must_use]
    pub fn new(frame: Tick) -> Pacing {
        Pacing {
            frame,
            frames: 0,
            unanswered: 0,
            latencies: Vec::new(),
            overruns: Vec::new(),
        }
    }

    /// Takes in one frame.
    pub fn observe(&mut self, samples: &Samples) {
        self.frames += 1;
        for transfer in samples.transfers() {
            self.unanswered = transfer.frame + 1;
            let sampled = self.frame * transfer.frame as i64;
            let latency = transfer.tick - sampled;
            self.latencies.push(latency);
            if latency >= self.frame {
                let late = Late::Updates(Some(latency - self.frame));
                self.overruns.push(Overrun {
                    frame: transfer.frame,
                    late,
                });
            }
        }
        if samples.late > self.margin() {
            self.overruns.push(Overrun {
                frame: samples.frame,
                late: Late::Samples(samples.late),
            });
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

    /// Lateness of samples from which on it counts.
    #[must_use]
    pub fn margin(&self) -> Tick {
        Tick(self.frame.0 / MARGIN_PARTS)
    }

    /// Frames so far.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// From sample to transfer, a frame each, in order.
    #[must_use]
    pub fn latencies(&self) -> &[Tick] {
        &self.latencies
    }

    /// Every overrun in the order in which it was told.
    #[must_use]
    pub fn overruns(&self) -> &[Overrun] {
        &self.overruns
    }

    /// Frames with an overrun of either kind.
    #[must_use]
    pub fn frames_overrun(&self) -> u64 {
        let mut frames: Vec<u64> = self.overruns.iter().map(|o| o.frame).collect();
        frames.sort_unstable();
        frames.dedup();
        frames.len() as u64
    }

    /// The latency that `part` (0 to 1) of the frames do not exceed; `None` without any.
    #[must_use]
    pub fn latency_quantile(&self, part: f64) -> Option<Tick> {
        let mut sorted = self.latencies.clone();
        sorted.sort_unstable();
        let last = sorted.len().checked_sub(1)?;
        sorted
            .get((part.clamp(0.0, 1.0) * last as f64).ceil() as usize)
            .copied()
    }

    /// For machines: counts, quantiles of the latency in seconds, and every overrun.
    #[must_use]
    pub fn json(&self) -> Value {
        let quantile = |part| self.latency_quantile(part).map(Tick::secs);
        let overruns: Vec<Value> = self
            .overruns
            .iter()
            .map(|overrun| match overrun.late {
                Late::Samples(by) => {
                    json!({"frame": overrun.frame, "late": "samples", "by_s": by.secs()})
                }
                Late::Updates(by) => {
                    json!({"frame": overrun.frame, "late": "updates", "by_s": by.map(Tick::secs)})
                }
            })
            .collect();
        json!({
            "frames": self.frames,
            "frames_overrun": self.frames_overrun(),
            "margin_s": self.margin().secs(),
            "latency_median_s": quantile(0.5),
            "latency_99_percent_s": quantile(0.99),
            "latency_max_s": quantile(1.0),
            "overruns": overruns,
        })
    }
}

impl std::fmt::Display for Overrun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let frame = self.frame;
        match self.late {
            Late::Samples(by) => write!(f, "frame {frame}: samples {by} late"),
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
        tell(0, RunState::Operate, 100, &[]);
        tell(1, RunState::Operate, 101, &[(0, 250)]);
        tell(2, RunState::Operate, 0, &[]);
        tell(3, RunState::Operate, 0, &[(1, 2_300), (2, 2_400)]);
        tell(4, RunState::Operate, 0, &[]);
        tell(5, RunState::Ended, 0, &[]);
        let frames: Vec<(u64, Late)> = pacing
            .overruns()
            .iter()
            .map(|o| (o.frame, o.late))
            .collect();
        assert_eq!(
            frames,
            [
                (1, Late::Samples(Tick(101))),
                (1, Late::Updates(Some(Tick(300)))),
                (3, Late::Updates(None)),
                (4, Late::Updates(None)),
            ]
        );
        assert_eq!(pacing.frames_overrun(), 3);
        assert_eq!(pacing.latency_quantile(0.5), Some(Tick(400)));
        assert_eq!(pacing.latency_quantile(1.0), Some(Tick(1_300)));
        assert_eq!(pacing.json()["overruns"].as_array().unwrap().len(), 4);
    }
}
