//! Translation in the pitch plane and across it: what the digital side integrates.
//!
//! State: inertial speed V in the pitch plane, flight-path angle γ from the local
//! horizontal, geometric altitude h, range angle Γ on a spherical, non-rotating
//! Earth; lateral speed v and distance y from the launch plane to starboard.
//! With r = R_E + h, g = μ/r², body incidence to the path a = θ + Γ − γ,
//! aerodynamic incidence α = θ + Γ − γ_air, and N′ = L_α α − F_c:
//!
//! * V̇ = [(T − A) cos a − N′ sin a]/m − g sin γ
//! * γ̇ = [(T − A) sin a + N′ cos a]/(m V) − (g/V − V/r) cos γ
//! * ḣ = V sin γ
//! * Γ̇ = V cos γ/r
//! * γ_air = atan2(V sin γ, V cos γ − W), V_a² = (V sin γ)² + (V cos γ − W)² + W_cross²
//! * v̇ = [(T − A) sin ψ + (L_α (ψ + atan2(W_cross − v, V_a)) − F_y) cos ψ]/m − g y/r
//! * ẏ = v
//!
//! θ is inertial pitch from the launch horizontal, so θ + Γ is pitch from the
//! local one. F_c, the control force in the pitch plane, is positive when it
//! turns the nose up; being aft of the centre of gravity it then pushes against
//! the normal force. F_y does the same in the yaw plane, positive where it turns
//! the nose to starboard.
//!
//! y points along the normal of the launch plane, which is fixed in the inertial
//! frame: the paper's v_E and R_oy, eqs. (11) and (16). So nothing but forces is in
//! v̇; the thrust axis leaves the plane by sin ψ, eq. (3), the side force follows
//! the drift through the air, and gravity pulls back by y/r. The plane itself feels
//! nothing of it: V, γ, h, Γ are the components in the pitch plane (cos ψ = 1), and
//! the yaw loop has the nominal α_y, without the drift (the paper, §4.2). Thrust
//! misalignment is a moment in both planes, no force.
//!
//! Departs from the paper, eq. (14): the azimuth departs from that of the launch
//! by atan2(v, V cos γ), since it needs the horizontal speed. Departs from the
//! paper, eq. (19): the angle off the launch plane is sin⁻¹(y/r).
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
//! The stage of a Runge–Kutta step takes θ, ψ, F_c and F_y as sampled at the frame
//! start, held, or with θ extrapolated along a given rate.

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
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TrajectoryState {
    /// V, m/s.
    pub speed_mps: f64,
    /// γ, rad.
    pub path_angle_rad: f64,
    /// h, m.
    pub altitude_m: f64,
    /// Γ, rad.
    pub range_angle_rad: f64,
    /// v, m/s, to starboard.
    pub cross_speed_mps: f64,
    /// y, m, to starboard of the launch plane.
    pub cross_m: f64,
}

/// A path this near to the vertical has no azimuth worth the name, rad (5°).
pub const VERTICAL_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Number of translational states.
pub const STATE_LEN: usize = 6;

impl TrajectoryState {
    /// Lift-off: 1 m/s, a hair off the vertical, at the launch altitude.
    pub fn at_lift_off(vehicle: &Vehicle) -> Self {
        Self {
            speed_mps: START_SPEED_MPS,
            path_angle_rad: std::f64::consts::FRAC_PI_2 - START_OFF_VERTICAL_RAD,
            altitude_m: vehicle.data().site.launch_altitude_m,
            range_angle_rad: 0.0,
            cross_speed_mps: 0.0,
            cross_m: 0.0,
        }
    }

    /// As the array `[V, γ, h, Γ, v, y]`.
    pub fn to_array(self) -> [f64; STATE_LEN] {
        [
            self.speed_mps,
            self.path_angle_rad,
            self.altitude_m,
            self.range_angle_rad,
            self.cross_speed_mps,
            self.cross_m,
        ]
    }

