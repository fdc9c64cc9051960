//! What blocks become: elements with regions, sources, stores and delay lines.
#![allow(missing_docs)]

mod choose;
pub mod curve;
pub mod dac;
pub mod delay;
pub mod friction;
pub mod integrator;
pub mod logic;
pub mod pace;
pub mod piecewise;
pub mod source;
pub mod surface;
