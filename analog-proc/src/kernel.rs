//! The derivative program: only what the derivatives depend on, folded.
//!
//! A method evaluates the derivatives many times a step, but the nets are looked
//! at only at its end. So the flat program is divided: what no derivative reads
//! (converters, monitors) is left for the end of the step, and the remainder is
//! folded as a programmer would fold it by hand. A gain, inverter or coefficient
//! unit becomes a factor of whoever reads it; a sum or a product that one
//! integrator reads becomes terms of its derivative; runs of like rows with
//! neighbouring nets (a rod, a chain) become loops over slices. Coefficients
//! that the digital side sets are multiplied into the weights when they change.
//!
//! A net that two blocks read is never taken apart: friction that balances a
//! force must cancel that very value. Every fold is fixed when the patch is
//! lowered, so that a patch has one order of rounding. It refuses to decide
//! regions, and to touch a net that anything but a derivative reads.

mod fold;
mod rows;

pub(crate) use fold::fold;

use crate::machine::{Frozen, Machine};
use crate::op::{Op, Slot};
use rows::Rows;

/// A weight that coefficient units take part in: `base · Π dcus`.
#[derive(Clone, Debug)]
struct Scaled {
    weight: usize,
    base: f64,
    dcus: Vec<u32>,
}

/// One folded operation; its weights lie side by side from `w`.
#[derive(Clone, Copy, Debug)]
enum Step {
    Sum1 {
        o: Slot,
        a: Slot,
        w: u32,
    },
    Sum2 {
        o: Slot,
        a: Slot,
        b: Slot,
        w: u32,
    },
    Sum3 {
        o: Slot,
        a: Slot,
        b: Slot,
        d: Slot,
        w: u32,
    },
    /// Of `len` nets, listed from `start`.
    Sum {
        o: Slot,
        start: u32,
        len: u32,
        w: u32,
    },
    Product {
        o: Slot,
        a: Slot,
        b: Slot,
        w: u32,
    },
    Curve1 {
        o: Slot,
        e: u32,
        a: Slot,
        w: u32,
    },
    Curve2 {
        o: Slot,
        e: u32,
        a: Slot,
        b: Slot,
        w: u32,
    },
    DeadZone1 {
        o: Slot,
        e: u32,
        a: Slot,
        w: u32,
        width: Slot,
    },
    DeadZone2 {
        o: Slot,
        e: u32,
        a: Slot,
        b: Slot,
        w: u32,
        width: Slot,
    },
    SinCos {
        o: Slot,
        a: Slot,
        w: u32,
    },
    Rotate {
        x: Slot,
        y: Slot,
        u: Slot,
        v: Slot,
        sin: Slot,
        w: u32,
    },
    /// As it was: operation `i` of the list.
    Other {
        i: u32,
    },
}

// The program is read through once a pass: two operations a cache line.
const _: () = assert!(size_of::<Step>() <= 32);

/// The derivative program of a machine.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kernel {
    steps: Vec<Step>,
    others: Vec<Op>,
    /// Nets of the long sums.
    slots: Vec<Slot>,
    rows: Rows,
    /// What no derivative reads, or only in folded form.
    rest: Vec<Op>,
    weights: Vec<f64>,
    scaled: Vec<Scaled>,
}

impl Kernel {
    /// Weights with every coefficient unit at one; [`Kernel::weigh`] sets them.
    pub fn weights(&self) -> Vec<f64> {
        self.weights.clone()
    }

    /// Multiplies the coefficients now held into the weights.
    pub fn weigh(&self, dcus: &[f64], weights: &mut [f64]) {
        for scaled in &self.scaled {
            let product = scaled
                .dcus
                .iter()
                .fold(scaled.base, |c, dcu| c * dcus[*dcu as usize]);
            weights[scaled.weight] = product;
        }
    }

    /// Folded operations and rows of one derivative pass.
    pub fn len(&self) -> usize {
        self.steps.len() + self.rows.len()
    }
}

impl Machine {
    /// Derivatives `d` of the states at `t_s`, with the states already in
    /// `nets[..states]`; brings up to date the nets that they depend on.
    #[inline]
    pub(crate) fn derivatives(&self, f: &Frozen, t_s: f64, nets: &mut [f64], d: &mut [f64]) {
        for step in &self.kernel.steps {
            self.step(step, f, t_s, nets);
        }
        self.kernel.rows.evaluate(&f.weights, nets, d);
        for (control, &running) in self.controls.iter().zip(&f.running) {
            if !running {
                d[control.state as usize] = 0.0;
            }
        }
    }

    /// After [`Machine::derivatives`], the varying nets that it left out.
    pub(crate) fn complete(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for op in &self.kernel.rest {
            self.evaluate(op, f, t_s, nets);
        }
    }

    #[inline(always)]
    fn step(&self, step: &Step, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        let weights = &f.weights[..];
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        // The weights of one operation, checked once.
        macro_rules! weights {
            ($w:expr, $n:literal) => {
                &weights[$w as usize..][..$n]
            };
        }
        match *step {
            Step::Sum1 { o, a, w } => net!(o) = weights[w as usize] * net!(a),
            Step::Sum2 { o, a, b, w } => {
                let w = weights!(w, 2);
                net!(o) = w[0] * net!(a) + w[1] * net!(b);
            }
            Step::Sum3 { o, a, b, d, w } => {
                let w = weights!(w, 3);
                net!(o) = w[0] * net!(a) + w[1] * net!(b) + w[2] * net!(d);
            }
            Step::Sum { o, start, len, w } => {
                let slots = &self.kernel.slots[start as usize..(start + len) as usize];
                let weights = &weights[w as usize..(w + len) as usize];
                let mut sum = 0.0;
                for (slot, w) in slots.iter().zip(weights) {
                    sum += w * net!(*slot);
                }
                net!(o) = sum;
            }
            Step::Product { o, a, b, w } => net!(o) = weights[w as usize] * net!(a) * net!(b),
            Step::Curve1 { o, e, a, w } => {
                net!(o) = f.piece[e as usize].at(weights[w as usize] * net!(a));
            }
            Step::Curve2 { o, e, a, b, w } => {
                let w = weights!(w, 2);
                net!(o) = f.piece[e as usize].at(w[0] * net!(a) + w[1] * net!(b));
            }
            Step::DeadZone1 { o, e, a, w, width } => {
                let u = weights[w as usize] * net!(a);
                net!(o) = crate::op::dead_zone(f.region[e as usize], u, net!(width));
            }
            Step::DeadZone2 {
                o,
                e,
                a,
                b,
                w,
                width,
            } => {
                let w = weights!(w, 2);
                let u = w[0] * net!(a) + w[1] * net!(b);
                net!(o) = crate::op::dead_zone(f.region[e as usize], u, net!(width));
            }
            Step::SinCos { o, a, w } => {
                let (sin, cos) = (weights[w as usize] * net!(a)).sin_cos();
                net!(o) = sin;
                net!(o + 1) = cos;
            }
            Step::Rotate { x, y, u, v, sin, w } => {
                let w = weights!(w, 3);
                let (u, v) = (w[0] * net!(u), w[1] * net!(v));
                let (s, c) = (w[2] * net!(sin), net!(sin + 1));
                net!(x) = u * c - v * s;
                net!(y) = u * s + v * c;
            }
            Step::Other { i } => self.evaluate(&self.kernel.others[i as usize], f, t_s, nets),
        }
    }
}
