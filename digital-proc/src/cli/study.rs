//! What the commands of the studies share: their arguments, the run that they leave, their time
//! on the machine.

use super::{
    Context, MachineArgs,
    vehicle_args::{self, VehicleArgs},
};
use crate::{linkage::console::Console, study::short_period::study_file::Study};
use desk::{failure::Failure, outcome::Run, progress::Progress, run_dir::DEFAULT_BASE};
use interface::profile::Profile;
use std::path::PathBuf;
use vehicle::Vehicle;

/// Vehicle, run directory and machine of a study.
#[derive(clap::Args)]
pub(super) struct StudyArgs {
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Directory for runs; each run makes its own directory there
    #[arg(help_heading = "Output", long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    pub machine: MachineArgs,
}

impl StudyArgs {
    pub fn vehicle(&self) -> Result<Vehicle, Failure> {
        self.vehicle.load()
    }

    pub fn profile(&self) -> Result<Profile, Failure> {
        Ok(desk::profile::load(&self.machine.profile)?)
    }

    /// Claims a directory for a run of `command`.
    pub fn begin(
        &self,
        command: &str,
        vehicle: &Vehicle,
        profile: &Profile,
    ) -> Result<Run, Failure> {
        let link = self.machine.join.link_name();
        let mut run = Run::begin(&self.out, command, &profile.name, link)?;
        vehicle_args::record(vehicle, &mut run.record.parameters)?;
        Ok(run)
    }

    /// Does `work` on the machine; it tells how many of `total` are done.
    pub fn on_machine<T, F>(
        &self,
        context: &Context,
        (total, unit): (usize, &'static str),
        work: impl FnOnce(&mut Console<'_>, &mut dyn FnMut(usize)) -> Result<T, F>,
    ) -> Result<T, Failure>
    where
        Failure: From<F>,
    {
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(&mut machine);
        let mut progress = Progress::new(total as u64, unit);
        let done = work(&mut console, &mut |done| progress.at(done as u64));
        progress.done();
        let done = done?;
        console.bye()?;
        Ok(done)
    }
}

/// Trajectory points and operating conditions.
#[derive(clap::Args)]
pub(super) struct PointsArgs {
    /// Study file of your own: trajectory points and operating conditions [default: the shipped
    /// study, at the events and gain switchings of the vehicle in use]
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,
}

impl PointsArgs {
    pub fn load(&self, vehicle: &Vehicle) -> Result<Study, Failure> {
        match &self.study {
            Some(file) => Ok(Study::load(file)?),
            None => Ok(Study::shipped_for(vehicle)?),
        }
    }
}

/// Notes the patches that ran.
pub(super) fn note_patches(run: &mut Run, patches: &[(String, String)]) {
    let hashes = patches.iter().map(|(name, hash)| (name.clone(), hash.clone().into()));
    run.set("patch-sha256", hashes.collect::<toml::Table>());
}
