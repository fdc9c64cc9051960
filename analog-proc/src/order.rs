//! Checked → ordered: an evaluation order in which every net is computed before it is read.

use crate::net::{BlockId, Netlist};

/// A checked net with its evaluation order. Only the checker makes one.
#[derive(Clone, Debug)]
pub struct Ordered {
    /// The checked net.
    pub netlist: Netlist,
    /// Blocks in order of evaluation: stores first, then each block after those it reads.
    pub order: Vec<BlockId>,
}
