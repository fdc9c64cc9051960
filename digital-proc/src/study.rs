//! The studies of the paper's section 4.

pub mod short_period;
