//! Second formulation of the short-period models, for tests and cross-checks.
//!
//! The same equations as the patches, written once more as plain derivative
//! functions and integrated by the classical fourth-order Runge–Kutta method at
//! a fixed fine step. It shares nothing with the analog processor but the
//! coefficients. It locates no switching instants: at a step h across a corner of
//! a dead zone or a limiter the error is O(h²) once, which the fine step makes
//! small. It is no substitute for the machine and no study runs on it.

use super::coefficients::{PitchSettings, Plane, YawRollSettings};
use super::machine::Answers;
use super::plan::Plan;
use super::response::{PitchResponse, YawRollResponse};

// States of the plane without its tips: drift rate, θ, θ̇, F_T, gyro rate and
// slope, η, η̇, filtered error.
const DRIFT: usize = 0;
const THETA: usize = 1;
const RATE: usize = 2;
const TVC: usize = 3;
const GYRO: usize = 4;
const GYRO_SLOPE: usize = 5;
const ETA: usize = 6;
const ETA_RATE: usize = 7;
const FILTERED: usize = 8;
// The pitch loop adds its tip deflection.
const TIP: usize = 9;
const PITCH: usize = 10;
// The yaw–roll loop adds two tips, roll angle and rate, roll gyro rate and slope.
const TIP2: usize = 9;
const TIP4: usize = 10;
const ROLL: usize = 11;
const ROLL_RATE: usize = 12;
const ROLL_GYRO: usize = 13;
const ROLL_GYRO_SLOPE: usize = 14;
const YAW_ROLL: usize = 15;

fn dead_zone(x: f64, half_width: f64) -> f64 {
    if x > half_width {
        x - half_width
    } else if x < -half_width {
        x + half_width
    } else {
        0.0
    }
}

fn limited(x: f64, limit: f64) -> f64 {
    x.max(-limit).min(limit)
}

fn tip_slope(plane: &Plane, demand: f64, deflection: f64) -> f64 {
    let servo = (limited(demand, plane.tip_travel) - deflection) * plane.tip_bandwidth;
    limited(servo, plane.tip_rate)
}

/// Incidence, and the lateral acceleration under a fin force.
fn incidence(plane: &Plane, x: &[f64]) -> f64 {
    x[THETA] + x[DRIFT] * plane.inverse_speed + plane.gust
}

fn drift_acceleration(plane: &Plane, x: &[f64], fin_force: f64) -> f64 {
    plane.control_pull * (fin_force + x[TVC])
        - plane.thrust_pull * x[THETA]
        - plane.normal_pull * incidence(plane, x)
}

fn plane_derivative(plane: &Plane, command: f64, fin_force: f64, x: &[f64], dx: &mut [f64]) {
    let alpha = incidence(plane, x);
    dx[DRIFT] = drift_acceleration(plane, x, fin_force);
    dx[THETA] = x[RATE];
    dx[RATE] = plane.aero_moment * alpha
        + plane.damping * x[RATE]
        + plane.ftc_moment * fin_force
        + plane.tvc_moment * x[TVC]
        + plane.misalignment;
    dx[ETA] = x[ETA_RATE];
    dx[ETA_RATE] = plane.bending_drive * (fin_force + x[TVC])
        - plane.bending_drag * x[ETA_RATE]
        - plane.bending_spring * x[ETA];
    let station_rate = x[RATE] + plane.gyro_slope * x[ETA_RATE];
    dx[GYRO] = x[GYRO_SLOPE];
    dx[GYRO_SLOPE] = plane.gyro_spring * (station_rate - x[GYRO]) - plane.gyro_drag * x[GYRO_SLOPE];
    let attitude_error = command - (x[THETA] + plane.imu_slope * x[ETA]);
    let tvc_error = attitude_error - plane.tvc_lead * x[GYRO];
    let tvc_command =
        limited(plane.tvc_gain * dead_zone(tvc_error, plane.dead_zone), plane.tvc_limit);
    dx[TVC] = plane.tvc_bandwidth * (tvc_command - x[TVC]);
    let ftc_error = attitude_error - plane.ftc_lead * x[GYRO];
    dx[FILTERED] = plane.filter_pole * (ftc_error - x[FILTERED]);
}

/// Derivative of the pitch loop.
fn pitch_derivative(settings: &PitchSettings, x: &[f64; PITCH]) -> [f64; PITCH] {
    let plane = &settings.plane;
    let mut dx = [0.0; PITCH];
    plane_derivative(plane, settings.command_rad, plane.tip_force * x[TIP], x, &mut dx);
    dx[TIP] = tip_slope(plane, plane.ftc_gain * x[FILTERED], x[TIP]);
    dx
}

