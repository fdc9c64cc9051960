//! digital-proc
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod report;
pub mod run_dir;
