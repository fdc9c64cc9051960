//! `digital-proc long-period`: every mode flown, the claims judged.

use super::{Context, failure_file, study::StudyArgs};
use crate::study::{
    fault::StudyFault,
    long_period::{
        outcome::outcome,
        run::{LongPeriodPlan, run},
    },
};
use desk::failure::Failure;
use std::path::PathBuf;

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
}

impl LongPeriod {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let failures = failure_file(self.failures.as_deref())?;
        let plan = LongPeriodPlan::new(failures.modes, self.study.profile()?);
        let mut begun = self.study.begin("long-period", &vehicle, &plan.profile)?;
        begun.set("failures", failures.file);
        let amount = (plan.flights(), "flights");
        let results = self.study.on_machine(context, amount, |console, progress| {
            let results = run(console, &vehicle, &plan, progress)?;
            begun.patch(&plan.patch.root, console.patch_hash());
            Ok::<_, StudyFault>(results)
        })?;
        outcome(&results, plan.step).publish(&begun, self.study.machine.json)
    }
}
