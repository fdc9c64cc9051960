//! Trajectory points of the short-period study, with their coefficients frozen.
//!
//! The coefficients come from the no-wind point-mass flight: the translational
//! equations with θ equal to the stored programme and no control force, by RK4
//! at 0.02 s from lift-off. Nothing is typed in but the times. The points are
//! those the paper lists (§4.1) plus maximum dynamic pressure.

use crate::airframe::AirframeCoefficients;
use crate::flight_mode::ControlSettings;
use crate::rk4;
use crate::trajectory::{self, FlightError, TrajectoryState};
use crate::vehicle::{BendingMode, Vehicle};
use crate::wind::Wind;

/// Step of the point-mass flight, s.
pub const STEP_S: f64 = 0.02;
/// Steps in a second; times are counted in whole steps.
const STEPS_PER_SECOND: f64 = 50.0;
/// Longest point-mass flight offered, s.
const LONGEST_S: f64 = 1_000.0;

/// The points of the study: name and flight time, s.
pub const POINTS: [(&str, f64); 12] = [
    ("vertical-rise", 2.0),
    ("pitch-initiation", 4.0),
    ("max-pitch-rate", 7.5),
    ("ftc-switch-in", 17.0),
    ("transonic", 18.3),
    ("gain-20", 20.0),
    ("gain-25", 25.0),
    ("max-q", 32.5),
    ("gain-34", 34.0),
    ("gain-40", 40.0),
    ("gain-45", 45.0),
    ("burn-out", 47.0),
];

/// A frozen trajectory point.
#[derive(Debug, Clone, PartialEq)]
pub struct SlicePoint {
    /// Name.
    pub name: String,
    /// Flight time, s.
    pub time_s: f64,
    /// Trajectory there.
    pub trajectory: TrajectoryState,
    /// Angle of attack of the point-mass flight, rad.
    pub incidence_rad: f64,
    /// Coefficients of the attitude equations.
    pub airframe: AirframeCoefficients,
    /// Gains of the designed schedule.
    pub settings: ControlSettings,
    /// First bending mode.
    pub bending: BendingMode,
}

/// All points of the study, in order of time, from one flight.
pub fn standard_points(vehicle: &Vehicle) -> Result<Vec<SlicePoint>, FlightError> {
    points(vehicle, &POINTS)
}

/// Points at given times (s, any order, 0 to 1000), from one flight.
pub fn points(vehicle: &Vehicle, wanted: &[(&str, f64)]) -> Result<Vec<SlicePoint>, FlightError> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].1.total_cmp(&wanted[b].1));
    let mut found: Vec<Option<SlicePoint>> = vec![None; wanted.len()];
    let mut state = TrajectoryState::at_lift_off(vehicle);
    let mut step_number = 0u64;
    for index in order {
        let (name, time_s) = wanted[index];
        if !(0.0..=LONGEST_S).contains(&time_s) {
            return Err(FlightError::BadSetting {
                what: "the time of a trajectory point",
                value: time_s,
            });
        }
        // A hair of slack, so that 18.3 s counts as 915 whole steps.
        let whole = (time_s * STEPS_PER_SECOND + 1e-9).floor() as u64;
        while step_number < whole {
            state =
                point_mass_step(vehicle, step_number as f64 / STEPS_PER_SECOND, &state, STEP_S)?;
            step_number += 1;
        }
        let start_s = whole as f64 / STEPS_PER_SECOND;
        let rest_s = time_s - start_s;
        let there =
            if rest_s > 1e-9 { point_mass_step(vehicle, start_s, &state, rest_s)? } else { state };
        found[index] = Some(freeze(vehicle, name, time_s, there)?);
    }
    Ok(found.into_iter().flatten().collect())
}

fn point_mass_step(
    vehicle: &Vehicle,
    time_s: f64,
    state: &TrajectoryState,
    step_s: f64,
) -> Result<TrajectoryState, FlightError> {
    let next = rk4::step(time_s, &state.to_array(), step_s, |stage_s, y| {
        let stage = TrajectoryState::from_array(*y);
        let (flow, airframe) = trajectory::surroundings(vehicle, &Wind::Calm, stage_s, &stage)?;
        let pitch_rad = vehicle.pitch_programme().at(stage_s).pitch_rad;
        trajectory::derivative(vehicle, stage_s, &stage, (&flow, &airframe), pitch_rad, 0.0)
    })?;
    Ok(TrajectoryState::from_array(next))
}

