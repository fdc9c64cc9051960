//! The user's side of both processors: files read, faults told, runs kept, reports drawn.
// Names carry their units; what a name says has no sentence beside it.
#![allow(missing_docs)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

pub mod bundle;
#[cfg(feature = "runs")]
pub mod checkpoint;
pub mod claim;
pub mod command_line;
pub mod failure;
pub mod faults;
#[cfg(feature = "runs")]
pub mod outcome;
pub mod profile;
#[cfg(feature = "runs")]
pub mod progress;
pub mod reader;
#[cfg(feature = "runs")]
pub mod report;
#[cfg(feature = "runs")]
mod run;
#[cfg(feature = "runs")]
pub mod run_dir;
#[cfg(feature = "runs")]
pub mod shell;
pub mod user_file;
