//! The vehicle: its data set, read, validated and made ready for look-up.
//!
//! The shipped set (`data/vehicle.toml`) is embedded, so that the program needs
//! no file; a user's own file is read by [`Vehicle::load`] or, from a text,
//! [`Vehicle::from_toml`]. Studies that disperse parameters change a copy of
//! [`VehicleData`] and rebuild by [`Vehicle::from_data`], which validates again.
//! A faulty set yields no vehicle: all its faults are reported instead.
// Names carry their units; what a name says has no sentence beside it.
#![allow(missing_docs)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::disallowed_methods))]

mod aero;
pub mod airframe;
pub mod atmosphere;
pub mod beam_shape;
mod data;
pub mod failure_file;
pub mod flight_mode;
pub mod flight_summary;
pub mod gain_schedule;
mod mass;
pub mod modal_response;
pub mod pitch_programme;
pub mod range_safety;
pub mod reference;
pub mod rk4;
pub mod slice;
pub mod structure;
pub mod table;
pub mod table_edges;
mod thrust;
pub mod trajectory;
pub mod wind;
pub mod wind_ensemble;

use std::path::Path;

pub use aero::{AeroCoefficients, AeroTables};
pub use data::{
    Aero, Bending, Component, DeadZone, Derived, DesignedGains, Disturbance, Ftc, Geometry, Gyro,
    Imu, Limits, LongPeriodCase, Mass, PitchProgrammeData, RangeSafety, ScheduleData, Site, Thrust,
    Tvc, VehicleData, WindData, WindStatistics,
};
pub use mass::{MassModel, MassProperties};
pub use thrust::{Motor, MotorState, NetThrust, STANDARD_GRAVITY_MPS2};

use crate::gain_schedule::{DeadZoneLaw, GainSchedule};
use crate::pitch_programme::PitchProgramme;
use crate::table::{Edge, Table, TableError};
use crate::table_edges::{EdgeRecord, TableName};
use desk::faults::{FileFaults, Source};
use desk::reader::{self, FileKind};

pub const SHIPPED_TEXT: &str = include_str!("../../data/vehicle.toml");
/// Name under which faults of the shipped set would be reported.
pub const SHIPPED_NAME: &str = "the shipped vehicle";

/// A validated vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct Vehicle {
    data: VehicleData,
    motor: Motor,
    mass: MassModel,
    aero: AeroTables,
    programme: PitchProgramme,
    designed: GainSchedule,
    reduced: GainSchedule,
    bending_frequency_hz: Table,
    bending_mass_kg: Table,
    gyro_slope_pm: Table,
}

/// First bending mode at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BendingMode {
    pub natural_frequency_radps: f64,
    pub damping_ratio: f64,
    pub generalised_mass_kg: f64,
    /// Mode displacement at the control forces.
    pub displacement_at_control: f64,
    /// Mode slope at the rate gyro, 1/m.
    pub gyro_slope_pm: f64,
    /// Mode slope at the IMU, 1/m.
    pub imu_slope_pm: f64,
    pub edges: EdgeRecord,
}

impl Vehicle {
    /// The shipped, SLV-3-like first stage.
    pub fn shipped() -> Result<Self, FileFaults> {
        Self::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
    }

    pub fn load(path: &Path) -> Result<Self, FileFaults> {
        reader::load(path, Self::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, FileFaults> {
        let source = Source { file, text };
        let data = reader::read(FileKind::Vehicle, source, |f| {
            let data = VehicleData::read(f)?;
            data::relations(f, &data);
            Some(data)
        })?;
        // The reader has seen to every table; this tells of what it might miss.
        Self::compile(data)
            .map_err(|error| source.whole(error.to_string(), "correct the table").into())
    }

    /// Builds from data in memory, which are written and read: there is one judge of both. Faults
    /// then carry keys but no lines.
    pub fn from_data(data: VehicleData) -> Result<Self, FileFaults> {
        let file = "vehicle data";
        let text = toml::to_string(&data).map_err(|error| {
            Source { file, text: "" }.whole(error.to_string(), "give numbers that TOML can hold")
        })?;
        Self::from_toml(file, &text).map_err(|mut faults| {
            faults.0.iter_mut().for_each(|fault| fault.place = None);
            faults
        })
    }

    fn compile(data: VehicleData) -> Result<Self, TableError> {
        let bending = &data.bending;
        let law = DeadZoneLaw::new(&data);
        Ok(Self {
            motor: Motor::new(&data)?,
            mass: MassModel::new(&data)?,
            aero: AeroTables::new(&data.aero)?,
            programme: PitchProgramme::new(&data.pitch_programme)?,
            designed: GainSchedule::new(&data.gains.schedule(), law),
            reduced: GainSchedule::new(&data.gains_reduced, law),
            bending_frequency_hz: Table::new(bending.time_s.clone(), bending.freq_hz.clone())?,
            bending_mass_kg: Table::new(
                bending.time_s.clone(),
                bending.generalised_mass_kg.clone(),
            )?,
            gyro_slope_pm: Table::new(
                bending.alternative_gyro_x_m.clone(),
                bending.alternative_gyro_slope_pm.clone(),
            )?,
            data,
        })
    }

    pub fn data(&self) -> &VehicleData {
        &self.data
    }

    pub fn motor(&self) -> &Motor {
        &self.motor
    }

    /// Mass properties at a flight time, with the motor's state there.
    pub fn mass_at(&self, time_s: f64) -> (MassProperties, MotorState) {
        let motor = self.motor.at(time_s);
        (self.mass.at(time_s, motor.propellant_left_kg, motor.mass_flow_kgps), motor)
    }

    pub fn aero_at(&self, mach: f64) -> AeroCoefficients {
        self.aero.at(mach)
    }

    pub fn pitch_programme(&self) -> &PitchProgramme {
        &self.programme
    }

    /// The gain schedule designed from the short-period models.
    pub fn designed_schedule(&self) -> &GainSchedule {
        &self.designed
    }

    /// The gain schedule with fewer switchings.
    pub fn reduced_schedule(&self) -> &GainSchedule {
        &self.reduced
    }

    /// The first bending mode at a flight time, nominal gyro station.
    pub fn bending_at(&self, time_s: f64) -> BendingMode {
        let frequency = self.bending_frequency_hz.lookup(time_s);
        let mut edges = EdgeRecord::NONE;
        edges.note(TableName::Bending, frequency.edge);
        let bending = &self.data.bending;
        BendingMode {
            natural_frequency_radps: std::f64::consts::TAU * frequency.value,
            damping_ratio: bending.damping_ratio,
            generalised_mass_kg: self.bending_mass_kg.lookup(time_s).value,
            displacement_at_control: bending.displacement_at_control,
            gyro_slope_pm: bending.gyro_slope_pm,
            imu_slope_pm: bending.imu_slope_pm,
            edges,
        }
    }

    /// First-mode slope (1/m) at another gyro station, m from the nozzle exit; `None`
    /// off the table, where the mode is not known.
    pub fn gyro_slope_at_station(&self, station_m: f64) -> Option<f64> {
        let lookup = self.gyro_slope_pm.lookup(station_m);
        (lookup.edge == Edge::Inside).then_some(lookup.value)
    }

    /// First and last station of the mode's slope table, m from the nozzle exit.
    pub fn gyro_stations_m(&self) -> [f64; 2] {
        let stations = self.gyro_slope_pm.abscissae();
        [stations[0], stations[stations.len() - 1]]
    }
}

#[cfg(test)]
mod tests;
