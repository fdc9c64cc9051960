//! Overload: a block beyond its reference, latched with the located time.

use crate::id::BlockId;
use serde::{Deserialize, Serialize};

/// An amplifier overloads where its output exceeds this many times its `max`.
pub const OVERLOAD_FACTOR: f64 = 1.1;

/// One latched overload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatchedOverload {
    /// The block.
    pub block: BlockId,
    /// Located problem time, s.
    pub t_s: f64,
    /// Output of the block then, problem units.
    pub value: f64,
}
