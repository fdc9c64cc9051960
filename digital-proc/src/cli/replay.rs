//! `digital-proc replay`: a recorded flight once more, compared bit by bit.

use super::{Context, JoinArgs, runs::Which};
use crate::{
    flight::{
        FlightFault, FlightPlan, Stage, Timing, TransferLog,
        plan_record::{Pace, PlanFault, PlanRecord},
        trace::{self, BATCH_ROWS, Recorder},
    },
    linkage::console::{Console, ConsoleFault},
};
use desk::{
    failure::Failure,
    faults::Source,
    outcome::{Outcome, Run},
    run_dir::{
        RECORD_FILE, RunRecord, SUMMARY_FILE, TRACE_FILE, TRANSFERS_FILE, Trace, TraceWriter,
        first_difference,
    },
};
use vehicle::Vehicle;

/// Repeat a recorded flight in lock-step and compare it to the last bit.
///
/// A flight on the wall clock is repeated with the instants at which its updates
/// took effect; nothing else of that clock enters a run. Exit code 0 when the two
/// are identical, 1 with the first difference when not.
///
///     digital-proc fly --clock wall --until 5s
///     digital-proc replay last
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Replay {
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    join: JoinArgs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A flight as its run directory tells of it.
pub(super) struct Recorded {
    pub run: Run,
    /// The text of its `run.toml`.
    pub text: String,
    pub plan_record: PlanRecord,
    pub vehicle: Vehicle,
    pub plan: FlightPlan,
}

impl Recorded {
    pub fn open(which: &Which) -> Result<Recorded, Failure> {
        let directory = which.open()?;
        let path = directory.file(RECORD_FILE);
        let text = desk::user_file::read_text(&path)
            .map_err(|e| Failure::input(format!("cannot read `{}`: {e}", path.display())))?;
        let file = path.display().to_string();
        let source = Source { file: &file, text: &text };
        let record: RunRecord = source.parse()?;
        if record.command.split(' ').next() != Some("fly") {
            return Err(Failure::input(format!(
                "`{}` is a run of `{}`; only flights can be replayed or resumed",
                directory.name(),
                record.command
            )));
        }
        let plan_record = PlanRecord::from_run_toml(&path, &text)?;
        let in_record = |fault: PlanFault| Failure::input(format!("{}: {fault}", path.display()));
        let vehicle = plan_record.vehicle().map_err(in_record)?;
        let plan = plan_record.plan(&vehicle).map_err(in_record)?;
        Ok(Recorded { run: Run { directory, record }, text, plan_record, vehicle, plan })
    }
}

/// Refuses another stage patch than the run `name` flew.
pub(super) fn expect_patch(record: &RunRecord, name: String, loaded: &str) -> Result<(), Failure> {
    match &record.patch {
        Some(patch) if patch.sha256 != loaded => Err(Failure::input(format!(
            "`{name}` flew another {}: its SHA-256 is {}, that of this build is {loaded}; use the build that flew it",
            patch.name, patch.sha256,
        ))),
        _ => Ok(()),
    }
}

impl Replay {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let Recorded { run, plan_record, vehicle, plan, .. } = Recorded::open(&self.which)?;
        let (directory, record) = (run.directory, run.record);
        let recorded = directory.read_trace()?;
        let transfers = match plan_record.clock {
            Pace::LockStep => None,
            Pace::Wall => {
                let path = directory.file(TRANSFERS_FILE);
                let stream = Trace::read(&path)?;
                let log = trace::read_transfers(&path, &stream).map_err(Failure::input)?;
                Some((log, stream.is_complete()))
            }
        };

        let mut machine = self.join.start(context)?;
        let mut console = Console::new(&mut machine);
        let mut stage =
            Stage::load_patch(&mut console, &vehicle, &plan.profile, plan.options.patch())?;
        expect_patch(&record, directory.name(), console.patch_hash())?;
        let mut bytes = Vec::new();
        let trace_path = directory.file(TRACE_FILE);
        let rows = TraceWriter::new(&mut bytes, &trace_path, &trace::columns(), BATCH_ROWS)?;
        let mut recorder = Recorder::new(rows, plan.stop);
        let timing = match &transfers {
            None => Timing::LockStep,
            Some((log, _)) => Timing::Replay(log),
        };
        let flown = stage.fly(&mut console, &vehicle, &plan, timing, &mut recorder);
        let closed = recorder.finish();
        // A flight that was lost is lost here too, at the same frame.
        let lost = match flown {
            Ok(_) => None,
            Err(FlightFault::Console(ConsoleFault::Link(fault))) => return Err(fault.into()),
            Err(fault) => Some(fault.to_string()),
        };
        closed?;
        console.bye()?;
        drop(machine);

        let replayed = Trace::from_bytes(&bytes, &trace_path)?;
        // A run that failed or was killed has no summary; the transfers of its last
        // instants may not have been told.
        let ended = directory.file(SUMMARY_FILE).is_file() && recorded.is_complete();
        let rows =
            if ended { usize::MAX } else { rows_of_a_run_cut_off(&recorded, transfers.as_ref()) };
        let difference = first_difference(&recorded, &replayed, rows);
        let compared = recorded.rows().min(rows);
        let mut outcome = Outcome::new(format!("Replay of {}", directory.name()), "");
        outcome.results.add("rows", "Rows compared", compared as f64, 17, "", "");
        match difference {
            None => outcome.remarks.push("identical to the last bit".to_owned()),
            Some(difference) => outcome
                .refused
                .push(format!("the replay of `{}` differs: {difference}", directory.name())),
        }
        outcome.remarks.extend(lost.map(|lost| format!("the flight was lost: {lost}")));
        if compared < replayed.rows() {
            outcome.remarks.push("the recorded run was cut off there".to_owned());
        }
        outcome.tell("replay", Some(directory.path()), self.json)
    }
}

/// Rows that a run that was cut off must share with its replay: those written, up to the
/// last known transfer when more may have taken effect.
fn rows_of_a_run_cut_off(recorded: &Trace, transfers: Option<&(TransferLog, bool)>) -> usize {
    match transfers {
        Some((log, false)) => {
            let known = log.transfers().last().map_or(i64::MIN, |t| t.tick.0);
            recorded.ticks().partition_point(|tick| *tick <= known)
        }
        _ => recorded.rows(),
    }
}
