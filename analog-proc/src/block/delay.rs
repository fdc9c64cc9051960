//! Transport delay: the input's past, kept as one polynomial a step.
//!
//! After each step the input is stored at five equidistant points; between
//! them it is the quartic through them, error O(h⁵), the order of the default
//! method's dense output. Segments never span an event. A breakpoint of the
//! input comes out one delay later as a stop instant, followed through
//! [`GENERATIONS`] passes round a loop: after that, integrations have smoothed it.

use std::collections::VecDeque;

use crate::op::Term;

/// How often one breakpoint is followed round a loop; equals the order of the
/// default method, since each pass through an integrator smooths it by one order.
const GENERATIONS: u8 = 5;

/// Points of one segment.
pub(crate) const POINTS: usize = 5;

#[derive(Clone, Copy, Debug)]
struct Segment {
    t0_s: f64,
    h_s: f64,
    epoch: u32,
    u: [f64; POINTS],
}

impl Segment {
    fn at(&self, t_s: f64) -> f64 {
        let x = 4.0 * (t_s - self.t0_s) / self.h_s;
        let [a, b, c, d, e] = self.u;
        // Newton's forward differences over the five equidistant points.
        let d1 = b - a;
        let d2 = c - 2.0 * b + a;
        let d3 = d - 3.0 * c + 3.0 * b - a;
        let d4 = e - 4.0 * d + 6.0 * c - 4.0 * b + a;
        a + x * (d1 + (x - 1.0) / 2.0 * (d2 + (x - 2.0) / 3.0 * (d3 + (x - 3.0) / 4.0 * d4)))
    }
}

/// One delay line with its past.
#[derive(Clone, Debug)]
pub(crate) struct DelayLine {
    pub input: Term,
    pub delay_s: f64,
    pub initial: f64,
    segments: VecDeque<Segment>,
    breakpoints: VecDeque<(f64, u8)>,
    epoch: u32,
    reading: u32,
}

impl DelayLine {
    pub fn new(input: Term, delay_s: f64, initial: f64) -> DelayLine {
        DelayLine {
            input,
            delay_s,
            initial,
            segments: VecDeque::with_capacity(256),
            breakpoints: VecDeque::with_capacity(16),
            epoch: 0,
            reading: 0,
        }
    }

    /// Fixes which side of a jump is read while the step `[t_s, t_s + h_s]` is under way.
    pub fn aim(&mut self, t_s: f64, h_s: f64) {
        let middle_s = t_s + 0.5 * h_s - self.delay_s;
        while self.segments.len() > 1 && self.segments[1].t0_s <= t_s - self.delay_s - h_s.abs() {
            self.segments.pop_front();
        }
        self.reading = if middle_s < 0.0 {
            0
        } else {
            self.find(middle_s).map_or(0, |i| self.segments[i].epoch)
        };
    }

    fn find(&self, s: f64) -> Option<usize> {
        let after = self.segments.partition_point(|g| g.t0_s <= s);
        after.checked_sub(1)
    }

    /// The delayed value at `t_s`.
    pub fn read(&self, t_s: f64) -> f64 {
        let s = t_s - self.delay_s;
        // Within a rounding of a jump the side of the present step is read.
        let slack_s = 8.0 * f64::EPSILON * t_s.abs();
        if self.reading == 0 && s <= slack_s {
            return self.initial;
        }
        let Some(mut i) = self.find(s) else {
            let Some(first) = self.segments.front() else {
                return self.initial;
            };
            return if s < -slack_s || s < first.t0_s - slack_s {
                self.initial
            } else {
                first.at(first.t0_s)
            };
        };
        let segment = &self.segments[i];
        if segment.epoch > self.reading && s - segment.t0_s <= slack_s && i > 0 {
            i -= 1;
        } else if segment.epoch < self.reading
            && segment.t0_s + segment.h_s - s <= slack_s
            && i + 1 < self.segments.len()
        {
            i += 1;
        }
        self.segments[i].at(s)
    }

    /// Stores the input over an accepted step.
    pub fn store(&mut self, t0_s: f64, h_s: f64, u: [f64; POINTS]) {
        let epoch = self.epoch.max(1);
        self.segments.push_back(Segment {
            t0_s,
            h_s,
            epoch,
            u,
        });
    }

    /// An event at `t_s`, as old as `generation` passes.
    pub fn event(&mut self, t_s: f64, generation: u8) {
        self.epoch += 1;
        if generation < GENERATIONS {
            let due = (t_s + self.delay_s, generation + 1);
            if self.breakpoints.back().is_none_or(|last| last.0 < due.0) {
                self.breakpoints.push_back(due);
            }
        }
    }

    /// The next instant at which a breakpoint comes out, s.
    pub fn next_s(&self) -> f64 {
        self.breakpoints.front().map_or(f64::INFINITY, |b| b.0)
    }

    /// Takes the breakpoints due by `t_s`; the least generation among them.
    pub fn take_due(&mut self, t_s: f64) -> Option<u8> {
        let mut generation = None;
        while self.next_s() <= t_s {
            let due = self.breakpoints.pop_front().map(|b| b.1);
            generation = match (generation, due) {
                (Some(a), Some(b)) => Some(u8::min(a, b)),
                (a, b) => a.or(b),
            };
        }
        generation
    }
}
