//! Long-period study (paper §4.2): operating modes flown to burn-out.
//!
//! Every mode of a failure file is flown on the hybrid machine, flight after flight in one
//! session ([`run`]): in the design case (headwind and nominal misalignments), over an envelope
//! of thrust misalignments, and in a tailwind. The results ([`results`]) are judged against the
//! paper's sentences ([`claims`]) and shown ([`outcome`]).

pub mod claims;
pub mod moment;
pub mod outcome;
pub mod results;
pub mod run;
