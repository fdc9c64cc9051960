//! `digital-proc sensitivity`: dispersions of the pitch loop, ranked.

use super::{Context, own_or, study::StudyArgs};
use crate::study::{
    sensitivity::{
        dispersion_file::Dispersions,
        outcome::outcome,
        pairs::pairs,
        run::{loops, run},
    },
    short_period::machine::Bench,
};
use desk::failure::Failure;
use std::path::PathBuf;

/// Disperse the pitch loop: aerodynamics, actuators, gyro and bending, one at a
/// time and at the corners, ranked.
#[derive(clap::Args)]
pub struct Sensitivity {
    /// Dispersion file of your own [default: the shipped one]
    #[arg(long, value_name = "FILE")]
    dispersions: Option<PathBuf>,
    #[command(flatten)]
    study: StudyArgs,
}

impl Sensitivity {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let own = self.dispersions.as_deref();
        let dispersions = own_or(own, Dispersions::load, Dispersions::shipped)?;
        let slices = dispersions.locate(&vehicle)?;
        let profile = self.study.profile()?;
        let mut begun = self.study.begin("sensitivity", &vehicle, &profile)?;
        begun.set("dispersions", dispersions.file.as_str());
        let amount = (loops(&dispersions), "loops");
        let points = self.study.on_machine(context, amount, |console, progress| {
            let bench = Bench::pitch(console, &profile)?;
            begun.patch("pitch-loop.toml", console.patch_hash());
            run(console, &bench, &vehicle, &dispersions, progress)
        })?;
        outcome(&points, &dispersions, &pairs(&vehicle, &dispersions, &slices))
            .publish(&begun, self.study.machine.json)
    }
}
