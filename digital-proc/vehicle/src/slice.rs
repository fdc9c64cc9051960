//! Points of the nominal flight, with their coefficients frozen.
//!
//! The coefficients come from the no-wind point-mass flight: the translational
//! equations with θ equal to the stored programme and no control force, by RK4
//! at 0.02 s from lift-off.

use crate::airframe::AirframeCoefficients;
use crate::flight_mode::ControlSettings;
use crate::rk4;
use crate::trajectory::{self, Attitude, FlightError, TrajectoryState};
use crate::wind::Wind;
use crate::{BendingMode, Vehicle};

pub const STEP_S: f64 = 0.02;
/// Steps in a second; times are counted in whole steps.
const STEPS_PER_SECOND: f64 = 50.0;
/// Longest point-mass flight offered, s.
const LONGEST_S: f64 = 1_000.0;

/// A frozen trajectory point.
#[derive(Debug, Clone, PartialEq)]
pub struct SlicePoint {
    pub name: String,
    pub time_s: f64,
    pub trajectory: TrajectoryState,
    /// Angle of attack of the point-mass flight, rad.
    pub incidence_rad: f64,
    /// Coefficients of the attitude equations.
    pub airframe: AirframeCoefficients,
    /// Gains of the designed schedule.
    pub settings: ControlSettings,
    pub bending: BendingMode,
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
        let attitude = Attitude::in_plane(pitch_rad);
        trajectory::derivative(vehicle, stage_s, &stage, (&flow, &airframe), &attitude)
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
}
