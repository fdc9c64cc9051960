//! Mode control of single integrators: operate, hold, reset, feedback-diode limits.

use crate::op::{Slot, Term};
use crate::signal::Signal;

/// An integrator with mode control or limits.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    pub state: u32,
    pub operate: Option<Slot>,
    pub reset: Option<Slot>,
    pub reset_to: Option<Term>,
    /// The element that holds the limits' region.
    pub stops: Option<u32>,
}

impl Control {
    /// Applies the logic as it now stands; `before` are the nets before this pass, `previous`
    /// the reset level of the last settling, `free` whether no stop holds the output. Whether
    /// the state moved, and whether it runs.
    pub fn apply(
        &self,
        ics: &[f64],
        (previous, free): (&mut f64, bool),
        before: &[f64],
        nets: &mut [f64],
        initial: bool,
    ) -> (bool, bool) {
        let mut moved = false;
        let resetting = self.reset.is_some_and(|s| nets[s as usize] != 0.0);
        let edge = resetting && *previous == 0.0 && !initial;
        *previous = f64::from(resetting);
        if edge {
            let state = self.state as usize;
            let target = self.reset_to.map_or(ics[state], |term| term.of(before));
            moved = nets[state] != target;
            nets[state] = target;
        }
        let operating = self.operate.is_none_or(|s| nets[s as usize] != 0.0);
        (moved, operating && !resetting && free)
    }
}

/// Feedback-diode limits: the output rests on a limit while the input drives outward.
#[derive(Clone, Copy, Debug)]
pub struct Stops {
    pub state: u32,
    pub rate: Term,
    pub low: f64,
    pub high: f64,
}

impl Stops {
    pub const FREE: u32 = 1;
    const LOW: u32 = 0;
    const HIGH: u32 = 2;

    pub fn sides<N: Signal>(&self, region: u32, nets: &[N], put: &mut impl FnMut(N)) {
        let y = nets[self.state as usize];
        match region {
            Self::LOW => put(self.rate.of(nets)),
            Self::HIGH => put(-self.rate.of(nets)),
            _ => {
                put(y - N::constant(self.high));
                put(N::constant(self.low) - y);
            }
        }
    }

    pub fn choose(&self, nets: &[f64]) -> u32 {
        let y = nets[self.state as usize];
        let rate = self.rate.of(nets);
        if y > self.high || (y == self.high && rate > 0.0) {
            Self::HIGH
        } else if y < self.low || (y == self.low && rate < 0.0) {
            Self::LOW
        } else {
            Self::FREE
        }
    }

    /// Where the state must stand in a region.
    pub fn stand(&self, region: u32) -> Option<f64> {
        match region {
            Self::LOW => Some(self.low),
            Self::HIGH => Some(self.high),
            _ => None,
        }
    }
}
