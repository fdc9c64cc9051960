//! One channel through the digital side: the law of circle and root, and what its record holds.

use super::{
    identify,
    plan::{LabError, Machine, RunPlan},
    theory::{C64, damping_ratio, feedback_loop::FeedbackLoop},
};
use desk::outcome::Outcome;
use nalgebra::ComplexField;

/// Measured and exact damping may differ by this; frequencies, relative.
const ROOT_LIMIT: f64 = 1e-4;

/// Runs the loop that theory solves for some frames of `patch` and finds its root.
///
/// The law is `u_n = k [m_n + a (m_n − m_{n−1})]` from ADC 0 to DAC 0, with `m_{−1} = m_0`. The
/// record is thinned to about twenty samples a cycle so that the modes stay apart in z. The first
/// frames are left out: there the buffers still hold their initial values, and the modes of
/// |z| ≪ 1 that this excites would be no exponentials any more after thinning.
pub(super) fn sampled_root(
    machine: &mut impl Machine,
    theory: &FeedbackLoop,
    (patch, params): (&'static str, Vec<(&'static str, f64)>),
    frames: f64,
    per_cycle: f64,
) -> Result<C64, LabError> {
    const FILLING: usize = 8;
    let frame_s = theory.frame_s;
    let plan = RunPlan {
        params,
        hold: theory.hold,
        ..RunPlan::new(patch, frame_s, theory.latency_s, frames * frame_s)?
    };
    let mut record = Vec::new();
    machine.run(&plan, &mut |samples, updates| {
        let m = samples.adc[0];
        let before = record.last().copied().unwrap_or(m);
        updates.set_dac(0, theory.gain * (m + theory.lead_frames * (m - before)));
        record.push(m);
    })?;
    let record = &record[FILLING.min(record.len())..];
    // 36 samples are the least that the matrix pencil takes.
    let longest = (record.len() / 40).max(1);
    let stride = ((per_cycle / 20.0).floor().max(1.0) as usize).min(longest);
    let thinned: Vec<f64> = record.iter().step_by(stride).copied().collect();
    let near = theory.continuous_root()?;
    Ok(identify::oscillatory_pole(&thinned, stride as f64 * frame_s, 1e-9, near)?)
}

/// Checks pairs of a measured root and the exact one, which is that `of` something.
pub(super) fn check_roots(outcome: &mut Outcome, of: &str, pairs: &[(C64, C64)]) {
    let zeta = super::worst(pairs.iter().map(|(m, e)| damping_ratio(*m) - damping_ratio(*e)));
    let omega = super::worst(pairs.iter().map(|(m, e)| m.modulus() / e.modulus() - 1.0));
    outcome.check(
        "roots",
        format!(
            "damping and frequency are those of {of} within {ROOT_LIMIT:e}: worst {zeta:.1e} in zeta, {omega:.1e} relative in omega, of {} cases",
            pairs.len()
        ),
        zeta < ROOT_LIMIT && omega < ROOT_LIMIT,
    );
}
