//! The long-period model integrated as one all-digital system.
//!
//! The partitioned machine solves the same five-degree-of-freedom model on two
//! processors with sampled exchange. This is the second formulation it is held
//! against: translation ([`crate::trajectory`]) and rotation, actuators and
//! sensors ([`attitude`]) as one state vector, by RK4 at 1 ms or finer, with
//! nothing sampled and nothing held. It shares no code with the patch engine.
//!
//! Gains are piecewise constant in time; each step takes those of its midpoint,
//! so that a switch on a step boundary is met exactly. The limiters and dead
//! zones have corners inside steps, which cost accuracy of second order in the
//! step there; at 1 ms that is far below what the partition does.
//!
//! [`fly_partitioned`] is the same model with the paper's split imposed on it:
//! everything the digital side sets is held over a frame, and the translation
//! advances by one RK4 step a frame. Converters, latency and multi-rate tasks
//! are not in it; it isolates the partition's own error.

pub mod attitude;

use attitude::{AttitudeInputs, AttitudeState, STATE_LEN};

use crate::Vehicle;
use crate::flight_mode::{FlightScript, control_settings};
use crate::flight_summary::{FlightMonitor, FlightSample, FlightSummary};
use crate::range_safety::impact_point;
use crate::rk4;
use crate::table_edges::{EdgeRecord, TableName};
use crate::trajectory::{self, FlightError, STATE_LEN as MOVING, TrajectoryState};
use crate::wind::Wind;

/// Coarsest step rate of the reference, 1/s: the gyro (100 rad/s) is its
/// fastest part, and 0.1 rad a step keeps RK4's error per step under 1e-7.
pub const LEAST_STEPS_PER_SECOND: u32 = 1_000;

/// What is flown.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightCase {
    /// Mode of operation: what fails, and when.
    pub script: FlightScript,
    /// No failure acts before this, s; earlier ones wait until then.
    pub failure_start_s: f64,
    pub wind: Wind,
    /// Thrust misalignment in pitch, fraction of 3σ.
    pub pitch_misalignment: f64,
    /// Thrust misalignment in yaw, fraction of 3σ.
    pub yaw_misalignment: f64,
    pub roll_drift: RollDrift,
}

/// Roll that the roll loop does not correct, because what it holds the vehicle to starts off and
/// drifts (paper, §4.2: "small uncorrected roll drift").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollDrift {
    /// Roll at lift-off, rad.
    pub initial_rad: f64,
    /// Rate at which the reference of the roll loop drifts on, rad/s.
    pub rate_radps: f64,
    /// Whether the attitude errors of pitch and yaw are resolved through the roll angle.
    pub resolved: bool,
}

impl RollDrift {
    pub const NONE: RollDrift = RollDrift { initial_rad: 0.0, rate_radps: 0.0, resolved: true };

    /// What the roll loop takes for zero, rad.
    pub fn reference_rad(&self, time_s: f64) -> f64 {
        self.initial_rad + self.rate_radps * time_s
    }
}

impl FlightCase {
    /// No wind, no misalignment, everything works.
    pub fn undisturbed() -> Self {
        Self {
            script: FlightScript::sound(),
            failure_start_s: 0.0,
            wind: Wind::Calm,
            pitch_misalignment: 0.0,
            yaw_misalignment: 0.0,
            roll_drift: RollDrift::NONE,
        }
    }

    /// The data set's design case in a mode of operation.
    pub fn design(
        vehicle: &Vehicle,
        script: &FlightScript,
    ) -> Result<Self, crate::table::TableError> {
        let case = &vehicle.data().long_period_case;
        Ok(Self {
            script: script.clone(),
            failure_start_s: 0.0,
            wind: Wind::design_case(vehicle)?,
            pitch_misalignment: case.misalign_pitch,
            yaw_misalignment: case.misalign_yaw,
            roll_drift: RollDrift::NONE,
        })
    }
}

/// One instant: state, inputs and table edges, before they become a sample.
struct Instant {
    inputs: AttitudeInputs,
    edges: EdgeRecord,
}

