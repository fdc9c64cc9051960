//! The digital processor: trajectory, executive, studies and reports.
//!
//! It meets the analog side only through [`linkage`]. Numeric modules do no I/O; [`cli`] is
//! the only one that talks to the user.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

pub mod cli;
pub mod flight;
mod lab;
pub mod linkage;
mod matrix_exp;
pub mod report;
pub mod study;