fn freeze(
    vehicle: &Vehicle,
    name: &str,
    time_s: f64,
    state: TrajectoryState,
) -> Result<SlicePoint, FlightError> {
    let (flow, airframe) = trajectory::surroundings(vehicle, &Wind::Calm, time_s, &state)?;
    let pitch_rad = vehicle.pitch_programme().at(time_s).pitch_rad;
    Ok(SlicePoint {
        name: name.to_owned(),
        time_s,
        trajectory: state,
        incidence_rad: pitch_rad + state.range_angle_rad - flow.air_path_angle_rad,
        airframe,
        settings: ControlSettings::sound(vehicle, time_s),
        bending: vehicle.bending_at(time_s),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_points_are_where_their_names_say() {
        let vehicle = Vehicle::shipped().unwrap();
        let points = standard_points(&vehicle).unwrap();
        assert_eq!(points.len(), POINTS.len());
        let at = |name: &str| points.iter().find(|p| p.name == name).unwrap();
        // The data set calls 18.3 s Mach 1.05: half a unit of its last digit.
        assert!((at("transonic").airframe.mach - 1.05).abs() <= 0.005);
        let peak = at("max-q").airframe.dynamic_pressure_pa;
        assert!(points.iter().all(|p| p.airframe.dynamic_pressure_pa <= peak));
        assert_eq!(at("ftc-switch-in").settings.gains.ftc_gain, 9.5);
        assert!(points.iter().all(|p| p.airframe.edges.is_empty() && p.bending.edges.is_empty()));
    }

    #[test]
    fn order_and_company_do_not_change_a_point() {
        let vehicle = Vehicle::shipped().unwrap();
        let alone = points(&vehicle, &[("x", 18.3)]).unwrap();
        let among = points(&vehicle, &[("late", 40.0), ("x", 18.3), ("off", 18.307)]).unwrap();
        assert_eq!(alone[0], among[1]);
        assert_eq!(among[2].time_s, 18.307);
        assert!(among[2].trajectory.altitude_m > alone[0].trajectory.altitude_m);
        assert!(points(&vehicle, &[("x", f64::NAN)]).is_err());
        assert!(points(&vehicle, &[("x", -1.0)]).is_err());
    }

    /// Natural frequency and damping of the slowest oscillation of the pitch
    /// loop closed by the TVC alone, inside its limits and past its dead zone;
    /// states `[ż, θ, θ̇, F_T, g, ġ, η, η̇]`, paper eqs. (20)–(25).
    fn tvc_only_root(vehicle: &Vehicle, point: &SlicePoint) -> (f64, f64) {
        let (k, gains, mode) = (&point.airframe, &point.settings.gains, &point.bending);
        let data = vehicle.data();
        let (m, i, v) = (k.mass_kg, k.pitch_inertia_kgm2, k.airspeed_mps);
        let (tau, wn) = (data.tvc.time_constant_s, data.gyro.natural_frequency_radps);
        let (lift, turn) = (k.normal_force_slope_nprad, k.moment_slope_nmprad);
        let axial = k.thrust_n - k.axial_force_n;
        let gain = gains.tvc_gain_nprad / tau;
        let wb = mode.natural_frequency_radps;
        let mut a = nalgebra::SMatrix::<f64, 8, 8>::zeros();
        let mut row = |r: usize, entries: &[(usize, f64)]| {
            for &(c, value) in entries {
                a[(r, c)] = value;
            }
        };
        row(0, &[(0, -lift / (m * v)), (1, -(axial + lift) / m), (3, 1.0 / m)]);
        row(1, &[(2, 1.0)]);
        row(
            2,
            &[
                (0, turn / (i * v)),
                (1, turn / i),
                (2, k.rate_damping_nms / i),
                (3, k.tvc_arm_m / i),
            ],
        );
        row(
            3,
            &[
                (1, -gain),
                (3, -1.0 / tau),
                (4, -gain * gains.tvc_lead_s),
                (6, -gain * mode.imu_slope_pm),
            ],
        );
        row(4, &[(5, 1.0)]);
        row(
            5,
            &[
                (2, wn * wn),
                (4, -wn * wn),
                (5, -2.0 * data.gyro.damping_ratio * wn),
                (7, wn * wn * mode.gyro_slope_pm),
            ],
        );
        row(6, &[(7, 1.0)]);
        row(
            7,
            &[
                (3, mode.displacement_at_control / mode.generalised_mass_kg),
                (6, -wb * wb),
                (7, -2.0 * mode.damping_ratio * wb),
            ],
        );
        a.complex_eigenvalues()
            .iter()
            .filter(|s| s.im > 0.0)
            .map(|s| (s.norm(), -s.re / s.norm()))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap()
    }

    #[test]
    fn the_tvc_alone_is_barely_damped_at_20_s_and_at_max_q() {
        let vehicle = Vehicle::shipped().unwrap();
        let points = standard_points(&vehicle).unwrap();
        // Roots of an independent linearisation of the same data, printed to
        // 0.01 rad/s and 0.001 of damping: one unit of the last digit.
        for (name, frequency, damping) in [("gain-20", 2.91, 0.084), ("max-q", 3.15, 0.085)] {
            let point = points.iter().find(|p| p.name == name).unwrap();
            let (w, zeta) = tvc_only_root(&vehicle, point);
            assert!((w - frequency).abs() <= 0.01, "{name}: {w} rad/s");
            assert!((zeta - damping).abs() <= 0.001, "{name}: {zeta}");
        }
    }
}
