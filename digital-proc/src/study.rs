//! The studies of the paper's section 4. Nothing here opens a session or writes a file.

pub mod case_study;
pub mod fault;
pub mod gain_design;
pub mod long_period;
pub mod profile_cost;
pub mod sensitivity;
pub mod short_period;
