//! The studies of the paper's section 4.

pub mod claim;
pub mod fault;
pub mod short_period;
