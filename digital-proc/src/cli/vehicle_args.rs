//! The vehicle that a command studies.

use super::own_or;
use desk::failure::Failure;
use std::path::PathBuf;
use vehicle::Vehicle;

/// The data set.
#[derive(clap::Args)]
pub struct VehicleArgs {
    /// Vehicle data set of your own [default: the shipped first stage]
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
}

impl VehicleArgs {
    /// Reads and checks it.
    pub fn load(&self) -> Result<Vehicle, Failure> {
        own_or(self.vehicle.as_deref(), Vehicle::load, Vehicle::shipped)
    }
}

/// The whole data set, for the record of a run.
pub fn record(vehicle: &Vehicle, parameters: &mut toml::Table) -> Result<(), Failure> {
    let data = toml::Value::try_from(vehicle.data()).map_err(Failure::input)?;
    parameters.insert("vehicle".to_owned(), data);
    Ok(())
}
