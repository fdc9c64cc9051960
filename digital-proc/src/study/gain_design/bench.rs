//! The patched pitch loop as an instrument: settings in, response out.
//!
//! The patch is loaded once; every run starts from initial conditions with other
//! coefficients (rep-op). A run that diverges answers with what was sampled
//! before it stopped.

use crate::{
    console::{Console, ConsoleFault},
    study::short_period::{
        coefficients::PitchSettings,
        response::{PITCH_CHANNELS, PitchResponse},
    },
};
use interface::{
    Tick,
    control::{ChannelKind, Clock, PatchBundle, RunSpec},
    profile::Profile,
};

/// Sampling interval of a run.
const SAMPLE: Tick = Tick(10_000_000);

/// The pitch patch and its sub-patches, as shipped.
#[must_use]
pub fn pitch_patch() -> PatchBundle {
    let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    PatchBundle {
        root: "pitch-loop.toml".to_owned(),
        files: vec![
            file(
                "pitch-loop.toml",
                include_str!("../../../../patch-files/pitch-loop.toml"),
            ),
            file(
                "sub/stage-plane.toml",
                include_str!("../../../../patch-files/sub/stage-plane.toml"),
            ),
            file(
                "sub/fin-tip.toml",
                include_str!("../../../../patch-files/sub/fin-tip.toml"),
            ),
        ],
    }
}

/// The loaded pitch loop.
pub struct PitchBench {
    channels: [usize; PITCH_CHANNELS.len()],
}

impl PitchBench {
    /// Loads the pitch patch.
    ///
    /// # Errors
    /// [`ConsoleFault`]: the machine or its link.
    pub fn load(console: &mut Console<'_>, profile: &Profile) -> Result<PitchBench, ConsoleFault> {
        console.load(pitch_patch(), Vec::new(), profile.clone())?;
        let mut channels = [0; PITCH_CHANNELS.len()];
        for (channel, name) in channels.iter_mut().zip(PITCH_CHANNELS) {
            *channel = console.channel(ChannelKind::Adc, name)?;
        }
        Ok(PitchBench { channels })
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
        // To IC first: a run that diverged leaves nets at which nothing can be set.
        console.set_ics(Vec::new())?;
        let values = settings.settings().into_iter();
        console.preset(values.map(|(name, v)| (name.to_owned(), v)).collect())?;
        let spec = RunSpec {
            frame: SAMPLE,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            stop: Tick::from_secs(duration_s).unwrap_or(Tick::ZERO),
            from_ic: true,
            clock: Clock::LockStep,
        };
        let mut response = PitchResponse::new(SAMPLE.secs());
        let ran = console.operate::<ConsoleFault>(&spec, |samples, _| {
            response.push(self.channels.map(|c| samples.adc[c]));
            Ok(())
        });
        match ran {
            Ok(_) | Err(ConsoleFault::RunFault { .. }) => Ok(response),
            Err(fault) => Err(fault),
        }
    }
}
