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
mod weights;

pub use fold::fold;

use crate::op::{Op, Slot};
use rows::Rows;
pub(crate) use weights::{Place, Scaled};

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
    pub(crate) fn weights(&mut self) -> &mut [f64] {
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
    pub(crate) dacs: Vec<(Slot, u32)>,
    pub(crate) steps: Vec<Step>,
    pub(crate) others: Vec<Op>,
    /// Nets of the long sums.
    pub(crate) slots: Vec<Slot>,
    pub(crate) rows: Rows,
    /// What no derivative reads, or only in folded form.
    pub(crate) rest: Vec<Op>,
    pub(crate) weights: Vec<f64>,
    pub(crate) scaled: Vec<Scaled>,
}

impl Kernel {
    /// Folded operations with every coefficient unit at one; `Machine::load` sets them.
    pub fn steps(&self) -> Vec<Step> {
        self.steps.clone()
    }

    /// Weights of the rows, likewise.
    pub fn weights(&self) -> Vec<f64> {
        self.weights.clone()
    }

    /// Folded operations and rows of one derivative pass.
    pub fn operations(&self) -> usize {
        self.steps.len() + self.rows.len()
    }
}
