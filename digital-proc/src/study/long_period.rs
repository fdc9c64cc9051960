//! Long-period study (paper §4.2): operating modes flown to burn-out.
//!
//! Every mode of a failure file is flown on the hybrid machine, flight after
//! flight in one session ([`run`]): in the design case (headwind and nominal
//! misalignments), over an envelope of thrust misalignments, and in a tailwind.
//! The results ([`results`], time histories in [`history`]) are judged against the paper's sentences
//! ([`claims`]). Nothing here opens a session or writes a file.

pub mod claims;
pub mod history;
pub mod results;
pub mod run;