    /// From the array `[V, γ, h, Γ, v, y]`.
    pub fn from_array(array: [f64; STATE_LEN]) -> Self {
        let [speed_mps, path_angle_rad, altitude_m, range_angle_rad, cross_speed_mps, cross_m] =
            array;
        Self { speed_mps, path_angle_rad, altitude_m, range_angle_rad, cross_speed_mps, cross_m }
    }

    /// Departure of the flight azimuth from that of the launch, rad, positive to starboard; none
    /// while the path is vertical within [`VERTICAL_RAD`].
    pub fn azimuth_departure_rad(&self) -> Option<f64> {
        let along = libm::cos(self.path_angle_rad);
        let azimuth_rad = libm::atan2(self.cross_speed_mps, self.speed_mps * along);
        (along.abs() > libm::sin(VERTICAL_RAD)).then_some(azimuth_rad)
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
    /// W_cross, m/s, positive to starboard.
    pub crosswind_mps: f64,
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
        crosswind_mps: sample.cross_mps,
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

/// What the translation takes from the attitude side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// θ, rad.
    pub pitch_rad: f64,
    /// ψ, rad.
    pub yaw_rad: f64,
    /// F_c and F_y, the control forces in the pitch and the yaw plane, N.
    pub control_force_n: [f64; 2],
}

impl Attitude {
    /// In the pitch plane at θ, without control forces.
    pub fn in_plane(pitch_rad: f64) -> Self {
        Self { pitch_rad, yaw_rad: 0.0, control_force_n: [0.0; 2] }
    }
}

/// `[V̇, γ̇, ḣ, Γ̇, v̇, ẏ]` for given flow, coefficients and attitude.
pub fn derivative(
    vehicle: &Vehicle,
    time_s: f64,
    state: &TrajectoryState,
    (flow, airframe): (&Flow, &AirframeCoefficients),
    attitude: &Attitude,
) -> Result<[f64; STATE_LEN], FlightError> {
    if state.speed_mps <= 0.0 {
        return Err(FlightError::SpeedLost { time_s, speed_mps: state.speed_mps });
    }
    let site = &vehicle.data().site;
    let radius_m = site.earth_radius_m + state.altitude_m;
    let gravity_mps2 = site.mu_m3ps2 / (radius_m * radius_m);
    let local_pitch_rad = attitude.pitch_rad + state.range_angle_rad;
    let (sin_a, cos_a) = libm::sincos(local_pitch_rad - state.path_angle_rad);
    let incidence_rad = local_pitch_rad - flow.air_path_angle_rad;
    let (sin_g, cos_g) = libm::sincos(state.path_angle_rad);
    let axial_n = airframe.thrust_n - airframe.axial_force_n;
    let [pitch_force_n, yaw_force_n] = attitude.control_force_n;
    let normal_n = airframe.normal_force_slope_nprad * incidence_rad - pitch_force_n;
    let speed_mps = state.speed_mps;

    let (sin_psi, cos_psi) = libm::sincos(attitude.yaw_rad);
    let drift_mps = flow.crosswind_mps - state.cross_speed_mps;
    let sideslip_rad = attitude.yaw_rad + libm::atan2(drift_mps, flow.airspeed_mps);
    let side_n = airframe.normal_force_slope_nprad * sideslip_rad - yaw_force_n;
    Ok([
        (axial_n * cos_a - normal_n * sin_a) / airframe.mass_kg - gravity_mps2 * sin_g,
        (axial_n * sin_a + normal_n * cos_a) / (airframe.mass_kg * speed_mps)
            - (gravity_mps2 / speed_mps - speed_mps / radius_m) * cos_g,
        speed_mps * sin_g,
        speed_mps * cos_g / radius_m,
        (axial_n * sin_psi + side_n * cos_psi) / airframe.mass_kg
            - gravity_mps2 * state.cross_m / radius_m,
        state.cross_speed_mps,
    ])
}

/// Axes in which the translation is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TranslationAxes {
    /// V and γ.
    FlightPath,
    /// Howe's H frame (x horizontal along the track, z down): r V_h and the vertical velocity.
    H,
}

