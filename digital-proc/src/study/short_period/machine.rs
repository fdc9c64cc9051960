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

use super::bench::{Bench, Occurrence};
use super::plan::Plan;
use super::response::{PITCH_CHANNELS, PitchResponse, YAW_ROLL_CHANNELS, YawRollResponse};
use crate::console::{Console, ConsoleFault};
use interface::{
    Tick,
    control::{Clock, PatchBundle, RunSpec},
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
        let bundle = |root: &str, text: &str| PatchBundle {
            root: root.to_owned(),
            files: [
                (root, text),
                (
                    "sub/stage-plane.toml",
                    include_str!("../../../../patch-files/sub/stage-plane.toml"),
                ),
                ("sub/fin-tip.toml", include_str!("../../../../patch-files/sub/fin-tip.toml")),
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
        let bench = Bench::load(console, &patches.pitch, profile, &PITCH_CHANNELS)?;
        answers.patches.push(bench.identity(console, &patches.pitch));
        for (number, case) in plan.pitch.iter().enumerate() {
            let (response, seen) = bench.run(console, plan.sample_s, &spec, &case.settings)?;
            answers.pitch.push(response);
            answers.remark(ControlLoop::Pitch, number, seen);
            progress(number + 1);
        }
    }
    if !plan.yaw_roll.is_empty() {
        let bench = Bench::load(console, &patches.yaw_roll, profile, &YAW_ROLL_CHANNELS)?;
        answers.patches.push(bench.identity(console, &patches.yaw_roll));
        for (number, case) in plan.yaw_roll.iter().enumerate() {
            let (response, seen) = bench.run(console, plan.sample_s, &spec, &case.settings)?;
            answers.yaw_roll.push(response);
            answers.remark(ControlLoop::YawRoll, number, seen);
            progress(plan.pitch.len() + number + 1);
        }
    }
    Ok(answers)
}

impl Answers {
    fn remark(&mut self, control_loop: ControlLoop, run: usize, seen: Vec<Occurrence>) {
        let remarks = seen.into_iter().map(|what| Remark { control_loop, run, what });
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
