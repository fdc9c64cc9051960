//! Where within an accepted step a surface may be crossed, if anywhere.
//!
//! A side with its rates at both ends of an interval has a cubic between them. In
//! Bernstein's form its coefficients bound it; so does, with the bulge
//! 16 E θ²(1 − θ)² of an error estimate E, the side itself. Where all coefficients
//! are not positive, nothing is crossed. Else the interval is halved: what the cubic
//! misses in the middle is the estimate for the halves, until each is free of
//! crossings or has one side that rises through zero once. The estimate for the whole
//! step costs nothing: it is the change of the third derivative since the step before.
//! (Bernstein coefficients: Farin, Curves and Surfaces for CAGD, chapter 5.)
//!
//! What rounding could have made is no excursion: intervals are not halved below it.

use super::Engine;
use super::instants::resolution_s;
use crate::fault::RunFault;
use crate::signal::Rated;

/// The nodes at the ends of a step; those inside follow.
pub(super) const START: usize = 0;
pub(super) const END: usize = 1;

/// Places looked at within a step before it counts as one that cannot be followed.
const MOST_PROBES: u32 = 5000;

/// Cuts on end.
const MOST_CUTS: u32 = 1000;

/// For a quartic the change of the third derivative over two neighbouring steps, in units of
/// the step, is at least 32 times the greatest error of the cubic; a quarter of it is taken.
const CHANGE: f64 = 0.125;

/// The bulge's only Bernstein coefficient, of degree four, in units of the error in the middle.
const BULGE: f64 = 16.0 / 6.0;

/// A divisor within so many roundings of zero, over the shortest interval, is zero.
const NEAR_ZERO: f64 = 64.0;

/// Divisions at turns before those in the middle.
const TURN_DEPTH: usize = 4;

/// The least part of an interval that is divided off.
const LEAST_PART: f64 = 0.02;

/// Halvings before the rounding at the ends of an interval is taken for that within it.
const NOISE_DEPTH: usize = 6;

/// What is known of an interval.
enum Verdict {
    Clear,
    /// A side rises through zero once, and no other does before it turns back.
    Crossed,
    /// Of this side it cannot be told.
    Unknown(usize),
}

/// Coefficients of degree four of the cubic over an interval of length `h`, without the
/// bulge: c0 to c4.
#[inline(always)]
fn bernstein(a: Rated, b: Rated, h: f64) -> [f64; 5] {
    let (d0, d1) = (h * a.rate, h * b.rate);
    let middle = 0.5 * (a.value + b.value) + (d0 - d1) / 6.0;
    [a.value, a.value + 0.25 * d0, middle, b.value - 0.25 * d1, b.value]
}

/// A sixth of the third derivative of the cubic, times `h` cubed.
#[inline(always)]
fn third(a: Rated, b: Rated, h: f64) -> f64 {
    2.0 * (a.value - b.value) + h * (a.rate + b.rate)
}

/// Coefficients of x, x² and x³ of the cubic over an interval of length `h`, x from 0 to 1.
pub(super) fn cubic(a: Rated, b: Rated, h: f64) -> [f64; 3] {
    let (d0, d1) = (h * a.rate, h * b.rate);
    let rise = b.value - a.value;
    [d0, 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise]
}

/// The part of an interval at which the cubic over it turns, or near it; a maximum first.
fn turn(a: Rated, b: Rated, h: f64) -> Option<f64> {
    let [d0, c2, c3] = cubic(a, b, h);
    let root = (c2 * c2 - 3.0 * c3 * d0).sqrt();
    // Of d0 + 2 c2 x + 3 c3 x²: the slope falls through the first of the zeros, rises through
    // the second.
    let q = -(c2 + root.copysign(c2));
    let [falls, rises] = if c2 < 0.0 { [d0 / q, q / (3.0 * c3)] } else { [q / (3.0 * c3), d0 / q] };
    let within = |x: &f64| *x > 0.0 && *x < 1.0;
    let place = [falls, rises].into_iter().find(within)?;
    Some(place.clamp(LEAST_PART, 1.0 - LEAST_PART))
}

