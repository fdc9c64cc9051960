//! What stores read, wired once every net is in place.

use super::scaled;
use crate::block::Lowering;
use crate::block::curve::{Piece, pieces_of_dead_zone, pieces_of_limiter};
use crate::block::integrator::{Control, Stops};
use crate::block::logic::Store;
use crate::block::piecewise::Piecewise;
use crate::block::source::Timer;
use crate::fault::RunFault;
use crate::net::Kind;
use crate::op::{Op, Slot, Term};
use crate::order::Ordered;

impl Lowering {
    /// Wires what a store reads, once every net is in place.
    pub(in crate::block) fn inputs_of_stores(&mut self, ordered: &Ordered) -> Result<(), RunFault> {
        let Some(block) = ordered.netlist.blocks.get(self.block.index()) else {
            return Ok(());
        };
        let Some(&net) = block.outputs.first() else {
            return Ok(());
        };
        let o = self.slot(net);
        match &block.kind {
            Kind::Integrator { limits, operate, reset, reset_to, .. } => {
                let mut terms = self.terms(&block.inputs);
                if terms.is_empty() {
                    return Err(self.malformed("it needs at least one input"));
                }
                let mut stops = None;
                if let Some([low, high]) = *limits {
                    let rate = self.sum(&block.inputs)?;
                    let element = Piecewise::Stops(Stops { state: o, rate, low, high });
                    stops = Some(self.element(element, &[o, rate.slot]));
                    terms = vec![rate];
                }
                self.rate(o, &terms);
                if stops.is_some() || operate.is_some() || reset.is_some() {
                    let control = Control {
                        state: o,
                        operate: operate.map(|n| self.slot(n)),
                        reset: reset.map(|n| self.slot(n)),
                        reset_to: reset_to.as_ref().map(|i| self.term(i)),
                        stops,
                    };
                    self.m.controls.push(control);
                }
            }
            Kind::Lag { tau, gain, .. } => {
                let mut terms = scaled(self.terms(&block.inputs), gain / tau);
                terms.push(Term { slot: o, c: -1.0 / tau });
                self.rate(o, &terms);
            }
            Kind::RateLimiter { rate, tau, .. } => {
                let mut terms = scaled(self.terms(&block.inputs), 1.0 / tau);
                terms.push(Term { slot: o, c: -1.0 / tau });
                let pieces = pieces_of_limiter(-rate, *rate);
                self.follower(o, &terms, &[-rate, *rate], &pieces, 1.0);
            }
            Kind::Backlash { width, tau, .. } => {
                let mut terms = self.terms(&block.inputs);
                terms.push(Term { slot: o, c: -1.0 });
                let half = 0.5 * width;
                let pieces = pieces_of_dead_zone(half);
                self.follower(o, &terms, &[-half, half], &pieces, 1.0 / tau);
            }
            Kind::TransportDelay { .. } => {
                let input = self.sum(&block.inputs)?;
                let line = self.fast.iter().find_map(|op| match op {
                    Op::Delay { o: out, line } if *out == o => Some(*line as usize),
                    _ => None,
                });
                if let Some(line) = line {
                    self.m.lines[line].input = input;
                }
            }
            Kind::FlipFlop { .. } => {
                let [set, reset] = self.exactly(&block.inputs)?;
                self.m.stores.push(Store::FlipFlop { o, set: set.slot, reset: reset.slot });
            }
            Kind::OneShot { width_s } => {
                let [input] = self.exactly(&block.inputs)?;
                let timer = self.m.timers.len() as u32;
                self.m.timers.push((o, Timer::OneShotEnd));
                let (input, width_s) = (input.slot, *width_s);
                self.m.stores.push(Store::OneShot { o, input, width_s, timer });
            }
            Kind::Counter { modulo } => {
                let Some(clock) = block.inputs.first() else {
                    return Err(self.malformed("it needs a clock"));
                };
                let clock = self.slot(clock.net);
                let reset = block.inputs.get(1).map(|i| self.slot(i.net));
                self.m.stores.push(Store::Counter { o, clock, reset, modulo: *modulo });
            }
            Kind::Interrupt { line } => {
                self.m.stores.push(Store::Interrupt { input: o, line: *line });
            }
            _ => {}
        }
        Ok(())
    }

    /// `dy/dt = factor · curve(Σ terms)`.
    fn follower(
        &mut self,
        o: Slot,
        terms: &[Term],
        corners: &[f64],
        pieces: &[Piece],
        factor: f64,
    ) {
        let slot = self.hidden();
        self.sum_into(slot, terms);
        let driven = self.hidden();
        self.curve_into(driven, Term { slot, c: 1.0 }, corners, pieces);
        self.rate(o, &[Term { slot: driven, c: factor }]);
    }
}
