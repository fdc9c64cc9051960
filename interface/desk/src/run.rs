//! A command's run on its way: directory and record.

use crate::{
    failure::Failure,
    run_dir::{PatchIdentity, RunDirectory, RunRecord, UtcSecond},
};
use std::path::Path;
use std::time::SystemTime;

/// A run's directory and its record, begun before the work so that a run that is killed shows.
#[derive(Debug)]
pub struct Run {
    pub directory: RunDirectory,
    /// Everything needed to repeat it.
    pub record: RunRecord,
}

impl Run {
    /// Claims a directory under `base` for a run of `command` that starts now.
    pub fn begin(base: &Path, command: &str, profile: &str, link: &str) -> Result<Run, Failure> {
        let started = UtcSecond::from_system(SystemTime::now());
        let directory = RunDirectory::create(base, command, started)?;
        let record = RunRecord::begin(command, started, profile, link);
        directory.write_record(&record)?;
        Ok(Run { directory, record })
    }

    pub fn set(&mut self, name: &str, value: impl Into<toml::Value>) {
        self.record.parameters.insert(name.to_owned(), value.into());
    }

    pub fn patch(&mut self, name: &str, sha256: &str) {
        self.record.patch =
            Some(PatchIdentity { name: name.to_owned(), sha256: sha256.to_owned() });
    }
}
