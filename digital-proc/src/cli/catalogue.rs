//! `digital-proc catalogue`: each failure at each time of the flight, and what becomes of it.

use super::{Context, failure_file, study::StudyArgs};
use crate::study::{
    catalogue::{CataloguePlan, STEP, run},
    fault::StudyFault,
    long_period::run::LongPeriodPlan,
};
use desk::failure::Failure;
use interface::Tick;
use std::path::PathBuf;

/// Fly each failure of the failure file with each time of its occurrence, from lift-off to
/// burn-out, and catalogue what becomes of the flight: salvageable, or a violation of the
/// trajectory's acceptance, of the load limit or of range safety.
///
/// A mode's first action is moved to the time of occurrence, the others keep their distance
/// from it. Wind and misalignments are those of the design case. Nothing is claimed: the exit
/// code is 0 whatever becomes of the flights.
#[derive(clap::Args)]
pub struct Catalogue {
    /// Failure file of your own that scripts the modes [default: the shipped one]
    #[arg(long, value_name = "FILE")]
    failures: Option<PathBuf>,
    /// Between two times of occurrence, a trajectory step (100 ms) at least
    #[arg(long, default_value_t = STEP, value_name = "TIME")]
    step: Tick,
    #[command(flatten)]
    study: StudyArgs,
}

impl Catalogue {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let failures = failure_file(self.failures.as_deref())?;
        let how = LongPeriodPlan::new(failures.modes, self.study.profile()?);
        // Failures act where the trajectory computer looks at them, once a step.
        if self.step < how.step {
            let told = format!("--step {} is too fine; give {} or more", self.step, how.step);
            return Err(Failure::input(told));
        }
        let plan = CataloguePlan::new(&how.modes, self.step, &vehicle);
        let mut begun = self.study.begin("catalogue", &vehicle, &how.profile)?;
        begun.set("failures", failures.file);
        begun.set("step", self.step.to_string());
        let amount = (plan.flights(), "flights");
        let catalogue = self.study.on_machine(context, amount, |console, progress| {
            let catalogue = run(console, &vehicle, &how, &plan, progress)?;
            begun.patch(&how.patch.root, console.patch_hash());
            Ok::<_, StudyFault>(catalogue)
        })?;
        catalogue.outcome().publish(&begun, self.study.machine.json)
    }
}
