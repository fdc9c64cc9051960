//! `digital-proc short-period`: the control loops at frozen trajectory points.

use super::{
    Context, MachineArgs,
    study_input::{Curves, StudyArgs, record, select},
};
use crate::{
    console::Console,
    report::short_period::{
        agreement_table, dashed, pitch_table, short_period_report, yaw_roll_table,
    },
    study::short_period::{
        claims::NORMAL,
        machine::{self, Patches},
        outcome::{Outcome, Run},
        plan::Plan,
        response::{PITCH_CHANNELS, YAW_ROLL_CHANNELS},
    },
};
use desk::failure::Failure;
use desk::say;
use desk::{
    progress::Progress,
    run_dir::{DEFAULT_BASE, RunDirectory, TRACE_FILE, UtcSecond},
};
use interface::Tick;
use serde_json::json;
use std::{path::PathBuf, time::SystemTime};

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
    /// Initial offsets in yaw and roll, whose loops share the fin tips
    YawRoll {
        /// Tips for roll only and thrust vector for yaw only, instead of sharing the tips
        #[arg(long)]
        decoupled: bool,
        #[command(flatten)]
        runs: Runs,
    },
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
    input: StudyArgs,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

impl ShortPeriod {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        match self.loops {
            Loops::Pitch(runs) => runs.execute(context, "short-period pitch", |plan| {
                plan.yaw_roll.clear();
            }),
            Loops::YawRoll { decoupled, runs } => {
                runs.execute(context, "short-period yaw-roll", |plan| {
                    plan.pitch.clear();
                    plan.yaw_roll.retain(|c| c.settings.dedicated == decoupled);
                })
            }
        }
    }
}

impl Runs {
    fn execute(
        &self,
        context: &Context,
        command: &str,
        keep: impl Fn(&mut Plan),
    ) -> Result<(), Failure> {
        let (vehicle, mut study) = self.input.load()?;
        let profile = desk::profile::load(&self.machine.profile)?;
        // Decoupled and undisturbed runs are there for every condition that is asked for.
        for condition in &mut study.conditions {
            condition.overshoot = true;
            condition.dedicated = true;
        }
        let mut plan = Plan::new(&study, &vehicle).map_err(Failure::input)?;
        let condition = (self.condition != "all").then_some(self.condition.as_str());
        select(&mut plan, &study, self.point.as_deref(), condition)?;
        keep(&mut plan);
        let total = plan.pitch.len() + plan.yaw_roll.len();
        if total == 0 {
            return Err(Failure::input(format!(
                "no run of `{command}` fits: condition `{}` changes nothing there, or there is no loop to study (without fin tips nothing controls roll); try another --point or --condition",
                self.condition
            )));
        }

        let started = UtcSecond::from_system(SystemTime::now());
        let mut started_machine = self.machine.start(context)?;
        let mut console = Console::new(started_machine.port());
        let mut progress = Progress::new(total as u64, "runs");
        let answers = machine::run(&mut console, &plan, &Patches::shipped(), &profile, |done| {
            progress.at(done as u64)
        });
        progress.done();
        let answers = answers?;
        console.bye()?;
        drop(started_machine);

        let outcome = Outcome::new(plan, answers);
        let directory = RunDirectory::create(&self.out, command, started)?;
        write_traces(&outcome, &directory, TRACE_FILE)?;
        let mut parameters = toml::Table::new();
        parameters.insert("condition".to_owned(), self.condition.as_str().into());
        if let Some(point) = &self.point {
            parameters.insert("point".to_owned(), point.as_str().into());
        }
        self.input.record(&mut parameters, &vehicle, &study)?;
        let record =
            record(command, &self.machine, &profile, started, &outcome.patches, parameters);
        directory.write_record(&record)?;
        let summary = json!({
            "pitch": pitch_table(&outcome).json(),
            "yaw_roll": yaw_roll_table(&outcome).json(),
            "linear_agreement": agreement_table(&outcome).json(),
            "remarks": outcome.remarks(),
        });
        directory.write_summary(&summary)?;
        let loops = if outcome.plan.pitch.is_empty() { "Yaw and roll loops" } else { "Pitch loop" };
        let place = self.point.as_deref().unwrap_or("all trajectory points");
        let title = format!("{loops}, short period: {place}, condition {}", self.condition);
        let html = short_period_report(&title, &outcome, &record);
        let report = directory.write_report(&html)?;

        if self.machine.json {
            say!("{summary:#}");
        } else {
            if !outcome.plan.pitch.is_empty() {
                say!("{}", dashed(pitch_table(&outcome)).text());
            }
            if !outcome.plan.yaw_roll.is_empty() {
                say!("{}", dashed(yaw_roll_table(&outcome)).text());
            }
            if !outcome.agreement.is_empty() {
                say!("Agreement with the linearised loop where it stays linear:");
                say!("{}", dashed(agreement_table(&outcome)).text());
            }
            for remark in outcome.remarks() {
                say!("{remark}");
            }
            say!("report: {}", report.display());
        }
        let disagreeing = outcome.disagreements().count();
        if disagreeing > 0 {
            let what = format!("{disagreeing} linear runs do not agree with their eigenvalues");
            return Err(Failure::failed(&what, &[]));
        }
        Ok(())
    }
}

/// Writes every response of one or both loops as columns of one trace, named by run and
/// channel.
pub fn write_traces(
    outcome: &Outcome,
    directory: &RunDirectory,
    name: &str,
) -> Result<(), Failure> {
    let mut curves = Curves::new();
    for Run { name: run, response, .. } in &outcome.pitch {
        for (c, channel) in PITCH_CHANNELS.iter().enumerate() {
            curves.add(format!("{run}.{}", channel.adc), channel.unit, response.channel(c));
        }
    }
    for Run { name: run, response, .. } in &outcome.yaw_roll {
        // A point and condition has both loops: their bending coordinates are two.
        for (c, channel) in YAW_ROLL_CHANNELS.iter().enumerate() {
            let name = format!("{run}.yaw-roll.{}", channel.adc);
            curves.add(name, channel.unit, response.channel(c));
        }
    }
    let sample_ns = (outcome.plan.sample_s * 1e9).round() as i64;
    curves.write(directory, name, |row| Tick(sample_ns * row as i64))
}
