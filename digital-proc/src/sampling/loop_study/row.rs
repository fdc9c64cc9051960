//! What a run of a loop study did: the least damped oscillatory mode of its record, or the
//! strongest one of a record that came through a converter.

use super::{
    super::{
        identify,
        loop_law::LoopLaw,
        plan::LabError,
        theory::{C64, damping_ratio, growth_per_cycle},
    },
    LoopCase,
};
use nalgebra::ComplexField;
use serde::Serialize;

/// One row of the answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopRow {
    /// Frame, s.
    pub frame_s: f64,
    /// Latency, s.
    pub latency_s: f64,
    /// Bits, none for ideal.
    pub bits: Option<u32>,
    /// ζ of the oscillatory mode found, if any: the least damped, or through a converter the strongest.
    pub zeta: Option<f64>,
    /// |s| of it, rad/s.
    pub omega_rad_s: Option<f64>,
    /// Its growth per cycle.
    pub growth_per_cycle: Option<f64>,
    /// Greatest magnitude in the last tenth of the record over that in the first tenth.
    pub last_over_first: f64,
}

impl LoopCase {
    /// What a run did.
    ///
    /// A record without oscillation leaves the modal columns empty; only a record that cannot be
    /// judged at all is an error.
    ///
    /// # Errors
    /// On an empty or non-finite record.
    pub fn row(&self, law: &LoopLaw) -> Result<LoopRow, LabError> {
        let record = law.record();
        let peak = |part: &[f64]| part.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let step = converter_step(record);
        let judged = above_the_steps(record, step);
        // Quantisation stands above the noise-free floor.
        let floor = (2.0 * step / peak(judged)).max(1e-9);
        let poles = match identify::poles(judged, self.frame.secs(), floor) {
            Ok(p) => p,
            Err(identify::IdentifyError::NoOscillation) => Vec::new(),
            Err(e) => return Err(e.into()),
        };
        let half_rate = std::f64::consts::PI / self.frame.secs();
        let oscillates = |s: &C64| s.im > 0.0 && s.im < 0.999 * half_rate;
        let least: Option<C64> = if step > 0.0 {
            // Noise has modes of its own, some of them undamped: the record's is the strongest.
            identify::strongest(judged, self.frame.secs(), &poles, oscillates)
        } else {
            let oscillating = poles.into_iter().filter(oscillates);
            oscillating.max_by(|a, b| a.re.total_cmp(&b.re))
        };
        let tenth = (record.len() / 10).max(1);
        Ok(LoopRow {
            frame_s: self.frame.secs(),
            latency_s: self.latency.secs(),
            bits: self.bits,
            zeta: least.map(damping_ratio),
            omega_rad_s: least.map(|s| s.modulus()),
            growth_per_cycle: least.map(growth_per_cycle),
            last_over_first: peak(&record[record.len() - tenth..]) / peak(&record[..tenth]),
        })
    }
}

/// A ring-down is judged while it is at least this many converter steps high: below, the loop
/// hunts about one step and has no damping to speak of.
const STEPS_HIGH: f64 = 10.0;
/// Share of a record's peak below which two samples differ by rounding, not by a converter step.
const ROUNDING: f64 = 1e-9;

/// The step of the converter through which a record came: what all its values are multiples of;
/// zero where they are not multiples of one step.
fn converter_step(record: &[f64]) -> f64 {
    let peak = record.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut sorted = record.to_vec();
    sorted.sort_by(f64::total_cmp);
    let step = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > ROUNDING * peak)
        .fold(f64::INFINITY, f64::min);
    let whole = |v: &f64| {
        let steps = v / step;
        (steps - steps.round()).abs() < 1e-3
    };
    if step.is_finite() && record.iter().all(whole) {
        step
    } else {
        0.0
    }
}

/// The record up to its last sample that stands well above the steps; all of it where that
/// leaves too little, or where there are no steps.
fn above_the_steps(record: &[f64], step: f64) -> &[f64] {
    let last = record.iter().rposition(|v| v.abs() >= STEPS_HIGH * step);
    match last {
        Some(last) if step > 0.0 && last + 1 >= identify::SHORTEST => &record[..=last],
        _ => record,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_of_a_converter_is_found_and_a_smooth_record_has_none() {
        let smooth: Vec<f64> = (0..200)
            .map(|n| (-0.02 * n as f64).exp() * (0.3 * n as f64).cos())
            .collect();
        assert_eq!(converter_step(&smooth), 0.0);
        let step = 4.0 / 4096.0;
        let coarse: Vec<f64> = smooth.iter().map(|v| (v / step).round() * step).collect();
        assert!((converter_step(&coarse) - step).abs() < 1e-12);
        let judged = above_the_steps(&coarse, step).len();
        // e^(-0.02 n) = 10 steps = 0.0098 at n = 231: all of it; with ten times the step, n = 116.
        assert!(judged > 190);
        let step = 10.0 * step;
        let coarser: Vec<f64> = smooth.iter().map(|v| (v / step).round() * step).collect();
        let judged = above_the_steps(&coarser, converter_step(&coarser)).len();
        assert!((100..=120).contains(&judged), "{judged}");
        assert_eq!(converter_step(&[0.0; 20]), 0.0);
    }
}
