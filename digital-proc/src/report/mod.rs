//! Reports: figures, tables and pages made from a run's data.
//!
//! Every component is a function from data to markup. A page is one file without
//! references to anything outside itself, complete without its script; it is read on a light
//! or a dark screen and on paper. Nothing here judges: verdicts and numbers come from the caller.

mod block_diagram;
pub mod flight;
pub mod pacing;

pub use block_diagram::block_diagram;
