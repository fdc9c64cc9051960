//! Tolerances that know the size of what they measure.
//!
//! The absolute tolerance of a state is `atol` times its `max`, or, where its block
//! states none, times the greatest magnitude that it has had; so an oscillation of a
//! millionth is followed as well as one of a million. How large a state will be that has
//! only grown so far is not known: until it turns back it is measured by a small part
//! of the greatest net, no more than one, where it is smaller than that.

use super::Engine;
use crate::integrate::Step;

/// Part of the greatest net that a state without a size of its own is measured by.
const FLOOR: f64 = 1e-8;

/// Roundings of the greatest net, as a rate, that a step's error may come of.
const GRAIN: f64 = 1e3;

/// A state has decayed to nothing where it is no larger than so many tolerances.
const FADED: f64 = 1e4;

impl Engine {
    /// Takes the size of the states at the start or end of a step.
    pub(super) fn size_up(&mut self, at_start: bool) {
        let y = if at_start { &self.step.y0 } else { &self.step.y1 };
        let mut changed = at_start;
        let sizes = self.largest.iter_mut().zip(&mut self.turned);
        for ((largest, turned), y) in sizes.zip(y) {
            if y.abs() > *largest {
                *largest = y.abs();
                changed = true;
            } else if y.abs() < *largest && !*turned {
                *turned = true;
                changed = true;
            }
        }
        let counts = changed && self.machine.scales.contains(&None);
        if !counts && !at_start {
            return;
        }
        let unscaled = |(scale, turned): (&Option<f64>, &bool)| scale.is_none() && !turned;
        if self.machine.scales.iter().zip(&self.turned).any(unscaled) {
            self.greatest = self.greatest.max(self.greatest_net());
        }
        let floor = if self.greatest > 0.0 { (FLOOR * self.greatest).min(1.0) } else { 1.0 };
        let atol = self.integration.atol;
        let sizes = self.largest.iter().zip(&self.turned);
        let states = self.machine.scales.iter().zip(sizes).zip(&self.grain);
        for (place, ((scale, (largest, turned)), grain)) in self.atol.iter_mut().zip(states) {
            let own = if *turned { *largest } else { largest.max(floor) };
            *place = (atol * scale.unwrap_or(own)).max(*grain);
        }
    }

    /// The greatest magnitude of a net as they stand.
    pub(super) fn greatest_net(&self) -> f64 {
        self.nets.iter().fold(0.0_f64, |most, x| most.max(x.abs()))
    }

    /// After a step was refused for its error: where a shorter one erred as much, within what
    /// rounding can do, that error is not to be asked for less.
    pub(super) fn find_grain(&mut self, error: f64, former: &mut Option<(usize, f64, f64)>) {
        let (worst, h_s) = (self.step.worst, self.step.h_s);
        let own = error * (self.atol[worst] + self.integration.rtol * self.step.y0[worst].abs());
        if let Some((was_worst, was_h_s, was)) = former.replace((worst, h_s, own))
            && was_worst == worst
            && own > was * (h_s / was_h_s).powi(2)
            && own <= GRAIN * f64::EPSILON * self.greatest_net() * h_s
        {
            self.grain[worst] = 4.0 * own;
            self.atol[worst] = self.atol[worst].max(4.0 * own);
        }
    }

    /// Back to the initial condition.
    pub(super) fn forget_sizes(&mut self) {
        self.largest.fill(0.0);
        self.turned.fill(false);
        self.grain.fill(0.0);
        self.greatest = 0.0;
    }

    /// States whose error was judged by the absolute tolerance alone: they stayed so small
    /// beside their `max`, or the other nets, that their own digits were not asked for.
    pub fn unresolved(&self) -> impl Iterator<Item = usize> {
        let rtol = self.integration.rtol;
        let states = self.largest.iter().zip(&self.atol).enumerate();
        states.filter_map(move |(i, (largest, atol))| {
            (*largest > 0.0 && rtol * largest < *atol).then_some(i)
        })
    }

    /// Whether a state stays below its tolerance over the step and does not just pass through zero:
    /// then not even its sign is known.
    pub(super) fn is_sunk(&self, i: usize) -> bool {
        let (Step { y0, y1, f0, .. }, atol) = (&self.step, self.atol[i]);
        y0[i].abs().max(y1[i].abs()) < atol && (f0[i] * self.t_s).abs() < FADED * atol
    }

    /// States that have decayed to where their absolute tolerance counts, and stay there.
    pub fn faded(&self) -> impl Iterator<Item = usize> {
        let rates = self.step.y0.iter().zip(&self.step.f0);
        let states = rates.zip(&self.atol).zip(&self.largest).enumerate();
        states.filter_map(|(i, (((y, f), atol), largest))| {
            let least = FADED * atol;
            let stays = y.abs() < least && (f * self.t_s).abs() < FADED * least;
            (*y != 0.0 && stays && least < *largest).then_some(i)
        })
    }
}
