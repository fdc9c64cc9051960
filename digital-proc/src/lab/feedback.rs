//! The circle test and the second-order root: one channel through the digital side.
//!
//! Both run the same law on ADC 0 and DAC 0; they differ in patch and in what is read
//! from the record. The circle test shows how an undamped oscillator grows by nothing
//! but the interface; the root experiment shows what is left of a loop's damping, and
//! what each compensation gives back.

use super::{
    identify,
    plan::{LabError, RunPlan, require, tick},
    theory::{C64, damping_ratio, feedback_loop::FeedbackLoop, growth_per_cycle, hold::Hold},
};
use interface::frame::Updates;
use nalgebra::ComplexField;
use serde::Serialize;

/// `u_n = k [m_n + a (m_n − m_{n−1})]`, with `m_{−1} = m_0`.
#[derive(Clone, Debug)]
pub struct FeedbackLaw {
    gain: f64,
    lead_frames: f64,
    previous: Option<f64>,
    record: Vec<f64>,
}

impl FeedbackLaw {
    /// A law of gain k and a lead of `lead_frames`.
    pub fn new(gain: f64, lead_frames: f64) -> FeedbackLaw {
        FeedbackLaw { gain, lead_frames, previous: None, record: Vec::new() }
    }

    /// Frame n: reads ADC 0, sets DAC 0.
    pub fn step(&mut self, _frame: u64, adc: &[f64], updates: &mut Updates) {
        let m = adc.first().copied().unwrap_or(f64::NAN);
        let before = self.previous.replace(m).unwrap_or(m);
        updates.set_dac(0, self.gain * (m + self.lead_frames * (m - before)));
        self.record.push(m);
    }

    /// Samples of ADC 0, one a frame.
    pub fn record(&self) -> &[f64] {
        &self.record
    }
}

/// Circle test: two integrators closed through the digital side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CircleSetting {
    /// Samples per cycle, 2π/(ωT).
    pub samples_per_cycle: u32,
    /// Frame T, s.
    pub frame_s: f64,
    /// Latency τ/T, 0…1.
    pub latency_frames: f64,
    /// Reconstruction.
    pub hold: Hold,
}

/// Growth per cycle, measured beside theory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CircleRow {
    /// Samples per cycle.
    pub samples_per_cycle: u32,
    /// Latency, frames.
    pub latency_frames: f64,
    /// Reconstruction.
    pub hold: &'static str,
    /// Amplitude ratio over one cycle, from the run.
    pub growth_measured: f64,
    /// The same from the exact discrete map.
    pub growth_exact: f64,
    /// `exp(π ω τ_e)`.
    pub growth_first_order: f64,
    /// measured/exact − 1.
    pub error_exact: f64,
    /// first order/exact − 1.
    pub error_first_order: f64,
}

impl CircleSetting {
    /// ω, rad/s.
    pub fn omega_rad_s(&self) -> f64 {
        std::f64::consts::TAU / (f64::from(self.samples_per_cycle) * self.frame_s)
    }

    fn theory(&self) -> FeedbackLoop {
        FeedbackLoop::circle(
            self.omega_rad_s(),
            self.hold,
            self.frame_s,
            self.latency_frames * self.frame_s,
        )
    }

    /// Eight cycles of `lab/circle.toml`.
    ///
    /// # Errors
    /// With fewer than six samples a cycle, or times out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        require(
            "samples per cycle",
            f64::from(self.samples_per_cycle),
            self.samples_per_cycle >= 6,
            "at least 6",
        )?;
        require(
            "the latency",
            self.latency_frames,
            (0.0..=1.0).contains(&self.latency_frames),
            "0 to 1 frame",
        )?;
        let frames = 8.0 * f64::from(self.samples_per_cycle);
        Ok(RunPlan {
            patch: "lab/circle.toml",
            params: vec![("w", self.omega_rad_s())],
            frame: tick("the frame", self.frame_s)?,
            latency: tick("the latency", self.latency_frames * self.frame_s)?,
            skew: interface::Tick::ZERO,
            stop: tick("the stop time", frames * self.frame_s)?,
            hold: self.hold,
        })
    }

    /// The digital law: what is sampled is sent.
    pub fn law(&self) -> FeedbackLaw {
        FeedbackLaw::new(1.0, 0.0)
    }

    /// Measured beside theory.
    ///
    /// # Errors
    /// When the record has no oscillation or theory no value.
    pub fn row(&self, law: &FeedbackLaw) -> Result<CircleRow, LabError> {
        let theory = self.theory();
        let measured = growth_per_cycle(pole(
            &law.record,
            self.frame_s,
            f64::from(self.samples_per_cycle),
            theory.continuous_root()?,
        )?);
        let exact = growth_per_cycle(theory.exact_root()?);
        let first =
            libm::exp(std::f64::consts::PI * self.omega_rad_s() * theory.effective_delay_s());
        Ok(CircleRow {
            samples_per_cycle: self.samples_per_cycle,
            latency_frames: self.latency_frames,
            hold: self.hold.name(),
            growth_measured: measured,
            growth_exact: exact,
            growth_first_order: first,
            error_exact: measured / exact - 1.0,
            error_first_order: first / exact - 1.0,
        })
    }
}

