//! What a long-period study comes to: a row a mode, with all its flights.

use crate::study::bending_moment::BendingMoments;
use vehicle::{
    RangeSafety, ScheduleData, Vehicle,
    flight_mode::{FlightScript, Schedule},
    flight_summary::{FlightSample, FlightSummary},
    structure::StructureError,
    table::TableError,
    wind::Wind,
};

/// Wind of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightWind {
    /// None.
    Calm,
    /// The wind of the vehicle's design case (a headwind as shipped).
    DesignCase,
    /// The same profile from behind.
    Reversed,
    /// The design wind times [`STRONG`].
    Strong,
}

/// Factor of the wind in which trajectories are compared beyond the design case. The envelope is
/// the mean and 1.65 σ of the shipped wind statistics (0.55 and 0.27 of it); 1.6 of it lies at
/// 3.9 σ, beyond every wind that the vehicle is launched into.
pub const STRONG: f64 = 1.6;

impl FlightWind {
    /// The wind itself.
    pub(super) fn of(self, vehicle: &Vehicle) -> Result<Wind, TableError> {
        let factor = match self {
            FlightWind::Calm => return Ok(Wind::Calm),
            FlightWind::DesignCase => 1.0,
            FlightWind::Reversed => -1.0,
            FlightWind::Strong => STRONG,
        };
        let sign = factor * vehicle.data().long_period_case.wind_sign;
        Wind::signed(vehicle, sign, sign)
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            FlightWind::Calm => "calm",
            FlightWind::DesignCase => "design wind",
            FlightWind::Reversed => "reversed wind",
            FlightWind::Strong => "1.6 × design wind",
        }
    }
}

/// One flight: what was flown, and what it came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// Wind.
    pub wind: FlightWind,
    /// Thrust misalignments in pitch and yaw, fractions of 3σ.
    pub misalignment: [f64; 2],
    /// The flight in short, or why it was lost.
    pub ended: Result<FlightSummary, String>,
    /// Its bending moments, of a flight that is shown: the undisturbed one and the design cases.
    pub moments: Option<Result<BendingMoments<2>, StructureError>>,
}

impl Flown {
    /// Largest |Qα| from the take-over of the fin tips on, kPa deg; infinite where it was lost.
    pub fn load_kpadeg(&self) -> f64 {
        self.ended.as_ref().map_or(f64::INFINITY, |f| f.max_q_alpha.value / 1e3)
    }

    /// Whether it breaks the load limit; a lost flight does, and a peak that is no number.
    pub fn exceeds(&self, accept: &Acceptance) -> bool {
        let peak = self.ended.as_ref().map_or(f64::INFINITY, |f| f.max_q_alpha.value);
        peak.is_nan() || peak > accept.q_alpha_padeg
    }
}

/// Departure of a flight's burn-out from another's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Of the velocity, fraction.
    pub speed_fraction: f64,
    /// Of the flight-path angle, deg.
    pub path_angle_deg: f64,
    /// Of the altitude, fraction.
    pub altitude_fraction: f64,
    /// Of the range, km.
    pub range_km: f64,
}

impl Departure {
    /// Of `flight` from `nominal`.
    pub fn new(flight: &FlightSummary, nominal: &FlightSummary) -> Self {
        let path_angle_deg = |f: &FlightSummary| f.end.path_angle_rad.to_degrees();
        Self {
            speed_fraction: flight.end.speed_mps / nominal.end.speed_mps - 1.0,
            path_angle_deg: path_angle_deg(flight) - path_angle_deg(nominal),
            altitude_fraction: flight.end.altitude_m / nominal.end.altitude_m - 1.0,
            range_km: (flight.range_m - nominal.range_m) / 1e3,
        }
    }

    /// The largest of its four parts, each over what is accepted: at most 1 is accepted.
    pub fn severity(&self, accept: &Acceptance) -> f64 {
        [
            self.speed_fraction / accept.speed_fraction,
            self.path_angle_deg / accept.path_angle_deg,
            self.altitude_fraction / accept.altitude_fraction,
            self.range_km / accept.range_km,
        ]
        // A quotient that is no number must not pass as small.
        .map(|part| if part.is_nan() { f64::INFINITY } else { part.abs() })
        .into_iter()
        .fold(0.0, f64::max)
    }
}

