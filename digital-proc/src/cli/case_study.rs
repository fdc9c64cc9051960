//! `digital-proc case-study`: section 4 of the paper, claim by claim.

use super::{
    Context, failure_file, own_or,
    study::{PointsArgs, StudyArgs, note_patches},
};
use crate::study::{
    case_study::{CasePlan, run},
    catalogue::{CataloguePlan, STEP as CATALOGUE_STEP},
    long_period::run::LongPeriodPlan,
    sensitivity::dispersion_file::Dispersions,
    short_period::plan::Plan,
};
use desk::failure::Failure;
use std::path::PathBuf;

/// The paper's case study: every run of its section 4, and whether each claim holds.
///
/// Short-period runs of the pitch and the yaw–roll loops at all trajectory points and
/// under all operating conditions, then long-period flights in every failure mode, the tankage,
/// and the catalogue of each failure at each second of the flight, all in one session. Ends with the claims table: holds, holds in part (and where not), or does not
/// hold; exit code 1 only for the last, or if a claim cannot be judged.
///
///     digital-proc case-study
///     digital-proc case-study --study my-points.toml --failures my-failures.toml
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct CaseStudy {
    #[command(flatten)]
    points: PointsArgs,
    /// Failure file of your own: modes of the long-period flights [default: the shipped modes]
    #[arg(long, value_name = "FILE")]
    failures: Option<PathBuf>,
    /// Dispersion file of your own for the sensitivity tables [default: the shipped one]
    #[arg(long, value_name = "FILE", conflicts_with = "no_sensitivity")]
    dispersions: Option<PathBuf>,
    /// Leave out the sensitivity tables, which no claim needs
    #[arg(long)]
    no_sensitivity: bool,
    /// Leave out the catalogue of failures and the tankage: most of all flights, and no claim
    /// needs them
    #[arg(long)]
    no_catalogue: bool,
    #[command(flatten)]
    study: StudyArgs,
}

impl CaseStudy {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let points = self.points.load(&vehicle)?;
        let failures = failure_file(self.failures.as_deref())?;
        let mut dispersions = None;
        if !self.no_sensitivity {
            let own = self.dispersions.as_deref();
            let wanted = own_or(own, Dispersions::load, Dispersions::shipped)?;
            wanted.locate(&vehicle)?;
            dispersions = Some(wanted);
        }
        let every = (!self.no_catalogue).then_some(CATALOGUE_STEP);
        let plan = CasePlan {
            short: Plan::new(&points, &vehicle)?,
            catalogue: every.map(|step| CataloguePlan::new(&failures.modes, step, &vehicle)),
            long: LongPeriodPlan::new(failures.modes, self.study.profile()?),
            dispersions,
        };
        let mut begun = self.study.begin("case-study", &vehicle, &plan.long.profile)?;
        begun.set("study-file", points.file);
        begun.set("failure-file", failures.file);
        let amount = (plan.runs(), "runs and flights");
        let results = self.study.on_machine(context, amount, |console, progress| {
            run(console, &vehicle, &plan, progress)
        })?;
        note_patches(&mut begun, &results.patches);
        results.outcome(&plan).publish(&begun, self.study.machine.json)
    }
}
