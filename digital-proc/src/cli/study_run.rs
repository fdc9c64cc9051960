//! What the study commands share: vehicle, run directory, record.

use super::{Failure, MachineArgs};
use crate::{
    report::{Section, page, provenance},
    run_dir::{DEFAULT_BASE, PatchIdentity, RunDirectory, RunRecord, UtcSecond},
    vehicle::Vehicle,
};
use serde::Serialize;
use std::{collections::BTreeMap, path::PathBuf, time::SystemTime};

/// Vehicle and run directory of a study.
#[derive(clap::Args)]
pub(super) struct StudyArgs {
    /// Vehicle data set of your own [default: the shipped first stage]
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
}

impl StudyArgs {
    pub fn vehicle(&self) -> Result<Vehicle, Failure> {
        match &self.vehicle {
            Some(path) => Vehicle::load(path),
            None => Vehicle::shipped(),
        }
        .map_err(Failure::input)
    }
}

/// One study's run directory with its record.
pub(super) struct StudyRun {
    directory: RunDirectory,
    record: RunRecord,
}

impl StudyRun {
    /// Claims a directory and starts the record; `patches` are names and hashes.
    pub fn begin(
        command: &str,
        args: &StudyArgs,
        machine: &MachineArgs,
        vehicle: &Vehicle,
    ) -> Result<StudyRun, Failure> {
        let started = UtcSecond::from_system(SystemTime::now());
        let directory =
            RunDirectory::create(&args.out, command, started).map_err(Failure::input)?;
        let link = machine.join.link_name();
        let mut parameters = toml::Table::new();
        if let Ok(data) = toml::Value::try_from(vehicle.data()) {
            parameters.insert("vehicle".to_owned(), data);
        }
        Ok(StudyRun {
            directory,
            record: RunRecord {
                command: command.to_owned(),
                command_line: std::env::args().collect(),
                started: started.to_string(),
                profile: machine.profile.clone(),
                link: link.to_owned(),
                versions: BTreeMap::from([(
                    "hybrid-computer".to_owned(),
                    env!("CARGO_PKG_VERSION").to_owned(),
                )]),
                patch: None,
                seeds: BTreeMap::new(),
                parameters,
            },
        })
    }

    /// Notes a parameter of the run.
    pub fn set(&mut self, name: &str, value: impl Into<toml::Value>) {
        self.record.parameters.insert(name.to_owned(), value.into());
    }

    /// Notes the patch that ran.
    pub fn patch(&mut self, name: &str, sha256: &str) {
        self.record.patch = Some(PatchIdentity {
            name: name.to_owned(),
            sha256: sha256.to_owned(),
        });
    }

    /// A file of the study's own beside the record.
    pub fn file(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        self.directory
            .write_file(name, text.as_bytes())
            .map_err(Failure::input)?;
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
        self.directory
            .write_record(&self.record)
            .map_err(Failure::input)?;
        self.directory
            .write_summary(summary)
            .map_err(Failure::input)?;
        sections.push(Section::new("Provenance", provenance(&self.record)));
        self.directory
            .write_report(&page(title, lead, &sections))
            .map_err(Failure::input)
    }
}