/// Derivative of the yaw and roll loops.
fn yaw_roll_derivative(settings: &YawRollSettings, x: &[f64; YAW_ROLL]) -> [f64; YAW_ROLL] {
    let plane = &settings.plane;
    let mut dx = [0.0; YAW_ROLL];
    let yaw_force = plane.tip_force * (x[TIP2] + x[TIP4]) / 2.0;
    let roll_force = plane.tip_force * (x[TIP2] - x[TIP4]) / 2.0;
    plane_derivative(plane, 0.0, yaw_force, x, &mut dx);
    let yaw_share = if settings.dedicated { 0.0 } else { plane.ftc_gain * x[FILTERED] };
    let roll_share = -settings.roll_gain * (x[ROLL] + settings.roll_lead * x[ROLL_GYRO]);
    dx[TIP2] = tip_slope(plane, yaw_share + roll_share, x[TIP2]);
    dx[TIP4] = tip_slope(plane, yaw_share - roll_share, x[TIP4]);
    dx[ROLL] = x[ROLL_RATE];
    dx[ROLL_RATE] =
        settings.roll_moment * roll_force + settings.roll_damping * x[ROLL_RATE] + settings.cant;
    dx[ROLL_GYRO] = x[ROLL_GYRO_SLOPE];
    dx[ROLL_GYRO_SLOPE] =
        plane.gyro_spring * (x[ROLL_RATE] - x[ROLL_GYRO]) - plane.gyro_drag * x[ROLL_GYRO_SLOPE];
    dx
}

/// One step of the classical Runge–Kutta method for an autonomous system.
fn step<const N: usize>(x: &mut [f64; N], h: f64, f: impl Fn(&[f64; N]) -> [f64; N]) {
    let shifted =
        |slope: &[f64; N], by: f64| -> [f64; N] { std::array::from_fn(|i| x[i] + by * slope[i]) };
    let k1 = f(x);
    let k2 = f(&shifted(&k1, h / 2.0));
    let k3 = f(&shifted(&k2, h / 2.0));
    let k4 = f(&shifted(&k3, h));
    for (i, value) in x.iter_mut().enumerate() {
        *value += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }
}

/// How finely the reference integrates and samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Duration, as a number of samples after the one at zero.
    pub samples: usize,
    /// Sampling interval, s.
    pub sample_s: f64,
    /// Integration steps a sample, at least 1.
    pub steps: usize,
}

impl Grid {
    fn step_s(&self) -> f64 {
        self.sample_s / self.steps.max(1) as f64
    }
}

/// Runs the pitch loop from rest.
pub fn pitch(settings: &PitchSettings, grid: &Grid) -> PitchResponse {
    let plane = &settings.plane;
    let mut response = PitchResponse::new(grid.sample_s);
    let mut x = [0.0; PITCH];
    for sample in 0..=grid.samples {
        let tvc_error =
            settings.command_rad - x[THETA] - plane.imu_slope * x[ETA] - plane.tvc_lead * x[GYRO];
        response.push([
            x[THETA],
            x[RATE],
            incidence(plane, &x),
            x[ETA],
            plane.tip_force * x[TIP],
            x[TVC],
            x[TIP],
            x[DRIFT],
            x[GYRO],
            tvc_error,
        ]);
        if sample < grid.samples {
            for _ in 0..grid.steps.max(1) {
                step(&mut x, grid.step_s(), |x| pitch_derivative(settings, x));
            }
        }
    }
    response
}

/// Runs the yaw and roll loops from their initial offsets.
pub fn yaw_roll(settings: &YawRollSettings, grid: &Grid) -> YawRollResponse {
    let plane = &settings.plane;
    let mut response = YawRollResponse::new(grid.sample_s);
    let mut x = [0.0; YAW_ROLL];
    x[THETA] = settings.initial.yaw_rad;
    x[RATE] = settings.initial.yaw_rate_radps;
    x[ROLL] = settings.initial.roll_rad;
    x[ROLL_RATE] = settings.initial.roll_rate_radps;
    for sample in 0..=grid.samples {
        let yaw_force = plane.tip_force * (x[TIP2] + x[TIP4]) / 2.0;
        response.push([
            x[THETA],
            x[RATE],
            x[ROLL],
            x[ROLL_RATE],
            incidence(plane, &x),
            x[RATE] + plane.inverse_speed * drift_acceleration(plane, &x, yaw_force),
            x[ETA],
            yaw_force,
            plane.tip_force * (x[TIP2] - x[TIP4]) / 2.0,
            x[TVC],
            x[TIP2],
            x[TIP4],
        ]);
        if sample < grid.samples {
            for _ in 0..grid.steps.max(1) {
                step(&mut x, grid.step_s(), |x| yaw_roll_derivative(settings, x));
            }
        }
    }
    response
}

