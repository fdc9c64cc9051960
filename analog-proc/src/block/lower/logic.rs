//! Switches and logic.

use crate::block::Lowering;
use crate::fault::RunFault;
use crate::net::{Block, Kind};
use crate::op::{Op, Slot};

impl Lowering {
    /// Wires the outputs of a block of this file.
    pub(super) fn logic(&mut self, o: Slot, block: &Block) -> Result<(), RunFault> {
        match &block.kind {
            Kind::Switch { control } => {
                let [a, b] = self.exactly(&block.inputs)?;
                let control = self.slot(*control);
                let varying = self.vary(&[a.slot, b.slot]);
                self.push(Op::Switch { o, control, a, b }, &[o], varying);
            }
            Kind::TrackStore { track, ic } => {
                let u = self.sum(&block.inputs)?;
                let control = self.slot(*track);
                let store = self.m.track_ics.len() as u32;
                self.m.track_ics.push(*ic);
                let varying = self.vary(&[u.slot]);
                self.push(Op::Track { o, control, a: u.slot, c: u.c, store }, &[o], varying);
            }
            Kind::And | Kind::Or => {
                let terms = self.terms(&block.inputs);
                let (start, len) = self.store_terms(&terms);
                let and = matches!(block.kind, Kind::And);
                let op = if and { Op::And { o, start, len } } else { Op::Or { o, start, len } };
                self.push(op, &[o], false);
            }
            Kind::Not => {
                let [a] = self.exactly(&block.inputs)?;
                self.push(Op::Not { o, a: a.slot }, &[o], false);
            }
            Kind::FlipFlop { initial } => self.m.initial_nets[o as usize] = f64::from(*initial),
            Kind::OneShot { .. } | Kind::Counter { .. } => {}
            Kind::Control { line, initial } => {
                self.m.initial_nets[o as usize] = f64::from(*initial);
                self.m.control_lines.push((*line, o));
            }
            _ => {}
        }
        Ok(())
    }
}
