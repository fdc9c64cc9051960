//! Settling an instant: logic, regions, resets and stores, to a fixed point.
//!
//! A pass evaluates every block in order and lets each element choose its region
//! from the values as they are; after it, all storing elements act at once on
//! what the pass found, whatever their order in the patch: each looks at the logic of
//! before any of them has switched. Resets take the values of before the pass. Passes
//! repeat until nothing moves; a bound turns a race into a fault. Locating the
//! instant is the simulation's part.
//!
//! The arguments of square roots are judged only at rest: what guards a root, a
//! limiter or a stop, turns at the instant at which the argument reaches zero.

use crate::element::integrator::Stops;
use crate::element::logic::Edge;
use crate::element::piecewise::{Fatal, Piecewise};
use crate::fault::RunFault;
use crate::id::BlockId;
use crate::machine::{Frozen, Machine, Settle};
use crate::op::Op;
use crate::overload::LatchedOverload;
use serde::{Deserialize, Serialize};

/// Passes beyond one for each store: room for chains through switches and limits.
const SPARE_PASSES: usize = 64;

/// Interrupt edges kept until they are taken: a run whose edges nobody takes must not grow.
const MOST_EDGES: usize = 65_536;

/// What a settling reports.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Happenings {
    pub edges: Vec<Edge>,
    pub overloads: Vec<LatchedOverload>,
    /// Elements that jump and left their first region, though they may have come back to it.
    pub switched: Vec<u32>,
}

impl Happenings {
    /// Drops the older half of the edges when there are more than are kept; how many went.
    pub fn drop_oldest_edges(&mut self) -> u64 {
        if self.edges.len() <= MOST_EDGES {
            return 0;
        }
        let excess = self.edges.len() - MOST_EDGES / 2;
        self.edges.drain(..excess);
        excess as u64
    }
}

pub(crate) fn fatal(machine: &Machine, block: BlockId, fatal: Fatal, t_s: f64) -> RunFault {
    let block = machine.block_name(block);
    match fatal {
        Fatal::DividedByZero => RunFault::DividedByZero { block, t_s },
        Fatal::NegativeRoot => RunFault::NegativeRoot { block, t_s },
    }
}

impl Machine {
    /// Brings every net, region and store to rest at `t_s`.
    #[allow(clippy::too_many_arguments, reason = "the parts of the running state, borrowed apart")]
    pub(crate) fn settle(
        &self,
        f: &mut Frozen,
        ics: &[f64],
        t_s: f64,
        nets: &mut [f64],
        before: &mut [f64],
        initial: bool,
        happenings: &mut Happenings,
    ) -> Result<(), RunFault> {
        let bound = SPARE_PASSES + 2 * (self.stores.len() + self.controls.len());
        let (mut movers, mut switched) = (Vec::new(), Vec::new());
        // Corners take rounding for rest; below a root even that counts.
        let mut sharp = false;
        for pass in 0..bound {
            before.copy_from_slice(nets);
            let last = pass + 1 == bound;
            let (mut moved, negative) = self.pass(f, t_s, nets, sharp, happenings)?;
            if moved {
                // Logic has seen a velocity before it was set to rest: stores wait.
                continue;
            }
            switched.clear();
            for (i, store) in self.stores.iter().enumerate() {
                let (previous, edges) = (&mut f.previous[i], &mut happenings.edges);
                switched.extend(store.act(previous, &mut f.timer_s, nets, (t_s, initial), edges));
            }
            for (i, control) in self.controls.iter().enumerate() {
                let free = control.stops.is_none_or(|e| f.region[e as usize] == Stops::FREE);
                let previous = &mut f.previous[self.stores.len() + i];
                let (reset, runs) = control.apply(ics, (previous, free), before, nets, initial);
                f.running[i] = runs;
                if reset {
                    moved = true;
                    if last {
                        movers.push(control.state);
                    }
                }
            }
            for (slot, value) in &switched {
                nets[*slot as usize] = *value;
                moved = true;
                if last {
                    movers.push(*slot);
                }
            }
            if moved {
                continue;
            }
            match negative {
                None => return Ok(()),
                Some(root) if sharp => {
                    return Err(fatal(self, root, Fatal::NegativeRoot, t_s));
                }
                Some(_) => sharp = true,
            }
        }
        let nets = movers.iter().map(|s| self.slot_name(*s)).collect();
        Err(RunFault::LogicRace { t_s, nets })
    }

    /// One pass over all blocks: whether a state moved, and the first square root whose
    /// argument is negative as yet.
    fn pass(
        &self,
        f: &mut Frozen,
        t_s: f64,
        nets: &mut [f64],
        sharp: bool,
        happenings: &mut Happenings,
    ) -> Result<(bool, Option<BlockId>), RunFault> {
        let mut moved = false;
        let mut negative = None;
        // An instant lies beyond what was located in it, but no output beyond its stop.
        for stops in self.controls.iter().filter_map(|control| control.stops) {
            if let Piecewise::Stops(stops) = self.elements[stops as usize].1 {
                let state = &mut nets[stops.state as usize];
                if *state > stops.high {
                    *state = stops.high;
                } else if *state < stops.low {
                    *state = stops.low;
                }
            }
        }
        for step in &self.settle {
            match step {
                Settle::Decide(e) => {
                    let (block, element) = self.elements[*e as usize];
                    let before = f.region[*e as usize];
                    let choice = match element.choose(*e as usize, self, f, nets, sharp) {
                        Ok(choice) => choice,
                        Err(Fatal::NegativeRoot) => {
                            negative = negative.or(Some(block));
                            continue;
                        }
                        Err(fault) => return Err(fatal(self, block, fault, t_s)),
                    };
                    moved |= choice.moved;
                    if before == 0 && f.region[*e as usize] != 0 && element.jumps() {
                        happenings.switched.push(*e);
                    }
                    if choice.overloaded {
                        let value = element.watched_net().map_or(f64::NAN, |s| nets[s as usize]);
                        happenings.overloads.push(LatchedOverload { block, t_s, value });
                    }
                }
                Settle::Op(op) => {
                    if let Op::Track { o, control, store, .. } = *op {
                        let tracking = nets[control as usize] != 0.0;
                        let was = &mut f.tracking[store as usize];
                        if *was && !tracking {
                            f.tracked[store as usize] = nets[o as usize];
                        }
                        *was = tracking;
                    }
                    self.evaluate(op, f, t_s, nets);
                }
            }
        }
        Ok((moved, negative))
    }

    /// Name of the net in a slot, or of the block that a hidden net belongs to.
    pub(crate) fn slot_name(&self, slot: u32) -> String {
        let net = self.slot_of_net.iter().position(|s| *s == slot);
        match net {
            Some(net) => self.net_names[net].clone(),
            None => self.block_name(self.block_of_slot[slot as usize]),
        }
    }
}
