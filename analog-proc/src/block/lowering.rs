//! The builder with which blocks are wired into the program.

use crate::net::{Block, Input, Level};
use engine::element::curve::{Curve, Piece, band};
use engine::element::piecewise::Piecewise;
use engine::id::BlockId;
use engine::machine::{Machine, Settle};
use engine::op::{Op, Slot, Term};
use engine::overload::OVERLOAD_FACTOR;

/// The machine under construction.
pub(crate) struct Lowering {
    pub(super) m: Machine,
    /// Whether a slot varies within a step.
    pub(super) varying: Vec<bool>,
    /// Operations whose result varies within a step.
    pub(super) fast: Vec<Op>,
    /// Nets that the sides of each watched element read.
    pub(super) watched: Vec<Vec<Slot>>,
    /// The block of each varying operation.
    pub(super) block_of_fast: Vec<BlockId>,
    /// Terms of each derivative.
    pub(super) rates: Vec<(u32, Vec<Term>)>,
    /// Angles whose sine is in a net, their cosine in the net after it.
    pub(super) angles: Vec<(Slot, f64, Slot)>,
    pub(super) block: BlockId,
}

pub(super) fn scaled(terms: Vec<Term>, factor: f64) -> Vec<Term> {
    terms.into_iter().map(|t| Term { slot: t.slot, c: factor * t.c }).collect()
}

impl Lowering {
    pub(super) fn term(&self, input: &Input) -> Term {
        Term { slot: self.slot(input.net), c: input.coefficient }
    }

    pub(super) fn slot(&self, net: engine::id::NetId) -> Slot {
        self.m.slot_of_net[net.index()]
    }

    pub(super) fn terms(&self, inputs: &[Input]) -> Vec<Term> {
        inputs.iter().map(|i| self.term(i)).collect()
    }

    pub(super) fn hidden(&mut self) -> Slot {
        let slot = self.m.slots as Slot;
        self.m.slots += 1;
        self.m.initial_nets.push(0.0);
        self.m.block_of_slot.push(self.block);
        self.varying.push(false);
        slot
    }

    pub(super) fn level(&mut self, level: Level) -> Slot {
        match level {
            Level::Fixed(value) => {
                let slot = self.hidden();
                self.m.initial_nets[slot as usize] = value;
                slot
            }
            Level::Net(net) => self.slot(net),
        }
    }

    pub(super) fn vary(&self, slots: &[Slot]) -> bool {
        slots.iter().any(|s| self.varying[*s as usize])
    }

    pub(super) fn push(&mut self, op: Op, outputs: &[Slot], varying: bool) {
        for o in outputs {
            self.varying[*o as usize] |= varying;
        }
        self.m.settle.push(Settle::Op(op));
        if varying {
            self.fast.push(op);
            self.block_of_fast.push(self.block);
        }
    }

    pub(super) fn store_terms(&mut self, terms: &[Term]) -> (u32, u32) {
        let start = self.m.terms.len() as u32;
        self.m.terms.extend_from_slice(terms);
        (start, terms.len() as u32)
    }

    /// `o = Σ terms`.
    pub(super) fn sum_into(&mut self, o: Slot, terms: &[Term]) {
        let slots: Vec<Slot> = terms.iter().map(|t| t.slot).collect();
        let varying = self.vary(&slots);
        let op = match *terms {
            [a] => Op::Sum1 { o, a: a.slot, ca: a.c },
            [a, b] => Op::Sum2 { o, a: a.slot, b: b.slot, ca: a.c, cb: b.c },
            [a, b, d] => Op::Sum3 { o, a: a.slot, b: b.slot, d: d.slot, ca: a.c, cb: b.c, cd: d.c },
            _ => {
                let (start, len) = self.store_terms(terms);
                Op::SumN { o, start, len }
            }
        };
        self.push(op, &[o], varying);
    }

    /// One term that carries `Σ inputs`, through a hidden net where there are several.
    pub(super) fn sum(&mut self, inputs: &[Input]) -> Term {
        if let [one] = inputs {
            return self.term(one);
        }
        let slot = self.hidden();
        self.sum_into(slot, &self.terms(inputs));
        Term { slot, c: 1.0 }
    }

    /// `o = factor · Σ`.
    pub(super) fn weighted(&mut self, o: Slot, block: &Block, factor: f64) {
        self.sum_into(o, &scaled(self.terms(&block.inputs), factor));
    }

    /// `o` by an operation on `Σ` alone.
    pub(super) fn through(&mut self, o: Slot, block: &Block, op: impl FnOnce(Term) -> Op) {
        let u = self.sum(&block.inputs);
        let varying = self.vary(&[u.slot]);
        self.push(op(u), &[o], varying);
    }

    /// The inputs of a kind that takes so many.
    pub(super) fn exactly<const N: usize>(&self, inputs: &[Input]) -> [Term; N] {
        std::array::from_fn(|i| self.term(&inputs[i]))
    }

    /// Adds an element and its decision; `reads` are the nets of its sides.
    pub(super) fn element(&mut self, element: Piecewise, reads: &[Slot]) -> u32 {
        let e = self.m.elements.len() as u32;
        self.m.elements.push((self.block, element));
        self.m.settle.push(Settle::Decide(e));
        if self.vary(reads) {
            self.m.watched.push(e);
            self.watched.push(reads.to_vec());
        }
        e
    }

    /// `o = curve(u)`.
    pub(super) fn curve_into(
        &mut self,
        o: Slot,
        u: Term,
        corners: &[f64],
        pieces: &[Piece],
    ) -> Curve {
        let curve = Curve {
            u,
            start: self.m.breakpoints.len() as u32,
            len: corners.len() as u32,
            pieces: self.m.initial_pieces.len() as u32,
            band: band(corners),
        };
        self.m.breakpoints.extend_from_slice(corners);
        self.m.initial_pieces.extend_from_slice(pieces);
        let e = self.element(Piecewise::Curve(curve), &[u.slot]);
        let varying = self.vary(&[u.slot]);
        self.push(Op::Curve { o, e, a: u.slot, c: u.c }, &[o], varying);
        curve
    }

    /// The sine of an angle as a term, its cosine in the net after that; resolvers share them.
    pub(super) fn sine_of(&mut self, angle: Term) -> Term {
        let c = angle.c.abs();
        let known = self.angles.iter().find(|a| (a.0, a.1) == (angle.slot, c));
        let slot = match known {
            Some(known) => known.2,
            None => {
                let (o, a) = (self.hidden(), angle.slot);
                let cosine = self.hidden();
                let varying = self.vary(&[a]);
                self.push(Op::SinCos { o, a, c }, &[o, cosine], varying);
                self.angles.push((a, c, o));
                o
            }
        };
        Term { slot, c: if angle.c < 0.0 { -1.0 } else { 1.0 } }
    }

    pub(super) fn overload(&mut self, o: Slot, max: Option<f64>) {
        if let Some(max) = max {
            let level = OVERLOAD_FACTOR * max.abs();
            self.element(Piecewise::Overload { net: o, level }, &[o]);
        }
    }

    pub(super) fn rate(&mut self, state: u32, terms: &[Term]) {
        self.rates.push((state, terms.to_vec()));
    }
}
