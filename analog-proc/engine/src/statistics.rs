//! What a run has counted.

/// Counts since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Evaluations of the derivatives, those for locating events included.
    pub evaluations: u64,
    /// Instants at which something switched.
    pub events: u64,
    /// Interrupt edges dropped because nobody took them.
    pub edges_lost: u64,
}