/// Compensation in the root experiment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compensation {
    /// Zero-order hold, no prediction.
    None,
    /// `r + ½(r_n − r_{n−1})` before a zero-order hold.
    HalfFrame,
    /// First-order extrapolating DAC.
    ExtrapolatingDac,
    /// Lead of ½ + τ/T frames before a zero-order hold.
    Lead,
}

impl Compensation {
    /// All, in the order of the tables.
    pub const ALL: [Compensation; 4] = [
        Compensation::None,
        Compensation::HalfFrame,
        Compensation::ExtrapolatingDac,
        Compensation::Lead,
    ];
}

/// `ẍ + 2ζω₀ẋ + ω₀²x = 0`, the stiffness closed through the digital side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RootSetting {
    /// ω₀, rad/s.
    pub omega0_rad_s: f64,
    /// ζ.
    pub zeta: f64,
    /// Frame T, s.
    pub frame_s: f64,
    /// Latency τ/T.
    pub latency_frames: f64,
    /// Compensation.
    pub compensation: Compensation,
}

/// Damping and frequency, measured beside theory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RootRow {
    /// The setting.
    #[serde(flatten)]
    pub setting: RootSetting,
    /// ζ from the run.
    pub zeta_measured: f64,
    /// ζ of the exact sampled-data root.
    pub zeta_exact: f64,
    /// ζ by Howe's first-order shift.
    pub zeta_first_order: f64,
    /// |s| from the run, rad/s.
    pub omega_measured_rad_s: f64,
    /// |s| exact, rad/s.
    pub omega_exact_rad_s: f64,
    /// |s| by the first-order shift, rad/s.
    pub omega_first_order_rad_s: f64,
}

impl RootSetting {
    fn hold(&self) -> Hold {
        match self.compensation {
            Compensation::ExtrapolatingDac => Hold::Extrapolating,
            _ => Hold::ZeroOrder,
        }
    }

    fn lead(&self) -> f64 {
        match self.compensation {
            Compensation::None | Compensation::ExtrapolatingDac => 0.0,
            Compensation::HalfFrame => 0.5,
            Compensation::Lead => 0.5 + self.latency_frames,
        }
    }

    /// The loop that theory solves.
    pub fn theory(&self) -> FeedbackLoop {
        FeedbackLoop::second_order(
            self.omega0_rad_s,
            self.zeta,
            self.lead(),
            self.hold(),
            self.frame_s,
            self.latency_frames * self.frame_s,
        )
    }

    /// Four cycles (at least 80 frames) of `lab/root.toml`.
    ///
    /// # Errors
    /// For numbers out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        require("the natural frequency", self.omega0_rad_s, self.omega0_rad_s > 0.0, "> 0 rad/s")?;
        require("the damping", self.zeta, (0.0..1.0).contains(&self.zeta), "0 to below 1")?;
        require(
            "the latency",
            self.latency_frames,
            (0.0..=1.0).contains(&self.latency_frames),
            "0 to 1 frame",
        )?;
        let cycle = std::f64::consts::TAU / self.omega0_rad_s;
        let frames = (4.0 * cycle / self.frame_s).ceil().max(80.0);
        Ok(RunPlan {
            patch: "lab/root.toml",
            params: vec![("wn", self.omega0_rad_s), ("zeta", self.zeta)],
            frame: tick("the frame", self.frame_s)?,
            latency: tick("the latency", self.latency_frames * self.frame_s)?,
            skew: interface::Tick::ZERO,
            stop: tick("the stop time", frames * self.frame_s)?,
            hold: self.hold(),
        })
    }

    /// The digital law, gain ω₀².
    pub fn law(&self) -> FeedbackLaw {
        FeedbackLaw::new(self.omega0_rad_s.powi(2), self.lead())
    }

    /// Measured beside theory.
    ///
    /// # Errors
    /// When the record has no oscillation or theory no value.
    pub fn row(&self, law: &FeedbackLaw) -> Result<RootRow, LabError> {
        let theory = self.theory();
        let exact = theory.exact_root()?;
        let first = theory.first_order_root()?;
        let per_cycle = std::f64::consts::TAU / (exact.im.abs() * self.frame_s);
        let measured = pole(&law.record, self.frame_s, per_cycle, theory.continuous_root()?)?;
        Ok(RootRow {
            setting: *self,
            zeta_measured: damping_ratio(measured),
            zeta_exact: damping_ratio(exact),
            zeta_first_order: damping_ratio(first),
            omega_measured_rad_s: measured.modulus(),
            omega_exact_rad_s: exact.modulus(),
            omega_first_order_rad_s: first.modulus(),
        })
    }
}

