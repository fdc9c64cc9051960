//! The variables that the paper monitors in a long-period flight, against time.
//!
//! Kept as columns, one value a trajectory step, in the units in which figures and
//! traces show them. [`VARIABLES`] says what a trace and what a figure call each.

use crate::study::evidence;
use serde::Serialize;
use vehicle::flight_summary::FlightSample;

/// The paper's ten variables against time, one value a trajectory step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct History {
    /// Flight time, s.
    pub time_s: Vec<f64>,
    /// (i) Inertial velocity, m/s.
    pub speed_mps: Vec<f64>,
    /// (ii) Flight-path angle, deg.
    pub path_angle_deg: Vec<f64>,
    /// (iii) Altitude, km.
    pub altitude_km: Vec<f64>,
    /// (iv) Range angle, deg.
    pub range_angle_deg: Vec<f64>,
    /// (v) Pitch angle of attack, deg.
    pub incidence_deg: Vec<f64>,
    /// (vi) Mach number.
    pub mach: Vec<f64>,
    /// (vii) Dynamic pressure, kPa.
    pub q_kpa: Vec<f64>,
    /// (viii) Qα, kPa deg, signed.
    pub q_alpha_kpadeg: Vec<f64>,
    /// (ix) Pitch angle, deg.
    pub pitch_deg: Vec<f64>,
    /// (ix) Roll angle, deg.
    pub roll_deg: Vec<f64>,
    /// (x) TVC force in pitch, kN.
    pub tvc_pitch_kn: Vec<f64>,
}

impl History {
    /// Appends a sample.
    pub fn push(&mut self, s: &FlightSample) {
        self.time_s.push(s.time_s);
        self.speed_mps.push(s.trajectory.speed_mps);
        self.path_angle_deg.push(s.trajectory.path_angle_rad.to_degrees());
        self.altitude_km.push(s.trajectory.altitude_m / 1e3);
        self.range_angle_deg.push(s.trajectory.range_angle_rad.to_degrees());
        self.incidence_deg.push(s.incidence_rad.to_degrees());
        self.mach.push(s.mach);
        self.q_kpa.push(s.dynamic_pressure_pa / 1e3);
        self.q_alpha_kpadeg.push(s.q_alpha_padeg() / 1e3);
        self.pitch_deg.push(s.pitch_rad.to_degrees());
        self.roll_deg.push(s.roll_rad.to_degrees());
        self.tvc_pitch_kn.push(s.tvc_pitch_n / 1e3);
    }
}

/// One of the monitored variables: its names, and where it lies.
pub struct Variable {
    /// Column of a trace.
    pub column: &'static str,
    /// Unit of that column.
    pub column_unit: &'static str,
    /// Anchor of its figure.
    pub anchor: &'static str,
    /// Its name in a figure.
    pub label: &'static str,
    /// Its unit in a figure.
    pub unit: &'static str,
    /// Its values.
    pub of: fn(&History) -> &[f64],
}

/// The paper's ten variables; pitch and roll are the two of its (ix).
pub const VARIABLES: [Variable; 11] = [
    variable(["velocity_m_s", "m/s"], ["velocity", "Inertial velocity", "m/s"], |h| &h.speed_mps),
    variable(
        ["flight_path_angle_deg", "deg"],
        ["path-angle", "Inertial flight-path angle", "°"],
        |h| &h.path_angle_deg,
    ),
    variable(["altitude_km", "km"], ["altitude", "Altitude", "km"], |h| &h.altitude_km),
    variable(["range_angle_deg", "deg"], ["range-angle", "Range angle", "°"], |h| {
        &h.range_angle_deg
    }),
    variable(["alpha_deg", "deg"], ["alpha", "Pitch angle of attack", "°"], |h| &h.incidence_deg),
    variable(["mach", ""], ["mach", "Mach number", ""], |h| &h.mach),
    variable(["dynamic_pressure_kpa", "kPa"], ["q", "Dynamic pressure", "kPa"], |h| &h.q_kpa),
    variable(
        ["q_alpha_kpa_deg", "kPa deg"],
        [evidence::Q_ALPHA.anchor(), "Load indicator Qα", "kPa·°"],
        |h| &h.q_alpha_kpadeg,
    ),
    variable(["theta_deg", "deg"], ["pitch", "Pitch angle", "°"], |h| &h.pitch_deg),
    variable(["phi_deg", "deg"], ["roll", "Roll angle", "°"], |h| &h.roll_deg),
    variable(["tvc_pitch_force_kn", "kN"], ["tvc", "TVC force, pitch loop", "kN"], |h| {
        &h.tvc_pitch_kn
    }),
];

/// Of the names in a trace (column, unit) and in a figure (anchor, label, unit).
const fn variable(
    [column, column_unit]: [&'static str; 2],
    [anchor, label, unit]: [&'static str; 3],
    of: fn(&History) -> &[f64],
) -> Variable {
    Variable { column, column_unit, anchor, label, unit, of }
}
