//! Translation in the pitch plane: what the digital side integrates.
//!
//! State: inertial speed V, flight-path angle γ from the local horizontal,
//! geometric altitude h, range angle Γ on a spherical, non-rotating Earth.
//! With r = R_E + h, g = μ/r², body incidence to the path a = θ + Γ − γ,
//! aerodynamic incidence α = θ + Γ − γ_air, and N′ = L_α α − F_c:
//!
//! * V̇ = [(T − A) cos a − N′ sin a]/m − g sin γ
//! * γ̇ = [(T − A) sin a + N′ cos a]/(m V) − (g/V − V/r) cos γ
//! * ḣ = V sin γ
//! * Γ̇ = V cos γ/r
//! * γ_air = atan2(V sin γ, V cos γ − W), V_a² = (V sin γ)² + (V cos γ − W)² + W_cross²
//!
//! θ is inertial pitch from the launch horizontal, so θ + Γ is pitch from the
//! local one. F_c, the control force in the pitch plane, is positive when it
//! turns the nose up; being aft of the centre of gravity it then pushes against
//! the normal force.
//!
//! These are the paper's eqs. (1) and (11)–(18) in flight-path axes, which keep
//! the product q·u (an "artificial acceleration") out of the digital frame.
//! Departs from the paper, eq. (1): gravity acts along −R/|R|, not along +x_E
//! as printed. Departs from the paper, eqs. (8)–(10): incidence is measured
//! against the velocity through the air, and the wind enters along the local
//! horizontal of the flight plane. Departs from the paper, eq. (13):
//! sin⁻¹(u_E/V) is γ at the launch point only; here γ is kept against the local
//! horizontal throughout. Departs from the paper, eq. (18): Γ is the whole
//! range angle.
//!
//! The stage of a Runge–Kutta step takes θ and F_c as sampled at the frame
//! start, either held or with θ extrapolated along a given rate.

use crate::Vehicle;
use crate::airframe::{AirframeCoefficients, airframe_at};
use crate::atmosphere::AtmosphereError;
use crate::rk4;
use crate::table_edges::{EdgeRecord, TableName};
use crate::wind::Wind;

/// Speed with which every flight starts, m/s: γ̇ divides by V.
pub const START_SPEED_MPS: f64 = 1.0;
/// How far the start is off the vertical, rad, so that the path can turn.
pub const START_OFF_VERTICAL_RAD: f64 = 1e-5;

/// Why a flight could not be continued.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FlightError {
    #[error("at {time_s} s: {source}")]
    Atmosphere { time_s: f64, source: AtmosphereError },
    #[error(
        "at {time_s} s the speed is {speed_mps} m/s; the flight-path equations need it positive"
    )]
    SpeedLost { time_s: f64, speed_mps: f64 },
    #[error("at {time_s} s {variable} is not finite")]
    NotFinite { time_s: f64, variable: &'static str },
    #[error("{what} is {value}; give a positive number")]
    BadSetting { what: &'static str, value: f64 },
}

/// The translational state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrajectoryState {
    /// V, m/s.
    pub speed_mps: f64,
    /// γ, rad.
    pub path_angle_rad: f64,
    /// h, m.
    pub altitude_m: f64,
    /// Γ, rad.
    pub range_angle_rad: f64,
}

impl TrajectoryState {
    /// Lift-off: 1 m/s, a hair off the vertical, at the launch altitude.
    pub fn at_lift_off(vehicle: &Vehicle) -> Self {
        Self {
            speed_mps: START_SPEED_MPS,
            path_angle_rad: std::f64::consts::FRAC_PI_2 - START_OFF_VERTICAL_RAD,
            altitude_m: vehicle.data().site.launch_altitude_m,
            range_angle_rad: 0.0,
        }
    }

    /// As the array `[V, γ, h, Γ]`.
    pub fn to_array(self) -> [f64; 4] {
        [self.speed_mps, self.path_angle_rad, self.altitude_m, self.range_angle_rad]
    }

    /// From the array `[V, γ, h, Γ]`.
    pub fn from_array([speed_mps, path_angle_rad, altitude_m, range_angle_rad]: [f64; 4]) -> Self {
        Self { speed_mps, path_angle_rad, altitude_m, range_angle_rad }
    }
}

/// The flow that the vehicle meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// V_a, m/s, crosswind included.
    pub airspeed_mps: f64,
    /// γ_air, rad.
    pub air_path_angle_rad: f64,
    /// atan2(W_cross, V_a), rad: what the crosswind adds to the yaw incidence.
    pub crosswind_angle_rad: f64,
    pub edges: EdgeRecord,
}

pub fn flow_at(wind: &Wind, state: &TrajectoryState) -> Flow {
    let sample = wind.at(state.altitude_m);
    let (sine, cosine) = libm::sincos(state.path_angle_rad);
    let up_mps = state.speed_mps * sine;
    let along_mps = state.speed_mps * cosine - sample.along_mps;
    let airspeed_mps =
        (up_mps * up_mps + along_mps * along_mps + sample.cross_mps * sample.cross_mps).sqrt();
    let mut edges = EdgeRecord::NONE;
    edges.note(TableName::Wind, sample.edge);
    Flow {
        airspeed_mps,
        air_path_angle_rad: libm::atan2(up_mps, along_mps),
        crosswind_angle_rad: libm::atan2(sample.cross_mps, airspeed_mps),
        edges,
    }
}

pub fn surroundings(
    vehicle: &Vehicle,
    wind: &Wind,
    time_s: f64,
    state: &TrajectoryState,
) -> Result<(Flow, AirframeCoefficients), FlightError> {
    let flow = flow_at(wind, state);
    let mut airframe = airframe_at(vehicle, time_s, state.altitude_m, flow.airspeed_mps)
        .map_err(|source| FlightError::Atmosphere { time_s, source })?;
    airframe.edges.merge(flow.edges);
    Ok((flow, airframe))
}

