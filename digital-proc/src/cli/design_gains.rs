//! `digital-proc design-gains`: the gain schedules, designed on the machine.

use super::{Context, study::StudyArgs};
use crate::study::{
    fault::StudyFault,
    gain_design::{design::EFFORT, outcome::run},
};
use desk::{failure::Failure, note};

/// Design the gain schedules: interval by interval on the short-period pitch loop,
/// then with fewer switchings by long-period flights, and back to the short period.
///
/// Prints the schedules as sections for a vehicle file and leaves them as `gains.toml`;
/// `--vehicle FILE` flies them. Exit code 1 when none with fewer switchings is accepted by the
/// flights and by the short period.
#[derive(clap::Args)]
pub struct DesignGains {
    /// Most evaluations of the cost for one interval of the sequencer
    #[arg(long, default_value_t = EFFORT.evaluations, value_name = "N")]
    evaluations: usize,
    #[command(flatten)]
    study: StudyArgs,
}

impl DesignGains {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        if self.evaluations == 0 {
            return Err(Failure::input("--evaluations must be at least 1"));
        }
        let (vehicle, profile) = (self.study.vehicle()?, self.study.profile()?);
        let mut begun = self.study.begin("design-gains", &vehicle, &profile)?;
        begun.set("evaluations", self.evaluations as i64);
        let designed = self.study.on_machine(context, (0, ""), |console, _| {
            let told = |line| note!("{line}");
            let designed = run(console, &profile, &vehicle, self.evaluations, told)?;
            begun.patch("pitch-loop.toml", console.patch_hash());
            Ok::<_, StudyFault>(designed)
        })?;
        begun.directory.write_file("gains.toml", designed.sections().as_bytes())?;
        designed.outcome(&vehicle).publish(&begun, self.study.machine.json)
    }
}
