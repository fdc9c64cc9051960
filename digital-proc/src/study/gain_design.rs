//! Design of the gain schedule by repeated runs on the hybrid machine.
//!
//! Three steps, as the paper goes through them (§4.2). For each interval of the sequencer the
//! gains are improved by a coordinate search ([`search`]) whose cost ([`criteria`]) is measured
//! on the patched pitch loop at both ends of the interval ([`design`]). Then intervals are
//! merged, as long as long-period flights keep within the load and trajectory limits
//! ([`merge`]). At last the merged schedule goes back to the short-period model ([`evaluate`]),
//! which the flights cannot replace: they do not see an overshoot. [`outcome`] goes through all
//! three and shows them.

pub mod criteria;
pub mod design;
pub mod evaluate;
pub mod merge;
pub mod outcome;
pub mod schedule;
pub mod search;
pub mod verdict;
