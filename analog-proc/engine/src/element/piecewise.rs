//! Elements with regions: everything whose right-hand side has corners or jumps.
//!
//! Within a step the region is frozen, so that the equations are smooth. A region
//! has one or more sides ([`Piecewise::sides`]), each a smooth function that is
//! positive beyond it. The region is chosen anew only at events, by
//! [`Piecewise::choose`], and the two agree: it is kept while no side is positive, by
//! more than the rounding of a signal that returns.

use crate::element::curve::Curve;
use crate::element::friction::Friction;
use crate::element::integrator::Stops;
use crate::element::surface::Cell;
use crate::op::{Slot, Term};

/// Region of an element that has not been settled yet.
pub const UNSET: u32 = u32::MAX;

/// Regions of an arctangent: y ≥ 0, y < 0, and y ≤ 0 of a vector that leaves zero downward.
pub(crate) const LOWER_SHEET: u32 = 1;
pub(crate) const LEFT_DOWNWARD: u32 = 2;

/// What cannot be passed: it ends the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fatal {
    DividedByZero,
    NegativeRoot,
}

/// What choosing a region did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Choice {
    pub moved: bool,
    pub overloaded: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum Piecewise {
    Curve(Curve),
    /// Dead zone whose half width is a net.
    DeadZone {
        u: Term,
        width: Slot,
    },
    /// Limiter whose levels are nets. Where they have crossed, the upper one holds.
    Limiter {
        u: Term,
        low: Slot,
        high: Slot,
    },
    /// The term, of `len` from `start`, that is greatest after multiplication by `sign`.
    Extremum {
        start: u32,
        len: u32,
        sign: f64,
    },
    Comparator {
        u: Term,
        on_above: f64,
        off_at: f64,
    },
    Relay {
        u: Term,
        points: [f64; 2],
        outputs: [f64; 2],
        initially_on: bool,
    },
    Friction(Friction),
    Cell(Cell),
    /// Half plane of an arctangent.
    Sheet {
        y: Term,
    },
    Divisor {
        u: Term,
    },
    Radicand {
        u: Term,
    },
    /// Latches once `|net|` exceeds the level.
    Overload {
        net: Slot,
        level: f64,
    },
    Stops(Stops),
}

impl Piecewise {
    /// The most sides that any region has.
    pub fn side_count(&self) -> usize {
        match self {
            Piecewise::Curve(_)
            | Piecewise::DeadZone { .. }
            | Piecewise::Limiter { .. }
            | Piecewise::Friction(_)
            | Piecewise::Overload { .. }
            | Piecewise::Stops(_) => 2,
            Piecewise::Extremum { len, .. } => *len as usize - 1,
            Piecewise::Cell(_) => 4,
            Piecewise::Comparator { .. }
            | Piecewise::Relay { .. }
            | Piecewise::Sheet { .. }
            | Piecewise::Divisor { .. }
            | Piecewise::Radicand { .. } => 1,
        }
    }

    /// The net that an overload witness watches.
    pub fn watched_net(&self) -> Option<Slot> {
        match self {
            Piecewise::Overload { net, .. } => Some(*net),
            _ => None,
        }
    }

    /// Whether its output jumps where a region is left.
    pub fn jumps(&self) -> bool {
        matches!(self, Piecewise::Comparator { .. } | Piecewise::Relay { .. })
    }

    /// The fault of leaving the region within a step, where that is one whatever else
    /// happens at that instant.
    pub fn fatal(&self) -> Option<Fatal> {
        match self {
            Piecewise::Divisor { .. } => Some(Fatal::DividedByZero),
            _ => None,
        }
    }
}
