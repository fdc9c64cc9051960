//! Logic that stores: flip-flop, one-shot, counter, and the interrupt lines that
//! watch edges. They act after all memoryless logic of an instant, all at once: each
//! looks at the levels of before any of them has switched.

use crate::op::Slot;
use serde::{Deserialize, Serialize};

/// One storing element and the net it drives.
#[derive(Clone, Copy, Debug)]
pub enum Store {
    FlipFlop { o: Slot, set: Slot, reset: Slot },
    OneShot { o: Slot, input: Slot, width_s: f64, timer: u32 },
    Counter { o: Slot, clock: Slot, reset: Option<Slot>, modulo: u32 },
    Interrupt { input: Slot, line: u32 },
}

/// An edge on an interrupt line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// Line.
    pub line: u32,
    /// Rising or falling.
    pub rising: bool,
    /// Located problem time, s.
    pub t_s: f64,
}

impl Store {
    /// Acts on the logic as it now stands: the output and its new value, where it changes.
    /// `previous` is its input at the last settling.
    pub fn act(
        &self,
        previous: &mut f64,
        timer_s: &mut [f64],
        nets: &[f64],
        (t_s, initial): (f64, bool),
        edges: &mut Vec<Edge>,
    ) -> Option<(Slot, f64)> {
        let input = match *self {
            Store::FlipFlop { set, .. } => set,
            Store::OneShot { input, .. } | Store::Interrupt { input, .. } => input,
            Store::Counter { clock, .. } => clock,
        };
        let level = nets[input as usize] != 0.0;
        let was = *previous != 0.0;
        *previous = f64::from(level);
        let rising = level && !was && !initial;
        let (o, value) = match *self {
            Store::FlipFlop { o, set, reset } => {
                let reset = nets[reset as usize] != 0.0;
                let set = nets[set as usize] != 0.0;
                let value = if reset {
                    0.0
                } else if set {
                    1.0
                } else {
                    return None;
                };
                (o, value)
            }
            Store::OneShot { o, width_s, timer, .. } => {
                if !rising {
                    return None;
                }
                timer_s[timer as usize] = t_s + width_s;
                (o, 1.0)
            }
            Store::Counter { o, reset, modulo, .. } => {
                let mut count = nets[o as usize];
                if rising {
                    count += 1.0;
                    if modulo > 0 && count >= f64::from(modulo) {
                        count = 0.0;
                    }
                }
                if reset.is_some_and(|r| nets[r as usize] != 0.0) {
                    count = 0.0;
                }
                (o, count)
            }
            Store::Interrupt { line, .. } => {
                if level != was && !initial {
                    edges.push(Edge { line, rising: level, t_s });
                }
                return None;
            }
        };
        (nets[o as usize] != value).then_some((o, value))
    }
}
