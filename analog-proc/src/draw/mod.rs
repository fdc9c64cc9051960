//! Wiring diagrams: a patch in the symbols of analog computation, as SVG.
//!
//! Signals run from left to right, feedback from right to left; solid wires are
//! analog, dashed ones logic. Coefficients stand beside the inputs, initial
//! conditions above the integrators. A large patch shows its long wires as
//! named tags. The drawing shows the patch that would run: sub-patches are
//! expanded and parameters put in.

mod columns;
mod graph;
mod label;
mod layout;
mod level;
mod pen;
mod place;
mod route;
mod sheet;
mod symbol;

pub(crate) use label::number;
pub(crate) use pen::{Pen, round};

use crate::order::Ordered;

/// Draws a patch.
pub fn svg(ordered: &Ordered) -> String {
    sheet::Sheet::new(ordered).document().into_string()
}
