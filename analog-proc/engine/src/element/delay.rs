//! Transport delay: the input's past, kept as polynomials under error control.
//!
//! An accepted step leaves one or more segments, each the polynomial of degree five
//! through the values and rates of the input at both ends and in the middle. Where
//! it does not meet the input at its quarters within tolerance, the segment is
//! halved ([`crate::operate`]). Segments never span an event. A breakpoint of the
//! input comes out one delay later as a stop instant, followed through
//! [`GENERATIONS`] passes round a loop: after that, integrations have smoothed it.

use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use crate::op::Term;
use crate::signal::{Rated, Signal};

/// How often one breakpoint is followed round a loop; equals the order of the
/// default method, since each pass through an integrator smooths it by one order.
const GENERATIONS: u8 = 5;

/// Values or rates that differ by more than this part of them make a jump or a corner; less
/// is what the tolerances leave.
const CORNER: f64 = 1e-6;

/// A segment shorter than so many roundings of its time is a straight line.
const SHORT: f64 = 4096.0;

/// Roundings of what a segment's divided differences are formed of.
const DIFFERENCES: f64 = 16.0;

/// A step passes over this many segments at most: each is as long as its input is smooth.
const SEGMENTS_A_STEP: usize = 4;

/// The input over a part of a step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Segment {
    t0_s: f64,
    h_s: f64,
    epoch: u32,
    /// Newton's divided differences over the places 0, 0, ½, ½, 1, 1 of the segment.
    c: [f64; 6],
    /// The rate, where the segment is too short to have one of its own.
    rate: Option<f64>,
    /// What rounding alone can have made of the input then.
    noise: f64,
}

impl Segment {
    /// The segment from `t0_s` on, `h_s` long, through the input at its start, middle and end.
    pub fn through(t0_s: f64, h_s: f64, [start, middle, end]: [Rated; 3]) -> Segment {
        let [d0, dm, d1] = [start, middle, end].map(|u| h_s * u.rate);
        if h_s <= SHORT * f64::EPSILON * t0_s.abs() {
            // Differences would tell of the rounding of time alone.
            return Segment {
                t0_s,
                h_s,
                epoch: 0,
                c: [start.value, end.value - start.value, 0.0, 0.0, 0.0, 0.0],
                rate: Some(start.rate),
                noise: 0.0,
            };
        }
        let (first, second) =
            (2.0 * (middle.value - start.value), 2.0 * (end.value - middle.value));
        let [a, b] = [2.0 * (first - d0), 2.0 * (dm - first)];
        let [c, d] = [2.0 * (second - dm), 2.0 * (d1 - second)];
        let [e, f, g] = [2.0 * (b - a), c - b, 2.0 * (d - c)];
        let [h, i] = [f - e, g - f];
        Segment {
            t0_s,
            h_s,
            epoch: 0,
            c: [start.value, d0, a, e, h, i - h],
            rate: None,
            noise: 0.0,
        }
    }

    /// The polynomial at the place `theta` of the segment.
    pub fn at<N: Signal>(&self, theta: N) -> N {
        let c = self.c.map(N::constant);
        let (from_middle, from_end) = (theta - N::constant(0.5), theta - N::constant(1.0));
        let high = c[3] + from_middle * (c[4] + from_end * c[5]);
        c[0] + theta * (c[1] + theta * (c[2] + from_middle * high))
    }

    fn end_s(&self) -> f64 {
        self.t0_s + self.h_s
    }
}

