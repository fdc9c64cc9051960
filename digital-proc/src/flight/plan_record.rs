//! A flight's plan as `run.toml` keeps it: the one place where the two meet.
//!
//! A flight is planned from this record and from nothing else, so that the record
//! of a run is enough to fly it again: the vehicle's data, the machine profile and
//! the script of the mode are in it, not the names of files that may have changed.
//! Times are written with their units; a damaged record is refused with its line.

use super::{AlphaPath, AxesName, FlightPlan, FunctionGeneration, Options};
use crate::linkage::executive::Rate;
use clap::ValueEnum;
use desk::{
    faults::{FileFaults, Source},
    run_dir::Seed,
};
use interface::{Tick, profile::Profile};
use serde::{Deserialize, Serialize};
use std::path::Path;
use vehicle::{
    Vehicle, VehicleData,
    flight_mode::FlightScript,
    reference::{FlightCase, RollDrift},
    table::TableError,
    wind::{Wind, WindDirection},
    wind_ensemble,
};

/// Who paces a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// As fast as both sides can; the result depends on no schedule
    LockStep,
    /// The wall clock: updates take effect when they arrive, and are recorded
    Wall,
}

/// Which wind blows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum WindName {
    /// Calm
    None,
    /// The synthetic profile against the flight
    Headwind,
    /// The synthetic profile with the flight
    Tailwind,
    /// A member of the random ensemble of headwinds, drawn by --seed
    Ensemble,
    /// That of the vehicle's design case
    #[value(skip)]
    DesignCase,
}

/// Everything that a flight follows from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PlanRecord {
    pub clock: Pace,
    /// Trajectory step.
    #[serde(with = "tick_text")]
    pub frame: Tick,
    /// Fast frames in one step.
    pub fast: u64,
    /// Total latency τ in lock-step.
    #[serde(with = "tick_text")]
    pub latency: Tick,
    /// Multiplexer skew δ.
    #[serde(with = "tick_text")]
    pub skew: Tick,
    /// Where the flight ends.
    #[serde(with = "tick_text")]
    pub stop: Tick,
    /// How α reaches the rotational equations.
    pub alpha: AlphaPath,
    /// How the yaw incidence does.
    #[serde(default = "held")]
    pub beta: AlphaPath,
    /// Axes of the translation.
    #[serde(default)]
    pub axes: AxesName,
    /// Where the aerodynamic moments are formed.
    #[serde(default)]
    pub functions: FunctionGeneration,
    pub wind: WindName,
    #[serde(default)]
    pub wind_seed: Seed,
    /// Thrust misalignment in pitch, fraction of 3σ.
    pub misalign_pitch: f64,
    /// Thrust misalignment in yaw, fraction of 3σ.
    pub misalign_yaw: f64,
    /// No failure acts before this.
    #[serde(with = "tick_text")]
    pub failure_at: Tick,
    pub mode: FlightScript,
    pub profile: Profile,
    pub vehicle: VehicleData,
}

/// Of a record older than the choice.
fn held() -> AlphaPath {
    Options::NONE.beta
}

/// A plan that cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum PlanFault {
    #[error("--misalign-pitch and --misalign-yaw must be finite")]
    Misalignment,
    #[error("--fast must be at least 1")]
    NoFastFrame,
    #[error(
        "--frame {step} is not {fast} fast frames of whole nanoseconds; choose another --frame or --fast"
    )]
    Periods { step: Tick, fast: u64 },
    #[error(
        "--latency {latency} must lie between 0 and one fast frame, {fast}; choose another --latency, --frame or --fast"
    )]
    Latency { latency: Tick, fast: Tick },
    #[error(transparent)]
    Wind(#[from] TableError),
    #[error(transparent)]
    Vehicle(#[from] FileFaults),
}

impl PlanRecord {
    pub fn fast_frame(&self) -> Result<Tick, PlanFault> {
        let slow = Rate::every(self.fast).ok_or(PlanFault::NoFastFrame)?;
        slow.fast_period(self.frame).ok_or(PlanFault::Periods { step: self.frame, fast: self.fast })
    }

    pub fn vehicle(&self) -> Result<Vehicle, PlanFault> {
        Ok(Vehicle::from_data(self.vehicle.clone())?)
    }

    /// The plan for its vehicle.
    pub fn plan(&self, vehicle: &Vehicle) -> Result<FlightPlan, PlanFault> {
        let fast = self.fast_frame()?;
        if self.latency < Tick::ZERO || self.latency > fast {
            return Err(PlanFault::Latency { latency: self.latency, fast });
        }
        let slow = Rate::every(self.fast).ok_or(PlanFault::NoFastFrame)?;
        if !(self.misalign_pitch.is_finite() && self.misalign_yaw.is_finite()) {
            return Err(PlanFault::Misalignment);
        }
        let wind = match self.wind {
            WindName::None => Wind::Calm,
            WindName::Headwind => Wind::synthetic(vehicle, WindDirection::Head)?,
            WindName::Tailwind => Wind::synthetic(vehicle, WindDirection::Tail)?,
            WindName::Ensemble => {
                wind_ensemble::member(vehicle, wind_ensemble::HEADWIND, self.wind_seed.0)?
            }
            WindName::DesignCase => Wind::design_case(vehicle)?,
        };
        Ok(FlightPlan {
            case: FlightCase {
                script: self.mode.clone(),
                failure_start_s: self.failure_at.secs(),
                wind,
                pitch_misalignment: self.misalign_pitch,
                yaw_misalignment: self.misalign_yaw,
                roll_drift: RollDrift::NONE,
            },
            step: self.frame,
            slow,
            latency: self.latency,
            skew: self.skew,
            stop: self.stop,
            alpha: self.alpha,
            options: Options { beta: self.beta, axes: self.axes, functions: self.functions },
            profile: self.profile.clone(),
        })
    }

    /// As the `parameters` of a run.
    pub fn to_parameters(&self) -> Result<toml::Table, toml::ser::Error> {
        toml::Table::try_from(self)
    }

    /// Reads the `parameters` in the text of a `run.toml`; `path` serves faults only.
    pub fn from_run_toml(path: &Path, text: &str) -> Result<PlanRecord, FileFaults> {
        #[derive(Deserialize)]
        struct Whole {
            parameters: PlanRecord,
        }
        let file = path.display().to_string();
        let whole: Whole = Source { file: &file, text }.parse()?;
        Ok(whole.parameters)
    }
}

/// A tick as text with its unit.
mod tick_text {
    use interface::Tick;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(tick: &Tick, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(tick)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Tick, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(D::Error::custom)
    }
}
