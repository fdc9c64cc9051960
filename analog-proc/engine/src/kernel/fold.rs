//! From the flat program to the folded one.
//!
//! Backwards from the derivatives: each operand is followed through gains and
//! coefficient units to the net behind them, and its readers are counted; an
//! operation without readers is left for the end of the step. Then a sum with a
//! single reader that is itself a sum is written into it, and likewise a product
//! whose single reader is a derivative. It is long, but one concept: every rewriting
//! rests on the same counts of readers, made before the first of them.

use super::rows::{Row, Rows};
use super::weights::{Part, Place, Weights};
use super::{Kernel, Step};
use crate::op::{Op, Slot, Term};

struct Folding<'a> {
    ops: &'a [Op],
    terms: &'a [Term],
    /// The operation that drives each varying net.
    driver: Vec<Option<usize>>,
    /// Readers of each net among what the derivatives depend on.
    readers: Vec<u32>,
    /// Foldable operands of each operation that the derivatives depend on.
    operands: Vec<Vec<Part>>,
    live: Vec<bool>,
    /// Nets whose very value is balanced by friction: not looked behind.
    kept: Vec<bool>,
    folded: Vec<bool>,
}

/// Folds the varying operations and the derivatives (`rates`, by state).
pub fn fold(ops: &[Op], terms: &[Term], rates: &[(u32, Vec<Term>)], slots: usize) -> Kernel {
    let mut driver = vec![None; slots];
    for (i, op) in ops.iter().enumerate() {
        op.drives(|slot| driver[slot as usize] = Some(i));
    }
    let mut kept = vec![false; slots];
    for op in ops {
        if let Op::Friction { a, .. } = op {
            kept[*a as usize] = true;
        }
    }
    let mut folding = Folding {
        ops,
        terms,
        driver,
        readers: vec![0; slots],
        operands: vec![Vec::new(); ops.len()],
        live: vec![false; ops.len()],
        kept,
        folded: vec![false; ops.len()],
    };
    let mut rows = Vec::with_capacity(rates.len());
    for (state, terms) in rates {
        let parts = terms.iter().map(|t| Part::plain(t.slot, t.c));
        rows.push((*state, folding.read(parts.collect())));
    }
    for i in (0..ops.len()).rev() {
        folding.mark(i);
    }
    let rows = rows.into_iter().map(|row| folding.row(row)).collect();
    let mut weights = Weights::default();
    let rows = Rows::build(rows, &mut weights);
    let mut kernel = Kernel { rows, ..Kernel::default() };
    // Readers come after what they read: backwards, so that a sum knows whether it was folded.
    let mut steps = Vec::new();
    for i in (0..ops.len()).rev() {
        let dac = matches!(ops[i], Op::Dac { .. });
        if folding.live[i] && !folding.folded[i] && !dac {
            let index = steps.len();
            steps.push(folding.step(i, index, &mut kernel, &mut weights));
        }
    }
    steps.reverse();
    let last = steps.len();
    kernel.steps = steps;
    for scaled in &mut weights.scaled {
        if let Place::Step { index, .. } = &mut scaled.place {
            *index = last - 1 - *index;
        }
    }
    for (i, op) in ops.iter().enumerate() {
        match *op {
            Op::Dac { o, hold } => kernel.dacs.push((o, hold)),
            _ if folding.live[i] && !folding.folded[i] => {}
            _ => kernel.rest.push(*op),
        }
    }
    kernel.weights = weights.base;
    kernel.scaled = weights.scaled;
    kernel
}

