//! The engine against truths in closed form, where events are easily missed or mistaken.
//!
//! One file a concept. Every patch runs with default settings, as a user would run it; none
//! bounds its step. What is counted must be exact. What is integrated is compared at 1e-8
//! relative, the claim of the default settings, unless a test says otherwise.

#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

#[path = "../common/bench.rs"]
mod bench;
#[path = "../common/roots.rs"]
mod roots;

mod angles;
mod corners;
mod counts;
mod delays;
mod faults;
mod fixed_steps;
mod friction;
mod integrals;
mod order;
mod polynomials;
mod shipped;
mod sizes;

use bench::close;
use std::f64::consts::TAU;
