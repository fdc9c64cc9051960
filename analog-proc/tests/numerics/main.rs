//! The engine against analytic solutions.
//!
//! One module a claim. Each tolerance carries its derivation; the default settings
//! claim 1e-8 relative of integrated results.

#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

#[path = "../common/bench.rs"]
mod bench;

mod attention;
mod blocks;
mod events;
mod faults;
mod invariance;
mod linear;
mod methods;

use bench::{Bench, close, tick};

/// x = cos 2t.
const OSCILLATOR: &str = r#"
    x = { kind = "integrator", in = ["v"], ic = 1.0 }
    v = { kind = "integrator", in = ["-4 * x"] }
"#;

/// The same by a method.
fn oscillator(method: &str) -> Bench {
    Bench::with(&format!("method = \"{method}\""), OSCILLATOR)
}
