//! Second formulation of the short-period models, for tests and cross-checks.
//!
//! The same equations as the patches, written once more as plain derivative
//! functions and integrated by the classical fourth-order Runge–Kutta method at
//! a fixed fine step. It shares nothing with the analog processor but the
//! coefficients. It locates no switching instants: at a step h across a corner of
//! a dead zone or a limiter the error is O(h²) once, which the fine step makes
//! small. It is no substitute for the machine: what it answers is only held against the machine's.

use super::coefficients::{Plane, Settings};
use super::control_loop::{ControlLoop, Response};
use super::higher_modes::HIGHER;
use super::inexact::Inexact;
use super::plan::Plan;
use super::results::{Results, Run};

// Drift rate, θ, θ̇, F_T, gyro rate and slope, η, η̇, filtered error of the plane; two tips,
// which move as one without roll; roll angle and rate, roll gyro rate and slope.
const DRIFT: usize = 0;
const THETA: usize = 1;
const RATE: usize = 2;
const TVC: usize = 3;
const GYRO: usize = 4;
const GYRO_SLOPE: usize = 5;
const ETA: usize = 6;
const ETA_RATE: usize = 7;
const FILTERED: usize = 8;
const TIP2: usize = 9;
const TIP4: usize = 10;
const ROLL: usize = 11;
const ROLL_RATE: usize = 12;
const ROLL_GYRO: usize = 13;
const ROLL_GYRO_SLOPE: usize = 14;
/// η₂, η̇₂, η₃, η̇₃.
const HIGHER_MODES: usize = 15;
type State = [f64; 15 + 2 * HIGHER];

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

/// What the attitude reference feels of attitude and bending.
fn sensed_attitude(plane: &Plane, x: &State) -> f64 {
    let higher = plane.higher.iter().flatten().enumerate();
    let felt = higher.map(|(i, mode)| mode.imu_slope * x[HIGHER_MODES + 2 * i]);
    x[THETA] + plane.imu_slope * x[ETA] + felt.sum::<f64>()
}

/// Yaw (or pitch) and roll force of the tips.
fn tip_forces(plane: &Plane, x: &State) -> [f64; 2] {
    [x[TIP2] + x[TIP4], x[TIP2] - x[TIP4]].map(|sum| plane.tip_force * sum / 2.0)
}

fn derivative(settings: &Settings, x: &State) -> State {
    let plane = &settings.plane;
    let mut dx = [0.0; 15 + 2 * HIGHER];
    let [fin_force, roll_force] = tip_forces(plane, x);
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
    let mut station_rate = x[RATE] + plane.gyro_slope * x[ETA_RATE];
    for (i, mode) in plane.higher.iter().flatten().enumerate() {
        let (eta, rate) = (HIGHER_MODES + 2 * i, HIGHER_MODES + 2 * i + 1);
        dx[eta] = x[rate];
        dx[rate] =
            mode.drive * (fin_force + x[TVC]) - mode.drag() * x[rate] - mode.spring() * x[eta];
        station_rate += mode.gyro_slope * x[rate];
    }
    dx[GYRO] = x[GYRO_SLOPE];
    dx[GYRO_SLOPE] = plane.gyro_spring * (station_rate - x[GYRO]) - plane.gyro_drag * x[GYRO_SLOPE];
    let attitude_error = settings.command_rad - sensed_attitude(plane, x);
    let tvc_error = attitude_error - plane.tvc_lead * x[GYRO];
    let width = plane.dead_zone - plane.dead_zone_yield * (x[TIP2] - x[TIP4]).abs() / 2.0;
    let tvc_command =
        limited(plane.tvc_gain * dead_zone(tvc_error, width.max(0.0)), plane.tvc_limit);
    dx[TVC] = plane.tvc_bandwidth * (tvc_command - x[TVC]);
    let ftc_error = attitude_error - plane.ftc_lead * x[GYRO];
    dx[FILTERED] = plane.filter_pole * (ftc_error - x[FILTERED]);
    let shared = settings.roll.is_none_or(|roll| !roll.dedicated);
    let share = if shared { plane.ftc_gain * x[FILTERED] } else { 0.0 };
    let mut roll_share = 0.0;
    if let Some(roll) = &settings.roll {
        roll_share = -roll.gain * (x[ROLL] + roll.lead * x[ROLL_GYRO]);
        dx[ROLL] = x[ROLL_RATE];
        dx[ROLL_RATE] = roll.moment * roll_force + roll.damping * x[ROLL_RATE] + roll.cant;
        dx[ROLL_GYRO] = x[ROLL_GYRO_SLOPE];
        dx[ROLL_GYRO_SLOPE] = plane.gyro_spring * (x[ROLL_RATE] - x[ROLL_GYRO])
            - plane.gyro_drag * x[ROLL_GYRO_SLOPE];
    }
    dx[TIP2] = tip_slope(plane, share + roll_share, x[TIP2]);
    dx[TIP4] = tip_slope(plane, share - roll_share, x[TIP4]);
    dx
}

