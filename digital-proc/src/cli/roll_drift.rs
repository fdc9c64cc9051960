//! `digital-proc roll-drift`: a roll that nobody corrects, with attitude errors resolved and not.

use super::{Context, study::StudyArgs};
use crate::study::{
    fault::StudyFault,
    long_period::run::LongPeriodPlan,
    roll_drift::{FLIGHTS, run},
};
use desk::failure::Failure;
use vehicle::reference;

/// Fly the design case with a small roll drift that the roll loop does not correct: attitude
/// errors resolved through the roll angle and unresolved side by side, yaw coupling shown, beside
/// the second formulation.
#[derive(clap::Args)]
pub struct RollDrift {
    /// Roll at lift-off, degrees
    #[arg(long, default_value_t = 2.0, value_name = "DEG", allow_negative_numbers = true)]
    roll: f64,
    /// Rate at which it drifts on, degrees per second
    #[arg(long, default_value_t = 0.2, value_name = "DEG_S", allow_negative_numbers = true)]
    rate: f64,
    #[command(flatten)]
    study: StudyArgs,
}

impl RollDrift {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        // A quarter turn changes the planes over; what is meant is small.
        let reaches_deg = self.roll.abs() + self.rate.abs() * vehicle.data().mass.burn_time_s;
        if !(self.roll.is_finite() && self.rate.is_finite() && reaches_deg <= 90.0) {
            return Err(Failure::input("--roll and --rate must not reach more than 90 degrees"));
        }
        let how = LongPeriodPlan::new(Vec::new(), self.study.profile()?);
        let mut begun = self.study.begin("roll-drift", &vehicle, &how.profile)?;
        begun.set("roll-deg", self.roll);
        begun.set("rate-deg-s", self.rate);
        let drift = reference::RollDrift {
            initial_rad: self.roll.to_radians(),
            rate_radps: self.rate.to_radians(),
            resolved: true,
        };
        let results =
            self.study.on_machine(context, (FLIGHTS, "flights"), |console, progress| {
                let results = run(console, &vehicle, &how, drift, progress)?;
                begun.patch(&how.patch.root, console.patch_hash());
                Ok::<_, StudyFault>(results)
            })?;
        results.outcome().publish(&begun, self.study.machine.json)
    }
}
