//! digital-proc
#![cfg_attr(test, allow(clippy::unwrap_used))]
pub mod atmosphere;
pub mod gain_schedule;
pub mod pitch_programme;
pub mod rk4;
pub mod table;
pub mod table_edges;
pub mod vehicle;
