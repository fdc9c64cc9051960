//! Machine profile: the numbers of one hybrid machine, with their provenance.

use serde::{Deserialize, Serialize};

/// Placeholder until the complete profile lands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Name of the profile.
    pub name: String,
}
