//! Instants known beforehand: timers, what comes out of delays, the fixed grid.

use interface::Tick;

use super::Engine;
use crate::element::source::Firing;

/// Instants closer to zero than this are resolved no finer than those at it, s.
pub(super) const LEAST_TIME_S: f64 = 1e-9;

/// About two units in the last place of `t_s`, s.
pub(super) fn resolution_s(t_s: f64) -> f64 {
    f64::EPSILON * t_s.abs().max(LEAST_TIME_S)
}

impl Engine {
    pub(super) fn fire_timers(&mut self) -> bool {
        let mut fired = false;
        for i in 0..self.machine.timers.len() {
            while self.frozen.timer_s[i] <= self.t_s {
                fired = true;
                let (slot, timer) = self.machine.timers[i];
                let n = self.frozen.timer_count[i];
                match timer.fire(n) {
                    Firing::Value(value) => self.nets[slot as usize] = value,
                    Firing::Started(wave) => self.frozen.started[wave as usize] = true,
                    Firing::Renew(noise) => {
                        self.nets[slot as usize] = self.frozen.noises[noise as usize].renew();
                    }
                }
                self.frozen.timer_count[i] = n + 1;
                // However short a period, time goes on between two firings.
                let least_s = self.t_s + resolution_s(self.t_s);
                self.frozen.timer_s[i] = timer.instant_s(n + 1).max(least_s);
            }
        }
        fired
    }

    /// The next instant that is known beforehand, s.
    pub(super) fn next_instant_s(&self) -> f64 {
        let timers = self.frozen.timer_s.iter().copied().fold(f64::INFINITY, f64::min);
        self.frozen.lines.iter().map(|line| line.next_s()).fold(timers, f64::min)
    }

    /// The next point of the fixed grid, a multiple of the step in whole ticks, s.
    pub(super) fn grid_s(&self) -> f64 {
        let step = Tick::from_secs(self.integration.step_s).map_or(1, |t| t.0.max(1));
        let mut n = (self.t_s * 1e9 / step as f64) as i64;
        loop {
            let next_s = Tick(step.saturating_mul(n)).secs();
            if next_s > self.t_s + resolution_s(self.t_s) || n == i64::MAX {
                return next_s;
            }
            n += 1;
        }
    }
}
