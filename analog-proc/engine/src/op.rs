//! The operations of the flat program: operands, what each reads and drives.
//!
//! They read and write one flat array of nets by `u32` index. What each computes stands in
//! [`crate::evaluate`]; which of them run, and when, is decided by [`crate::machine`] and
//! [`crate::kernel`].

use crate::signal::Signal;
use serde::{Deserialize, Serialize};

/// Index into the flat array of nets.
pub type Slot = u32;

/// One weighted net.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Term {
    pub slot: Slot,
    pub c: f64,
}

impl Term {
    #[inline(always)]
    pub fn of<N: Signal>(self, nets: &[N]) -> N {
        nets[self.slot as usize] * self.c
    }
}

/// One memoryless operation; `o` is the net it drives, other letters are nets it reads.
#[derive(Clone, Copy, Debug)]
pub enum Op {
    Sum1 {
        o: Slot,
        a: Slot,
        ca: f64,
    },
    Sum2 {
        o: Slot,
        a: Slot,
        b: Slot,
        ca: f64,
        cb: f64,
    },
    Sum3 {
        o: Slot,
        a: Slot,
        b: Slot,
        d: Slot,
        ca: f64,
        cb: f64,
        cd: f64,
    },
    SumN {
        o: Slot,
        start: u32,
        len: u32,
    },
    /// `c·a·b`.
    Product {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `c·a/b`.
    Quotient {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `√max(c·a, 0)`: the argument's sign is a guarded surface.
    Root {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Sine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Cosine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    /// Sine into `o`, cosine into the net after it.
    SinCos {
        o: Slot,
        a: Slot,
        c: f64,
    },
    /// Turns the terms at `start` by the angle whose sine is the term after them.
    Rotate {
        x: Slot,
        y: Slot,
        start: u32,
    },
    /// The angle of the vector (x, y); of a vector that is zero, where it turns to (`y0` of piece
    /// `e`, put there when all has settled).
    Arctangent {
        o: Slot,
        e: u32,
        y: Term,
        x: Term,
    },
    /// The present piece of curve `e`.
    Curve {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    /// The constant of element `e` (comparator, relay).
    Constant {
        o: Slot,
        e: u32,
    },
    DeadZone {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        w: Slot,
    },
    Limit {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        low: Slot,
        high: Slot,
    },
    /// The present extreme of the terms from `start`.
    Extreme {
        o: Slot,
        e: u32,
        start: u32,
        len: u32,
    },
    Surface {
        o: Slot,
        e: u32,
        table: u32,
        x: Term,
        y: Term,
    },
    Friction {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    Dac {
        o: Slot,
        hold: u32,
    },
    Mdac {
        o: Slot,
        hold: u32,
        a: Slot,
        c: f64,
    },
    Dcu {
        o: Slot,
        dcu: u32,
        a: Slot,
        c: f64,
    },
    Switch {
        o: Slot,
        control: Slot,
        a: Term,
        b: Term,
    },
    Track {
        o: Slot,
        control: Slot,
        a: Slot,
        c: f64,
        store: u32,
    },
    Delay {
        o: Slot,
        line: u32,
    },
    Wave {
        o: Slot,
        wave: u32,
    },
    Time {
        o: Slot,
    },
    And {
        o: Slot,
        start: u32,
        len: u32,
    },
    Or {
        o: Slot,
        start: u32,
        len: u32,
    },
    Not {
        o: Slot,
        a: Slot,
    },
}

impl Op {
    /// Calls `f` with every net that the operation drives.
    pub fn drives(&self, mut f: impl FnMut(Slot)) {
        match *self {
            Op::Rotate { x, y, .. } => {
                f(x);
                f(y);
            }
            Op::SinCos { o, .. } => {
                f(o);
                f(o + 1);
            }
            Op::Sum1 { o, .. }
            | Op::Sum2 { o, .. }
            | Op::Sum3 { o, .. }
            | Op::SumN { o, .. }
            | Op::Product { o, .. }
            | Op::Quotient { o, .. }
            | Op::Root { o, .. }
            | Op::Sine { o, .. }
            | Op::Cosine { o, .. }
            | Op::Arctangent { o, .. }
            | Op::Curve { o, .. }
            | Op::Constant { o, .. }
            | Op::DeadZone { o, .. }
            | Op::Limit { o, .. }
            | Op::Extreme { o, .. }
            | Op::Surface { o, .. }
            | Op::Friction { o, .. }
            | Op::Dac { o, .. }
            | Op::Mdac { o, .. }
            | Op::Dcu { o, .. }
            | Op::Switch { o, .. }
            | Op::Track { o, .. }
            | Op::Delay { o, .. }
            | Op::Wave { o, .. }
            | Op::Time { o }
            | Op::And { o, .. }
            | Op::Or { o, .. }
            | Op::Not { o, .. } => f(o),
        }
    }

    /// Calls `f` with every net that the operation reads.
    pub fn reads(&self, terms: &[Term], mut f: impl FnMut(Slot)) {
        let listed = |start: u32, len: u32, f: &mut dyn FnMut(Slot)| {
            for term in &terms[start as usize..(start + len) as usize] {
                f(term.slot);
            }
        };
        match *self {
            Op::Constant { .. }
            | Op::Dac { .. }
            | Op::Delay { .. }
            | Op::Wave { .. }
            | Op::Time { .. } => {}
            Op::Sum1 { a, .. }
            | Op::Root { a, .. }
            | Op::Sine { a, .. }
            | Op::Cosine { a, .. }
            | Op::SinCos { a, .. }
            | Op::Curve { a, .. }
            | Op::Friction { a, .. }
            | Op::Mdac { a, .. }
            | Op::Dcu { a, .. }
            | Op::Not { a, .. } => f(a),
            Op::Sum2 { a, b, .. } | Op::Product { a, b, .. } | Op::Quotient { a, b, .. } => {
                f(a);
                f(b);
            }
            Op::Sum3 { a, b, d, .. } => {
                f(a);
                f(b);
                f(d);
            }
            Op::SumN { start, len, .. }
            | Op::Extreme { start, len, .. }
            | Op::And { start, len, .. }
            | Op::Or { start, len, .. } => listed(start, len, &mut f),
            Op::Rotate { start, .. } => {
                listed(start, 3, &mut f);
                f(terms[start as usize + 2].slot + 1);
            }
            Op::Arctangent { y, x, .. } | Op::Surface { y, x, .. } => {
                f(y.slot);
                f(x.slot);
            }
            Op::DeadZone { a, w, .. } => {
                f(a);
                f(w);
            }
            Op::Limit { a, low, high, .. } => {
                f(a);
                f(low);
                f(high);
            }
            Op::Switch { control, a, b, .. } => {
                f(control);
                f(a.slot);
                f(b.slot);
            }
            Op::Track { control, a, .. } => {
                f(control);
                f(a);
            }
        }
    }
}

/// Degree of each net as a polynomial in signals that the steps resolve one by one (states,
/// time, sines of bounded turn): a product of sixteen sines has peaks a quarter as wide.
pub fn degrees(ops: &[Op], terms: &[Term], slots: usize) -> Vec<u32> {
    let mut degree = vec![1_u32; slots];
    for op in ops {
        let of = |slot: Slot| degree[slot as usize];
        let found = match *op {
            Op::Product { a, b, .. } => of(a).saturating_add(of(b)),
            Op::Quotient { a, b, .. } => of(a).saturating_add(of(b).saturating_mul(2)),
            Op::Mdac { a, .. } => of(a).saturating_add(1),
            Op::Surface { x, y, .. } => of(x.slot).saturating_add(of(y.slot)),
            Op::Rotate { start, .. } => {
                let [u, v, sine] = [0, 1, 2].map(|k| of(terms[start as usize + k].slot));
                u.max(v).saturating_add(sine)
            }
            Op::Delay { .. } => 1,
            _ => {
                let mut greatest = 1;
                op.reads(terms, |slot| greatest = greatest.max(of(slot)));
                greatest
            }
        };
        op.drives(|slot| degree[slot as usize] = found);
    }
    degree
}

/// The greatest degree of what each net goes into.
pub fn powers(ops: &[Op], terms: &[Term], degree: &[u32]) -> Vec<u32> {
    let mut power = degree.to_vec();
    for op in ops.iter().rev() {
        let mut of = 1;
        op.drives(|slot| of = of.max(power[slot as usize]));
        op.reads(terms, |slot| power[slot as usize] = power[slot as usize].max(of));
    }
    power
}

/// Which of the operations, in order of evaluation, the nets `wanted` depend on.
pub fn behind(ops: &[Op], terms: &[Term], wanted: &[Slot], slots: usize) -> Vec<bool> {
    let mut needed = vec![false; slots];
    for slot in wanted {
        needed[*slot as usize] = true;
    }
    let mut is_behind = vec![false; ops.len()];
    for (i, op) in ops.iter().enumerate().rev() {
        op.drives(|slot| is_behind[i] |= needed[slot as usize]);
        if is_behind[i] {
            op.reads(terms, |slot| needed[slot as usize] = true);
        }
    }
    is_behind
}
