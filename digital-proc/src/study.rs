//! The studies of the paper's section 4. Nothing here opens a session or writes a file.

pub mod bending_moment;
pub mod case_study;
pub mod catalogue;
pub mod fault;
pub mod gain_design;
pub(crate) mod gyro_location;
pub mod long_period;
pub mod profile_cost;
pub mod roll_drift;
pub mod sensitivity;
pub mod short_period;
pub mod tankage;