/// Pole of a record, thinned to about twenty samples a cycle so that the modes stay apart in z.
///
/// The first frames are left out: there the buffers still hold their initial values, and the
/// modes of |z| ≪ 1 that this excites would be no exponentials any more after thinning.
fn pole(record: &[f64], frame_s: f64, per_cycle: f64, near: C64) -> Result<C64, LabError> {
    const FILLING: usize = 8;
    let record = &record[FILLING.min(record.len())..];
    // 36 samples are the least that the matrix pencil takes.
    let longest = (record.len() / 40).max(1);
    let stride = ((per_cycle / 20.0).floor().max(1.0) as usize).min(longest);
    let thinned: Vec<f64> = record.iter().step_by(stride).copied().collect();
    Ok(identify::oscillatory_pole(&thinned, stride as f64 * frame_s, 1e-9, near)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::plain_machine::PlainMachine;

    /// The grid of the laboratory: 10…400 samples a cycle, latency 0…1, every hold.
    fn circle_grid() -> Vec<CircleSetting> {
        let mut all = Vec::new();
        for hold in Hold::ALL {
            for latency_frames in [0.0, 0.25, 0.5, 1.0] {
                for samples_per_cycle in [10, 20, 40, 100, 200, 400] {
                    all.push(CircleSetting {
                        samples_per_cycle,
                        frame_s: 0.01,
                        latency_frames,
                        hold,
                    });
                }
            }
        }
        all
    }

    /// The worked example (ω₀ = 3, ζ = 0.3) over frames, latencies and compensations.
    fn root_grid() -> Vec<RootSetting> {
        let mut all = Vec::new();
        for compensation in Compensation::ALL {
            for latency_frames in [0.0, 0.5, 1.0] {
                for frame_s in [0.02, 0.05, 0.1, 0.2] {
                    all.push(RootSetting {
                        omega0_rad_s: 3.0,
                        zeta: 0.3,
                        frame_s,
                        latency_frames,
                        compensation,
                    });
                }
            }
        }
        all
    }

    #[test]
    fn circle_growth_of_a_run_is_that_of_the_exact_map() {
        for setting in circle_grid() {
            let w = setting.omega_rad_s();
            let mut machine = PlainMachine::new(
                &[&[0.0, w], &[0.0, 0.0]],
                &[&[0.0], &[-w]],
                &[&[1.0, 0.0]],
                &[1.0, 0.0],
            );
            let mut law = setting.law();
            machine.run(&setting.plan().unwrap(), |n, adc, up| law.step(n, adc, up));
            let row = setting.row(&law).unwrap();
            // The claim is 1e-6. Both sides are exact but for rounding, amplified by the pencil's
            // conditioning (thinned to twenty samples a cycle: below 1e4).
            assert!(row.error_exact.abs() < 1e-8, "{row:?}");
        }
    }

    #[test]
    fn root_of_a_run_is_the_sampled_data_eigenvalue() {
        for setting in root_grid() {
            let (w, z) = (setting.omega0_rad_s, setting.zeta);
            let mut machine = PlainMachine::new(
                &[&[0.0, 1.0], &[0.0, -2.0 * z * w]],
                &[&[0.0], &[-1.0]],
                &[&[1.0, 0.0]],
                &[1.0, 0.0],
            );
            let mut law = setting.law();
            machine.run(&setting.plan().unwrap(), |n, adc, up| law.step(n, adc, up));
            let row = setting.row(&law).unwrap();
            // The claim is 1e-4; floating-point records of decaying modes lose at most half the digits.
            assert!((row.zeta_measured - row.zeta_exact).abs() < 1e-6, "{row:?}");
            let ratio = row.omega_measured_rad_s / row.omega_exact_rad_s;
            assert!((ratio - 1.0).abs() < 1e-6, "{row:?}");
        }
    }
}
