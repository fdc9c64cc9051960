//! Modes of the computer and the static check.
//!
//! Pot-set is the time before a [`crate::simulation::Simulation`] exists: settings
//! are parts of the patch. Problem time runs in OPERATE only.

use crate::net::NetId;

/// Mode of the whole computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Integrators stand at their initial conditions.
    InitialCondition,
    /// Integrators integrate.
    Operate,
    /// Integrators keep their outputs; problem time stands still.
    Hold,
}

/// What the static check found to differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// The net.
    pub net: NetId,
    /// The derivative differs, not the output.
    pub derivative: bool,
    /// Value in the patch.
    pub expected: f64,
    /// Value found; undefined for a derivative of a block that is no integrator.
    pub found: f64,
    /// Tolerance in the patch.
    pub tolerance: f64,
}