/// Evaluates what acts on the vehicle at `time_s`; gains are those in force at
/// `gains_s`.
fn instant(
    vehicle: &Vehicle,
    case: &FlightCase,
    time_s: f64,
    gains_s: f64,
    state: &TrajectoryState,
) -> Result<(Instant, trajectory::Flow), FlightError> {
    let (flow, airframe) = trajectory::surroundings(vehicle, &case.wind, time_s, state)?;
    let command = vehicle.pitch_programme().at(time_s);
    let mut edges = airframe.edges;
    edges.note(TableName::PitchProgramme, command.edge);
    let inputs = AttitudeInputs {
        airframe,
        settings: control_settings(vehicle, &case.script, case.failure_start_s, gains_s),
        pitch_command_rad: command.pitch_rad,
        incidence_offset_rad: state.range_angle_rad - flow.air_path_angle_rad,
        yaw_incidence_offset_rad: flow.crosswind_angle_rad,
        misalignment: [case.pitch_misalignment, case.yaw_misalignment],
        roll_reference_rad: case.roll_drift.reference_rad(time_s),
        errors_resolved: case.roll_drift.resolved,
    };
    Ok((Instant { inputs, edges }, flow))
}

fn sample(
    vehicle: &Vehicle,
    time_s: f64,
    state: &TrajectoryState,
    attitude: &AttitudeState,
    now: &AttitudeInputs,
) -> FlightSample {
    FlightSample {
        time_s,
        trajectory: *state,
        angle_rad: attitude.angle_rad,
        pitch_command_rad: now.pitch_command_rad,
        incidence_rad: attitude.angle_rad[0] + now.incidence_offset_rad,
        yaw_incidence_rad: attitude.angle_rad[1] + now.yaw_incidence_offset_rad,
        mach: now.airframe.mach,
        dynamic_pressure_pa: now.airframe.dynamic_pressure_pa,
        tip_rad: attitude.tip_rad,
        tvc_n: attitude.tvc_n,
        impact: impact_point(&vehicle.data().site, state),
    }
}

/// Names of the monolithic state, in its order, for error reports.
const NAMES: [&str; MOVING + STATE_LEN] = [
    "speed",
    "flight-path angle",
    "altitude",
    "range angle",
    "lateral speed",
    "distance from the launch plane",
    "pitch",
    "yaw",
    "roll",
    "pitch rate",
    "yaw rate",
    "roll rate",
    "pitch tips",
    "tip 2",
    "tip 4",
    "TVC pitch force",
    "TVC yaw force",
    "pitch gyro",
    "yaw gyro",
    "roll gyro",
    "pitch gyro rate",
    "yaw gyro rate",
    "roll gyro rate",
    "pitch filter",
    "yaw filter",
];

fn split(y: &[f64; MOVING + STATE_LEN]) -> (TrajectoryState, AttitudeState) {
    let translation: [f64; MOVING] = std::array::from_fn(|i| y[i]);
    let rotation: [f64; STATE_LEN] = std::array::from_fn(|i| y[MOVING + i]);
    (TrajectoryState::from_array(translation), AttitudeState::from_array(rotation))
}

fn joined(translation: [f64; MOVING], rotation: [f64; STATE_LEN]) -> [f64; MOVING + STATE_LEN] {
    std::array::from_fn(|i| if i < MOVING { translation[i] } else { rotation[i - MOVING] })
}

fn require_finite(time_s: f64, y: &[f64; MOVING + STATE_LEN]) -> Result<(), FlightError> {
    match y.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(FlightError::NotFinite { time_s, variable: NAMES[i] }),
        None => Ok(()),
    }
}

/// Whole steps to the end of burning, at a step rate.
fn steps_to_burn_out(vehicle: &Vehicle, steps_per_second: u32) -> Result<u64, FlightError> {
    if steps_per_second < LEAST_STEPS_PER_SECOND {
        return Err(FlightError::BadSetting {
            what: "the reference's steps per second (1000 at least)",
            value: f64::from(steps_per_second),
        });
    }
    let steps = vehicle.data().mass.burn_time_s * f64::from(steps_per_second);
    if !(1.0..=2e7).contains(&steps) {
        return Err(FlightError::BadSetting {
            what: "the number of steps to burn-out",
            value: steps,
        });
    }
    Ok(steps.round() as u64)
}

