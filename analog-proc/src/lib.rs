//! The analog processor: a parallel array of continuously integrated blocks.
//!
//! A patch passes through stages, each a type of its own, so that a net with faults
//! cannot run: text → net → ordered → machine.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

pub mod block;
pub mod check;
pub mod cli;
pub mod draw;
pub mod net;
pub mod order;
pub mod patch;
pub mod record;
pub mod session;
pub mod tolerance;
