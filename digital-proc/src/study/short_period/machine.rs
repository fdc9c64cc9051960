//! A plan run on the hybrid machine: one session, run after run by rep-op.
//!
//! The pitch patch is loaded once and then, for each run, the machine goes to IC,
//! its coefficients are set in one request and it operates; the yaw–roll patch
//! follows in the same session. Nothing is restarted in between. The digital side
//! only reads while a run operates, so that the frame cycle's latency (one frame)
//! changes no number and lets both sides work in parallel.
//!
//! A run that diverges until the machine refuses to go on is kept up to there and
//! remarked upon; it does not end the study. A lost partner does.

use super::coefficients::{PitchSettings, YawRollSettings};
use super::plan::{PitchCase, Plan, YawRollCase};
use super::response::{
    PITCH_CHANNELS, PitchResponse, Response, YAW_ROLL_CHANNELS, YawRollResponse,
};
use crate::console::{Console, ConsoleFault};
use interface::{
    Tick,
    control::{ChannelKind, Clock, PatchBundle, RunSpec},
    frame::Samples,
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
    #[must_use]
    pub fn shipped() -> Patches {
        let bundle = |root: &str, text: &str| PatchBundle {
            root: root.to_owned(),
            files: [
                (root, text),
                (
                    "sub/stage-plane.toml",
                    include_str!("../../../../patch-files/sub/stage-plane.toml"),
                ),
                (
                    "sub/fin-tip.toml",
                    include_str!("../../../../patch-files/sub/fin-tip.toml"),
                ),
            ]
            .map(|(name, text)| (name.to_owned(), text.to_owned()))
            .into(),
        };
        Patches {
            pitch: bundle(
                "pitch-loop.toml",
                include_str!("../../../../patch-files/pitch-loop.toml"),
            ),
            yaw_roll: bundle(
                "yaw-roll-loop.toml",
                include_str!("../../../../patch-files/yaw-roll-loop.toml"),
            ),
        }
    }
}

/// Which loop a run belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControlLoop {
    /// The pitch loop.
    Pitch,
    /// The yaw and roll loops.
    YawRoll,
}

/// Something a reader of a run's numbers must know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// The loop.
    pub control_loop: ControlLoop,
    /// Number of the run in the plan.
    pub run: usize,
    /// What happened.
    pub what: Occurrence,
}

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

/// The machine's answers in the plan's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Pitch runs.
    pub pitch: Vec<PitchResponse>,
    /// Yaw–roll runs.
    pub yaw_roll: Vec<YawRollResponse>,
    /// What happened beside.
    pub remarks: Vec<Remark>,
    /// SHA-256 of each patch that ran, by its name.
    pub patches: Vec<(String, String)>,
}

/// Runs a whole plan; `progress` is told the number of runs done.
///
/// # Errors
/// [`ConsoleFault`]: a refused patch or setting, or a lost partner.
pub fn run(
    console: &mut Console<'_>,
    plan: &Plan,
    patches: &Patches,
    profile: &Profile,
    mut progress: impl FnMut(usize),
) -> Result<Answers, ConsoleFault> {
    let mut answers = Answers::default();
    let spec = spec(plan);
    if !plan.pitch.is_empty() {
        let bench = Bench::load(console, &patches.pitch, profile, PITCH_CHANNELS)?;
        answers
            .patches
            .push(bench.identity(console, &patches.pitch));
        for (number, case) in plan.pitch.iter().enumerate() {
            let (response, seen) = bench.run(console, plan.sample_s, &spec, case)?;
            answers.pitch.push(response);
            answers.remark(ControlLoop::Pitch, number, seen);
            progress(number + 1);
        }
    }
    if !plan.yaw_roll.is_empty() {
        let bench = Bench::load(console, &patches.yaw_roll, profile, YAW_ROLL_CHANNELS)?;
        answers
            .patches
            .push(bench.identity(console, &patches.yaw_roll));
        for (number, case) in plan.yaw_roll.iter().enumerate() {
            let (response, seen) = bench.run(console, plan.sample_s, &spec, case)?;
            answers.yaw_roll.push(response);
            answers.remark(ControlLoop::YawRoll, number, seen);
            progress(plan.pitch.len() + number + 1);
        }
    }
    Ok(answers)
}

impl Answers {
    fn remark(&mut self, control_loop: ControlLoop, run: usize, seen: Vec<Occurrence>) {
        let remarks = seen.into_iter().map(|what| Remark {
            control_loop,
            run,
            what,
        });
        self.remarks.extend(remarks);
    }
}

/// Frames are the samples of the study. A study's interval is whole milliseconds, so
/// that its ticks are exact.
fn spec(plan: &Plan) -> RunSpec {
    let frame = Tick((plan.sample_s * 1e9).round() as i64);
    RunSpec {
        frame,
        latency: frame,
        skew: Tick::ZERO,
        stop: frame * plan.samples() as i64,
        from_ic: true,
        clock: Clock::LockStep,
    }
}

/// What the bench asks of a case of either loop.
trait Case {
    /// Coefficients, converters and control lines by name.
    fn settings(&self) -> Vec<(&'static str, f64)>;
    /// Initial conditions by integrator name; the others stand as patched.
    fn initial_conditions(&self) -> Vec<(&'static str, f64)>;
}

impl Case for PitchCase {
    fn settings(&self) -> Vec<(&'static str, f64)> {
        PitchSettings::settings(&self.settings)
    }

    fn initial_conditions(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}

impl Case for YawRollCase {
    fn settings(&self) -> Vec<(&'static str, f64)> {
        YawRollSettings::settings(&self.settings)
    }

    fn initial_conditions(&self) -> Vec<(&'static str, f64)> {
        self.settings.initial_conditions().to_vec()
    }
}

/// A loaded patch with the numbers of its `N` sampled channels.
struct Bench<const N: usize> {
    adc: [usize; N],
}

impl<const N: usize> Bench<N> {
    fn load(
        console: &mut Console<'_>,
        patch: &PatchBundle,
        profile: &Profile,
        channels: [&str; N],
    ) -> Result<Self, ConsoleFault> {
        console.load(patch.clone(), Vec::new(), profile.clone())?;
        let mut adc = [0; N];
        for (number, name) in adc.iter_mut().zip(channels) {
            *number = console.channel(ChannelKind::Adc, name)?;
        }
        Ok(Bench { adc })
    }

    fn identity(&self, console: &Console<'_>, patch: &PatchBundle) -> (String, String) {
        (patch.root.clone(), console.patch_hash().to_owned())
    }

    fn run(
        &self,
        console: &mut Console<'_>,
        sample_s: f64,
        spec: &RunSpec,
        case: &impl Case,
    ) -> Result<(Response<N>, Vec<Occurrence>), ConsoleFault> {
        // The initial conditions first: they reset what a stopped run left behind.
        console.set_ics(owned(case.initial_conditions()))?;
        console.preset(owned(case.settings()))?;
        let mut response = Response::new(sample_s);
        let mut saturated = false;
        let ended = console.operate::<ConsoleFault>(spec, |samples: &Samples, _| {
            response.push(self.adc.map(|channel| samples.adc[channel]));
            saturated |= samples.adc_saturated | samples.dac_saturated != 0
                || samples.dcu_saturated != [0; 2];
            Ok(())
        });
        let mut seen = Vec::new();
        match ended {
            Ok(last) if last.overloads > 0 => {
                let overloads = console.diagnose()?.overloads;
                seen.push(Occurrence::Overloaded(
                    overloads.into_iter().map(|o| o.block).collect(),
                ));
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
    values
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}