impl Engine {
    /// The nodes between which the first crossing of the step lies, the crossing by
    /// then at the later one; `None` where the step crosses nothing.
    pub(super) fn exclude(&mut self, h_s: f64) -> Result<Option<(usize, usize)>, RunFault> {
        self.probes = 0;
        let (start, end) = (&self.nodes[START].sides, &self.nodes[END].sides);
        let cube = h_s * h_s * h_s;
        let scale = cube / self.former_cube;
        // Nearly every step is done with here: one pass without branches. What is undefined is
        // not clear.
        let mut clear = true;
        let thirds = self.thirds.iter_mut().zip(&self.former_thirds);
        for ((a, b), (now, former)) in start.iter().zip(end).zip(thirds) {
            *now = third(*a, *b, h_s);
            let bulge = BULGE * CHANGE * (*now - scale * former).abs();
            let [c0, c1, c2, c3, c4] = bernstein(*a, *b, h_s);
            clear &= (c0 <= 0.0) & (c1 <= 0.0) & (c2 + bulge <= 0.0) & (c3 <= 0.0) & (c4 <= 0.0);
        }
        if clear && self.followed && self.machine.smooth {
            return Ok(None);
        }
        self.active.clear();
        let errors = &mut self.errors[0];
        for (i, (&a, &b)) in start.iter().zip(end).enumerate() {
            errors[i] = CHANGE * (self.thirds[i] - scale * self.former_thirds[i]).abs();
            let coefficients = bernstein(a, b, h_s);
            let clear = coefficients.iter().all(|c| *c <= 0.0)
                && coefficients[2] + BULGE * errors[i] <= 0.0
                && self.machine.halvings[i] == 0;
            if !(clear && self.followed) {
                self.active.push(i as u32);
            }
        }
        if self.active.is_empty() {
            return Ok(None);
        }
        // Where a side is beyond its surface and returns, rounding tells whether it was crossed.
        for node in [START, END] {
            let sheet = |i| self.machine.is_sheet(i);
            if self.has_active(node, |i, side| side.value > 0.0 && (side.rate < 0.0 || sheet(i))) {
                self.find_noise(node);
            }
        }
        if self.followed {
            match self.verdict(START, END, 0, h_s) {
                Verdict::Clear => return Ok(None),
                Verdict::Crossed => return Ok(Some((START, END))),
                Verdict::Unknown(side) => return self.split(START, END, 0, h_s, Some(side)),
            }
        }
        self.split(START, END, 0, h_s, None)
    }

    /// The rounding at both ends of the whole step.
    pub(super) fn find_noise_of_ends(&mut self) {
        self.find_noise(START);
        if !self.nodes[END].doubted {
            self.rate_end();
            self.find_noise(END);
        }
    }

    /// Divides an interval of which too little is known, of `side` perhaps: where that turns, as
    /// far as its cubic tells, else in the middle.
    fn split(
        &mut self,
        a: usize,
        b: usize,
        depth: usize,
        h_s: f64,
        side: Option<usize>,
    ) -> Result<Option<(usize, usize)>, RunFault> {
        self.probes += 1;
        if self.probes > MOST_PROBES {
            return Err(self.not_followed());
        }
        let middle = END + 1 + depth;
        if self.nodes.len() <= middle {
            let node = self.nodes[END].clone();
            self.nodes.push(node);
            self.errors.push(self.errors[0].clone());
        }
        if depth + 1 == NOISE_DEPTH {
            self.find_noise_of_ends();
        }
        let width_s = h_s * (self.nodes[b].theta - self.nodes[a].theta);
        let side = side.filter(|_| depth < TURN_DEPTH);
        let turn = side.and_then(|i| turn(self.nodes[a].sides[i], self.nodes[b].sides[i], width_s));
        let part = turn.unwrap_or(0.5);
        let theta = (1.0 - part) * self.nodes[a].theta + part * self.nodes[b].theta;
        self.rate_at(theta);
        self.look_at_sides(middle, theta);
        if depth + 1 >= NOISE_DEPTH || self.has_active(middle, |_, side| side.value > 0.0) {
            self.find_noise(middle);
        }
        // The bulge of the error, and its slope, at the place of division.
        let (rest, bulge) = (1.0 - part, 16.0 * (part * (1.0 - part)).powi(2));
        for &i in &self.active {
            let i = i as usize;
            let [low, mid, high] = [a, middle, b].map(|n| self.nodes[n].sides[i]);
            let (d0, d1) = (width_s * low.rate, width_s * high.rate);
            let value = rest * rest * ((1.0 + 2.0 * part) * low.value + part * d0)
                + part * part * ((1.0 + 2.0 * rest) * high.value - rest * d1);
            let slope = 6.0 * part * rest * (high.value - low.value)
                + rest * (1.0 - 3.0 * part) * d0
                + part * (3.0 * part - 2.0) * d1;
            let missed = (width_s * mid.rate - slope).abs();
            self.errors[depth + 1][i] = (mid.value - value).abs().max(0.25 * missed) / bulge;
        }
        for (low, high) in [(a, middle), (middle, b)] {
            match self.verdict(low, high, depth + 1, h_s) {
                Verdict::Clear => {}
                Verdict::Crossed => return Ok(Some((low, high))),
                Verdict::Unknown(side) => {
                    let width_s = h_s * (self.nodes[high].theta - self.nodes[low].theta);
                    let least_s = 4.0 * resolution_s(self.t_s + h_s);
                    if width_s <= least_s {
                        self.refuse_touch(low, high)?;
                        if self.is_crossed(high) {
                            return Ok(Some((low, high)));
                        }
                    } else if let Some(found) = self.split(low, high, depth + 1, h_s, Some(side))? {
                        return Ok(Some(found));
                    }
                }
            }
        }
        Ok(None)
    }

