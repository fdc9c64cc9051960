//! A patched control loop as an instrument, and a plan run on it: one session, run after run.
//!
//! A patch is loaded once and then, for each run, the machine goes to IC, its coefficients
//! are set in one request and it operates (rep-op). Nothing is restarted in between. The
//! digital side only reads while a run operates, so that the frame cycle's latency (one
//! frame) changes no number and lets both sides work in parallel.
//!
//! A run that diverges until the machine refuses to go on answers with what was sampled
//! before, and says so; it does not end the study. A lost partner or a refused setting does.

use super::{
    coefficients::Settings,
    control_loop::{ControlLoop, Response},
    plan::Plan,
    results::{Occurrence, Results, Run},
};
use crate::linkage::console::{Console, ConsoleFault};
use interface::{
    Tick,
    control::{ChannelKind, Clock, PatchBundle, RunSpec},
    frame::{Samples, Updates},
    profile::Profile,
};

/// The two patches of the study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patches {
    /// The pitch loop.
    pub pitch: PatchBundle,
    /// The yaw and roll loops.
    pub yaw_roll: PatchBundle,
}

impl Patches {
    /// As shipped.
    pub fn shipped() -> Patches {
        macro_rules! files {
            ($($name:literal),*) => {
                [$(($name, include_str!(concat!("../../../../patch-files/", $name)))),*]
                    .map(|(name, text)| (name.to_owned(), text.to_owned()))
                    .into()
            };
        }
        Patches {
            pitch: PatchBundle {
                root: "pitch-loop.toml".to_owned(),
                files: files!["pitch-loop.toml", "sub/stage-plane.toml", "sub/fin-tip.toml"],
            },
            yaw_roll: PatchBundle {
                root: "yaw-roll-loop.toml".to_owned(),
                files: files!["yaw-roll-loop.toml", "sub/stage-plane.toml", "sub/fin-tip.toml"],
            },
        }
    }

    fn of(&self, control_loop: ControlLoop) -> &PatchBundle {
        match control_loop {
            ControlLoop::Pitch => &self.pitch,
            ControlLoop::YawRoll => &self.yaw_roll,
        }
    }
}

/// A loaded patch with the numbers of its sampled channels.
pub struct Bench {
    control_loop: ControlLoop,
    adc: Vec<usize>,
}

impl Bench {
    /// Loads the patch of a loop and looks its channels up.
    pub fn load(
        console: &mut Console<'_>,
        control_loop: ControlLoop,
        patches: &Patches,
        profile: &Profile,
    ) -> Result<Bench, ConsoleFault> {
        console.load(patches.of(control_loop).clone(), Vec::new(), profile.clone())?;
        let channels = control_loop.channels().iter();
        let adc = channels.map(|channel| console.channel(ChannelKind::Adc, channel.adc));
        Ok(Bench { control_loop, adc: adc.collect::<Result<_, _>>()? })
    }

    /// The shipped pitch loop.
    pub fn pitch(console: &mut Console<'_>, profile: &Profile) -> Result<Bench, ConsoleFault> {
        Bench::load(console, ControlLoop::Pitch, &Patches::shipped(), profile)
    }

    /// One run from its initial conditions, sampled once a `frame`, with what happened in it.
    ///
    /// # Errors
    /// [`ConsoleFault`]: a refused setting or a lost partner, but not a run that diverges.
    pub fn run(
        &self,
        console: &mut Console<'_>,
        settings: &Settings,
        frame: Tick,
        stop: Tick,
    ) -> Result<(Response, Vec<Occurrence>), ConsoleFault> {
        // The initial conditions first: they reset what a stopped run left behind.
        console.set_ics(owned(settings.initial_conditions()))?;
        console.preset(&console.settings(&settings.values())?)?;
        let mut response = Response::new(self.control_loop, frame.secs());
        let mut saturated = false;
        let spec = RunSpec {
            frame,
            latency: frame,
            skew: Tick::ZERO,
            stop,
            from_ic: true,
            clock: Clock::LockStep,
        };
        let ended = console.run(&spec, &mut |samples: &Samples, _: &mut Updates| {
            response.push(self.adc.iter().map(|&channel| samples.adc[channel]));
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

/// Runs a whole plan; `progress` is told the number of runs done.
pub fn run(
    console: &mut Console<'_>,
    plan: &Plan,
    patches: &Patches,
    profile: &Profile,
    mut progress: impl FnMut(usize),
) -> Result<Results, ConsoleFault> {
    let mut runs = Vec::with_capacity(plan.cases.len());
    let mut hashes = Vec::new();
    for control_loop in ControlLoop::ALL {
        let mut cases = plan.of(control_loop).peekable();
        if cases.peek().is_none() {
            continue;
        }
        let bench = Bench::load(console, control_loop, patches, profile)?;
        hashes.push((patches.of(control_loop).root.clone(), console.patch_hash().to_owned()));
        for case in cases {
            let stop = plan.sample * plan.samples() as i64;
            let (response, seen) = bench.run(console, &case.settings, plan.sample, stop)?;
            runs.push(Run::new(plan, case, response, seen));
            progress(runs.len());
        }
    }
    Ok(Results { plan: plan.clone(), runs, patches: hashes })
}
