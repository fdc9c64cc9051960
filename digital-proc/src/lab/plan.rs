//! What one run of an experiment asks of a machine.

use super::theory::{Refusal, hold::Hold, require};
use crate::{flight::FlightFault, linkage::console::ConsoleFault};
use desk::{failure::Failure, faults::FileFaults};
use interface::{
    Tick,
    control::{Clock, RunSpec},
    frame::{Samples, Updates},
};

/// What is loaded, how the run is timed, and what is read at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// Patch file, relative to `patch-files/`.
    pub patch: &'static str,
    /// Values for its `[params]`.
    pub params: Vec<(&'static str, f64)>,
    /// Reconstruction of every DAC.
    pub hold: Hold,
    /// Bits of every DAC where they are not the profile's.
    pub dac_bits: Option<u32>,
    pub spec: RunSpec,
    /// Nets whose values at the end are wanted.
    pub read: &'static [&'static str],
}

impl RunPlan {
    /// A plan with a zero-order hold and nothing else.
    pub fn new(
        patch: &'static str,
        frame_s: f64,
        latency_s: f64,
        stop_s: f64,
    ) -> Result<RunPlan, Refusal> {
        let frame = tick("the frame", frame_s)?;
        let (latency, stop) = (tick("the latency", latency_s)?, tick("the stop time", stop_s)?);
        let spec = lock_step(frame, latency, Tick::ZERO, stop);
        let hold = Hold::ZeroOrder;
        Ok(RunPlan { patch, params: Vec::new(), hold, dac_bits: None, spec, read: &[] })
    }
}

/// A run from the initial conditions in lock-step.
pub(super) fn lock_step(frame: Tick, latency: Tick, skew: Tick, stop: Tick) -> RunSpec {
    RunSpec { frame, latency, skew, stop, from_ic: true, clock: Clock::LockStep }
}

/// What runs plans: the [`Bench`](super::bench::Bench).
pub trait Machine {
    /// Runs a plan from its initial conditions. `law` is called once a frame; the last one,
    /// whose updates would never take effect, is left out. Gives the nets that are read.
    fn run(
        &mut self,
        plan: &RunPlan,
        law: &mut dyn FnMut(&Samples, &mut Updates),
    ) -> Result<Vec<f64>, LabError>;
}

/// Why an experiment gave no row.
#[derive(Debug, thiserror::Error)]
pub enum LabError {
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The machine or its link.
    #[error(transparent)]
    Console(#[from] ConsoleFault),
    /// A flight of the stage.
    #[error(transparent)]
    Flight(#[from] FlightFault),
    /// The user's study.
    #[error(transparent)]
    Study(#[from] FileFaults),
}

impl From<LabError> for Failure {
    fn from(fault: LabError) -> Failure {
        match fault {
            LabError::Console(fault) => fault.into(),
            LabError::Flight(fault) => fault.into(),
            LabError::Study(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}

/// Seconds as a tick, refused when out of range.
pub(super) fn tick(what: &'static str, seconds: f64) -> Result<Tick, Refusal> {
    let range = "a duration of 0 to 292 years";
    let tick = Tick::from_secs(seconds).filter(|t| t.0 >= 0);
    tick.ok_or(Refusal::Setting { what, value: seconds, range })
}

/// Refuses a latency, in frames, beyond one.
pub(super) fn require_latency(frames: f64) -> Result<f64, Refusal> {
    require("the latency", frames, (0.0..=1.0).contains(&frames), "0 to 1 frame")
}
