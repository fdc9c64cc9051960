//! What a run of a loop study did: the least damped oscillatory mode of its record.

use super::{
    super::{
        identify,
        loop_law::LoopLaw,
        plan::LabError,
        theory::{C64, damping_ratio, growth_per_cycle},
    },
    LoopCase,
};
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
    /// ζ of the least damped oscillatory mode found, if any.
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
        let floor = match self.bits {
            // Quantisation of relative size 2^−bits stands above the noise-free floor.
            Some(bits) => 4.0 * 2f64.powi(-i32::try_from(bits).unwrap_or(32)),
            None => 1e-9,
        };
        let poles = match identify::poles(record, self.frame.secs(), floor) {
            Ok(p) => p,
            Err(identify::IdentifyError::NoOscillation) => Vec::new(),
            Err(e) => return Err(e.into()),
        };
        let half_rate = std::f64::consts::PI / self.frame.secs();
        let least: Option<C64> = poles
            .into_iter()
            .filter(|s| s.im > 0.0 && s.im < 0.999 * half_rate)
            .max_by(|a, b| a.re.total_cmp(&b.re));
        let tenth = (record.len() / 10).max(1);
        let peak = |part: &[f64]| part.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        Ok(LoopRow {
            frame_s: self.frame.secs(),
            latency_s: self.latency.secs(),
            bits: self.bits,
            zeta: least.map(damping_ratio),
            omega_rad_s: least.map(|s| s.norm()),
            growth_per_cycle: least.map(growth_per_cycle),
            last_over_first: peak(&record[record.len() - tenth..]) / peak(&record[..tenth]),
        })
    }
}