/// What is accepted at burn-out, and the load limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceptance {
    /// Velocity, fraction.
    pub speed_fraction: f64,
    /// Flight-path angle, deg.
    pub path_angle_deg: f64,
    /// Altitude, fraction.
    pub altitude_fraction: f64,
    /// Range, km.
    pub range_km: f64,
    /// Design limit of |Qα|, Pa deg.
    pub q_alpha_padeg: f64,
}

impl Acceptance {
    /// Of the vehicle's data.
    pub fn new(vehicle: &Vehicle) -> Self {
        let case = &vehicle.data().long_period_case;
        Self {
            speed_fraction: case.accept_speed_fraction,
            path_angle_deg: case.accept_dgam_deg,
            altitude_fraction: case.accept_altitude_fraction,
            range_km: case.accept_drange_km,
            q_alpha_padeg: vehicle.data().limits.q_alpha_padeg,
        }
    }
}

/// One mode's flights.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeResult {
    /// Name.
    pub name: String,
    /// The paper's words.
    pub text: String,
    /// Whether it flies the schedule with fewer switchings.
    pub reduced_schedule: bool,
    /// The design case.
    pub design: Flown,
    /// Its samples, one a trajectory step.
    pub history: Vec<FlightSample>,
    /// The same wind with other misalignments in pitch.
    pub envelope: Vec<Flown>,
    /// The design case with the wind reversed.
    pub reversed: Option<Flown>,
    /// The design case in the strong wind, for its trajectory alone: its load is beyond design.
    pub strong: Option<Flown>,
}

impl ModeResult {
    /// Before anything was flown but the design case.
    pub(super) fn new(script: &FlightScript, design: Flown, history: Vec<FlightSample>) -> Self {
        Self {
            name: script.name.clone(),
            text: script.text.clone(),
            reduced_schedule: script.schedule == Schedule::Reduced,
            design,
            history,
            envelope: Vec::new(),
            reversed: None,
            strong: None,
        }
    }

    /// Every flight of the mode in winds that it is designed for.
    pub fn flights(&self) -> impl Iterator<Item = &Flown> {
        self.in_design_wind().chain(&self.reversed)
    }

    /// These and the strong wind.
    pub(super) fn all_flights(&self) -> impl Iterator<Item = &Flown> {
        self.flights().chain(&self.strong)
    }

    /// The design case and its envelope.
    pub(super) fn in_design_wind(&self) -> impl Iterator<Item = &Flown> {
        std::iter::once(&self.design).chain(&self.envelope)
    }
}

/// A whole study.
#[derive(Clone, Debug, PartialEq)]
pub struct LongPeriodResults {
    /// What is accepted.
    pub accept: Acceptance,
    /// The undisturbed normal flight.
    pub undisturbed: Flown,
    /// What it came to.
    pub nominal: FlightSummary,
    /// Its samples.
    pub nominal_history: Vec<FlightSample>,
    /// The flights of the sound vehicle, in the winds and under the misalignments of every mode's.
    pub sound: Vec<Flown>,
    /// The modes in the failure file's order.
    pub modes: Vec<ModeResult>,
    /// The designed gain schedule (figure 7).
    pub designed: ScheduleData,
    /// The schedule with fewer switchings (figure 8).
    pub reduced: ScheduleData,
    /// Where the vehicle may come down.
    pub range_safety: RangeSafety,
}

impl LongPeriodResults {
    /// Departure of a flight's burn-out from that of the sound vehicle in the same wind under the
    /// same misalignments: what the mode does, apart from what wind and misalignment do. `None`
    /// where either was lost.
    pub fn departure(&self, flown: &Flown) -> Option<Departure> {
        let alike = |s: &&Flown| s.wind == flown.wind && s.misalignment == flown.misalignment;
        let sound = self.sound.iter().find(alike)?.ended.as_ref().ok()?;
        Some(Departure::new(flown.ended.as_ref().ok()?, sound))
    }

    /// The largest part of that departure over what is accepted; infinite where there is none.
    pub(super) fn severity(&self, flown: &Flown) -> f64 {
        self.departure(flown).map_or(f64::INFINITY, |d| d.severity(&self.accept))
    }
}
