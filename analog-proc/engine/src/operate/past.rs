//! What goes into the delay lines: the inputs over an accepted step, as polynomials that
//! meet them within tolerance.

use super::Engine;
use crate::element::delay::Segment;
use crate::signal::{Doubted, Rated};

/// Halvings of a step; a corner that is none of a region (the root of zero) ends there.
const MOST_HALVINGS: u32 = 8;

/// A relative tolerance below rounding asks for nothing more.
const LEAST_RTOL: f64 = 1e-14;

impl Engine {
    /// Looks at all inputs at the place `theta` of the step; the place of the first in `past`.
    fn take_in(&mut self, theta: f64) -> usize {
        self.rate_at(theta);
        let first = self.past.len();
        let inputs = self.frozen.lines.iter().map(|line| line.input);
        self.past.extend(inputs.map(|input| input.of(&self.rated)));
        first
    }

    /// Stores the inputs over the step.
    pub(super) fn store_delays(&mut self) {
        self.past.clear();
        let ends = [0.0, 0.5, 1.0].map(|theta| self.take_in(theta));
        self.doubt(false, 1.0);
        self.store_part(0.0, 1.0, ends, MOST_HALVINGS);
    }

    fn store_part(&mut self, from: f64, to: f64, at: [usize; 3], halvings: u32) {
        let width = to - from;
        let quarters = [0.25, 0.75].map(|part| self.take_in(from + part * width));
        let t0_s = self.step.t0_s + from * self.step.h_s;
        let h_s = width * self.step.h_s;
        let tolerance = self.integration.rtol.max(LEAST_RTOL);
        let mut met = true;
        self.missed.clear();
        for (i, line) in self.frozen.lines.iter_mut().enumerate() {
            let segment = Segment::through(t0_s, h_s, at.map(|first| self.past[first + i]));
            let inputs = at.iter().chain(&quarters);
            let inputs = inputs.map(|first| self.past[first + i].value.abs());
            line.largest = inputs.fold(line.largest, f64::max);
            let misses =
                |theta: f64, first: usize| (segment.at(theta) - self.past[first + i].value).abs();
            let missed = misses(0.25, quarters[0]).max(misses(0.75, quarters[1]));
            let misses_it = missed > tolerance * line.largest;
            met &= !misses_it;
            self.missed.push(missed);
        }
        if met || halvings == 0 {
            for (i, line) in self.frozen.lines.iter_mut().enumerate() {
                let nodes: [Rated; 3] = at.map(|first| self.past[first + i]);
                let input: Doubted = line.input.of(&self.doubted);
                line.store(Segment::through(t0_s, h_s, nodes), input.doubt + 2.0 * self.missed[i]);
            }
            return;
        }
        let (middle, [start, half, end]) = (from + 0.5 * width, at);
        self.store_part(from, middle, [start, quarters[0], half], halvings - 1);
        self.store_part(middle, to, [half, quarters[1], end], halvings - 1);
    }
}
