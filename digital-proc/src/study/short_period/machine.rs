//! A patched control loop as an instrument, and a plan run on it: one session, run after run.
//!
//! A patch is loaded once; then the digital side asks for runs by the dozen, each with its
//! coefficients and initial conditions, and reads what was sampled (iterative operation).
//!
//! A run that diverges until the machine refuses to go on answers with what was sampled
//! before, and says so; it does not end the study. A lost partner or a refused setting does.

use super::{
    coefficients::Settings,
    control_loop::{ControlLoop, Response},
    inexact::Inexact,
    plan::{Case, Plan},
    results::{Occurrence, Results, Run},
};
use crate::linkage::console::{Console, ConsoleFault, SweepRun};
use interface::{
    Tick,
    control::{ChannelKind, PatchBundle, SweptRun},
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
    /// As shipped, the pitch loop with its first bending mode.
    pub fn shipped() -> Patches {
        Patches::with_modes(1)
    }

    /// As shipped, the pitch loop with so many bending modes.
    pub fn with_modes(modes: usize) -> Patches {
        macro_rules! files {
            ($($name:literal),*) => {
                [$(($name, include_str!(concat!("../../../../patch-files/", $name)))),*]
                    .map(|(name, text)| (name.to_owned(), text.to_owned()))
                    .into()
            };
        }
        Patches {
            pitch: match modes {
                0 | 1 => PatchBundle {
                    root: "pitch-loop.toml".to_owned(),
                    files: files!["pitch-loop.toml", "sub/stage-plane.toml", "sub/fin-tip.toml"],
                },
                _ => PatchBundle {
                    root: "pitch-loop-modes.toml".to_owned(),
                    files: files![
                        "pitch-loop-modes.toml",
                        "sub/stage-plane.toml",
                        "sub/bending-mode.toml",
                        "sub/fin-tip.toml"
                    ],
                },
            },
            yaw_roll: PatchBundle {
                root: "yaw-roll-loop.toml".to_owned(),
                files: files!["yaw-roll-loop.toml", "sub/stage-plane.toml", "sub/fin-tip.toml"],
            },
        }
    }

    /// That of a loop.
    pub fn of(&self, control_loop: ControlLoop) -> &PatchBundle {
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

    /// Runs from their initial conditions, each to its own stop, sampled once a `frame`; `each`
    /// is given them in order, with what happened in them.
    ///
    /// # Errors
    /// [`ConsoleFault`]: a refused setting or a lost partner, but not a run that diverges.
    pub fn run(
        &self,
        console: &mut Console<'_>,
        frame: Tick,
        runs: impl IntoIterator<Item = (Settings, Tick)>,
        mut each: impl FnMut(Response, Vec<Occurrence>),
    ) -> Result<(), ConsoleFault> {
        let asked = runs.into_iter().map(|(settings, stop)| SweepRun {
            ics: settings.initial_conditions(),
            settings: settings.values(),
            stop,
        });
        console.sweep(frame, &self.adc, asked, |run| {
            let mut response = Response::new(self.control_loop, frame.secs());
            for row in run.samples.chunks(self.adc.len()) {
                response.push(row.iter().copied());
            }
            each(response, occurrences(run));
        })
    }
}

fn occurrences(run: SweptRun) -> Vec<Occurrence> {
    let mut seen = Vec::new();
    if let Some((time, fault)) = run.fault {
        seen.push(Occurrence::Stopped { time, fault });
    } else if !run.overloads.is_empty() {
        let blocks = run.overloads.into_iter().map(|o| o.block);
        seen.push(Occurrence::Overloaded(blocks.collect()));
    }
    if run.saturated {
        seen.push(Occurrence::Saturated);
    }
    seen
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
        let cases: Vec<&Case> = plan.of(control_loop).collect();
        if cases.is_empty() {
            continue;
        }
        let bench = Bench::load(console, control_loop, patches, profile)?;
        hashes.push((patches.of(control_loop).root.clone(), console.patch_hash().to_owned()));
        let inexact = Inexact::new(patches.of(control_loop), profile);
        let stop = plan.sample * plan.samples() as i64;
        let asked = cases.iter().map(|case| (case.settings, stop));
        let mut next = cases.iter();
        bench.run(console, plan.sample, asked, |response, seen| {
            runs.extend(next.next().map(|case| Run::new(plan, case, response, seen, &inexact)));
            progress(runs.len());
        })?;
    }
    Ok(Results { plan: plan.clone(), runs, patches: hashes })
}
