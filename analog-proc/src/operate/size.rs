//! Tolerances that know the size of what they measure.
//!
//! The absolute tolerance of a state is `atol` times its `max`, or, where its block
//! states none, times the greatest magnitude that it has had; so an oscillation of a
//! millionth is followed as well as one of a million. A state that has stood near zero
//! beside the others is measured by a small part of the largest of them, no more than
//! one: how large it will be is not known as yet.

use super::Engine;

/// Part of the largest state that a state without a size of its own is measured by.
const FLOOR: f64 = 1e-8;

impl Engine {
    /// Takes the size of the states at the start (`initial`) or end of a step.
    pub(super) fn size_up(&mut self, at_start: bool) {
        let y = if at_start {
            &self.step.y0
        } else {
            &self.step.y1
        };
        let mut grown = at_start;
        for (largest, y) in self.largest.iter_mut().zip(y) {
            if y.abs() > *largest {
                *largest = y.abs();
                grown = true;
            }
        }
        if !grown {
            return;
        }
        let greatest = self.largest.iter().copied().fold(0.0, f64::max);
        let floor = if greatest > 0.0 {
            (FLOOR * greatest).min(1.0)
        } else {
            1.0
        };
        let atol = self.integration.atol;
        let scales = self.machine.scales.iter().zip(&self.largest);
        for (place, (scale, largest)) in self.atol.iter_mut().zip(scales) {
            *place = atol * scale.unwrap_or(largest.max(floor));
        }
    }

    /// States whose error was judged by the absolute tolerance alone: they stayed so small
    /// beside their `max`, or the other states, that their own digits were not asked for.
    pub fn unresolved(&self) -> impl Iterator<Item = usize> {
        let rtol = self.integration.rtol;
        let states = self.largest.iter().zip(&self.atol).enumerate();
        states.filter_map(move |(i, (largest, atol))| {
            (*largest > 0.0 && rtol * largest < *atol).then_some(i)
        })
    }
}
