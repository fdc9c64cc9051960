//! The array in operation: program, methods, crossings, runs. No files, no links, no text.
//!
//! A [`machine::Machine`] is the program of a patch, flat and immutable; who lowers a patch
//! fills it, so that all of it is public. A [`simulation::Simulation`] runs it.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

pub mod element;
mod evaluate;
mod event;
pub mod fault;
pub mod id;
mod integrate;
pub mod integration;
#[allow(missing_docs)]
pub mod kernel;
pub mod linear;
pub mod machine;
pub mod mode;
#[allow(missing_docs)]
pub mod op;
mod operate;
pub mod outlook;
pub mod overload;
mod pass;
pub mod remark;
#[allow(missing_docs)]
pub mod signal;
pub mod simulation;
mod statistics;