/// One delay line with its past.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DelayLine {
    pub input: Term,
    pub delay_s: f64,
    pub initial: f64,
    /// The greatest magnitude that the input has had.
    pub largest: f64,
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
            largest: 0.0,
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
    pub fn signal<N: Signal>(&self, t_s: f64) -> N {
        let s = t_s - self.delay_s;
        // Within a rounding of a jump the side of the present step is read.
        let slack_s = 8.0 * f64::EPSILON * t_s.abs();
        if self.reading == 0 && s <= slack_s {
            return N::constant(self.initial);
        }
        let Some(mut i) = self.find(s) else {
            let Some(first) = self.segments.front() else {
                return N::constant(self.initial);
            };
            return if s < -slack_s || s < first.t0_s - slack_s {
                N::constant(self.initial)
            } else {
                read(first, first.t0_s, t_s)
            };
        };
        let segment = &self.segments[i];
        if segment.epoch > self.reading && s - segment.t0_s <= slack_s && i > 0 {
            i -= 1;
        } else if segment.epoch < self.reading
            && segment.end_s() - s <= slack_s
            && i + 1 < self.segments.len()
        {
            i += 1;
        }
        // What is read beyond its ends by rounding of time is what holds at its ends.
        let segment = &self.segments[i];
        read(segment, s.clamp(segment.t0_s, segment.end_s().max(segment.t0_s)), t_s)
    }

    /// How far a step from `t_s` may go: what has been smooth when it went in comes out
    /// smooth, so the segments tell how long a step may be.
    pub fn reach_s(&self, t_s: f64) -> f64 {
        let Some(i) = self.find(t_s - self.delay_s) else {
            return f64::INFINITY;
        };
        let last = self.segments.get(i + SEGMENTS_A_STEP);
        last.map_or(f64::INFINITY, |segment| segment.t0_s + self.delay_s - t_s)
    }

    /// Stores the input over a part of an accepted step, known to within `doubt`: its rounding, and
    /// what the segment misses of it.
    pub fn store(&mut self, segment: Segment, doubt: f64) {
        let epoch = self.epoch.max(1);
        let noise = doubt + DIFFERENCES * f64::EPSILON * self.largest;
        self.segments.push_back(Segment { epoch, noise, ..segment });
    }

    /// Segments from here on lie behind an event.
    pub fn part(&mut self) {
        self.epoch += 1;
    }

    /// An event at `t_s`, as old as `generation` passes round a loop, at which the input went
    /// from `before` to `after`: a jump or a corner comes out as one, however often it was
    /// delayed.
    pub fn event(&mut self, t_s: f64, generation: u8, before: Rated, after: Rated) {
        let differ = |a: f64, b: f64| (a - b).abs() > CORNER * (a.abs() + b.abs());
        let generation = if differ(before.value, after.value) {
            0
        } else if differ(before.rate, after.rate) {
            generation.min(1)
        } else {
            generation
        };
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

/// The segment at the time `s` of its input, which comes out at `t_s`.
fn read<N: Signal>(segment: &Segment, s: f64, t_s: f64) -> N {
    let theta = (s - segment.t0_s) / segment.h_s;
    N::of_time(t_s, segment.at(theta), || {
        let moving = Rated { value: theta, rate: 1.0 / segment.h_s };
        segment.rate.unwrap_or_else(|| segment.at(moving).rate)
    })
    .blurred(segment.noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_reproduces_degree_five_with_its_rate() {
        // p(s) = 1 − 2 s + 3 s³ − s⁵ on [2, 3]: rounding of a few hundred in p.
        let p = |s: f64| Rated {
            value: 1.0 - 2.0 * s + 3.0 * s.powi(3) - s.powi(5),
            rate: -2.0 + 9.0 * s.powi(2) - 5.0 * s.powi(4),
        };
        let segment = Segment::through(2.0, 1.0, [p(2.0), p(2.5), p(3.0)]);
        for s in [2.0, 2.2, 2.5, 2.9, 3.0] {
            let found: Rated = read_rated(&segment, s);
            assert!((found.value - p(s).value).abs() < 1e-12 * 200.0, "{s}");
            assert!((found.rate - p(s).rate).abs() < 1e-11 * 200.0, "{s}");
        }
    }

    fn read_rated(segment: &Segment, s: f64) -> Rated {
        read(segment, s, s)
    }
}