/// Flies from lift-off to burn-out as one continuous system; `observe` gets a
/// sample at every step, lift-off and burn-out included.
pub fn fly(
    vehicle: &Vehicle,
    case: &FlightCase,
    steps_per_second: u32,
    mut observe: impl FnMut(&FlightSample),
) -> Result<FlightSummary, FlightError> {
    let steps = steps_to_burn_out(vehicle, steps_per_second)?;
    let rate = f64::from(steps_per_second);
    let step_s = rate.recip();
    let mut monitor = FlightMonitor::new(vehicle);
    let mut y = joined(
        TrajectoryState::at_lift_off(vehicle).to_array(),
        AttitudeState::on_pad(vehicle, case.roll_drift.initial_rad).to_array(),
    );
    for n in 0..=steps {
        let time_s = n as f64 / rate;
        let gains_s = time_s + 0.5 * step_s;
        let (translation, rotation) = split(&y);
        let (now, _) = instant(vehicle, case, time_s, gains_s, &translation)?;
        let seen = sample(vehicle, time_s, &translation, &rotation, &now.inputs);
        monitor.observe(&seen, now.edges);
        observe(&seen);
        if n == steps {
            break;
        }
        y = rk4::step(time_s, &y, step_s, |stage_s, y| {
            let (translation, rotation) = split(y);
            let (now, flow) = instant(vehicle, case, stage_s, gains_s, &translation)?;
            let moving = trajectory::derivative(
                vehicle,
                stage_s,
                &translation,
                (&flow, &now.inputs.airframe),
                &attitude::for_translation(&rotation, &now.inputs),
            )?;
            let turning = attitude::derivative(vehicle, &rotation, &now.inputs);
            Ok(joined(moving, turning.to_array()))
        })?;
        require_finite(time_s + step_s, &y)?;
    }
    monitor.finish().ok_or(FlightError::BadSetting { what: "the number of samples", value: 0.0 })
}

/// How θ enters the Runge–Kutta stages of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StagePitch {
    /// As sampled at the frame start (the paper's way).
    Held,
    /// Carried on along the rate sampled at the frame start.
    Extrapolated,
}

/// Flies with the paper's partition and frames of `steps_per_frame` steps of
/// the attitude side: slopes, gains, θ_c, γ_air and Γ are those of the frame
/// start, held; the trajectory takes one RK4 step a frame with the attitude and control forces of
/// the frame start. The flight ends with the last whole frame before burn-out.
/// `observe` gets a sample at every frame start and at the end.
pub fn fly_partitioned(
    vehicle: &Vehicle,
    case: &FlightCase,
    steps_per_second: u32,
    steps_per_frame: u32,
    stage_pitch: StagePitch,
    mut observe: impl FnMut(&FlightSample),
) -> Result<FlightSummary, FlightError> {
    let steps = steps_to_burn_out(vehicle, steps_per_second)?;
    if steps_per_frame == 0 {
        return Err(FlightError::BadSetting { what: "the number of steps in a frame", value: 0.0 });
    }
    let rate = f64::from(steps_per_second);
    let step_s = rate.recip();
    let frame_s = f64::from(steps_per_frame) / rate;
    let frames = steps / u64::from(steps_per_frame);
    let mut monitor = FlightMonitor::new(vehicle);
    let mut translation = TrajectoryState::at_lift_off(vehicle);
    let mut rotation = AttitudeState::on_pad(vehicle, case.roll_drift.initial_rad);
    for frame in 0..=frames {
        let first_step = frame * u64::from(steps_per_frame);
        let time_s = first_step as f64 / rate;
        // A frame never switches gains inside: those in force just after its start.
        let (now, _) = instant(vehicle, case, time_s, time_s + 0.5 * step_s, &translation)?;
        let seen = sample(vehicle, time_s, &translation, &rotation, &now.inputs);
        monitor.observe(&seen, now.edges);
        observe(&seen);
        if frame == frames {
            break;
        }
        let sampled = attitude::for_translation(&rotation, &now.inputs);
        let pitch_rate_radps = match stage_pitch {
            StagePitch::Held => 0.0,
            StagePitch::Extrapolated => rotation.rate_radps[0],
        };
        let (wind, frame) = (&case.wind, (time_s, frame_s));
        translation =
            trajectory::advance(vehicle, wind, frame, &translation, &sampled, pitch_rate_radps)?.0;
        for sub in 0..u64::from(steps_per_frame) {
            let sub_s = (first_step + sub) as f64 / rate;
            let next = rk4::step(sub_s, &rotation.to_array(), step_s, |_, y| {
                let state = AttitudeState::from_array(*y);
                Ok::<_, FlightError>(attitude::derivative(vehicle, &state, &now.inputs).to_array())
            })?;
            rotation = AttitudeState::from_array(next);
        }
        require_finite(time_s + frame_s, &joined(translation.to_array(), rotation.to_array()))?;
    }
    monitor.finish().ok_or(FlightError::BadSetting { what: "the number of samples", value: 0.0 })
}

#[cfg(test)]
mod tests;
