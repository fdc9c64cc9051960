//! The analog side of a session: requests, frames, converters.

mod board;
mod channels;
mod frame_cycle;
mod free_run;
pub mod serve;
pub mod static_check;
mod sweep;
