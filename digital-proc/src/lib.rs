//! digital-proc
#![cfg_attr(test, allow(clippy::unwrap_used))]
pub mod airframe;
pub mod atmosphere;
pub mod flight_mode;
pub mod flight_summary;
pub mod gain_schedule;
pub mod pitch_programme;
pub mod reference;
pub mod rk4;
pub mod table;
pub mod table_edges;
pub mod trajectory;
pub mod vehicle;
pub mod wind;
