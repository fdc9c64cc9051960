//! The pitch loop of the short-period study, run for as long as a criterion looks.

use crate::{
    console::{Console, ConsoleFault},
    study::short_period::{
        bench::Bench,
        coefficients::PitchSettings,
        machine::Patches,
        response::{PITCH_CHANNELS, PitchResponse},
    },
};
use interface::{
    Tick,
    control::{Clock, RunSpec},
    profile::Profile,
};

/// Sampling interval of a run.
const SAMPLE: Tick = Tick(10_000_000);

/// The loaded pitch loop.
pub struct PitchBench(Bench<{ PITCH_CHANNELS.len() }>);

impl PitchBench {
    /// Loads the pitch patch.
    ///
    /// # Errors
    /// [`ConsoleFault`]: the machine or its link.
    pub fn load(console: &mut Console<'_>, profile: &Profile) -> Result<PitchBench, ConsoleFault> {
        let patch = Patches::shipped().pitch;
        Ok(PitchBench(Bench::load(console, &patch, profile, &PITCH_CHANNELS)?))
    }

    /// One run from rest; samples every 10 ms.
    ///
    /// # Errors
    /// [`ConsoleFault`]: the machine or its link, but not a diverging run.
    pub fn run(
        &self,
        console: &mut Console<'_>,
        settings: &PitchSettings,
        duration_s: f64,
    ) -> Result<PitchResponse, ConsoleFault> {
        let spec = RunSpec {
            frame: SAMPLE,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            stop: Tick::from_secs(duration_s).unwrap_or(Tick::ZERO),
            from_ic: true,
            clock: Clock::LockStep,
        };
        let (response, _) = self.0.run(console, SAMPLE.secs(), &spec, settings)?;
        Ok(response)
    }
}
