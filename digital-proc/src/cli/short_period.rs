//! `digital-proc short-period`: the control loops at frozen trajectory points.

use super::{
    Context,
    study::{PointsArgs, StudyArgs, note_patches},
};
use crate::study::short_period::{
    claims::NORMAL,
    coefficients::Disturbance,
    control_loop::{
        Offset::{Both, LargeYaw},
        Test,
    },
    forms,
    machine::{self, Patches},
    offsets,
    outcome::outcome,
    plan::Plan,
    study_file::Study,
};
use desk::{failure::Failure, faults::suggestion};
use vehicle::Vehicle;

/// The control loops at frozen trajectory points: step responses, failures, eigenvalues.
///
/// The loop is patched on the analog processor; coefficients of each trajectory point are
/// frozen from the nominal flight, changed by an operating condition, and set from here.
/// All runs follow one another in one session.
///
///     digital-proc short-period pitch --point max-q --condition tvc-slow
///     digital-proc short-period yaw-roll --point max-q --decoupled
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct ShortPeriod {
    #[command(subcommand)]
    loops: Loops,
}

#[derive(clap::Subcommand)]
enum Loops {
    /// Step command in pitch under thrust misalignment and a step gust
    Pitch(Runs),
    /// Initial offsets in yaw (small and large) and roll, whose loops share the fin tips
    YawRoll {
        /// Tips for roll only and thrust vector for yaw only, instead of sharing the tips
        #[arg(long)]
        decoupled: bool,
        #[command(flatten)]
        runs: Runs,
    },
    /// The drift form (20)-(22) and the alpha form of the pitch loop, compared
    Forms(AllPoints),
    /// Yaw and roll from offsets in attitude and from the corresponding offsets in rate
    Offsets(AllPoints),
}

#[derive(clap::Args)]
struct AllPoints {
    #[command(flatten)]
    points: PointsArgs,
    #[command(flatten)]
    study: StudyArgs,
}

#[derive(clap::Args)]
struct Runs {
    /// Trajectory point of the study [default: all]
    #[arg(long, value_name = "NAME")]
    point: Option<String>,
    /// Operating condition of the study, or `all`
    #[arg(long, value_name = "NAME", default_value = NORMAL)]
    condition: String,
    #[command(flatten)]
    points: PointsArgs,
    #[command(flatten)]
    study: StudyArgs,
}

impl ShortPeriod {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        match self.loops {
            Loops::Pitch(runs) => {
                runs.execute(context, "short-period pitch", &[Test::Disturbed, Test::StepOnly])
            }
            Loops::YawRoll { decoupled, runs } => {
                let test = if decoupled { Test::Dedicated } else { Test::Shared };
                runs.execute(context, "short-period yaw-roll", &[test(Both), test(LargeYaw)])
            }
            Loops::Forms(all) => all.forms(context),
            Loops::Offsets(all) => all.offsets(context),
        }
    }
}

impl AllPoints {
    fn plan(&self, vehicle: &Vehicle) -> Result<(Study, Plan), Failure> {
        let study = self.points.load(vehicle)?;
        let plan = Plan::new(&study, vehicle)?;
        Ok((study, plan))
    }

    fn forms(&self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let (study, plan) = self.plan(&vehicle)?;
        let profile = self.study.profile()?;
        let begun = self.study.begin("short-period forms", &vehicle, &profile)?;
        let pitch = &study.pitch;
        let shaken = Disturbance { misalignment: pitch.misalignment, gust: pitch.gust, cant: 0.0 };
        let amount = (2 * plan.points.len(), "loops");
        let apart = self.study.on_machine(context, amount, |console, progress| {
            forms::run(console, &plan, &vehicle, &shaken, &profile, progress)
        })?;
        forms::outcome(&apart, plan.sample.secs()).publish(&begun, self.study.machine.json)
    }

    fn offsets(&self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let (study, plan) = self.plan(&vehicle)?;
        let profile = self.study.profile()?;
        let begun = self.study.begin("short-period offsets", &vehicle, &profile)?;
        let amount = (plan.points.len() * offsets::Offset::ALL.len(), "runs");
        let rows = self.study.on_machine(context, amount, |console, progress| {
            offsets::run(console, &plan, &vehicle, &study.yaw_roll, &profile, progress)
        })?;
        offsets::outcome(&rows).publish(&begun, self.study.machine.json)
    }
}

impl Runs {
    fn execute(&self, context: &Context, command: &str, tests: &[Test]) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let mut study = self.points.load(&vehicle)?;
        // Decoupled and undisturbed runs are there for every condition that is asked for.
        for condition in &mut study.conditions {
            condition.overshoot = true;
            condition.dedicated = true;
            condition.offsets = true;
        }
        let mut plan = Plan::new(&study, &vehicle)?;
        let condition = Some(self.condition.as_str()).filter(|name| *name != "all");
        let point = index(
            &study.file,
            "point",
            self.point.as_deref(),
            plan.points.iter().map(|p| &*p.name),
        )?;
        let condition =
            index(&study.file, "condition", condition, plan.conditions.iter().map(|c| &*c.name))?;
        plan.cases.retain(|case| {
            point.is_none_or(|point| point == case.point)
                && condition.is_none_or(|condition| condition == case.condition)
                && tests.contains(&case.test)
        });
        if plan.cases.is_empty() {
            return Err(Failure::input(format!(
                "no run of `{command}` fits: condition `{}` changes nothing there, or there is no loop to study (without fin tips nothing controls roll); try another --point or --condition",
                self.condition
            )));
        }
        let profile = self.study.profile()?;
        let mut begun = self.study.begin(command, &vehicle, &profile)?;
        begun.set("condition", self.condition.as_str());
        if let Some(point) = &self.point {
            begun.set("point", point.as_str());
        }
        begun.set("study-file", study.file);
        let amount = (plan.cases.len(), "runs");
        let results = self.study.on_machine(context, amount, |console, progress| {
            machine::run(console, &plan, &Patches::with_modes(plan.modes), &profile, progress)
        })?;
        note_patches(&mut begun, &results.patches);
        let loops = tests[0].control_loop().title();
        let place = self.point.as_deref().unwrap_or("all trajectory points");
        let title = format!("{loops}, short period: {place}, condition {}", self.condition);
        outcome(&title, &results).publish(&begun, self.study.machine.json)
    }
}

/// Which of the names of a study is meant, if one is given.
fn index<'a>(
    file: &str,
    what: &str,
    name: Option<&str>,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Result<Option<usize>, Failure> {
    let Some(name) = name else { return Ok(None) };
    let found = known.clone().position(|k| k == name);
    found.map(Some).ok_or_else(|| {
        Failure::input(format!("{file} has no {what} `{name}`; {}", suggestion(name, known)))
    })
}
