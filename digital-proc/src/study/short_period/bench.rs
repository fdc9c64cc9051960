//! A patched control loop as an instrument: settings in, response out.
//!
//! The patch is loaded once; every run goes to IC and starts with other coefficients
//! (rep-op). A run that diverges until the machine refuses to go on answers with what was
//! sampled before, and says so; only a lost partner or a refused setting is a fault.

use super::coefficients::{PitchSettings, YawRollSettings};
use super::response::{Channel, Response};
use crate::console::{Console, ConsoleFault};
use interface::{
    Tick,
    control::{ChannelKind, PatchBundle, RunSpec},
    frame::{Samples, Updates},
    profile::Profile,
};

/// What may happen in a run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Occurrence {
    /// The machine stopped it; its samples end there.
    #[error("stopped at {time}: {fault}")]
    Stopped {
        /// Problem time of the last frame.
        time: Tick,
        /// The analog side's account.
        fault: String,
    },
    /// A converter or coefficient unit was driven beyond its range.
    #[error("a converter was saturated")]
    Saturated,
    /// Blocks were overloaded: their names, in order of time.
    #[error("overloaded: {}", .0.join(", "))]
    Overloaded(Vec<String>),
}

/// What the bench asks of a run of either loop.
pub(crate) trait Case {
    /// Coefficients, converters and control lines by name.
    fn settings(&self) -> Vec<(&'static str, f64)>;
    /// Initial conditions by integrator name; the others stand as patched.
    fn initial_conditions(&self) -> Vec<(&'static str, f64)>;
}

impl Case for PitchSettings {
    fn settings(&self) -> Vec<(&'static str, f64)> {
        PitchSettings::settings(self)
    }

    fn initial_conditions(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}

impl Case for YawRollSettings {
    fn settings(&self) -> Vec<(&'static str, f64)> {
        YawRollSettings::settings(self)
    }

    fn initial_conditions(&self) -> Vec<(&'static str, f64)> {
        YawRollSettings::initial_conditions(self).to_vec()
    }
}

/// A loaded patch with the numbers of its `N` sampled channels.
pub(crate) struct Bench<const N: usize> {
    adc: [usize; N],
}

impl<const N: usize> Bench<N> {
    /// Loads the patch and looks its channels up.
    pub(crate) fn load(
        console: &mut Console<'_>,
        patch: &PatchBundle,
        profile: &Profile,
        channels: &[Channel; N],
    ) -> Result<Self, ConsoleFault> {
        console.load(patch.clone(), Vec::new(), profile.clone())?;
        let mut adc = [0; N];
        for (number, channel) in adc.iter_mut().zip(channels) {
            *number = console.channel(ChannelKind::Adc, channel.adc)?;
        }
        Ok(Bench { adc })
    }

    /// Name of the patch, and the hash of what was loaded.
    pub(crate) fn identity(&self, console: &Console<'_>, patch: &PatchBundle) -> (String, String) {
        (patch.root.clone(), console.patch_hash().to_owned())
    }

    /// One run from its initial conditions, with what happened in it.
    pub(crate) fn run(
        &self,
        console: &mut Console<'_>,
        sample_s: f64,
        spec: &RunSpec,
        case: &impl Case,
    ) -> Result<(Response<N>, Vec<Occurrence>), ConsoleFault> {
        // The initial conditions first: they reset what a stopped run left behind.
        console.set_ics(owned(case.initial_conditions()))?;
        console.preset(&console.settings(&case.settings())?)?;
        let mut response = Response::new(sample_s);
        let mut saturated = false;
        let ended = console.run(spec, &mut |samples: &Samples, _: &mut Updates| {
            response.push(self.adc.map(|channel| samples.adc[channel]));
            saturated |= samples.adc_saturated | samples.dac_saturated != 0
                || samples.dcu_saturated != [0; 2];
        });
        let mut seen = Vec::new();
        match ended {
            Ok(last) if last.overloads > 0 => {
                let overloads = console.diagnose()?.overloads;
                seen.push(Occurrence::Overloaded(overloads.into_iter().map(|o| o.block).collect()));
            }
            Ok(_) => {}
            Err(ConsoleFault::RunFault { time, fault }) => {
                seen.push(Occurrence::Stopped { time, fault });
            }
            Err(fault) => return Err(fault),
        }
        if saturated {
            seen.push(Occurrence::Saturated);
        }
        Ok((response, seen))
    }
}

fn owned(values: Vec<(&'static str, f64)>) -> Vec<(String, f64)> {
    values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
