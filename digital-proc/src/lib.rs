//! The digital processor: trajectory, executive, studies and reports.
//!
//! It meets the analog side only through `interface`: a [`console`] names its
//! channels, [`launch`] starts it, [`executive`] says which task is due when.
//! Numeric modules do no I/O; [`cli`] is the only one that talks to the user.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

pub mod cli;
pub mod console;
pub mod executive;
pub mod flight;
mod lab;
pub mod launch;
mod matrix_exp;
pub mod report;
pub mod saturation;
pub mod study;
