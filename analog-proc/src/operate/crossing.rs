//! Where within a step a side first crosses its surface, to the last representable instant.
//!
//! The search ([`super::search`]) brackets the earliest crossing on the dense output.
//! It is narrowed there first, then by steps of the method itself.

use super::Engine;
use super::instants::resolution_s;
use super::search::{END, START};
use super::watch::is_beyond;
use crate::event::fatal;
use crate::fault::RunFault;

/// Probes of one bracketing: bisection alone needs 60, every fourth probe bisects.
const PROBES: usize = 250;

impl Engine {
    /// The sides at a node; what is beyond its surface by rounding alone is at it.
    fn margins_at(&self, node: usize, margins: &mut [f64]) {
        let node = &self.nodes[node];
        let sides = node.sides.iter().zip(&self.nodes[END].noise);
        for (margin, (side, noise)) in margins.iter_mut().zip(sides) {
            let is_noise = side.value > 0.0 && !is_beyond(*side, *noise);
            *margin = if is_noise { 0.0 } else { side.value };
        }
    }

    /// Sides at `t_s`, into `margins`; true where a surface is crossed.
    fn crossed_at(&mut self, t_s: f64, by_steps: bool) -> bool {
        if by_steps {
            self.attempt(t_s - self.t_s);
            self.rate_end();
        } else {
            self.rate_at((t_s - self.step.t0_s) / self.step.h_s);
        }
        self.look_at_sides(END, 1.0);
        let mut margins = std::mem::take(&mut self.margins);
        self.margins_at(END, &mut margins);
        self.margins = margins;
        self.margins.iter().any(|g| *g > 0.0)
    }

    /// The end of the step as events have it: `None` where nothing is crossed; else
    /// the end, and the element that is left there (none, if the step is merely cut).
    /// The step, and what is watched of it, then end there.
    pub(super) fn find_crossing(
        &mut self,
        end_s: f64,
    ) -> Result<Option<(f64, Option<u32>)>, RunFault> {
        let start_s = self.t_s;
        let h_s = end_s - start_s;
        self.look_at_sides(END, 1.0);
        let Some((low, high)) = self.exclude(h_s)? else {
            return Ok(None);
        };
        let place = |node: usize| start_s + self.nodes[node].theta * h_s;
        let low_s = place(low);
        let mut high_s = if high == END { end_s } else { place(high) };
        let mut margins = std::mem::take(&mut self.margins_low);
        self.margins_at(low, &mut margins);
        self.margins_low = margins;
        let mut margins = std::mem::take(&mut self.margins_high);
        self.margins_at(high, &mut margins);
        self.margins_high = margins;
        let (_, guess_s) = self.narrow(low_s, high_s, 1e-6 * h_s, false);
        let mut margins = std::mem::take(&mut self.margins_low);
        self.margins_at(START, &mut margins);
        self.margins_low = margins;
        if !self.crossed_at(high_s, true) {
            // The dense output saw what the method does not confirm: the step is cut
            // there and goes on from its true value.
            return Ok(Some((high_s, None)));
        }
        std::mem::swap(&mut self.margins, &mut self.margins_high);
        let mut low_s = start_s;
        let mut last_s = high_s;
        if guess_s > low_s && guess_s < high_s {
            last_s = guess_s;
            if self.crossed_at(guess_s, true) {
                high_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
            } else {
                low_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
            }
        }
        let (probed_s, located_s) = self.narrow(low_s, high_s, resolution_s(high_s), true);
        if let Some(probed_s) = probed_s {
            last_s = probed_s;
        }
        if last_s != located_s {
            self.crossed_at(located_s, true);
        }
        let mut first = None;
        for (margin, e) in self.margins_high.iter().zip(&self.machine.element_of_side) {
            if *margin > 0.0 {
                let (block, piecewise) = self.machine.elements[*e as usize];
                if let Some(fault) = piecewise.fatal() {
                    return Err(fatal(&self.machine, block, fault, located_s));
                }
                first = first.or(Some(*e));
            }
        }
        Ok(Some((located_s, first)))
    }

    /// Narrows a bracket whose lower end is not crossed (`margins_low`) and whose upper
    /// end is (`margins_high`) to `width_s`: the Illinois form of false position on the
    /// earliest side, with a bisection every fourth time. Returns the last instant
    /// probed and the upper end.
    fn narrow(
        &mut self,
        mut low_s: f64,
        mut high_s: f64,
        width_s: f64,
        by_steps: bool,
    ) -> (Option<f64>, f64) {
        let (mut weight_low, mut weight_high, mut side) = (1.0, 1.0, 0);
        let mut probed = None;
        for probe in 0..PROBES {
            if high_s - low_s <= width_s {
                break;
            }
            let mut t_s = 0.5 * (low_s + high_s);
            if probe % 4 != 3 {
                let mut earliest_s = high_s;
                for (low, high) in self.margins_low.iter().zip(&self.margins_high) {
                    if *high > 0.0 {
                        let (low, high) = (weight_low * low.min(0.0), weight_high * high);
                        let root_s = low_s + (high_s - low_s) * (low / (low - high));
                        if root_s < earliest_s {
                            earliest_s = root_s;
                        }
                    }
                }
                t_s = earliest_s.clamp(low_s + 0.5 * width_s, high_s - 0.5 * width_s);
            }
            if !(t_s > low_s && t_s < high_s) {
                break;
            }
            probed = Some(t_s);
            if self.crossed_at(t_s, by_steps) {
                high_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
                weight_high = 1.0;
                weight_low = if side == 1 { 0.5 * weight_low } else { 1.0 };
                side = 1;
            } else {
                low_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
                weight_low = 1.0;
                weight_high = if side == -1 { 0.5 * weight_high } else { 1.0 };
                side = -1;
            }
        }
        (probed, high_s)
    }
}