/// Answers every run of a plan, in its order, at about `step_s` of integration step.
pub fn answer(plan: &Plan, step_s: f64) -> Answers {
    let grid = Grid {
        samples: plan.samples(),
        sample_s: plan.sample_s,
        steps: (plan.sample_s / step_s).ceil().max(1.0) as usize,
    };
    Answers {
        pitch: plan.pitch.iter().map(|case| pitch(&case.settings, &grid)).collect(),
        yaw_roll: plan.yaw_roll.iter().map(|case| yaw_roll(&case.settings, &grid)).collect(),
        ..Answers::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::coefficients::{Disturbance, YawRollInitial};
    use crate::study::short_period::point::tests::numbered;

    fn initial() -> YawRollInitial {
        YawRollInitial { yaw_rad: 0.04, yaw_rate_radps: 0.0, roll_rad: 0.35, roll_rate_radps: 0.0 }
    }

    const DISTURBED: Disturbance = Disturbance { misalignment: 1.0, gust: 1.0, cant: 1.0 };

    /// Corners are not located, so that the error falls with the square of the step.
    #[test]
    fn halving_the_step_changes_nothing_that_is_judged() {
        let point = numbered();
        let settings = PitchSettings::new(&point, &DISTURBED, 0.035);
        let run = |steps| pitch(&settings, &Grid { samples: 300, sample_s: 0.02, steps });
        let (coarse, fine) = (run(20), run(40));
        for (a, b) in coarse.theta_rad().iter().zip(fine.theta_rad()) {
            // A corner costs at most ½·h²·(jump of slope): ½·(1 ms)²·(20 rad/s²·20 1/s).
            assert!((a - b).abs() < 2e-5 * 0.035 * 300.0, "{a} {b}");
        }
    }

    /// Yaw with the tips unshared is pitch: same plane, no roll.
    #[test]
    fn yaw_without_roll_is_pitch_from_an_offset() {
        let point = numbered();
        let grid = Grid { samples: 200, sample_s: 0.02, steps: 20 };
        let level = YawRollInitial { roll_rad: 0.0, ..initial() };
        let yaw_disturbance = Disturbance { cant: 0.0, ..DISTURBED };
        let yaw = yaw_roll(&YawRollSettings::new(&point, &yaw_disturbance, level, false), &grid);
        assert!(yaw.roll_rad().iter().all(|phi| *phi == 0.0));
        assert_eq!(yaw.tip2_rad(), yaw.tip4_rad());
        // Reversing every input reverses every answer: the model is odd.
        let opposite = YawRollInitial { yaw_rad: -level.yaw_rad, ..level };
        let reversed = Disturbance { misalignment: -1.0, gust: -1.0, cant: 0.0 };
        let mirrored = yaw_roll(&YawRollSettings::new(&point, &reversed, opposite, false), &grid);
        for (a, b) in yaw.yaw_rad().iter().zip(mirrored.yaw_rad()) {
            assert_eq!(*a, -*b);
        }
    }

    /// A rolling moment of the tips alone, at their limit: φ̈ = L·δ_max/I_xx.
    #[test]
    fn tips_at_their_limit_roll_the_stage_as_newton_says() {
        let mut point = numbered();
        point.roll_damping_nms = 0.0;
        point.tip_rate_radps = 1e6;
        point.ftc_time_constant_s = 1e-3;
        let far = YawRollInitial { yaw_rad: 0.0, roll_rad: 3.0, ..initial() };
        let settings = YawRollSettings::new(&point, &Disturbance::NONE, far, true);
        let run = yaw_roll(&settings, &Grid { samples: 20, sample_s: 0.02, steps: 100 });
        let acceleration =
            point.tip_force_slope_nprad * point.tip_travel_rad * point.tip_roll_arm_m
                / point.roll_inertia_kgm2;
        let expected = 3.0 - acceleration * 0.4 * 0.4 / 2.0;
        // The tips take 1 ms to get there: a delay of τ costs a·t·τ.
        let bound = 1.1 * acceleration * 0.4 * 1e-3;
        assert!((run.roll_rad()[20] - expected).abs() < bound);
    }
}
