//! What a run has counted.

use serde::{Deserialize, Serialize};

/// Counts since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
