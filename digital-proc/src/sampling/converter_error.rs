//! Quantisation noise, multiplexer skew and staircase coefficients.
//!
//! Three small experiments on `lab/quantisation.toml`, `lab/skew.toml` and
//! `lab/coefficient.toml`. The quantisation run sends seeded values that the law knows
//! exactly through a DAC of limited bits and reads back the DAC, an integrator and a lag
//! driven by it: what is left after the law's own exact solution is the noise.

use super::{
    identify::angle_difference_rad,
    plan::{LabError, RunPlan, require, tick},
    theory::{hold::Hold, noise},
};
use interface::{Tick, frame::Updates};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Serialize;

/// Quantisation run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct QuantisationSetting {
    /// Bits of the DAC.
    pub bits: u32,
    /// ± full scale (`max` of DAC 0 in the patch).
    pub full_scale: f64,
    /// Frame T, s. The latency is zero.
    pub frame_s: f64,
    /// Corner a of the lag, rad/s.
    pub corner_rad_s: f64,
    /// Frames in the run.
    pub frames: u32,
    /// Frames between the readings of the integrator's growth.
    pub span_frames: u32,
    /// Seed.
    pub seed: u64,
}

/// One variance, measured beside theory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VarianceRow {
    /// What.
    pub quantity: &'static str,
    /// From the run, squared problem units.
    pub measured: f64,
    /// By theory.
    pub theory: f64,
    /// measured/theory − 1.
    pub relative_error: f64,
}

/// Sends seeded uniform values and collects what the converter adds.
///
/// DAC 0 drives; ADC 0 reads the DAC, ADC 1 its integral, ADC 2 its lag.
#[derive(Clone, Debug)]
pub struct QuantisationLaw {
    setting: QuantisationSetting,
    random: Xoshiro256PlusPlus,
    sent: Option<f64>,
    exact_integral: f64,
    exact_lag: f64,
    direct: Vec<f64>,
    integral: Vec<f64>,
    lag: Vec<f64>,
}

impl QuantisationLaw {
    /// Frame n.
    pub fn step(&mut self, _frame: u64, adc: &[f64], updates: &mut Updates) {
        let at = |i: usize| adc.get(i).copied().unwrap_or(f64::NAN);
        if let Some(sent) = self.sent {
            let decay = (-self.setting.corner_rad_s * self.setting.frame_s).exp();
            self.exact_integral += sent * self.setting.frame_s;
            self.exact_lag = decay * self.exact_lag + (1.0 - decay) * sent;
            self.direct.push(at(0) - sent);
            self.integral.push(at(1) - self.exact_integral);
            self.lag.push(at(2) - self.exact_lag);
        }
        // 0.9 of full scale: no code saturates, and thousands are crossed at each step.
        let reach = 0.9 * self.setting.full_scale;
        let value = self.random.random_range(-reach..reach);
        updates.set_dac(0, value);
        self.sent = Some(value);
    }
}

impl QuantisationSetting {
    /// 12 bits, 10⁵ frames of 10 ms, a corner at 0.5/T.
    #[must_use]
    pub fn standard(seed: u64) -> QuantisationSetting {
        QuantisationSetting {
            bits: 12,
            full_scale: 10.0,
            frame_s: 0.01,
            corner_rad_s: 50.0,
            frames: 100_001,
            span_frames: 4,
            seed,
        }
    }

