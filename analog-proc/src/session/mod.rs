//! The analog side of a session: requests, frames, converters.

pub mod channels;
pub mod frame_cycle;
mod free_run;
pub mod serve;
pub mod static_check;
