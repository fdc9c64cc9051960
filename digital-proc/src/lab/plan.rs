//! What one run of an experiment asks of the machine.

use super::theory::{TheoryError, hold::Hold};
use crate::lab::identify::IdentifyError;
use interface::Tick;

/// Patch, parameters and timing of one run; the reader maps it to a profile and a run request.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// Patch file, relative to `patch-files/`.
    pub patch: &'static str,
    /// Values for its `[params]`.
    pub params: Vec<(&'static str, f64)>,
    /// Frame T.
    pub frame: Tick,
    /// Latency τ.
    pub latency: Tick,
    /// Skew δ between ADC channels.
    pub skew: Tick,
    /// End of the run.
    pub stop: Tick,
    /// Reconstruction of every DAC.
    pub hold: Hold,
}

/// Why an experiment cannot be set up or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LabError {
    /// A setting is out of range.
    #[error("{what} is {value}; it must be {range}")]
    Setting {
        /// Which.
        what: &'static str,
        /// Value.
        value: f64,
        /// Range in words.
        range: &'static str,
    },
    /// No theory for this setting.
    #[error(transparent)]
    Theory(#[from] TheoryError),
    /// The record says nothing.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
}

/// Seconds as a tick, refused when out of range.
pub(crate) fn tick(what: &'static str, seconds: f64) -> Result<Tick, LabError> {
    Tick::from_secs(seconds).filter(|t| t.0 >= 0).ok_or(LabError::Setting {
        what,
        value: seconds,
        range: "a duration of 0 to 292 years",
    })
}

/// Refuses `value` unless `ok`.
pub(crate) fn require(
    what: &'static str,
    value: f64,
    ok: bool,
    range: &'static str,
) -> Result<(), LabError> {
    if ok && value.is_finite() { Ok(()) } else { Err(LabError::Setting { what, value, range }) }
}
