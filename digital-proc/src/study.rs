//! The studies of the paper's section 4.

pub mod case_study;
pub(crate) mod evidence;
pub mod gain_design;
pub mod long_period;
pub mod sensitivity;
pub mod short_period;