    fn has_active(&self, node: usize, is: impl Fn(usize, Rated) -> bool) -> bool {
        let sides = &self.nodes[node].sides;
        self.active.iter().map(|i| *i as usize).any(|i| is(i, sides[i]))
    }

    fn is_crossed(&self, node: usize) -> bool {
        let mut active = self.active.iter();
        active.any(|&i| self.is_side_crossed(i as usize, node))
    }

    /// Whether a side is beyond its surface at a node, between the ends of the step by more
    /// than its rounding.
    fn is_side_crossed(&self, i: usize, node: usize) -> bool {
        let at = &self.nodes[node];
        let (side, noise) = (at.sides[i], at.noise[i]);
        self.machine.is_beyond(i, side, noise) && (node <= END || side.value > noise)
    }

    /// A divisor that cannot be told from zero in an interval as short as time resolves ends
    /// the run, though it does not change its sign.
    fn refuse_touch(&self, a: usize, b: usize) -> Result<(), RunFault> {
        for &i in &self.active {
            let i = i as usize;
            let touches = |node: usize| {
                let at = &self.nodes[node];
                at.sides[i].value >= -NEAR_ZERO * at.noise[i]
            };
            let element = self.machine.element_of_side[i];
            let (block, piecewise) = self.machine.elements[element as usize];
            if piecewise.fatal().is_some() && touches(a) && touches(b) {
                let t_s = self.t_s + self.nodes[b].theta * self.step.h_s;
                return Err(RunFault::TooQuick { t_s, block: self.machine.block_name(block) });
            }
        }
        Ok(())
    }

    fn is_fatal(&self, side: usize) -> bool {
        let element = self.machine.element_of_side[side];
        self.machine.elements[element as usize].1.fatal().is_some()
    }

    fn verdict(&self, a: usize, b: usize, depth: usize, h_s: f64) -> Verdict {
        let width_s = h_s * (self.nodes[b].theta - self.nodes[a].theta);
        let mut crossed = false;
        for &i in &self.active {
            let i = i as usize;
            if depth < usize::from(self.machine.halvings[i]) {
                return Verdict::Unknown(i);
            }
            let (low, high) = (self.nodes[a].sides[i], self.nodes[b].sides[i]);
            let [c0, c1, c2, c3, c4] = bernstein(low, high, width_s);
            let bulge = BULGE * self.errors[depth][i];
            let inside = c1.max(c2 + bulge).max(c3);
            let within = if depth < NOISE_DEPTH || self.is_fatal(i) {
                0.0
            } else {
                // One of them is known: it was looked at this deep.
                let known = [a, b].map(|node| &self.nodes[node]).into_iter();
                let known = known.filter(|node| node.doubted);
                // Between ends that are just within it there may be as much again.
                2.0 * known.map(|node| node.noise[i]).fold(f64::INFINITY, f64::min)
            };
            let is_number = (inside + bulge).is_finite();
            let [at_start, at_end] = [a, b].map(|node| self.is_side_crossed(i, node));
            if !at_start && inside <= within && !at_end && is_number {
                continue;
            }
            let rising = at_end && c1 >= c0 && c2 - bulge >= c1 && c3 >= c2 + bulge && c4 >= c3;
            if !rising {
                return Verdict::Unknown(i);
            }
            crossed = true;
        }
        if crossed { Verdict::Crossed } else { Verdict::Clear }
    }

    /// After a step was accepted, `cut` if it was not searched as it is now: its end is the
    /// start of the next.
    pub(super) fn follow(&mut self, cut: bool) {
        let h_s = self.step.h_s;
        if cut {
            let (start, end) = (&self.nodes[START].sides, &self.nodes[END].sides);
            for (place, (a, b)) in self.thirds.iter_mut().zip(start.iter().zip(end)) {
                *place = third(*a, *b, h_s);
            }
        }
        std::mem::swap(&mut self.thirds, &mut self.former_thirds);
        self.former_cube = h_s * h_s * h_s;
        self.nodes.swap(START, END);
        self.nodes[START].theta = 0.0;
        self.nodes[END].theta = 1.0;
        self.followed = true;
    }

    /// Steps on end that were cut where the dense output crosses a surface and the method does
    /// not: beyond some, the output tells nothing of the solution.
    pub(super) fn count_cuts(&mut self, cut: bool) -> Result<(), RunFault> {
        self.cuts = if cut { self.cuts + 1 } else { 0 };
        if self.cuts > MOST_CUTS {
            return Err(self.not_followed());
        }
        Ok(())
    }

    fn not_followed(&self) -> RunFault {
        let side = self.active.first().map_or(0, |i| *i as usize);
        let element = self.machine.element_of_side[side];
        let (block, _) = self.machine.elements[element as usize];
        RunFault::NotFollowed { t_s: self.t_s, block: self.machine.block_name(block) }
    }
}