    /// The run.
    ///
    /// # Errors
    /// For numbers out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        require(
            "the bits",
            f64::from(self.bits),
            (2..=24).contains(&self.bits),
            "2 to 24",
        )?;
        require(
            "the frames",
            f64::from(self.frames),
            self.frames > 10 * self.span_frames.max(1),
            "above ten spans",
        )?;
        Ok(RunPlan {
            patch: "lab/quantisation.toml",
            params: vec![
                ("full_scale", self.full_scale),
                ("tau", 1.0 / self.corner_rad_s),
            ],
            frame: tick("the frame", self.frame_s)?,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            stop: tick("the stop time", f64::from(self.frames) * self.frame_s)?,
            hold: Hold::ZeroOrder,
        })
    }

    /// The digital side.
    ///
    /// # Errors
    /// When the full scale is not positive.
    pub fn law(&self) -> Result<QuantisationLaw, LabError> {
        require(
            "the full scale",
            self.full_scale,
            self.full_scale > 0.0,
            "> 0",
        )?;
        Ok(QuantisationLaw {
            setting: *self,
            random: Xoshiro256PlusPlus::seed_from_u64(self.seed),
            sent: None,
            exact_integral: 0.0,
            exact_lag: 0.0,
            direct: Vec::new(),
            integral: Vec::new(),
            lag: Vec::new(),
        })
    }

    /// Variances of the error itself, of its integral over the span, and of its lag.
    #[must_use]
    pub fn rows(&self, law: &QuantisationLaw) -> Vec<VarianceRow> {
        let span = self.span_frames.max(1) as usize;
        let growth: Vec<f64> = law
            .integral
            .windows(span + 1)
            .map(|w| w[span] - w[0])
            .collect();
        let step = noise::quantum(self.bits, self.full_scale);
        // The lag needs about 20/(aT) frames to become stationary.
        let settle = (20.0 / (self.corner_rad_s * self.frame_s)).ceil() as usize;
        let settled = law.lag.get(settle..).unwrap_or_default();
        [
            (
                "rounding error",
                variance(&law.direct),
                noise::quantisation_variance(step),
            ),
            (
                "integral over the span",
                variance(&growth),
                noise::integrator_variance(step, self.frame_s, span as f64 * self.frame_s),
            ),
            (
                "lag",
                variance(settled),
                noise::lag_variance(step, self.frame_s, self.corner_rad_s),
            ),
        ]
        .into_iter()
        .map(|(quantity, measured, theory)| VarianceRow {
            quantity,
            measured,
            theory,
            relative_error: measured / theory - 1.0,
        })
        .collect()
    }
}

/// Mean square about the mean.
fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}

/// Resolver pair read through a multiplexer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SkewSetting {
    /// Rate of the angle, rad/s.
    pub omega_rad_s: f64,
    /// Skew δ between the channels, s.
    pub skew_s: f64,
    /// Frame, s.
    pub frame_s: f64,
    /// Frames a revolution.
    pub frames: u32,
}

/// Reads sine (ADC 0) and cosine (ADC 1, δ later) of θ = ωt.
#[derive(Clone, Debug)]
pub struct SkewLaw {
    setting: SkewSetting,
    errors: Vec<f64>,
    theory: Vec<f64>,
}

/// Angle error over whole revolutions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SkewRow {
    /// Skew, s.
    pub skew_s: f64,
    /// Mean error from the run, rad.
    pub mean_measured_rad: f64,
    /// ωδ/2.
    pub mean_theory_rad: f64,
    /// Greatest error from the run, rad.
    pub max_measured_rad: f64,
    /// ωδ.
    pub max_theory_rad: f64,
    /// Greatest difference from ωδ sin²θ, rad.
    pub worst_difference_rad: f64,
}

impl SkewLaw {
    /// Frame n.
    pub fn step(&mut self, frame: u64, adc: &[f64], _updates: &mut Updates) {
        let at = |i: usize| adc.get(i).copied().unwrap_or(f64::NAN);
        let theta = self.setting.omega_rad_s * (frame as f64 * self.setting.frame_s);
        self.errors
            .push(angle_difference_rad(at(0).atan2(at(1)), theta));
        self.theory.push(noise::resolver_skew_error_rad(
            self.setting.omega_rad_s,
            self.setting.skew_s,
            theta,
        ));
    }
}

impl SkewSetting {
    /// One revolution of `frames` frames with a skew.
    #[must_use]
    pub fn revolution(frames: u32, frame_s: f64, skew_s: f64) -> SkewSetting {
        SkewSetting {
            omega_rad_s: std::f64::consts::TAU / (f64::from(frames) * frame_s),
            skew_s,
            frame_s,
            frames,
        }
    }

