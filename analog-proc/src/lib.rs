//! The analog processor: a parallel array of continuously integrated blocks.
//!
//! A patch passes through stages, each a type of its own, so that an unchecked
//! net cannot run: text → net → checked → ordered → machine.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod check;
pub mod net;
pub mod order;
pub mod patch;