impl TranslationAxes {
    /// The state in these axes.
    fn of_state(self, earth_radius_m: f64, state: &TrajectoryState) -> [f64; STATE_LEN] {
        let mut array = state.to_array();
        if self == TranslationAxes::H {
            let (sine, cosine) = libm::sincos(state.path_angle_rad);
            array[0] = (earth_radius_m + state.altitude_m) * state.speed_mps * cosine;
            array[1] = state.speed_mps * sine;
        }
        array
    }

    fn to_state(self, earth_radius_m: f64, array: [f64; STATE_LEN]) -> TrajectoryState {
        let mut state = TrajectoryState::from_array(array);
        if self == TranslationAxes::H {
            let level_mps = array[0] / (earth_radius_m + state.altitude_m);
            state.speed_mps = libm::hypot(level_mps, array[1]);
            state.path_angle_rad = libm::atan2(array[1], level_mps);
        }
        state
    }

    /// `[V̇, γ̇, …]` in these axes: d(r V_h)/dt = ṙ V_h + r V̇_h, V_h = V cos γ, V_v = V sin γ.
    fn of_rates(
        self,
        earth_radius_m: f64,
        state: &TrajectoryState,
        mut rates: [f64; STATE_LEN],
    ) -> [f64; STATE_LEN] {
        if self == TranslationAxes::H {
            let (sine, cosine) = libm::sincos(state.path_angle_rad);
            let (v, [v_rate, turn, climb, ..]) = (state.speed_mps, rates);
            let level_rate = v_rate * cosine - v * sine * turn;
            rates[0] = climb * v * cosine + (earth_radius_m + state.altitude_m) * level_rate;
            rates[1] = v_rate * sine + v * cosine * turn;
        }
        rates
    }
}

/// One Runge–Kutta frame of the trajectory, as [`advance_in`], in flight-path axes.
pub fn advance(
    vehicle: &Vehicle,
    wind: &Wind,
    frame: (f64, f64),
    state: &TrajectoryState,
    sampled: &Attitude,
    pitch_rate_radps: f64,
) -> Result<(TrajectoryState, EdgeRecord), FlightError> {
    let axes = TranslationAxes::FlightPath;
    advance_in(axes, vehicle, wind, frame, state, (sampled, pitch_rate_radps))
}

