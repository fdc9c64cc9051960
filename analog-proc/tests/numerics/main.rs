//! The engine against analytic solutions.
//!
//! One module a claim. Each tolerance carries its derivation; the default settings
//! claim 1e-8 relative of integrated results.

#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

#[path = "../common/mod.rs"]
mod common;

mod attention;
mod blocks_exact;
mod events;
mod faults;
mod invariance;
mod orders;

use common::{Patch, integrator};
use engine::element::logic::Edge;
use engine::integration::Method;
use engine::simulation::Simulation;

/// Takes the interrupt edges so far.
fn edges(simulation: &mut Simulation) -> Vec<Edge> {
    let mut out = Vec::new();
    simulation.take_edges(&mut out);
    out
}

/// x = cos 2t, by `method`.
fn oscillator(method: Method) -> Patch {
    let mut patch = Patch::with(method);
    patch.add("x", integrator(1.0), &["v"]);
    patch.add("v", integrator(0.0), &["-4 * x"]);
    patch
}
