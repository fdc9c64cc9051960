//! The machine as a user meets it: two real processes, started, joined, killed.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, missing_docs)]

mod bench_top;
mod case_study;
mod catalogue;
mod checkpoints;
mod determinism;
mod endings;
mod exercises;
mod faults;
mod flight;
mod frame_cycle;
mod gain_design;
mod golden;
mod json;
mod kills;
mod linear;
mod long_period;
mod loop_study;
mod loops;
mod partition;
mod pictures;
mod replay;
mod requests;
mod roll_drift;
mod sampling;
mod sessions;
mod surroundings;
mod sweep;
