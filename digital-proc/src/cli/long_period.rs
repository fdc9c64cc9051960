//! `digital-proc long-period`: every mode flown, the claims judged.

use super::{Context, failure_file, study::StudyArgs};
use crate::study::{
    fault::StudyFault,
    long_period::{
        outcome::outcome,
        run::{LongPeriodPlan, run},
    },
    tankage,
};
use desk::failure::Failure;
use std::path::PathBuf;

/// Fly every mode of the failure file to burn-out, flight after flight in one
/// session, and judge the paper's claims about trajectory and loads; then under disturbances of
/// every sign for the tankage of the side-force fluid.
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
        let (claimed, modes) = (plan.flights(), plan.modes.len());
        let amount = (claimed + tankage::flights(modes), "flights");
        let (results, tankage) = self.study.on_machine(context, amount, |console, progress| {
            let results = run(console, &vehicle, &plan, &mut *progress)?;
            begun.patch(&plan.patch.root, console.patch_hash());
            let flown = |flights| progress(claimed + flights);
            let tankage = tankage::run(console, &vehicle, &plan, flown)?;
            Ok::<_, StudyFault>((results, tankage))
        })?;
        let mut outcome = outcome(&results, plan.step);
        tankage.fill(&mut outcome);
        outcome.publish(&begun, self.study.machine.json)
    }
}
