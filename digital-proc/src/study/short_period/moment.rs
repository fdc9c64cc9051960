//! Bending moments of the short-period runs: each in its own plane, from its recorded columns, on
//! the beam of its point under its condition.

pub mod outcome;

use super::{
    control_loop::{ControlLoop, Response},
    plan::{Case, Plan},
};
use crate::study::bending_moment::{BendingMoments, Recorder, outcome::GreatestMoment};
use std::rc::Rc;
use vehicle::structure::{Applied, Beam, Loads, StructureError};

/// Channels of incidence, tip force and thrust-vector force in the loop's plane.
fn channels(control_loop: ControlLoop) -> [&'static str; 3] {
    match control_loop {
        ControlLoop::Pitch => ["angle_of_attack", "ftc_force", "tvc_force"],
        ControlLoop::YawRoll => ["yaw_angle_of_attack", "ftc_yaw_force", "tvc_yaw_force"],
    }
}

/// The beam at a case's point as its condition leaves it: slopes, arms, misalignment and first
/// bending mode are the condition's, the masses those of the vehicle.
pub fn beam(plan: &Plan, case: &Case) -> Result<Beam, StructureError> {
    let p = &case.frozen;
    plan.structure.beam(&Applied {
        time_s: p.time_s,
        mach: p.mach,
        normal_force_slope_nprad: p.normal_force_slope_nprad,
        moment_slope_nmprad: p.moment_slope_nmprad,
        tip_arm_m: p.tip_arm_m,
        tvc_arm_m: p.tvc_arm_m,
        misalignment_moment_nm: p.misalignment_moment_nm,
        bending_frequency_radps: p.bending_frequency_radps,
        bending_damping: p.bending_damping,
    })
}

/// The moments of an answer; none of one that diverged to what is no number.
pub fn moments(
    plan: &Plan,
    case: &Case,
    response: &Response,
) -> Result<Option<BendingMoments<1>>, StructureError> {
    let beam = Rc::new(beam(plan, case)?);
    let [incidence, tips, tvc] = channels(case.test.control_loop()).map(|adc| response.of(adc));
    if response.is_empty() || !response.is_finite() {
        return Ok(None);
    }
    // The settings hold it as an angular acceleration.
    let full = case.frozen.misalignment_moment_nm / case.frozen.inertia_kgm2;
    let misalignment = if full == 0.0 { 0.0 } else { case.settings.plane.misalignment / full };
    let mut recorder = Recorder::new(&plan.structure);
    for i in 0..response.len() {
        let loads = Loads {
            incidence_rad: incidence[i],
            tip_force_n: tips[i],
            tvc_force_n: tvc[i],
            misalignment,
        };
        recorder.observe(i as f64 * response.sample_s, &beam, [loads]);
    }
    Ok(Some(recorder.finish()))
}

/// What the moments of an answer come to, if it has any.
pub fn greatest(plan: &Plan, case: &Case, response: &Response) -> Option<GreatestMoment> {
    // A plan has beams for all its cases.
    moments(plan, case, response).ok().flatten().map(|found| GreatestMoment::from(&found))
}

#[cfg(test)]
mod tests;
