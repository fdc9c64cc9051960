//! Where within a step a witness first crosses its surface.
//!
//! A finished step is looked at in its middle, where a witness's parabola comes
//! nearest to its surface, and at its end. The earliest crossing is bracketed,
//! first on the dense output, then by steps of the method itself, down to the
//! last representable instant.

use super::Engine;
use super::instants::resolution_s;
use crate::event::fatal;
use crate::fault::RunFault;
use crate::machine::Machine;

/// Probes of one bracketing: bisection alone needs 60, every fourth probe bisects.
const PROBES: usize = 250;

impl Engine {
    fn witness(&self, nets: &[f64], margins: &mut [f64]) {
        let Machine {
            watched,
            levels,
            elements,
            ..
        } = &self.machine;
        let region = &self.frozen.region;
        let (of_elements, of_levels) = margins.split_at_mut(watched.len() - levels.len());
        for (margin, e) in of_elements.iter_mut().zip(watched) {
            let e = *e as usize;
            *margin = elements[e].1.margin(region[e], &self.machine, nets);
        }
        for (margin, watch) in of_levels.iter_mut().zip(levels) {
            *margin = watch.margin(region[watch.element as usize], nets);
        }
    }

    pub(super) fn witness_low(&mut self) {
        let mut margins = std::mem::take(&mut self.margins_low);
        self.witness(&self.nets, &mut margins);
        self.margins_low = margins;
    }

    /// Margins at `t_s`, into `margins`; true where a surface is crossed.
    fn crossed_at(&mut self, t_s: f64, by_steps: bool) -> bool {
        if by_steps {
            self.attempt(t_s - self.t_s);
            self.complete(t_s);
        } else {
            self.look_at_witnesses((t_s - self.step.t0_s) / self.step.h_s);
        }
        let mut margins = std::mem::take(&mut self.margins);
        self.witness(
            if by_steps { &self.nets } else { &self.probe },
            &mut margins,
        );
        self.margins = margins;
        self.margins.iter().any(|g| *g > 0.0)
    }

    /// The end of the step as events have it: `None` where nothing is crossed; else
    /// the end, and the element that is left there (none, if the step is merely cut).
    pub(super) fn find_crossing(
        &mut self,
        end_s: f64,
    ) -> Result<Option<(f64, Option<u32>)>, RunFault> {
        let start_s = self.t_s;
        let h_s = end_s - start_s;
        let mut at_end = std::mem::take(&mut self.margins_high);
        self.witness(&self.nets, &mut at_end);
        self.margins_high = at_end;
        let crossed_at_end = self.margins_high.iter().any(|g| *g > 0.0);
        let middle_s = start_s + 0.5 * h_s;
        let mut high_s = end_s;
        let mut by_dense = false;
        if h_s > 4.0 * resolution_s(end_s) {
            if self.crossed_at(middle_s, false) {
                high_s = middle_s;
                by_dense = true;
            } else if let Some(theta) = self.nearest_approach() {
                let t_s = start_s + theta * h_s;
                if self.crossed_at(t_s, false) {
                    high_s = t_s;
                    by_dense = true;
                }
            }
        }
        if !crossed_at_end && !by_dense {
            std::mem::swap(&mut self.margins_low, &mut self.margins_high);
            return Ok(None);
        }
        self.margins_start.copy_from_slice(&self.margins_low);
        if by_dense {
            std::mem::swap(&mut self.margins, &mut self.margins_high);
        }
        let (_, guess_s) = self.narrow(start_s, high_s, 1e-6 * h_s, false);
        self.margins_low.copy_from_slice(&self.margins_start);
        if !self.crossed_at(high_s, true) {
            // The dense output saw what the method does not confirm: the step is cut
            // there and goes on from its true value.
            self.witness_low();
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
        let crossed = self.margins_high.iter().position(|g| *g > 0.0);
        let element = crossed.map(|i| self.machine.watched[i]);
        if let Some(e) = element {
            let (block, piecewise) = self.machine.elements[e as usize];
            if let Some(fault) = piecewise.fatal() {
                return Err(fatal(&self.machine, block, fault, located_s));
            }
        }
        Ok(Some((located_s, element)))
    }

    /// Where the parabola of a witness through start, middle and end rises above its
    /// surface, if one does: the place of a graze. The middle is in `margins`.
    fn nearest_approach(&self) -> Option<f64> {
        // A parabola rises above the greatest of its three points by an eighth of their
        // second difference at most: nearly every witness is done with here.
        let near = |((low, middle), high): ((&f64, &f64), &f64)| {
            let rise = (0.125 * (2.0 * middle - low - high)).max(0.0);
            low.max(*middle).max(*high) + rise > 0.0
        };
        let witnesses = self.margins_low.iter().zip(&self.margins);
        if !witnesses.zip(&self.margins_high).any(near) {
            return None;
        }
        let mut best: Option<(f64, f64)> = None;
        for ((low, middle), high) in self
            .margins_low
            .iter()
            .zip(&self.margins)
            .zip(&self.margins_high)
        {
            let bend = 2.0 * (low - 2.0 * middle + high);
            if bend >= 0.0 || bend.is_nan() {
                continue;
            }
            let slope = 4.0 * middle - 3.0 * low - high;
            let theta = -slope / (2.0 * bend);
            let peak = low + 0.5 * slope * theta;
            if theta > 0.0 && theta < 1.0 && peak > 0.0 && best.is_none_or(|b| theta < b.1) {
                best = Some((peak, theta));
            }
        }
        best.map(|b| b.1)
    }

    /// Narrows a bracket whose lower end is not crossed (`margins_low`) and whose upper
    /// end is (`margins_high`) to `width_s`: the Illinois form of false position on the
    /// earliest witness, with a bisection every fourth time. Returns the last instant
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
