//! What the study commands share: vehicle, run directory, record.

use super::{
    MachineArgs,
    vehicle_args::{self, VehicleArgs},
};
use desk::failure::Failure;
use desk::{
    report::{Section, page, provenance},
    run_dir::{DEFAULT_BASE, PatchIdentity, RunDirectory, RunRecord, UtcSecond},
};
use interface::profile::Profile;
use serde::Serialize;
use std::{path::PathBuf, time::SystemTime};
use vehicle::Vehicle;

/// Vehicle and run directory of a study.
#[derive(clap::Args)]
pub(super) struct StudyArgs {
    #[command(flatten)]
    vehicle: VehicleArgs,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
}

impl StudyArgs {
    pub fn vehicle(&self) -> Result<Vehicle, Failure> {
        self.vehicle.load()
    }
}

/// One study's run directory with its record.
pub(super) struct StudyRun {
    directory: RunDirectory,
    record: RunRecord,
}

impl StudyRun {
    /// Claims a directory and starts the record in it.
    pub fn begin(
        command: &str,
        args: &StudyArgs,
        machine: &MachineArgs,
        profile: &Profile,
        vehicle: &Vehicle,
    ) -> Result<StudyRun, Failure> {
        let started = UtcSecond::from_system(SystemTime::now());
        let directory = RunDirectory::create(&args.out, command, started)?;
        let link = machine.join.link_name();
        let mut record = RunRecord::begin(command, started, &profile.name, link);
        vehicle_args::record(vehicle, &mut record.parameters)?;
        directory.write_record(&record)?;
        Ok(StudyRun { directory, record })
    }

    /// Notes a parameter of the run.
    pub fn set(&mut self, name: &str, value: impl Into<toml::Value>) {
        self.record.parameters.insert(name.to_owned(), value.into());
    }

    /// Notes the patch that ran.
    pub fn patch(&mut self, name: &str, sha256: &str) {
        self.record.patch =
            Some(PatchIdentity { name: name.to_owned(), sha256: sha256.to_owned() });
    }

    /// A file of the study's own beside the record.
    pub fn file(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        self.directory.write_file(name, text.as_bytes())?;
        Ok(self.directory.file(name))
    }

    /// Writes record, summary and report; returns the report's path.
    pub fn finish(
        &self,
        summary: &impl Serialize,
        title: &str,
        lead: &str,
        mut sections: Vec<Section>,
    ) -> Result<PathBuf, Failure> {
        self.directory.write_record(&self.record)?;
        self.directory.write_summary(summary)?;
        sections.push(Section::new("Provenance", provenance(&self.record)));
        let report = self.directory.write_report(&page(title, lead, &sections))?;
        Ok(report)
    }
}
