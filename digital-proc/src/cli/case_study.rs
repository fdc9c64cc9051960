//! `digital-proc case-study`: section 4 of the paper, claim by claim.

use super::{
    Context, MachineArgs,
    short_period::write_traces,
    study_input::{Curves, StudyArgs, record},
};
use crate::{
    console::Console,
    report::{case_study::case_study_report, long_period::fuel_words},
    study::{
        case_study::{self, CaseFault, CasePlan, CaseResults},
        long_period::{history::VARIABLES, run::LongPeriodPlan},
        sensitivity::dispersion_file::Dispersions,
        short_period::{machine::Patches, plan::Plan},
    },
};
use desk::failure::Failure;
use desk::say;
use desk::{
    progress::Progress,
    report::claims_text,
    run_dir::{DEFAULT_BASE, RunDirectory, TRACE_FILE, UtcSecond},
};
use interface::Tick;
use std::{
    path::PathBuf,
    time::{Instant, SystemTime},
};
use vehicle::failure_file::FailureFile;

/// Trace of every short-period run.
const SHORT_PERIOD_FILE: &str = "short-period.arrow";

/// The paper's case study: every run of its section 4, and whether each claim holds.
///
/// Short-period runs of the pitch and the yaw–roll loops at all trajectory points and
/// under all operating conditions, then long-period flights in every failure mode, all in
/// one session. Ends with the claims table; exit code 1 if a claim does not hold.
///
///     digital-proc case-study
///     digital-proc case-study --study my-points.toml --failures my-failures.toml
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct CaseStudy {
    #[command(flatten)]
    input: StudyArgs,
    /// Failure file of your own: modes of the long-period flights [default: the shipped modes]
    #[arg(long, value_name = "FILE")]
    failures: Option<PathBuf>,
    /// Dispersion file of your own for the sensitivity tables [default: the shipped one]
    #[arg(long, value_name = "FILE", conflicts_with = "no_sensitivity")]
    dispersions: Option<PathBuf>,
    /// Leave out the sensitivity tables, which no claim needs
    #[arg(long)]
    no_sensitivity: bool,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

impl CaseStudy {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let clock = Instant::now();
        let started = UtcSecond::from_system(SystemTime::now());
        let (vehicle, study) = self.input.load()?;
        let own = self.failures.as_deref().map(FailureFile::load).transpose()?;
        let failures = own.as_ref().unwrap_or_else(|| FailureFile::shipped());
        let dispersions = match &self.dispersions {
            _ if self.no_sensitivity => None,
            Some(path) => Some(Dispersions::load(path)?),
            None => Some(Dispersions::shipped()?),
        };
        if let Some(dispersions) = &dispersions {
            dispersions.locate(&vehicle).map_err(Failure::input)?;
        }
        let profile = desk::profile::load(&self.machine.profile)?;
        let plan = CasePlan {
            short: Plan::new(&study, &vehicle).map_err(Failure::input)?,
            patches: Patches::shipped(),
            long: LongPeriodPlan::new(failures.modes.clone(), profile.clone()),
            dispersions,
        };

        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let mut progress = Progress::new(plan.runs() as u64, "runs and flights");
        let results = case_study::run(&mut console, &vehicle, &plan, |done| {
            progress.at(done as u64);
        });
        progress.done();
        let results = results?;
        let stage_patch = (plan.long.patch.root.clone(), console.patch_hash().to_owned());
        console.bye()?;
        drop(machine);

        let directory = RunDirectory::create(&self.out, "case-study", started)?;
        write_traces(&results.short, &directory, SHORT_PERIOD_FILE)?;
        write_histories(&results, &plan, &directory)?;
        let mut parameters = toml::Table::new();
        self.input.record(&mut parameters, &vehicle, &study)?;
        parameters.insert("failure-file".to_owned(), failures.file.clone().into());
        let mut patches = results.short.patches.clone();
        patches.push(stage_patch);
        let record = record("case-study", &self.machine, &profile, started, &patches, parameters);
        directory.write_record(&record)?;
        let summary = results.summary();
        directory.write_summary(&summary)?;
        let html = case_study_report(&results, &plan, &record);
        let report = directory.write_report(&html)?;

        if self.machine.json {
            say!("{summary:#}");
        } else {
            print_claims(&results);
            say!(
                "{} runs and flights in {:.1} s; report: {}",
                plan.runs(),
                clock.elapsed().as_secs_f64(),
                report.display()
            );
        }
        verdict(&results)
    }
}

impl From<CaseFault> for Failure {
    fn from(fault: CaseFault) -> Failure {
        match fault {
            CaseFault::Study(fault) => fault.into(),
            CaseFault::Sensitivity(fault) => fault.into(),
        }
    }
}

fn print_claims(results: &CaseResults) {
    let claims = results.claims();
    say!("{}", claims_text(&claims).trim_end());
    let noted: Vec<_> = claims.iter().filter_map(|c| Some((&*c.id, c.remark.as_ref()?))).collect();
    if !noted.is_empty() {
        say!("\nNoted beside:");
        for (id, remark) in noted {
            say!("  {id}: {remark}");
        }
    }
    let short = &results.short;
    say!(
        "\n{} of {} undisturbed runs that stay linear agree with their eigenvalues.",
        short.agreement.len() - short.disagreements().count(),
        short.agreement.len()
    );
    for remark in short.remarks() {
        say!("{remark}");
    }
    say!("{}.", fuel_words(&results.long));
}

/// Exit 1 unless every claim holds and every linear run agrees.
fn verdict(results: &CaseResults) -> Result<(), Failure> {
    if results.holds() {
        return Ok(());
    }
    let claims = results.claims();
    let mut failed: Vec<&str> = claims.iter().filter(|c| !c.holds()).map(|c| &*c.id).collect();
    if results.short.disagreements().next().is_some() {
        failed.push("agreement with the linearised loop");
    }
    Err(Failure::failed("not shown to hold", &failed))
}

/// The paper's ten variables of every mode as one trace, columns named by mode and variable.
fn write_histories(
    results: &CaseResults,
    plan: &CasePlan,
    directory: &RunDirectory,
) -> Result<(), Failure> {
    let long = &results.long;
    let flights = std::iter::once(("undisturbed", &long.nominal_history))
        .chain(long.modes.iter().map(|m| (m.name.as_str(), &m.history)));
    let mut curves = Curves::new();
    for (flight, history) in flights {
        for variable in VARIABLES {
            let name = format!("{flight}.{}", variable.column);
            curves.add(name, variable.column_unit, (variable.of)(history));
        }
    }
    // The last sample stands at burn-out, which need not be a multiple of the step.
    let step = plan.long.step.0;
    let end = long.nominal_history.time_s.last().copied().unwrap_or(0.0);
    let end = Tick::from_secs(end).unwrap_or(Tick(i64::MAX));
    curves.write(directory, TRACE_FILE, |row| Tick(step * row as i64).min(end))
}
