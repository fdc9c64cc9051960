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

pub use fold::fold;

use crate::machine::{Frozen, Machine};
use crate::op::{Op, Slot};
use crate::signal::Signal;
use rows::Rows;

/// Where a weight stands.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// In the flat array of the rows and long sums.
    Row(usize),
    /// The `k`-th of a folded operation.
    Step { index: usize, k: usize },
}

/// A weight that coefficient units take part in: `base · Π dcus`.
#[derive(Clone, Debug)]
struct Scaled {
    place: Place,
    base: f64,
    dcus: Vec<u32>,
}

/// One folded operation, with its weights.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    Sum1 {
        o: Slot,
        a: Slot,
        w: [f64; 1],
    },
    Sum2 {
        o: Slot,
        a: Slot,
        b: Slot,
        w: [f64; 2],
    },
    Sum3 {
        o: Slot,
        a: Slot,
        b: Slot,
        d: Slot,
        w: [f64; 3],
    },
    /// Of `len` nets, listed from `start`, weighted from `w`.
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
        w: [f64; 1],
    },
    Curve1 {
        o: Slot,
        e: u32,
        a: Slot,
        w: [f64; 1],
    },
    Curve2 {
        o: Slot,
        e: u32,
        a: Slot,
        b: Slot,
        w: [f64; 2],
    },
    DeadZone1 {
        o: Slot,
        e: u32,
        a: Slot,
        width: Slot,
        w: [f64; 1],
    },
    DeadZone2 {
        o: Slot,
        e: u32,
        a: Slot,
        b: Slot,
        width: Slot,
        w: [f64; 2],
    },
    SinCos {
        o: Slot,
        a: Slot,
        w: [f64; 1],
    },
    /// The third weight is the sense of rotation.
    Rotate {
        x: Slot,
        y: Slot,
        u: Slot,
        v: Slot,
        sin: Slot,
        w: [f64; 3],
    },
    /// As it was: operation `i` of the list.
    Other {
        i: u32,
    },
}

// The list is read through at every evaluation of the derivatives.
const _: () = assert!(size_of::<Step>() <= 48);

impl Step {
    fn weights(&mut self) -> &mut [f64] {
        match self {
            Step::Sum1 { w, .. }
            | Step::Product { w, .. }
            | Step::Curve1 { w, .. }
            | Step::DeadZone1 { w, .. }
            | Step::SinCos { w, .. } => w,
            Step::Sum2 { w, .. } | Step::Curve2 { w, .. } | Step::DeadZone2 { w, .. } => w,
            Step::Sum3 { w, .. } | Step::Rotate { w, .. } => w,
            Step::Sum { .. } | Step::Other { .. } => &mut [],
        }
    }
}

/// The derivative program of a machine.
#[derive(Clone, Debug, Default)]
pub struct Kernel {
    /// Nets of the converters, and what each holds.
    dacs: Vec<(Slot, u32)>,
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
    /// Folded operations with every coefficient unit at one; [`Kernel::load`] sets them.
    pub fn steps(&self) -> Vec<Step> {
        self.steps.clone()
    }

    /// Weights of the rows, likewise.
    pub fn weights(&self) -> Vec<f64> {
        self.weights.clone()
    }

    /// Multiplies the coefficients now held into the weights, and lists the converters
    /// whose output moves within a step; the nets of the others stand as settled.
    pub(crate) fn load(&self, f: &mut Frozen) {
        f.moving.clear();
        let moves = |dac: &&(Slot, u32)| !f.holds[dac.1 as usize].constant();
        f.moving.extend(self.dacs.iter().filter(moves));
        for scaled in &self.scaled {
            let product = scaled.dcus.iter().fold(scaled.base, |c, dcu| c * f.dcus[*dcu as usize]);
            match scaled.place {
                Place::Row(i) => f.weights[i] = product,
                Place::Step { index, k } => f.steps[index].weights()[k] = product,
            }
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
        self.steps(f, t_s, nets);
        self.kernel.rows.evaluate(&f.weights, nets, d);
        for (control, &running) in self.controls.iter().zip(&f.running) {
            if !running {
                d[control.state as usize] = 0.0;
            }
        }
    }

    /// Out of line, so that the rare operations do not crowd the frequent ones.
    #[inline(never)]
    fn other(&self, i: usize, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        self.evaluate(&self.kernel.others[i], f, t_s, nets);
    }

    /// The varying nets at `t_s`, without derivatives.
    pub(crate) fn outputs(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        self.steps(f, t_s, nets);
        self.complete(f, t_s, nets);
    }

    /// After [`Machine::derivatives`], the varying nets that it left out.
    pub(crate) fn complete(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for op in &self.kernel.rest {
            self.evaluate(op, f, t_s, nets);
        }
    }

    #[inline(always)]
    fn steps(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for (o, hold) in &f.moving {
            nets[*o as usize] = f.holds[*hold as usize].at_time(t_s);
        }
        for step in &f.steps {
            self.step(step, f, t_s, nets);
        }
    }

    #[inline(always)]
    fn step(&self, step: &Step, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        match *step {
            Step::Sum1 { o, a, w: [w] } => net!(o) = w * net!(a),
            Step::Sum2 { o, a, b, w } => net!(o) = w[0] * net!(a) + w[1] * net!(b),
            Step::Sum3 { o, a, b, d, w } => {
                net!(o) = w[0] * net!(a) + w[1] * net!(b) + w[2] * net!(d);
            }
            Step::Sum { o, start, len, w } => {
                let slots = &self.kernel.slots[start as usize..(start + len) as usize];
                let weights = &f.weights[w as usize..(w + len) as usize];
                let mut sum = 0.0;
                for (slot, w) in slots.iter().zip(weights) {
                    sum += w * net!(*slot);
                }
                net!(o) = sum;
            }
            Step::Product { o, a, b, w: [w] } => net!(o) = w * net!(a) * net!(b),
            Step::Curve1 { o, e, a, w: [w] } => {
                net!(o) = f.piece[e as usize].at(w * net!(a));
            }
            Step::Curve2 { o, e, a, b, w } => {
                net!(o) = f.piece[e as usize].at(w[0] * net!(a) + w[1] * net!(b));
            }
            Step::DeadZone1 { o, e, a, width, w: [w] } => {
                net!(o) = crate::op::dead_zone(f.region[e as usize], w * net!(a), net!(width));
            }
            Step::DeadZone2 { o, e, a, b, width, w } => {
                let u = w[0] * net!(a) + w[1] * net!(b);
                net!(o) = crate::op::dead_zone(f.region[e as usize], u, net!(width));
            }
            Step::SinCos { o, a, w: [w] } => {
                let (sin, cos) = Signal::sin_cos(w * net!(a));
                net!(o) = sin;
                net!(o + 1) = cos;
            }
            Step::Rotate { x, y, u, v, sin, w } => {
                let (u, v) = (w[0] * net!(u), w[1] * net!(v));
                let (s, c) = (w[2] * net!(sin), net!(sin + 1));
                net!(x) = u * c - v * s;
                net!(y) = u * s + v * c;
            }
            Step::Other { i } => self.other(i as usize, f, t_s, nets),
        }
    }
}
