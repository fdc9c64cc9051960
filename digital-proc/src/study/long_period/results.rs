//! What a long-period study comes to: burn-out, loads and fuel of every flight.

use super::history::History;
use serde::Serialize;
use vehicle::{
    ScheduleData, Vehicle,
    flight_mode::{FlightScript, Schedule},
    flight_summary::FlightSummary,
};

/// Wind of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlightWind {
    /// None.
    Calm,
    /// The wind of the vehicle's design case (a headwind as shipped).
    DesignCase,
    /// The same profile from behind.
    Reversed,
}

impl FlightWind {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            FlightWind::Calm => "calm",
            FlightWind::DesignCase => "design wind",
            FlightWind::Reversed => "reversed wind",
        }
    }
}

/// One flight: what was flown, and what it came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flown {
    /// Wind.
    pub wind: FlightWind,
    /// Thrust misalignment in pitch, fraction of 3σ.
    pub pitch_misalignment: f64,
    /// Thrust misalignment in yaw, fraction of 3σ.
    pub yaw_misalignment: f64,
    /// Figures at burn-out and peaks; absent where the flight was lost.
    pub figures: Option<FlightFigures>,
    /// Why it was lost.
    pub lost: Option<String>,
}

/// What a flight to burn-out comes to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlightFigures {
    /// Burn-out velocity, m/s.
    pub speed_mps: f64,
    /// Burn-out flight-path angle, deg.
    pub path_angle_deg: f64,
    /// Burn-out altitude, m.
    pub altitude_m: f64,
    /// Burn-out range over the ground, m.
    pub range_m: f64,
    /// Largest |Qα| from the take-over of the fin tips on, Pa deg.
    pub max_q_alpha_padeg: f64,
    /// Its flight time, s.
    pub max_q_alpha_time_s: f64,
    /// Its Mach number.
    pub max_q_alpha_mach: f64,
    /// Largest dynamic pressure, Pa.
    pub max_q_pa: f64,
    /// Largest |φ|, deg.
    pub max_roll_deg: f64,
    /// ∫|F_T| dt in pitch, N s.
    pub tvc_pitch_impulse_ns: f64,
    /// ∫|F_T| dt in yaw, N s.
    pub tvc_yaw_impulse_ns: f64,
    /// Side-force injectant used, kg.
    pub injectant_kg: f64,
    /// A table was left at one of its ends, whose value was held.
    pub table_edge: bool,
}

impl FlightFigures {
    /// Of a summary.
    pub fn new(s: &FlightSummary) -> Self {
        Self {
            speed_mps: s.end.speed_mps,
            path_angle_deg: s.end.path_angle_rad.to_degrees(),
            altitude_m: s.end.altitude_m,
            range_m: s.range_m,
            max_q_alpha_padeg: s.max_q_alpha.value,
            max_q_alpha_time_s: s.max_q_alpha.time_s,
            max_q_alpha_mach: s.max_q_alpha.mach,
            max_q_pa: s.max_dynamic_pressure.value,
            max_roll_deg: s.max_roll_rad.to_degrees(),
            tvc_pitch_impulse_ns: s.tvc_pitch_impulse_ns,
            tvc_yaw_impulse_ns: s.tvc_yaw_impulse_ns,
            injectant_kg: s.injectant_kg,
            table_edge: !s.edges.is_empty(),
        }
    }
}

/// Departure of a flight's burn-out from the undisturbed normal flight's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
    pub fn new(flight: &FlightFigures, nominal: &FlightFigures) -> Self {
        Self {
            speed_fraction: flight.speed_mps / nominal.speed_mps - 1.0,
            path_angle_deg: flight.path_angle_deg - nominal.path_angle_deg,
            altitude_fraction: flight.altitude_m / nominal.altitude_m - 1.0,
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
        .iter()
        // A quotient that is no number must not pass as small.
        .fold(
            0.0,
            |worst, part| {
                if part.is_nan() { f64::INFINITY } else { part.abs().max(worst) }
            },
        )
    }
}

/// What is accepted at burn-out, and the load limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeResult {
    /// Name.
    pub name: String,
    /// The paper's words.
    pub text: String,
    /// Whether it flies the schedule with fewer switchings.
    pub reduced_schedule: bool,
    /// The design case.
    pub design: Flown,
    /// Its departure from the undisturbed normal flight.
    pub departure: Option<Departure>,
    /// Its time histories.
    pub history: History,
    /// The same wind with other misalignments in pitch.
    pub envelope: Vec<Flown>,
    /// The design case with the wind reversed.
    pub reversed: Option<Flown>,
}

impl ModeResult {
    /// Before anything was flown but the design case.
    pub fn new(
        script: &FlightScript,
        design: Flown,
        departure: Option<Departure>,
        history: History,
    ) -> Self {
        Self {
            name: script.name.clone(),
            text: script.text.clone(),
            reduced_schedule: script.schedule == Schedule::Reduced,
            design,
            departure,
            history,
            envelope: Vec::new(),
            reversed: None,
        }
    }

    /// Every flight of the mode.
    pub fn flights(&self) -> impl Iterator<Item = &Flown> {
        std::iter::once(&self.design).chain(&self.envelope).chain(&self.reversed)
    }
}

/// The flight that used most side-force fluid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FuelCase {
    /// Mode.
    pub mode: String,
    /// Wind.
    pub wind: FlightWind,
    /// Misalignment in pitch, fraction of 3σ.
    pub pitch_misalignment: f64,
    /// Fluid used, kg.
    pub injectant_kg: f64,
    /// Fluid carried, kg.
    pub carried_kg: f64,
}

/// A whole study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LongPeriodResults {
    /// What is accepted.
    pub accept: Acceptance,
    /// The undisturbed normal flight.
    pub nominal: FlightFigures,
    /// Its time histories.
    pub nominal_history: History,
    /// The modes in the failure file's order.
    pub modes: Vec<ModeResult>,
    /// The designed gain schedule (figure 7).
    pub designed: ScheduleData,
    /// The schedule with fewer switchings (figure 8).
    pub reduced: ScheduleData,
    /// Side-force fluid carried, kg.
    pub carried_kg: f64,
}

impl LongPeriodResults {
    /// The flight with the greatest use of side-force fluid (objective v) among
    /// all that were flown; yaw misalignment is nominal in all of them.
    pub fn worst_fuel(&self) -> Option<FuelCase> {
        self.modes
            .iter()
            .flat_map(|mode| mode.flights().map(move |flown| (mode, flown)))
            .filter_map(|(mode, flown)| {
                flown.figures.map(|figures| FuelCase {
                    mode: mode.name.clone(),
                    wind: flown.wind,
                    pitch_misalignment: flown.pitch_misalignment,
                    injectant_kg: figures.injectant_kg,
                    carried_kg: self.carried_kg,
                })
            })
            .max_by(|a, b| a.injectant_kg.total_cmp(&b.injectant_kg))
    }
}
