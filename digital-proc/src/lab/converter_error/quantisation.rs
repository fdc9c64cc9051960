//! The noise of rounding: directly, through an integrator and through a lag.
//!
//! The run sends seeded values that the law knows exactly through a DAC of limited bits and
//! reads back the DAC, an integrator and a lag driven by it: what is left after the law's
//! own exact solution is the noise.

use crate::lab::{
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
            let decay = libm::exp(-self.setting.corner_rad_s * self.setting.frame_s);
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
        require("the bits", f64::from(self.bits), (2..=24).contains(&self.bits), "2 to 24")?;
        require(
            "the frames",
            f64::from(self.frames),
            self.frames > 10 * self.span_frames.max(1),
            "above ten spans",
        )?;
        Ok(RunPlan {
            patch: "lab/quantisation.toml",
            params: vec![("full_scale", self.full_scale), ("tau", 1.0 / self.corner_rad_s)],
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
        require("the full scale", self.full_scale, self.full_scale > 0.0, "> 0")?;
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
    pub fn rows(&self, law: &QuantisationLaw) -> Vec<VarianceRow> {
        let span = self.span_frames.max(1) as usize;
        let growth: Vec<f64> = law.integral.windows(span + 1).map(|w| w[span] - w[0]).collect();
        let step = noise::quantum(self.bits, self.full_scale);
        // The lag needs about 20/(aT) frames to become stationary.
        let settle = (20.0 / (self.corner_rad_s * self.frame_s)).ceil() as usize;
        let settled = law.lag.get(settle..).unwrap_or_default();
        [
            ("rounding error", variance(&law.direct), noise::quantisation_variance(step)),
            (
                "integral over the span",
                variance(&growth),
                noise::integrator_variance(step, self.frame_s, span as f64 * self.frame_s),
            ),
            ("lag", variance(settled), noise::lag_variance(step, self.frame_s, self.corner_rad_s)),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::plain_machine::PlainMachine;

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
}