/// One Runge–Kutta frame of the trajectory from `time_s` over `frame_s`; returns the new state
/// and the table edges met in the stages. The attitude is that of the frame start, held, but for
/// θ, which is carried into the stages along `pitch_rate_radps` (0 holds it too).
pub fn advance_in(
    axes: TranslationAxes,
    vehicle: &Vehicle,
    wind: &Wind,
    (time_s, frame_s): (f64, f64),
    state: &TrajectoryState,
    (sampled, pitch_rate_radps): (&Attitude, f64),
) -> Result<(TrajectoryState, EdgeRecord), FlightError> {
    let mut edges = EdgeRecord::NONE;
    let radius_m = vehicle.data().site.earth_radius_m;
    let start = axes.of_state(radius_m, state);
    let next = rk4::step(time_s, &start, frame_s, |stage_s, y| {
        let stage = axes.to_state(radius_m, *y);
        let (flow, airframe) = surroundings(vehicle, wind, stage_s, &stage)?;
        edges.merge(airframe.edges);
        let pitch_rad = sampled.pitch_rad + pitch_rate_radps * (stage_s - time_s);
        let attitude = Attitude { pitch_rad, ..*sampled };
        let rates = derivative(vehicle, stage_s, &stage, (&flow, &airframe), &attitude)?;
        Ok(axes.of_rates(radius_m, &stage, rates))
    })?;
    Ok((axes.to_state(radius_m, next), edges))
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
            cross_speed_mps: 40.0,
            cross_m: -500.0,
        };
        let radius = |s: &TrajectoryState| 6_371_000.0 + s.altitude_m;
        let energy = |s: &TrajectoryState| 0.5 * s.speed_mps.powi(2) - 3.986004418e14 / radius(s);
        let momentum = |s: &TrajectoryState| radius(s) * s.speed_mps * s.path_angle_rad.cos();
        // Of the way across: the normal of the orbital plane, R × V over its length.
        let normal = |s: &TrajectoryState| {
            let (r, y, v) = (radius(s), s.cross_m, s.cross_speed_mps);
            let (up, along) = s.path_angle_rad.sin_cos();
            let (up, along) = (s.speed_mps * up, s.speed_mps * along);
            let (sin, cos) = s.range_angle_rad.sin_cos();
            let [vx, vz] = [up * sin + along * cos, up * cos - along * sin];
            [y * vz - r * cos * v, r * sin * v - y * vx].map(|n| n / (r * along))
        };
        let (e0, l0, n0) = (energy(&state), momentum(&state), normal(&state));
        let sampled = Attitude::in_plane(1.0);
        for n in 0..500 {
            let t = 60.0 + 0.1 * f64::from(n);
            state = advance(&vehicle, &Wind::Calm, (t, 0.1), &state, &sampled, 0.0).unwrap().0;
        }
        // RK4 at 0.1 s: the path turns at γ̇ ≈ g/V ≈ 0.01 rad/s, so h⁴γ̇⁵/120
        // is below 1e-16 a step; what remains is rounding, 500 steps of some
        // ten operations: 5000·1.1e-16.
        assert!((energy(&state) / e0 - 1.0).abs() < 1e-12);
        assert!((momentum(&state) / l0 - 1.0).abs() < 1e-12);
        // Gravity is taken at r instead of √(r² + y²): (y/r)² = 1e-7 of the turn of the plane's
        // normal, which is below 0.1 rad.
        for (now, then) in normal(&state).into_iter().zip(n0) {
            assert!((now - then).abs() < 1e-8, "{now} {then}");
        }
    }

    /// With a fine step both axes are one flight; at a coarse one they differ by what RK4 leaves.
    #[test]
    fn the_h_frame_is_the_same_flight() {
        let vehicle = Vehicle::shipped().unwrap();
        let fly = |axes: TranslationAxes, step_s: f64| {
            let mut state = TrajectoryState::at_lift_off(&vehicle);
            for n in 0..(30.0 / step_s).round() as usize {
                let t = n as f64 * step_s;
                let pitch = vehicle.pitch_programme().at(t).pitch_rad;
                let sampled = Attitude::in_plane(pitch);
                state =
                    advance_in(axes, &vehicle, &Wind::Calm, (t, step_s), &state, (&sampled, 0.0))
                        .unwrap()
                        .0;
            }
            state
        };
        let apart = |step_s: f64| {
            let [a, b] = [TranslationAxes::FlightPath, TranslationAxes::H].map(|x| fly(x, step_s));
            ((a.path_angle_rad - b.path_angle_rad).abs(), (a.altitude_m - b.altitude_m).abs())
        };
        let (fine, coarse) = (apart(0.002), apart(0.1));
        assert!(fine.0 < 1e-9 && fine.1 < 1e-4, "{fine:?}");
        assert!(coarse.0 < 1e-4 && coarse.1 < 0.5, "{coarse:?}");
        assert!(coarse.1 > 100.0 * fine.1, "{fine:?} {coarse:?}");
    }

    #[test]
    fn lost_speed_is_an_error() {
        let vehicle = Vehicle::shipped().unwrap();
        let mut state = TrajectoryState::at_lift_off(&vehicle);
        state.speed_mps = 0.0;
        assert!(matches!(
            advance(&vehicle, &Wind::Calm, (0.0, 0.1), &state, &Attitude::in_plane(1.5), 0.0),
            Err(FlightError::SpeedLost { .. })
        ));
    }
}
