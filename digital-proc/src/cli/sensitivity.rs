//! `digital-proc sensitivity`: dispersions of the pitch loop, ranked.

use super::{
    Context, MachineArgs,
    study_run::{StudyArgs, StudyRun},
};
use crate::{
    console::Console,
    report::sensitivity::{corner_table, ranking_table, sensitivity_sections},
    study::{
        gain_design::bench::PitchBench,
        sensitivity::{
            dispersion_file::Dispersions,
            run::{Measure, loops, run},
        },
    },
};
use desk::failure::Failure;
use desk::progress::Progress;
use desk::say;
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
    #[command(flatten)]
    machine: MachineArgs,
}

impl Sensitivity {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let dispersions = match &self.dispersions {
            Some(path) => Dispersions::load(path),
            None => Dispersions::shipped(),
        }
        .map_err(Failure::input)?;
        dispersions.locate(&vehicle).map_err(Failure::input)?;
        let profile = desk::profile::load(&self.machine.profile)?;
        let mut record =
            StudyRun::begin("sensitivity", &self.study, &self.machine, &profile, &vehicle)?;
        if let Some(file) = &self.dispersions {
            record.set("dispersions", file.display().to_string());
        }
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let bench = PitchBench::load(&mut console, &profile)?;
        record.patch("pitch-loop.toml", console.patch_hash());
        let mut progress = Progress::new(loops(&dispersions) as u64, "loops");
        let points = run(&mut console, &bench, &vehicle, &dispersions, |done| {
            progress.at(done as u64);
        });
        progress.done();
        let points = points?;
        console.bye()?;
        drop(machine);

        let report = record.finish(
            &points,
            "Sensitivity of the pitch loop",
            "Dispersions one at a time and at the corners, measured on the patched pitch loop at frozen trajectory points, with linear eigenvalues beside.",
            sensitivity_sections(&points, &dispersions),
        )?;
        if self.machine.json {
            say!("{}", serde_json::to_string_pretty(&points).map_err(Failure::input)?);
            return Ok(());
        }
        for measure in Measure::ALL {
            say!("{}", ranking_table(&points, measure).text());
        }
        say!("Corners\n{}", corner_table(&points).text());
        say!("report: {}", report.display());
        Ok(())
    }
}
