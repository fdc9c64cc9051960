//! The machine as a user meets it: two real processes, started, joined, killed.
#![allow(clippy::unwrap_used, missing_docs)]

mod bench_top;
mod determinism;
mod faults;
mod flight;
mod gain_design;
mod long_period;
mod partition;
mod sessions;
