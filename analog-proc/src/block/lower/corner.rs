//! Everything with corners or jumps: functions by pieces, friction, relays, comparators.

use crate::block::Lowering;
use crate::block::curve::{
    DigitalFunction, band, pieces_of_abs, pieces_of_dead_zone, pieces_of_limiter, pieces_of_table,
};
use crate::block::friction::Friction;
use crate::block::piecewise::Piecewise;
use crate::block::surface::{Cell, Table};
use crate::fault::RunFault;
use crate::net::{Block, Kind, Level};
use crate::op::{Op, Slot};

impl Lowering {
    /// Wires the outputs of a block of this file.
    pub(super) fn corner(&mut self, o: Slot, block: &Block) -> Result<(), RunFault> {
        match &block.kind {
            Kind::Abs => {
                let u = self.sum(&block.inputs)?;
                self.curve_into(o, u, &[0.0], &pieces_of_abs());
            }
            Kind::Min => self.extremum(o, block, -1.0)?,
            Kind::Max => self.extremum(o, block, 1.0)?,
            Kind::Function { x, y } => {
                if x.is_empty() || x.len() != y.len() {
                    return Err(self.malformed("its table needs as many values as breakpoints"));
                }
                let u = self.sum(&block.inputs)?;
                self.curve_into(o, u, x, &pieces_of_table(x, y));
            }
            Kind::DigitalFunction { x, first_channel, initial } => {
                if x.is_empty() || x.len() != initial.len() {
                    return Err(self.malformed("its table needs as many values as breakpoints"));
                }
                let u = self.sum(&block.inputs)?;
                let curve = self.curve_into(o, u, x, &pieces_of_table(x, initial));
                // The ordinates lie side by side, so they have coefficients of their own.
                let first = self.m.dcu_channels.len() as u32;
                for (i, value) in initial.iter().enumerate() {
                    let channel = first_channel.saturating_add(i as u32);
                    self.m.dcu_channels.push((channel, *value));
                }
                self.m.digital_functions.push(DigitalFunction { curve, first });
            }
            Kind::Function2d { x, y, z } => {
                if x.is_empty() || y.is_empty() || z.len() != x.len() * y.len() {
                    return Err(
                        self.malformed("its table needs one value for each pair of breakpoints")
                    );
                }
                let [u, v] = self.exactly(&block.inputs)?;
                let table = self.m.tables.len() as u32;
                let bands = [band(x), band(y)];
                self.m.tables.push(Table { x: x.clone(), y: y.clone(), z: z.clone(), bands });
                let slots = [u.slot, v.slot];
                let e = self.element(Piecewise::Cell(Cell { table, x: u, y: v }), &slots);
                let varying = self.vary(&slots);
                self.push(Op::Surface { o, e, table, x: u, y: v }, &[o], varying);
            }
            Kind::DeadZone { width } => {
                let u = self.sum(&block.inputs)?;
                match *width {
                    Level::Fixed(w) => {
                        self.curve_into(o, u, &[-w, w], &pieces_of_dead_zone(w));
                    }
                    Level::Net(net) => {
                        let w = self.slot(net);
                        let e = self.element(Piecewise::DeadZone { u, width: w }, &[u.slot, w]);
                        let varying = self.vary(&[u.slot, w]);
                        self.push(Op::DeadZone { o, e, a: u.slot, c: u.c, w }, &[o], varying);
                    }
                }
            }
            Kind::Limiter { low, high } => {
                let u = self.sum(&block.inputs)?;
                if let (Level::Fixed(low), Level::Fixed(high)) = (low, high) {
                    let pieces = pieces_of_limiter(*low, *high);
                    self.curve_into(o, u, &[*low, *high], &pieces);
                } else {
                    let (low, high) = (self.level(*low), self.level(*high));
                    let slots = [u.slot, low, high];
                    let e = self.element(Piecewise::Limiter { u, low, high }, &slots);
                    let varying = self.vary(&slots);
                    self.push(Op::Limit { o, e, a: u.slot, c: u.c, low, high }, &[o], varying);
                }
            }
            Kind::DryFriction { level, breakaway } => {
                let [velocity, applied] = self.exactly(&block.inputs)?;
                let state = ((velocity.slot as usize) < self.m.states).then_some(velocity.slot);
                let friction =
                    Friction { velocity, applied, level: *level, breakaway: *breakaway, state };
                let slots = [velocity.slot, applied.slot];
                let e = self.element(Piecewise::Friction(friction), &slots);
                self.push(Op::Friction { o, e, a: applied.slot, c: applied.c }, &[o], true);
            }
            Kind::Relay { points, outputs, initially_on } => {
                let u = self.sum(&block.inputs)?;
                let relay = Piecewise::Relay {
                    u,
                    points: *points,
                    outputs: *outputs,
                    initially_on: *initially_on,
                };
                let e = self.element(relay, &[u.slot]);
                self.push(Op::Constant { o, e }, &[o], false);
            }
            Kind::Comparator { threshold, hysteresis } => {
                let u = self.sum(&block.inputs)?;
                let comparator = Piecewise::Comparator {
                    u,
                    on_above: threshold + 0.5 * hysteresis,
                    off_at: threshold - 0.5 * hysteresis,
                };
                let e = self.element(comparator, &[u.slot]);
                self.push(Op::Constant { o, e }, &[o], false);
            }
            _ => {}
        }
        Ok(())
    }

    fn extremum(&mut self, o: Slot, block: &Block, sign: f64) -> Result<(), RunFault> {
        if block.inputs.is_empty() {
            return Err(self.malformed("it needs at least one input"));
        }
        let terms = self.terms(&block.inputs);
        let slots: Vec<Slot> = terms.iter().map(|t| t.slot).collect();
        let (start, len) = self.store_terms(&terms);
        let e = self.element(Piecewise::Extremum { start, len, sign }, &slots);
        let varying = self.vary(&slots);
        self.push(Op::Extreme { o, e, start, len }, &[o], varying);
        Ok(())
    }
}
