//! Reports: figures, tables and pages made from a run's data.
//!
//! Every component is a function from data to markup. A page is one file without
//! references to anything outside itself, complete without its script; it is read on a light
//! or a dark screen and on paper. Nothing here judges: verdicts and numbers come from the caller.

mod block_diagram;
pub mod case_study;
pub mod flight;
pub mod gain_design;
pub mod long_period;
pub mod pacing;
pub mod sensitivity;
pub mod short_period;

pub use block_diagram::block_diagram;
