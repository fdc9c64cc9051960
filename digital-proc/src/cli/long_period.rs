//! `digital-proc long-period`: every mode flown, the claims judged.

use super::{
    Context, MachineArgs,
    study_run::{StudyArgs, StudyRun},
};
use crate::{
    console::Console,
    report::long_period::{fuel_table, fuel_words, load_table, long_period_sections, mode_table},
    study::long_period::{
        claims::judge,
        results::LongPeriodResults,
        run::{LongPeriodPlan, run},
    },
};
use desk::failure::Failure;
use desk::say;
use desk::{
    claim::{Claim, Verdict},
    progress::Progress,
    report::claims_text,
};
use serde::Serialize;
use std::path::PathBuf;
use vehicle::failure_file::FailureFile;

/// Fly every mode of the failure file to burn-out, flight after flight in one
/// session, and judge the paper's claims about trajectory and loads.
///
/// Exit code 1 when a claim does not hold.
#[derive(clap::Args)]
pub struct LongPeriod {
    /// Failure file of your own that scripts the modes [default: the shipped one]
    #[arg(long, value_name = "FILE")]
    failures: Option<PathBuf>,
    #[command(flatten)]
    study: StudyArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

#[derive(Serialize)]
struct Outcome<'a> {
    claims: &'a [Claim],
    results: &'a LongPeriodResults,
}

impl LongPeriod {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let own = self.failures.as_deref().map(FailureFile::load).transpose()?;
        let failures = own.as_ref().unwrap_or_else(|| FailureFile::shipped());
        let profile = desk::profile::load(&self.machine.profile)?;
        let mut record =
            StudyRun::begin("long-period", &self.study, &self.machine, &profile, &vehicle)?;
        record.set("failures", failures.file.as_str());
        let plan = LongPeriodPlan::new(failures.modes.clone(), profile);
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let mut progress = Progress::new(plan.flights() as u64, "flights");
        let results = run(&mut console, &vehicle, &plan, |done| {
            progress.at(done as u64);
        });
        progress.done();
        let results = results?;
        record.patch("long-period.toml", console.patch_hash());
        console.bye()?;
        drop(machine);

        let claims = judge(&results);
        let outcome = Outcome { claims: &claims, results: &results };
        let page = record.finish(
            &outcome,
            "Long-period study",
            "Modes of operation flown to burn-out: control dynamics on the analog processor, trajectory on the digital one.",
            long_period_sections(&results, &claims),
        )?;
        if self.machine.json {
            say!("{}", serde_json::to_string_pretty(&outcome).map_err(Failure::input)?);
        } else {
            say!("Design case\n{}", mode_table(&results).text());
            say!(
                "Largest Q alpha over wind and pitch misalignment (fractions of 3 sigma)\n{}",
                load_table(&results).text()
            );
            say!("Side-force fluid over the same\n{}", fuel_table(&results).text());
            say!("{}.\n", fuel_words(&results));
            say!("{}", claims_text(&claims));
            for claim in claims.iter().filter(|c| c.verdict == Verdict::Holds) {
                if let Some(remark) = &claim.remark {
                    say!("{}: {remark}", claim.id);
                }
            }
            say!("report: {}", page.display());
        }
        let failed: Vec<&str> =
            claims.iter().filter(|c| c.verdict == Verdict::Fails).map(|c| &*c.id).collect();
        if failed.is_empty() { Ok(()) } else { Err(Failure::failed("does not hold", &failed)) }
    }
}