    /// Four revolutions of `lab/skew.toml`.
    ///
    /// # Errors
    /// For numbers out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        Ok(RunPlan {
            patch: "lab/skew.toml",
            params: vec![("frequency", self.omega_rad_s / std::f64::consts::TAU)],
            frame: tick("the frame", self.frame_s)?,
            latency: tick("the skew", self.skew_s)?,
            skew: tick("the skew", self.skew_s)?,
            stop: tick("the stop time", 4.0 * f64::from(self.frames) * self.frame_s)?,
            hold: Hold::ZeroOrder,
        })
    }

    /// The digital side.
    #[must_use]
    pub fn law(&self) -> SkewLaw {
        SkewLaw {
            setting: *self,
            errors: Vec::new(),
            theory: Vec::new(),
        }
    }

    /// Measured beside theory.
    #[must_use]
    pub fn row(&self, law: &SkewLaw) -> SkewRow {
        let n = law.errors.len().max(1) as f64;
        SkewRow {
            skew_s: self.skew_s,
            mean_measured_rad: law.errors.iter().sum::<f64>() / n,
            mean_theory_rad: noise::resolver_skew_mean_rad(self.omega_rad_s, self.skew_s),
            max_measured_rad: law.errors.iter().copied().fold(0.0, f64::max),
            max_theory_rad: self.omega_rad_s * self.skew_s,
            worst_difference_rad: law
                .errors
                .iter()
                .zip(&law.theory)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max),
        }
    }
}

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
    #[must_use]
    pub fn start_s(&self) -> f64 {
        2.0 * self.frame_s
    }

    /// The digital side.
    #[must_use]
    pub fn law(&self) -> CoefficientLaw {
        CoefficientLaw { setting: *self }
    }

    /// From the final values of `error_sum` (∫e dt) and `square_sum` (∫e² dt).
    #[must_use]
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
    use crate::sampling::plain_machine::PlainMachine;

    #[test]
    fn quantisation_variances_of_a_seeded_run() {
        let setting = QuantisationSetting::standard(1978);
        let mut law = setting.law().unwrap();
        let a = setting.corner_rad_s;
        let mut machine = PlainMachine::new(
            &[&[0.0, 0.0], &[0.0, -a]],
            &[&[1.0], &[a]],
            &[&[1.0, 0.0], &[0.0, 1.0]],
            &[0.0, 0.0],
        );
        let step = noise::quantum(setting.bits, setting.full_scale);
        let mut held = 0.0;
        machine.run(&setting.plan().unwrap(), |n, adc, up| {
            law.step(n, &[held, adc[0], adc[1]], up);
            held = (up.dac[0] / step).round() * step;
            up.dac[0] = held;
        });
        // 10⁵ samples: the sampling error of a variance of uniform noise is √(0.8/N) = 0.3 %, of the
        // overlapping four-frame sums about 0.7 %, of the lag (correlation e^{−1/2}) 0.7 %;
        // 3 % is the claim.
        for row in setting.rows(&law) {
            assert!(row.relative_error.abs() < 0.03, "{row:?}");
        }
    }

    #[test]
    fn skewed_resolver_pair() {
        let setting = SkewSetting::revolution(128, 0.01, 1e-4);
        let mut law = setting.law();
        let w = setting.omega_rad_s;
        for n in 0..512_u32 {
            let t = f64::from(n) * setting.frame_s;
            let adc = [(w * t).sin(), (w * (t + setting.skew_s)).cos()];
            law.step(
                u64::from(n),
                &adc,
                &mut Updates::new(u64::from(n), Tick::ZERO),
            );
        }
        let row = setting.row(&law);
        let second_order = (w * setting.skew_s).powi(2);
        assert!((row.mean_measured_rad - row.mean_theory_rad).abs() < second_order);
        assert!(row.worst_difference_rad < second_order, "{row:?}");
    }

    #[test]
    fn staircase_of_a_coefficient() {
        let setting = CoefficientSetting {
            rate_per_s: 0.3,
            frame_s: 0.1,
            latency_s: 0.02,
            stop_s: 2.0,
        };
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
        assert!(
            (row.mean_measured - row.mean_theory).abs() < 1e-12,
            "{row:?}"
        );
        // Midpoint sums of e² are low by (rate·T/100)²/12 = 7.5e-9 of 6e-4.
        assert!(
            (row.rms_measured / row.rms_theory - 1.0).abs() < 1e-4,
            "{row:?}"
        );
    }
}
