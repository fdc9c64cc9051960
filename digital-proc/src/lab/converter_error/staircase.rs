//! A coefficient that the digital side renews once a period, against its ramp.

use crate::lab::{
    plan::{LabError, RunPlan, tick},
    theory::{hold::Hold, noise},
};
use interface::{Tick, frame::Updates};
use serde::Serialize;

/// A coefficient that should follow a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CoefficientSetting {
    /// Rate of the ideal coefficient, 1/s.
    pub rate_per_s: f64,
    /// Period of the settings T, s.
    pub frame_s: f64,
    /// Latency τ, s.
    pub latency_s: f64,
    /// Duration, s.
    pub stop_s: f64,
}

/// Sets DCU 0 to the ramp at each frame.
#[derive(Clone, Copy, Debug)]
pub struct CoefficientLaw {
    setting: CoefficientSetting,
}

/// Staircase error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoefficientRow {
    /// Period, s.
    pub frame_s: f64,
    /// Latency, s.
    pub latency_s: f64,
    /// Mean error from the run.
    pub mean_measured: f64,
    /// `rate (T/2 + τ)`.
    pub mean_theory: f64,
    /// RMS error from the run.
    pub rms_measured: f64,
    /// `rate √(T²/3 + Tτ + τ²)`.
    pub rms_theory: f64,
}

impl CoefficientLaw {
    /// Frame n.
    pub fn step(&mut self, frame: u64, _adc: &[f64], updates: &mut Updates) {
        let s = &self.setting;
        updates.set_dcu(0, s.rate_per_s * (frame as f64 * s.frame_s));
    }
}

impl CoefficientSetting {
    /// `lab/coefficient.toml`; its nets `error_sum` and `square_sum` integrate the error from
    /// the second frame to the end.
    ///
    /// # Errors
    /// For numbers out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        Ok(RunPlan {
            patch: "lab/coefficient.toml",
            params: vec![("rate", self.rate_per_s), ("start", self.start_s())],
            frame: tick("the period", self.frame_s)?,
            latency: tick("the latency", self.latency_s)?,
            skew: Tick::ZERO,
            stop: tick("the stop time", self.stop_s)?,
            hold: Hold::ZeroOrder,
        })
    }

    /// The settled part starts here: after the first transfer of a whole frame, s.
    pub fn start_s(&self) -> f64 {
        2.0 * self.frame_s
    }

    /// The digital side.
    pub fn law(&self) -> CoefficientLaw {
        CoefficientLaw { setting: *self }
    }

    /// From the final values of `error_sum` (∫e dt) and `square_sum` (∫e² dt).
    pub fn row(&self, error_sum: f64, square_sum: f64) -> CoefficientRow {
        let duration = self.stop_s - self.start_s();
        CoefficientRow {
            frame_s: self.frame_s,
            latency_s: self.latency_s,
            mean_measured: error_sum / duration,
            mean_theory: noise::staircase_mean(self.rate_per_s, self.frame_s, self.latency_s),
            rms_measured: (square_sum / duration).sqrt(),
            rms_theory: noise::staircase_rms(self.rate_per_s, self.frame_s, self.latency_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn staircase_of_a_coefficient() {
        let setting =
            CoefficientSetting { rate_per_s: 0.3, frame_s: 0.1, latency_s: 0.02, stop_s: 2.0 };
        let mut law = setting.law();
        let (mut held, mut sum, mut square) = (0.0, 0.0, 0.0);
        let fine = 100;
        for n in 0..20_u32 {
            let mut up = Updates::new(u64::from(n), Tick::ZERO);
            law.step(u64::from(n), &[], &mut up);
            for i in 0..fine {
                if i == 20 {
                    held = up.dcu[0];
                }
                if n >= 2 {
                    let dt = setting.frame_s / f64::from(fine);
                    let t =
                        (f64::from(n) + (f64::from(i) + 0.5) / f64::from(fine)) * setting.frame_s;
                    let e = setting.rate_per_s * t - held;
                    sum += e * dt;
                    square += e * e * dt;
                }
            }
        }
        let row = setting.row(sum, square);
        assert!((row.mean_measured - row.mean_theory).abs() < 1e-12, "{row:?}");
        // Midpoint sums of e² are low by (rate·T/100)²/12 = 7.5e-9 of 6e-4.
        assert!((row.rms_measured / row.rms_theory - 1.0).abs() < 1e-4, "{row:?}");
    }
}
