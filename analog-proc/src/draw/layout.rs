//! A layout: what stands in each column, and how high.

use super::symbol::Size;
use std::collections::HashMap;

/// Vertical distance between two wires that pass a column.
pub(super) const PASSAGE: f64 = 12.0;
/// Clear distance between blocks.
pub(super) const CLEARANCE: f64 = 20.0;

/// What stands at a place of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Item {
    Block(usize),
    /// A wire of a net that passes the column; `back` from right to left.
    Passage {
        net: usize,
        back: bool,
    },
}

/// One item with its place.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) item: Item,
    pub(super) layer: usize,
    pub(super) y: f64,
    pub(super) above: f64,
    pub(super) below: f64,
}

/// A wire between two items of neighbouring columns (or, fed back, of the same one).
pub(super) struct Link {
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) a_offset: f64,
    pub(super) b_offset: f64,
    pub(super) weight: f64,
}

/// All items placed.
pub(super) struct Layout {
    pub(super) items: Vec<Placed>,
    pub(super) index: HashMap<(usize, Item), usize>,
    pub(super) sizes: Vec<Size>,
    /// Height of each port above or below its block's middle.
    pub(super) port_offsets: Vec<Vec<f64>>,
}

/// Columns in the order of a sweep.
pub(super) fn sweep(columns: usize, forward: bool) -> impl Iterator<Item = usize> {
    (0..columns).map(move |at| if forward { at } else { columns - 1 - at })
}
