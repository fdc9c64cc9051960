//! Where within a step a side first crosses its surface, to the last representable instant.
//!
//! The search ([`super::search`]) brackets the earliest crossing on the dense output.
//! It is narrowed there first, then by steps of the method itself.

use super::Engine;
use super::instants::resolution_s;
use super::search::{END, START, cubic};
use crate::event::fatal;
use crate::fault::RunFault;
use crate::signal::Rated;

/// Probes of one bracketing: bisection alone needs 60, every fourth probe bisects.
const PROBES: usize = 250;

/// A probe is laid beyond the expected crossing by this part of what the expectation moved last:
/// the next lies before it, and both ends of the bracket close in.
const BEYOND: f64 = 0.01;

/// Iterations for the root of a cubic: what it leaves open, the next probe does not.
const ROOT_ITERATIONS: usize = 12;

/// The place between 0 and 1 where the cubic through `low` ≤ 0 and `high` > 0, with their rates
/// over an interval of `h`, rises through zero: Newton's method, halving where that leaves the
/// bracket.
fn root_of_cubic(low: Rated, high: Rated, h: f64) -> f64 {
    let [d0, c2, c3] = cubic(low, high, h);
    let (mut from, mut to) = (0.0, 1.0);
    let mut x = (-low.value / (high.value - low.value)).clamp(0.0, 1.0);
    for _ in 0..ROOT_ITERATIONS {
        let value = low.value + x * (d0 + x * (c2 + x * c3));
        if value > 0.0 {
            to = x;
        } else {
            from = x;
        }
        let next = x - value / (d0 + x * (2.0 * c2 + x * 3.0 * c3));
        let next = if next > from && next < to { next } else { 0.5 * (from + to) };
        if (next - x).abs() <= 4.0 * f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

/// How a step ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ending {
    /// Nothing is crossed.
    Whole,
    /// It is cut at this instant, where nothing was crossed after all.
    Cut(f64),
    /// The same, where what seemed to cross rests on its surface as far as rounding tells.
    Rest(f64),
    /// At this instant an element leaves its region.
    Crossed(f64, u32),
    /// The method failed at a shorter step than the one accepted.
    Failed,
}

impl Engine {
    /// The sides at a node; what is beyond its surface by rounding alone is at it.
    fn margins_at(&self, node: usize, margins: &mut [Rated]) {
        let node = &self.nodes[node];
        let sides = node.sides.iter().zip(&self.nodes[END].noise);
        for (margin, (side, noise)) in margins.iter_mut().zip(sides) {
            // The rounding of the step's end says nothing of what rises long before it.
            let is_noise = side.value > 0.0 && side.rate < 0.0 && side.value <= *noise;
            *margin = Rated { value: if is_noise { 0.0 } else { side.value }, rate: side.rate };
        }
    }

    /// Sides at `t_s`, into `margins`; whether a surface is crossed, `None` where the method
    /// does not get there.
    fn crossed_at(&mut self, t_s: f64, by_steps: bool) -> Option<bool> {
        if by_steps {
            if !self.attempt(t_s - self.t_s).is_finite() {
                return None;
            }
            self.rate_end();
        } else {
            self.rate_at((t_s - self.step.t0_s) / self.step.h_s);
        }
        self.look_at_sides(END, 1.0);
        let mut margins = std::mem::take(&mut self.margins);
        self.margins_at(END, &mut margins);
        self.margins = margins;
        Some(self.margins.iter().any(|g| g.value > 0.0))
    }

    /// Where the step to `end_s` ends by its events. The step, and what is watched of it, then
    /// end there.
    pub(super) fn find_crossing(&mut self, end_s: f64) -> Result<Ending, RunFault> {
        let start_s = self.t_s;
        let h_s = end_s - start_s;
        self.look_at_sides(END, 1.0);
        let Some((low, high)) = self.exclude(h_s)? else {
            if self.probes > 0 {
                // The search has looked elsewhere.
                self.rate_end();
            }
            return Ok(Ending::Whole);
        };
        self.find_noise_of_ends();
        let place = |node: usize| start_s + self.nodes[node].theta * h_s;
        let low_s = place(low);
        let high_s = if high == END { end_s } else { place(high) };
        let [mut low_margins, mut high_margins] =
            [&mut self.margins_low, &mut self.margins_high].map(std::mem::take);
        self.margins_at(low, &mut low_margins);
        self.margins_at(high, &mut high_margins);
        (self.margins_low, self.margins_high) = (low_margins, high_margins);
        self.locate(low_s, high_s, h_s).unwrap_or(Ok(Ending::Failed))
    }

    /// Whether a side that the dense output saw crossed is at its surface as far as rounding
    /// tells.
    fn is_at_surface(&self) -> bool {
        let sides = self.nodes[END].sides.iter().zip(&self.nodes[END].noise);
        let mut seen = sides.zip(&self.margins_high).filter(|(_, seen)| seen.value > 0.0);
        seen.any(|((side, noise), _)| side.value.abs() <= *noise)
    }

    /// Locates the crossing between `low_s` and `high_s` on the dense output of a step of `h_s`
    /// first, then by steps; `None` where the method fails.
    fn locate(&mut self, low_s: f64, high_s: f64, h_s: f64) -> Option<Result<Ending, RunFault>> {
        let (_, guess_s) = self.narrow(low_s, high_s, low_s, 1e-6 * h_s, false)?;
        let mut margins = std::mem::take(&mut self.margins_low);
        self.margins_at(START, &mut margins);
        self.margins_low = margins;
        if !self.crossed_at(high_s, true)? {
            // The dense output saw what the method does not confirm: the step is cut
            // there and goes on from its true value.
            let ending = if self.is_at_surface() { Ending::Rest } else { Ending::Cut };
            return Some(Ok(ending(high_s)));
        }
        std::mem::swap(&mut self.margins, &mut self.margins_high);
        let (mut low_s, mut high_s) = (self.t_s, high_s);
        let mut last_s = high_s;
        if guess_s > low_s && guess_s < high_s {
            last_s = guess_s;
            if self.crossed_at(guess_s, true)? {
                high_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
            } else {
                low_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
            }
        }
        let least_s = resolution_s(high_s);
        let (probed_s, located_s) = self.narrow(low_s, high_s, guess_s, least_s, true)?;
        if probed_s.unwrap_or(last_s) != located_s {
            self.crossed_at(located_s, true)?;
        }
        let mut first = None;
        for (margin, e) in self.margins_high.iter().zip(&self.machine.element_of_side) {
            if margin.value > 0.0 {
                let (block, piecewise) = self.machine.elements[*e as usize];
                if let Some(fault) = piecewise.fatal() {
                    return Some(Err(fatal(&self.machine, block, fault, located_s)));
                }
                first = first.or(Some(*e));
            }
        }
        Some(
            Ok(first.map_or(Ending::Cut(located_s), |element| Ending::Crossed(located_s, element))),
        )
    }

    /// The earliest crossing between `low_s` (`margins_low`) and `high_s` (`margins_high`) by the
    /// cubics of the sides.
    fn expected_s(&self, low_s: f64, high_s: f64) -> f64 {
        let h_s = high_s - low_s;
        let pairs = self.margins_low.iter().zip(&self.margins_high);
        let risen = pairs.filter(|(_, high)| high.value > 0.0);
        let places = risen.map(|(low, high)| {
            let low = Rated { value: low.value.min(0.0), rate: low.rate };
            root_of_cubic(low, *high, h_s)
        });
        low_s + h_s * places.fold(1.0, f64::min)
    }

    /// Whether rounding alone is left between the ends of the bracket, of the one side that is
    /// crossed.
    fn is_level(&self) -> bool {
        let margins = self.margins_low.iter().zip(&self.margins_high);
        let mut crossed =
            margins.zip(&self.nodes[END].noise).filter(|((_, high), _)| high.value > 0.0);
        let level = |((low, high), noise): ((&Rated, &Rated), &f64)| {
            -low.value <= *noise && high.value <= *noise
        };
        crossed.next().is_some_and(level) && crossed.next().is_none()
    }

    /// Narrows a bracket whose lower end is not crossed (`margins_low`) and whose upper
    /// end is (`margins_high`) to `width_s`, or to rounding, by the cubics through both ends, with
    /// a bisection every fourth time; `former_s` is where the crossing was expected before.
    /// Returns the last instant probed and the upper end; `None` where the method fails.
    fn narrow(
        &mut self,
        mut low_s: f64,
        mut high_s: f64,
        mut former_s: f64,
        width_s: f64,
        by_steps: bool,
    ) -> Option<(Option<f64>, f64)> {
        let mut probed = None;
        let mut was_crossed = false;
        for probe in 0..PROBES {
            if high_s - low_s <= width_s || by_steps && self.is_level() {
                break;
            }
            let mut t_s = 0.5 * (low_s + high_s);
            if probe % 4 != 3 {
                let expected_s = self.expected_s(low_s, high_s);
                let moved_s = (expected_s - former_s).abs();
                let beyond_s = (BEYOND * moved_s).max(0.5 * width_s);
                former_s = expected_s;
                t_s = if was_crossed { expected_s - beyond_s } else { expected_s + beyond_s };
                t_s = t_s.clamp(low_s + 0.5 * width_s, high_s - 0.5 * width_s);
            }
            if !(t_s > low_s && t_s < high_s) {
                break;
            }
            probed = Some(t_s);
            was_crossed = self.crossed_at(t_s, by_steps)?;
            if was_crossed {
                high_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
            } else {
                low_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
            }
        }
        Some((probed, high_s))
    }
}
