//! The paces of a running machine: which of them bounds the next step, and where.

use crate::element::delay::DelayLine;
use crate::machine::Machine;
use crate::signal::Rated;
use serde::{Deserialize, Serialize};

/// What is known of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Paces {
    /// The magnitude of each divisor, radicand or vector at the start of the step, and the greatest
    /// so far.
    sizes: Vec<f64>,
    largest: Vec<f64>,
    /// The longest step from here, s, and what bounds it.
    pub limit_s: f64,
    pub bounded_by: usize,
}

impl Paces {
    pub fn new(machine: &Machine) -> Paces {
        let zeros = || vec![0.0; machine.paces.len()];
        Paces { sizes: zeros(), largest: zeros(), limit_s: f64::INFINITY, bounded_by: 0 }
    }

    pub fn reset(&mut self) {
        self.largest.fill(0.0);
    }

    /// Whether vector `i` was at its origin at the start of the step.
    pub fn began_at_origin(&self, i: usize) -> bool {
        self.sizes[i] == 0.0
    }

    /// Finds the longest step from `t_s`.
    pub fn look(&mut self, machine: &Machine, lines: &[DelayLine], t_s: f64, nets: &[Rated]) {
        self.limit_s = f64::INFINITY;
        for (i, (pace, _)) in machine.paces.iter().enumerate() {
            self.sizes[i] = pace.size(nets);
            self.largest[i] = self.largest[i].max(self.sizes[i]);
            let limit_s = pace.limit_s(lines, t_s, nets, self.largest[i]);
            // What does not move has no bound, even where it is not defined.
            if limit_s < self.limit_s {
                (self.limit_s, self.bounded_by) = (limit_s, i);
            }
        }
    }

    /// The element of a vector that is at its origin as far as time is resolved, to
    /// `resolution_s`: of what bounds the step, where that is too short (`bounded`); else one that
    /// is about to pass.
    pub fn at_origin(
        &self,
        machine: &Machine,
        resolution_s: f64,
        nets: &[Rated],
        bounded: bool,
    ) -> Option<u32> {
        machine.paces.iter().enumerate().find_map(|(i, (pace, _))| {
            let causes = if bounded { i == self.bounded_by } else { pace.size(nets) > 0.0 };
            pace.at_origin(resolution_s, nets, self.largest[i]).filter(|_| causes)
        })
    }

    /// Whether the step of `h_s` between these nets hid nothing.
    pub fn kept(&mut self, machine: &Machine, h_s: f64, start: &[Rated], end: &[Rated]) -> bool {
        for (i, (pace, _)) in machine.paces.iter().enumerate() {
            if !pace.kept(h_s, start, end, self.largest[i]) {
                self.bounded_by = i;
                return false;
            }
        }
        true
    }
}