/// One step of the classical Runge–Kutta method for an autonomous system.
fn step(x: &mut State, h: f64, f: impl Fn(&State) -> State) {
    let shifted =
        |slope: &State, by: f64| -> State { std::array::from_fn(|i| x[i] + by * slope[i]) };
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

/// The grid of a plan at about `step_s` of integration step.
pub fn grid(plan: &Plan, step_s: f64) -> Grid {
    let sample_s = plan.sample.secs();
    let steps = (sample_s / step_s).ceil().max(1.0) as usize;
    Grid { samples: plan.samples(), sample_s, steps }
}

/// Runs a loop from its initial offsets.
pub fn run(settings: &Settings, grid: &Grid) -> Response {
    let plane = &settings.plane;
    let mut response = Response::new(ControlLoop::of(settings), grid.sample_s);
    let mut x: State = [0.0; 15 + 2 * HIGHER];
    if let Some(roll) = &settings.roll {
        x[THETA] = roll.initial.yaw_rad;
        x[RATE] = roll.initial.yaw_rate_radps;
        x[ROLL] = roll.initial.roll_rad;
        x[ROLL_RATE] = roll.initial.roll_rate_radps;
    }
    let step_s = grid.sample_s / grid.steps.max(1) as f64;
    for sample in 0..=grid.samples {
        let [fin_force, roll_force] = tip_forces(plane, &x);
        let alpha = incidence(plane, &x);
        match settings.roll {
            None => {
                let attitude = sensed_attitude(plane, &x);
                let tvc_error = settings.command_rad - attitude - plane.tvc_lead * x[GYRO];
                response.push([
                    x[THETA], x[RATE], alpha, x[ETA], fin_force, x[TVC], x[TIP2], x[DRIFT],
                    x[GYRO], tvc_error,
                ]);
            }
            Some(_) => {
                let alpha_rate =
                    x[RATE] + plane.inverse_speed * drift_acceleration(plane, &x, fin_force);
                response.push([
                    x[THETA],
                    x[RATE],
                    x[ROLL],
                    x[ROLL_RATE],
                    alpha,
                    alpha_rate,
                    x[ETA],
                    fin_force,
                    roll_force,
                    x[TVC],
                    x[TIP2],
                    x[TIP4],
                ]);
            }
        }
        if sample < grid.samples {
            for _ in 0..grid.steps.max(1) {
                step(&mut x, step_s, |x| derivative(settings, x));
            }
        }
    }
    response
}

/// Answers every run of a plan, in its order, at about `step_s` of integration step.
pub fn answer(plan: &Plan, step_s: f64) -> Results {
    let grid = grid(plan, step_s);
    let answered =
        |case| Run::new(plan, case, run(&case.settings, &grid), Vec::new(), &Inexact::default());
    let runs = plan.cases.iter().map(answered).collect();
    Results { plan: plan.clone(), runs, patches: Vec::new() }
}
