//! What the study commands read before they run: vehicle, study, selection, record.

use super::{
    MachineArgs,
    vehicle_args::{self, VehicleArgs},
};
use crate::study::short_period::{plan::Plan, study_file::Study};
use desk::failure::Failure;
use desk::{
    faults::suggestion,
    run_dir::{Column, RunDirError, RunDirectory, RunRecord, TraceWriter, UtcSecond},
};
use interface::{Tick, profile::Profile};
use std::{fs::File, path::PathBuf};
use vehicle::Vehicle;

/// Rows in one batch of a trace.
const BATCH_ROWS: usize = 256;

/// The files a study is made of.
#[derive(clap::Args)]
pub struct StudyArgs {
    /// Study file of your own: trajectory points and operating conditions [default: the shipped study]
    #[arg(long, value_name = "FILE")]
    pub study: Option<PathBuf>,
    #[command(flatten)]
    vehicle: VehicleArgs,
}

impl StudyArgs {
    /// Reads and checks both files.
    pub fn load(&self) -> Result<(Vehicle, Study), Failure> {
        let vehicle = self.vehicle.load()?;
        let study = match &self.study {
            Some(path) => Study::load(path),
            None => Study::shipped(),
        }
        .map_err(Failure::input)?;
        Ok((vehicle, study))
    }

    /// Names of the files for the record.
    pub fn record(
        &self,
        parameters: &mut toml::Table,
        vehicle: &Vehicle,
        study: &Study,
    ) -> Result<(), Failure> {
        parameters.insert("study-file".to_owned(), study.file.clone().into());
        vehicle_args::record(vehicle, parameters)
    }
}

/// A record with what every study command shares.
pub fn record(
    command: &str,
    machine: &MachineArgs,
    profile: &Profile,
    started: UtcSecond,
    patches: &[(String, String)],
    mut parameters: toml::Table,
) -> RunRecord {
    let hashes: toml::Table =
        patches.iter().map(|(name, hash)| (name.clone(), hash.clone().into())).collect();
    parameters.insert("patch-sha256".to_owned(), hashes.into());
    let link = machine.join.link_name();
    RunRecord { parameters, ..RunRecord::begin(command, started, &profile.name, link) }
}

/// Keeps the runs of one point and of one condition, each by name.
pub fn select(
    plan: &mut Plan,
    study: &Study,
    point: Option<&str>,
    condition: Option<&str>,
) -> Result<(), Failure> {
    let named = |what: &str, name: &str, known: Vec<&str>| {
        known.iter().position(|k| *k == name).ok_or_else(|| {
            let remedy = suggestion(name, known.iter().copied());
            Failure::input(format!("{} has no {what} `{name}`; {remedy}", study.file))
        })
    };
    let point = point
        .map(|name| named("point", name, plan.points.iter().map(|p| p.name.as_str()).collect()))
        .transpose()?;
    let condition = condition
        .map(|name| {
            let known = plan.conditions.iter().map(|c| c.name.as_str()).collect();
            named("condition", name, known)
        })
        .transpose()?;
    let keep = |p: usize, c: usize| {
        point.is_none_or(|point| point == p) && condition.is_none_or(|condition| condition == c)
    };
    plan.pitch.retain(|c| keep(c.point, c.condition));
    plan.yaw_roll.retain(|c| keep(c.point, c.condition));
    Ok(())
}

/// Curves of equal sampling as a trace: a column each, `None` past the end of a short one.
pub struct Curves<'a> {
    columns: Vec<Column>,
    values: Vec<&'a [f64]>,
}

impl<'a> Curves<'a> {
    /// None yet.
    pub fn new() -> Curves<'a> {
        Curves { columns: Vec::new(), values: Vec::new() }
    }

    /// Adds a column.
    pub fn add(&mut self, name: String, unit: &str, values: &'a [f64]) {
        self.columns.push(Column::new(name, unit));
        self.values.push(values);
    }

    /// Writes them as `name` into the directory; `tick` is the time of a row.
    pub fn write(
        &self,
        directory: &RunDirectory,
        name: &str,
        tick: impl Fn(usize) -> Tick,
    ) -> Result<(), Failure> {
        let trace = directory.create_stream(name, &self.columns, BATCH_ROWS)?;
        Ok(self.write_to(trace, tick)?)
    }

    fn write_to(
        &self,
        mut trace: TraceWriter<File>,
        tick: impl Fn(usize) -> Tick,
    ) -> Result<(), RunDirError> {
        let rows = self.values.iter().map(|v| v.len()).max().unwrap_or(0);
        let mut row = vec![f64::NAN; self.values.len()];
        for i in 0..rows {
            for (cell, column) in row.iter_mut().zip(&self.values) {
                *cell = column.get(i).copied().unwrap_or(f64::NAN);
            }
            trace.push(tick(i), &row)?;
        }
        trace.finish().map(|_| ())
    }
}