/// `[V̇, γ̇, ḣ, Γ̇]` for given flow, coefficients, pitch attitude θ (rad) and
/// control force F_c (N) in the pitch plane.
pub fn derivative(
    vehicle: &Vehicle,
    time_s: f64,
    state: &TrajectoryState,
    (flow, airframe): (&Flow, &AirframeCoefficients),
    pitch_rad: f64,
    control_force_n: f64,
) -> Result<[f64; 4], FlightError> {
    if state.speed_mps <= 0.0 {
        return Err(FlightError::SpeedLost { time_s, speed_mps: state.speed_mps });
    }
    let site = &vehicle.data().site;
    let radius_m = site.earth_radius_m + state.altitude_m;
    let gravity_mps2 = site.mu_m3ps2 / (radius_m * radius_m);
    let local_pitch_rad = pitch_rad + state.range_angle_rad;
    let (sin_a, cos_a) = libm::sincos(local_pitch_rad - state.path_angle_rad);
    let incidence_rad = local_pitch_rad - flow.air_path_angle_rad;
    let (sin_g, cos_g) = libm::sincos(state.path_angle_rad);
    let axial_n = airframe.thrust_n - airframe.axial_force_n;
    let normal_n = airframe.normal_force_slope_nprad * incidence_rad - control_force_n;
    let speed_mps = state.speed_mps;
    Ok([
        (axial_n * cos_a - normal_n * sin_a) / airframe.mass_kg - gravity_mps2 * sin_g,
        (axial_n * sin_a + normal_n * cos_a) / (airframe.mass_kg * speed_mps)
            - (gravity_mps2 / speed_mps - speed_mps / radius_m) * cos_g,
        speed_mps * sin_g,
        speed_mps * cos_g / radius_m,
    ])
}

/// What a frame knows of the attitude side, sampled at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledAttitude {
    /// θ, rad.
    pub pitch_rad: f64,
    /// Rate along which θ is carried into the stages, rad/s; 0 holds it.
    pub extrapolation_radps: f64,
    /// F_c, N, held.
    pub control_force_n: f64,
}

/// One Runge–Kutta frame of the trajectory from `time_s` over `frame_s`;
/// returns the new state and the table edges met in the stages.
pub fn advance(
    vehicle: &Vehicle,
    wind: &Wind,
    time_s: f64,
    state: &TrajectoryState,
    frame_s: f64,
    attitude: &SampledAttitude,
) -> Result<(TrajectoryState, EdgeRecord), FlightError> {
    let mut edges = EdgeRecord::NONE;
    let next = rk4::step(time_s, &state.to_array(), frame_s, |stage_s, y| {
        let stage = TrajectoryState::from_array(*y);
        let (flow, airframe) = surroundings(vehicle, wind, stage_s, &stage)?;
        edges.merge(airframe.edges);
        let pitch_rad = attitude.pitch_rad + attitude.extrapolation_radps * (stage_s - time_s);
        derivative(
            vehicle,
            stage_s,
            &stage,
            (&flow, &airframe),
            pitch_rad,
            attitude.control_force_n,
        )
    })?;
    Ok((TrajectoryState::from_array(next), edges))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ballistic_arc_keeps_its_energy_and_angular_momentum() {
        // After burn-out and far above the dense air: drag is what is left, so
        // take a vehicle without aerodynamics.
        let mut data = Vehicle::shipped().unwrap().data().clone();
        data.aero.nose_slope = 0.0;
        for column in [&mut data.aero.axial, &mut data.aero.body_slope, &mut data.aero.fin_slope] {
            column.iter_mut().for_each(|c| *c = 0.0);
        }
        let vehicle = Vehicle::from_data(data).unwrap();
        let mut state = TrajectoryState {
            speed_mps: 1_000.0,
            path_angle_rad: 1.0,
            altitude_m: 24_000.0,
            range_angle_rad: 0.01,
        };
        let radius = |s: &TrajectoryState| 6_371_000.0 + s.altitude_m;
        let energy = |s: &TrajectoryState| 0.5 * s.speed_mps.powi(2) - 3.986004418e14 / radius(s);
        let momentum = |s: &TrajectoryState| radius(s) * s.speed_mps * s.path_angle_rad.cos();
        let (e0, l0) = (energy(&state), momentum(&state));
        let sampled =
            SampledAttitude { pitch_rad: 1.0, extrapolation_radps: 0.0, control_force_n: 0.0 };
        for n in 0..500 {
            let t = 60.0 + 0.1 * f64::from(n);
            state = advance(&vehicle, &Wind::Calm, t, &state, 0.1, &sampled).unwrap().0;
        }
        // RK4 at 0.1 s: the path turns at γ̇ ≈ g/V ≈ 0.01 rad/s, so h⁴γ̇⁵/120
        // is below 1e-16 a step; what remains is rounding, 500 steps of some
        // ten operations: 5000·1.1e-16.
        assert!((energy(&state) / e0 - 1.0).abs() < 1e-12);
        assert!((momentum(&state) / l0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn lost_speed_is_an_error() {
        let vehicle = Vehicle::shipped().unwrap();
        let mut state = TrajectoryState::at_lift_off(&vehicle);
        state.speed_mps = 0.0;
        let sampled =
            SampledAttitude { pitch_rad: 1.5, extrapolation_radps: 0.0, control_force_n: 0.0 };
        assert!(matches!(
            advance(&vehicle, &Wind::Calm, 0.0, &state, 0.1, &sampled),
            Err(FlightError::SpeedLost { .. })
        ));
    }
}