impl Folding<'_> {
    /// The weighted sum that drives a net, if it is one.
    fn sum_at(&self, slot: Slot) -> Option<(usize, Vec<Part>)> {
        let i = self.driver[slot as usize]?;
        Some((i, self.sum(&self.ops[i])?))
    }

    fn sum(&self, op: &Op) -> Option<Vec<Part>> {
        Some(match *op {
            Op::Sum1 { a, ca, .. } => vec![Part::plain(a, ca)],
            Op::Sum2 { a, b, ca, cb, .. } => vec![Part::plain(a, ca), Part::plain(b, cb)],
            Op::Sum3 { a, b, d, ca, cb, cd, .. } => {
                vec![Part::plain(a, ca), Part::plain(b, cb), Part::plain(d, cd)]
            }
            Op::SumN { start, len, .. } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                terms.iter().map(|t| Part::plain(t.slot, t.c)).collect()
            }
            Op::Dcu { dcu, a, c, .. } => vec![Part { slot: a, c, dcus: vec![dcu] }],
            _ => return None,
        })
    }

    /// Follows gains and coefficient units, and counts the reader.
    fn read(&mut self, parts: Vec<Part>) -> Vec<Part> {
        let mut resolved = Vec::with_capacity(parts.len());
        for mut part in parts {
            while !self.kept[part.slot as usize]
                && let Some((_, inner)) = self.sum_at(part.slot)
                && let [one] = &inner[..]
            {
                part = part.times(one);
            }
            self.readers[part.slot as usize] += 1;
            resolved.push(part);
        }
        resolved
    }

    /// Marks an operation that the derivatives depend on, and counts what it reads.
    fn mark(&mut self, i: usize) {
        let op = self.ops[i];
        let mut live = false;
        op.drives(|slot| live |= self.readers[slot as usize] > 0);
        if !live {
            return;
        }
        self.live[i] = true;
        let foldable = match op {
            Op::Product { a, b, c, .. } => Some(vec![Part::plain(a, c), Part::plain(b, 1.0)]),
            Op::Curve { a, c, .. } | Op::SinCos { a, c, .. } => Some(vec![Part::plain(a, c)]),
            Op::DeadZone { a, c, w, .. } => {
                self.readers[w as usize] += 1;
                Some(vec![Part::plain(a, c)])
            }
            Op::Rotate { start, .. } => {
                let [u, v, angle] = [0, 1, 2].map(|k| self.terms[start as usize + k]);
                self.readers[angle.slot as usize] += 1;
                Some(vec![Part::plain(u.slot, u.c), Part::plain(v.slot, v.c)])
            }
            _ => self.sum(&op),
        };
        match foldable {
            Some(parts) => self.operands[i] = self.read(parts),
            None => op.reads(self.terms, |slot| self.readers[slot as usize] += 1),
        }
    }

    /// Writes sums with a single reader into it.
    fn expand(&mut self, parts: &[Part], out: &mut Vec<Part>) {
        for part in parts {
            match self.own_sum(part) {
                Some(i) => {
                    self.folded[i] = true;
                    let inner: Vec<Part> = self.operands[i].iter().map(|p| part.times(p)).collect();
                    self.expand(&inner, out);
                }
                None => out.push(part.clone()),
            }
        }
    }

    /// The sum behind a part, if the part is its only reader.
    fn own_sum(&self, part: &Part) -> Option<usize> {
        if self.readers[part.slot as usize] != 1 {
            return None;
        }
        self.sum_at(part.slot).map(|found| found.0)
    }

    fn row(&mut self, (state, parts): (u32, Vec<Part>)) -> Row {
        let mut expanded = Vec::new();
        self.expand(&parts, &mut expanded);
        let (mut linear, mut products) = (Vec::new(), Vec::new());
        for part in expanded {
            let driver = self.driver[part.slot as usize];
            match driver.filter(|_| self.readers[part.slot as usize] == 1) {
                Some(i) if matches!(self.ops[i], Op::Product { .. }) => {
                    self.folded[i] = true;
                    let [a, b] = &self.operands[i][..] else {
                        unreachable!("a product has two operands")
                    };
                    let both = part.times(a).times(b);
                    let weighted = Part { slot: a.slot, ..both };
                    products.push((weighted, b.slot));
                }
                _ => linear.push(part),
            }
        }
        Row { state, linear, products }
    }

    /// The one operand of a curve: two terms, where it is a sum of two that nothing else reads.
    fn one_or_two(&mut self, i: usize) -> Vec<Part> {
        let parts = std::mem::take(&mut self.operands[i]);
        if let [part] = &parts[..]
            && let Some(sum) = self.own_sum(part)
        {
            let mut expanded = Vec::new();
            self.expand(&parts, &mut expanded);
            if expanded.len() == 2 {
                return expanded;
            }
            self.folded[sum] = false;
        }
        parts
    }

    fn step(&mut self, i: usize, at: usize, kernel: &mut Kernel, weights: &mut Weights) -> Step {
        let op = self.ops[i];
        match op {
            Op::Product { o, .. } => {
                let [a, b] = &self.operands[i][..] else {
                    unreachable!("a product has two operands")
                };
                let w = weights.within(at, &[a.times(b)]);
                let (a, b) = (a.slot, b.slot);
                Step::Product { o, a, b, w }
            }
            Op::Curve { o, e, .. } => {
                let parts = self.one_or_two(i);
                let a = parts[0].slot;
                match parts.get(1) {
                    Some(second) => {
                        Step::Curve2 { o, e, a, b: second.slot, w: weights.within(at, &parts) }
                    }
                    None => Step::Curve1 { o, e, a, w: weights.within(at, &parts) },
                }
            }
            Op::DeadZone { o, e, w: width, .. } => {
                let parts = self.one_or_two(i);
                let a = parts[0].slot;
                match parts.get(1) {
                    Some(second) => Step::DeadZone2 {
                        o,
                        e,
                        a,
                        b: second.slot,
                        width,
                        w: weights.within(at, &parts),
                    },
                    None => Step::DeadZone1 { o, e, a, width, w: weights.within(at, &parts) },
                }
            }
            Op::SinCos { o, .. } => {
                let a = self.operands[i][0].slot;
                let w = weights.within(at, &self.operands[i]);
                Step::SinCos { o, a, w }
            }
            Op::Rotate { x, y, start } => {
                let angle = self.terms[start as usize + 2];
                self.operands[i].push(Part::plain(angle.slot, angle.c));
                let [u, v, sin] = [0, 1, 2].map(|k| self.operands[i][k].slot);
                let w = weights.within(at, &self.operands[i]);
                Step::Rotate { x, y, u, v, sin, w }
            }
            Op::Sum1 { o, .. }
            | Op::Sum2 { o, .. }
            | Op::Sum3 { o, .. }
            | Op::SumN { o, .. }
            | Op::Dcu { o, .. } => {
                let parts = std::mem::take(&mut self.operands[i]);
                let mut expanded = Vec::new();
                self.expand(&parts, &mut expanded);
                let parts = expanded;
                let slots: Vec<Slot> = parts.iter().map(|p| p.slot).collect();
                match slots[..] {
                    [a] => {
                        let w = weights.within(at, &parts);
                        Step::Sum1 { o, a, w }
                    }
                    [a, b] => {
                        let w = weights.within(at, &parts);
                        Step::Sum2 { o, a, b, w }
                    }
                    [a, b, d] => {
                        let w = weights.within(at, &parts);
                        Step::Sum3 { o, a, b, d, w }
                    }
                    _ => {
                        let w = weights.push_all(&parts);
                        let (start, len) = (kernel.slots.len() as u32, slots.len() as u32);
                        kernel.slots.extend_from_slice(&slots);
                        Step::Sum { o, start, len, w }
                    }
                }
            }
            _ => {
                let i = kernel.others.len() as u32;
                kernel.others.push(op);
                Step::Other { i }
            }
        }
    }
}
