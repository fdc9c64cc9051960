//! Modes of the computer.
//!
//! Pot-set is the time before a [`crate::simulation::Simulation`] exists: settings
//! are parts of the patch. Problem time runs in OPERATE only.

use serde::{Deserialize, Serialize};

/// Mode of the whole computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// Integrators stand at their initial conditions.
    InitialCondition,
    /// Integrators integrate.
    Operate,
    /// Integrators keep their outputs; problem time stands still.
    Hold,
}
