//! A resolver pair whose channels are held one after the other.
//!
//! Sine and cosine of one turning angle pass a multiplexer with a skew between them; the
//! angle formed of both is wrong by ωδ sin²θ.

use crate::lab::{
    identify::angle_difference_rad,
    plan::{LabError, RunPlan, tick},
    theory::{hold::Hold, noise},
};
use interface::frame::Updates;
use serde::Serialize;

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
        self.errors.push(angle_difference_rad(libm::atan2(at(0), at(1)), theta));
        self.theory.push(noise::resolver_skew_error_rad(
            self.setting.omega_rad_s,
            self.setting.skew_s,
            theta,
        ));
    }
}

impl SkewSetting {
    /// One revolution of `frames` frames with a skew.
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
    pub fn law(&self) -> SkewLaw {
        SkewLaw { setting: *self, errors: Vec::new(), theory: Vec::new() }
    }

    /// Measured beside theory.
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

#[cfg(test)]
mod tests {
    use super::*;
    use interface::Tick;

    #[test]
    fn skewed_resolver_pair() {
        let setting = SkewSetting::revolution(128, 0.01, 1e-4);
        let mut law = setting.law();
        let w = setting.omega_rad_s;
        for n in 0..512_u32 {
            let t = f64::from(n) * setting.frame_s;
            let adc = [(w * t).sin(), (w * (t + setting.skew_s)).cos()];
            law.step(u64::from(n), &adc, &mut Updates::new(u64::from(n), Tick::ZERO));
        }
        let row = setting.row(&law);
        let second_order = (w * setting.skew_s).powi(2);
        assert!((row.mean_measured_rad - row.mean_theory_rad).abs() < second_order);
        assert!(row.worst_difference_rad < second_order, "{row:?}");
    }
}
