//! Sums, coefficients, products and the functions without corners.

use crate::block::Lowering;
use crate::block::piecewise::Piecewise;
use crate::fault::RunFault;
use crate::net::{Block, Kind};
use crate::op::{Op, Slot, Term};

use super::scaled;

impl Lowering {
    /// Wires the outputs of a block of this file.
    pub(super) fn arithmetic(&mut self, o: Slot, block: &Block) -> Result<(), RunFault> {
        match &block.kind {
            Kind::Summer | Kind::Adc { .. } => self.weighted(o, block, 1.0)?,
            Kind::Interrupt { .. } => self.weighted(o, block, 1.0)?,
            Kind::Sense { line } => {
                self.weighted(o, block, 1.0)?;
                self.m.senses.push((*line, o));
            }
            Kind::Inverter => self.weighted(o, block, -1.0)?,
            Kind::Gain { k } | Kind::Pot { k } => self.weighted(o, block, *k)?,
            Kind::Dcu { channel, initial, .. } => {
                let u = self.sum(&block.inputs)?;
                let dcu = self.dcu(*channel, *initial);
                let varying = self.vary(&[u.slot]);
                self.push(Op::Dcu { o, dcu, a: u.slot, c: u.c }, &[o], varying);
            }
            Kind::Mdac { channel, initial } => {
                let u = self.sum(&block.inputs)?;
                let hold = self.dac(*channel, *initial);
                self.push(Op::Mdac { o, hold, a: u.slot, c: u.c }, &[o], true);
            }
            Kind::Dac { channel, initial } => {
                let hold = self.dac(*channel, *initial);
                self.push(Op::Dac { o, hold }, &[o], true);
            }
            Kind::Multiplier => self.product(o, block)?,
            Kind::Divider => {
                let [a, b] = self.exactly(&block.inputs)?;
                self.element(Piecewise::Divisor { u: b }, &[b.slot]);
                let varying = self.vary(&[a.slot, b.slot]);
                let op = Op::Quotient { o, a: a.slot, b: b.slot, c: a.c / b.c };
                self.push(op, &[o], varying);
            }
            Kind::Square => {
                let u = self.sum(&block.inputs)?;
                let varying = self.vary(&[u.slot]);
                self.push(Op::Product { o, a: u.slot, b: u.slot, c: u.c * u.c }, &[o], varying);
            }
            Kind::SquareRoot => {
                let u = self.sum(&block.inputs)?;
                self.element(Piecewise::Radicand { u }, &[u.slot]);
                let varying = self.vary(&[u.slot]);
                self.push(Op::Root { o, a: u.slot, c: u.c }, &[o], varying);
            }
            Kind::Sine | Kind::Cosine => {
                let u = self.sum(&block.inputs)?;
                let varying = self.vary(&[u.slot]);
                let (a, c) = (u.slot, u.c);
                let sine = matches!(block.kind, Kind::Sine);
                let op = if sine { Op::Sine { o, a, c } } else { Op::Cosine { o, a, c } };
                self.push(op, &[o], varying);
            }
            Kind::Resolver => {
                let terms: [Term; 3] = self.exactly(&block.inputs)?;
                let Some(&second) = block.outputs.get(1) else {
                    return Err(self.malformed("a resolver drives two nets"));
                };
                let y = self.slot(second);
                let varying = self.vary(&terms.map(|t| t.slot));
                let [u, v, angle] = terms;
                let sine = self.sine_of(angle);
                let (start, _) = self.store_terms(&[u, v, sine]);
                self.push(Op::Rotate { x: o, y, start }, &[o, y], varying);
                self.overload(y, block.max);
            }
            Kind::Arctangent => {
                let [y, x] = self.exactly(&block.inputs)?;
                let e = self.element(Piecewise::Sheet { y }, &[y.slot]);
                let varying = self.vary(&[y.slot, x.slot]);
                self.push(Op::Arctangent { o, e, y, x }, &[o], varying);
            }
            _ => {}
        }
        Ok(())
    }

    fn weighted(&mut self, o: Slot, block: &Block, factor: f64) -> Result<(), RunFault> {
        if block.inputs.is_empty() {
            return Err(self.malformed("it needs at least one input"));
        }
        let terms = scaled(self.terms(&block.inputs), factor);
        self.sum_into(o, &terms);
        Ok(())
    }

    fn product(&mut self, o: Slot, block: &Block) -> Result<(), RunFault> {
        let terms = self.terms(&block.inputs);
        let [first, .., last] = *terms else {
            return Err(self.malformed("a product needs two inputs"));
        };
        let mut left = first;
        for right in &terms[1..terms.len() - 1] {
            let slot = self.hidden();
            let varying = self.vary(&[left.slot, right.slot]);
            let op = Op::Product { o: slot, a: left.slot, b: right.slot, c: left.c * right.c };
            self.push(op, &[slot], varying);
            left = Term { slot, c: 1.0 };
        }
        let varying = self.vary(&[left.slot, last.slot]);
        let op = Op::Product { o, a: left.slot, b: last.slot, c: left.c * last.c };
        self.push(op, &[o], varying);
        Ok(())
    }
}
