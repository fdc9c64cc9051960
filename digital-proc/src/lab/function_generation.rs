//! All-digital multivariable function generation against Rubin's hybrid one.
//!
//! `C(α, M)` is wanted while α oscillates and M drifts. Three ways, at once in one run of
//! `lab/function-generation.toml`, beside the exact function on the analog side:
//! * *all-digital*: α by ADC 0, bilinear look-up, DAC 0: α itself is late, by τ + T/2;
//! * *hybrid* (Rubin): `C = Σ c_i(M) h_i(α)` with analog hat functions h_i on fixed breakpoints and
//!   ordinates c_i(M) in DCUs: only the slow M is late, α is not sampled at all;
//! * *local cell*: `C = a_j + s_j α` in the cell j that comparators report on sense lines, a_j on
//!   DAC 1 and s_j on DCU [`FIRST_LOCAL`]: exact in the cell, late only at its borders.
//!
//! Phases are taken by correlators in the patch (sine and cosine products integrated over whole
//! periods), so that the images of the staircase play no part.

use super::{
    identify::{angle_difference_rad, correlated_phase_rad},
    plan::{LabError, RunPlan, require, tick},
    table::Table2,
    theory::noise::staircase_rms,
};
use interface::{Tick, frame::Updates};
use serde::Serialize;

/// Breakpoints of α, rad; the same stand in the patch.
pub const ALPHA_RAD: [f64; 7] = [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3];
/// Breakpoints of M; the same stand in the patch.
pub const MACH: [f64; 3] = [0.8, 1.2, 1.6];
/// Ordinates, `[alpha][mach]`: a pitching-moment-like curve that stiffens with incidence and
/// changes through the transonic range. Made up for the experiment; the same stand in the patch.
pub const VALUES: [f64; 21] = [
    0.98, 1.22, 0.86, //
    0.56, 0.72, 0.50, //
    0.24, 0.32, 0.22, //
    0.00, 0.00, 0.00, //
    -0.24, -0.32, -0.22, //
    -0.56, -0.72, -0.50, //
    -0.98, -1.22, -0.86,
];
/// DCU channel of the first ordinate.
pub const FIRST_ORDINATE: usize = 0;
/// DCU channel of the local cell's slope.
pub const FIRST_LOCAL: usize = 16;

/// One run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FunctionSetting {
    /// Frames in one period of α, which makes the correlation windows whole frames.
    pub frames_per_cycle: u32,
    /// Period T of sampling and of the settings, s.
    pub frame_s: f64,
    /// Latency τ/T.
    pub latency_frames: f64,
    /// Amplitude of α, rad.
    pub amplitude_rad: f64,
    /// M at the start.
    pub mach_start: f64,
    /// dM/dt, 1/s.
    pub mach_rate_per_s: f64,
    /// Whole periods correlated.
    pub cycles: u32,
}

/// The digital side: all three ways at once.
#[derive(Clone, Debug)]
pub struct FunctionLaw {
    setting: FunctionSetting,
    table: Table2,
}

/// Which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Way {
    /// ADC, look-up, DAC.
    AllDigital,
    /// Rubin's ordinates.
    Hybrid,
    /// Slope and intercept of the present cell.
    LocalCell,
}

/// What the correlators of one output hold at the end: `∫y sin ωt dt`, `∫y cos ωt dt`, `∫(y − C)² dt`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Correlated {
    /// Nets `WAY_sine`.
    pub sine: f64,
    /// Nets `WAY_cosine`.
    pub cosine: f64,
    /// Nets `WAY_square`; for the exact function `∫C² dt`.
    pub square: f64,
}

/// Lag and error, measured beside theory.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FunctionRow {
    /// Way.
    pub way: Way,
    /// ω, rad/s.
    pub omega_rad_s: f64,
    /// Period, s.
    pub frame_s: f64,
    /// Lag behind the exact function, deg, from the run.
    pub lag_measured_deg: f64,
    /// `ω(T/2 + τ)`, or zero where α is not sampled.
    pub lag_theory_deg: f64,
    /// RMS error over the RMS of C, percent.
    pub rms_measured_percent: f64,
    /// `2 sin(lag/2)`, or the staircase error of M; for the local cell none.
    pub rms_theory_percent: Option<f64>,
}

impl FunctionLaw {
    /// Frame n. Bit i of `sense` is 1 when α is above interior breakpoint i.
    pub fn step(&mut self, frame: u64, adc: &[f64], sense: u64, updates: &mut Updates) {
        let alpha = adc.first().copied().unwrap_or(f64::NAN);
        let mach = self.setting.mach(frame as f64 * self.setting.frame_s);
        updates.set_dac(0, self.table.value(alpha, mach));
        for i in 0..ALPHA_RAD.len() {
            updates.set_dcu(FIRST_ORDINATE + i, self.table.ordinate(i, mach));
        }
        let interior = (1_u64 << (ALPHA_RAD.len() - 2)) - 1;
        let cell = (sense & interior).count_ones() as usize;
        let (low, high) = (self.table.ordinate(cell, mach), self.table.ordinate(cell + 1, mach));
        let slope = (high - low) / (ALPHA_RAD[cell + 1] - ALPHA_RAD[cell]);
        updates.set_dcu(FIRST_LOCAL, slope);
        updates.set_dac(1, low - slope * ALPHA_RAD[cell]);
    }
}

impl FunctionSetting {
    /// ω near 8 rad/s, T = 0.02 s, one frame late.
    pub fn standard() -> FunctionSetting {
        FunctionSetting {
            frames_per_cycle: 39,
            frame_s: 0.02,
            latency_frames: 1.0,
            amplitude_rad: 0.25,
            mach_start: 0.9,
            mach_rate_per_s: 0.01,
            cycles: 8,
        }
    }

    /// M at `t_s`.
    pub fn mach(&self, t_s: f64) -> f64 {
        self.mach_start + self.mach_rate_per_s * t_s
    }

    /// ω, rad/s.
    pub fn omega_rad_s(&self) -> f64 {
        std::f64::consts::TAU / (f64::from(self.frames_per_cycle) * self.frame_s)
    }

    /// The correlators open here, one period in, s.
    pub fn start_s(&self) -> f64 {
        f64::from(self.frames_per_cycle) * self.frame_s
    }

    /// The run.
    ///
    /// # Errors
    /// With fewer than four frames a cycle, M or α beyond the table, or times out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        require(
            "frames per cycle",
            f64::from(self.frames_per_cycle),
            self.frames_per_cycle >= 4,
            "at least 4",
        )?;
        require(
            "the amplitude",
            self.amplitude_rad,
            self.amplitude_rad > 0.0 && self.amplitude_rad <= ALPHA_RAD[6],
            "within the table",
        )?;
        let stop_s = f64::from(self.cycles + 1) * self.start_s();
        let range = MACH[0]..=MACH[2];
        require(
            "M at the end",
            self.mach(stop_s),
            range.contains(&self.mach_start) && range.contains(&self.mach(stop_s)),
            "within the table",
        )?;
        Ok(RunPlan {
            patch: "lab/function-generation.toml",
            params: vec![
                ("frequency", self.omega_rad_s() / std::f64::consts::TAU),
                ("amplitude", self.amplitude_rad),
                ("mach_start", self.mach_start),
                ("mach_rate", self.mach_rate_per_s),
                ("start", self.start_s()),
            ],
            frame: tick("the frame", self.frame_s)?,
            latency: tick("the latency", self.latency_frames * self.frame_s)?,
            skew: Tick::ZERO,
            stop: tick("the stop time", stop_s)?,
            hold: super::theory::hold::Hold::ZeroOrder,
        })
    }

    /// The digital side.
    ///
    /// # Errors
    /// Never for the table of this module; the type says so to the caller.
    pub fn law(&self) -> Result<FunctionLaw, LabError> {
        Ok(FunctionLaw { setting: *self, table: table()? })
    }

    /// Measured beside theory, from the correlators at the end of the run.
    ///
    /// # Errors
    /// As [`FunctionSetting::law`].
    pub fn row(
        &self,
        way: Way,
        output: Correlated,
        exact: Correlated,
    ) -> Result<FunctionRow, LabError> {
        let lag = angle_difference_rad(
            correlated_phase_rad(exact.sine, exact.cosine),
            correlated_phase_rad(output.sine, output.cosine),
        );
        let delay = (self.latency_frames + 0.5) * self.frame_s;
        let lag_theory = match way {
            Way::AllDigital => self.omega_rad_s() * delay,
            Way::Hybrid | Way::LocalCell => 0.0,
        };
        let rms_theory = match way {
            Way::AllDigital => Some(2.0 * libm::sin(lag_theory / 2.0)),
            Way::Hybrid => Some(self.staircase_ratio()?),
            Way::LocalCell => None,
        };
        Ok(FunctionRow {
            way,
            omega_rad_s: self.omega_rad_s(),
            frame_s: self.frame_s,
            lag_measured_deg: lag.to_degrees(),
            lag_theory_deg: lag_theory.to_degrees(),
            rms_measured_percent: 100.0 * (output.square / exact.square).sqrt(),
            rms_theory_percent: rms_theory.map(|r| 100.0 * r),
        })
    }

    /// RMS of `(∂C/∂M) Ṁ (t − t_held)` over the RMS of C, at the mean M.
    fn staircase_ratio(&self) -> Result<f64, LabError> {
        let table = table()?;
        let window = f64::from(self.cycles) * self.start_s();
        let n = 2000;
        let (mut slope, mut level) = (0.0, 0.0);
        for i in 0..n {
            let part = (f64::from(i) + 0.5) / f64::from(n);
            let t = self.start_s() + part * window;
            let alpha = self.amplitude_rad * libm::sin(self.omega_rad_s() * t);
            let (m, d) = (self.mach(t), 1e-6);
            slope += ((table.value(alpha, m + d) - table.value(alpha, m - d)) / (2.0 * d)).powi(2);
            level += table.value(alpha, m).powi(2);
        }
        let held =
            staircase_rms(self.mach_rate_per_s, self.frame_s, self.latency_frames * self.frame_s);
        Ok(held * (slope / level).sqrt())
    }
}

/// The function of the experiment.
///
/// # Errors
/// Never for these constants.
pub fn table() -> Result<Table2, LabError> {
    Table2::new(ALPHA_RAD.to_vec(), MACH.to_vec(), VALUES.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hat(table: &Table2, up: &Updates, alpha: f64) -> f64 {
        let x = table.breakpoints();
        let i = x.partition_point(|b| *b <= alpha).clamp(1, x.len() - 1) - 1;
        let w = (alpha - x[i]) / (x[i + 1] - x[i]);
        (1.0 - w) * up.dcu[FIRST_ORDINATE + i] + w * up.dcu[FIRST_ORDINATE + i + 1]
    }

    /// Runs all ways with `fine` midpoint cells a frame: [exact, all-digital, hybrid, local].
    fn run(setting: &FunctionSetting, fine: u32) -> [Correlated; 4] {
        let table = table().unwrap();
        let mut law = setting.law().unwrap();
        let mut sums = [Correlated { sine: 0.0, cosine: 0.0, square: 0.0 }; 4];
        let w = setting.omega_rad_s();
        let late = (setting.latency_frames * f64::from(fine)).round() as u32;
        let mut active = Updates::new(0, Tick::ZERO);
        for n in 0..setting.frames_per_cycle * (setting.cycles + 1) {
            let t0 = f64::from(n) * setting.frame_s;
            let alpha0 = setting.amplitude_rad * (w * t0).sin();
            let sense = (1..6).fold(0, |s, i| s | u64::from(alpha0 > ALPHA_RAD[i]) << (i - 1));
            let mut next = Updates::new(u64::from(n), Tick::ZERO);
            law.step(u64::from(n), &[alpha0], sense, &mut next);
            for i in 0..fine {
                if i == late {
                    active = next;
                }
                let t = t0 + (f64::from(i) + 0.5) / f64::from(fine) * setting.frame_s;
                if t < setting.start_s() {
                    continue;
                }
                let alpha = setting.amplitude_rad * (w * t).sin();
                let exact = table.value(alpha, setting.mach(t));
                let outputs = [
                    exact,
                    active.dac[0],
                    hat(&table, &active, alpha),
                    active.dac[1] + active.dcu[FIRST_LOCAL] * alpha,
                ];
                let dt = setting.frame_s / f64::from(fine);
                for (k, (sum, y)) in sums.iter_mut().zip(outputs).enumerate() {
                    sum.sine += y * (w * t).sin() * dt;
                    sum.cosine += y * (w * t).cos() * dt;
                    let e = if k == 0 { y } else { y - exact };
                    sum.square += e * e * dt;
                }
            }
            if late == fine {
                active = next;
            }
        }
        sums
    }

    #[test]
    fn all_digital_lags_and_hybrid_does_not() {
        for (latency_frames, frames_per_cycle) in [(1.0, 39), (0.0, 39), (0.5, 80)] {
            let setting =
                FunctionSetting { latency_frames, frames_per_cycle, ..FunctionSetting::standard() };
            setting.plan().unwrap();
            let [exact, digital, hybrid, local] = run(&setting, 200);
            let row = setting.row(Way::AllDigital, digital, exact).unwrap();
            // Claims: 0.2° and 0.01°.
            assert!((row.lag_measured_deg - row.lag_theory_deg).abs() < 0.2, "{row:?}");
            // 2 sin(φ/2) neglects the images: T²ω²/12 of the mean square, and the harmonics' own lag.
            let theory = row.rms_theory_percent.unwrap();
            assert!((row.rms_measured_percent / theory - 1.0).abs() < 0.2, "{row:?}");
            let row = setting.row(Way::Hybrid, hybrid, exact).unwrap();
            assert!(row.lag_measured_deg.abs() < 0.01, "{row:?}");
            // The staircase formula takes M's error as independent of where α is: a few percent.
            let theory = row.rms_theory_percent.unwrap();
            assert!((row.rms_measured_percent / theory - 1.0).abs() < 0.05, "{row:?}");
            let row = setting.row(Way::LocalCell, local, exact).unwrap();
            assert!(
                row.lag_measured_deg.abs()
                    < 0.2 * setting.row(Way::AllDigital, digital, exact).unwrap().lag_measured_deg
            );
            assert!(row.rms_measured_percent > 0.0);
        }
    }

    #[test]
    fn beyond_the_table_is_refused() {
        let mut s = FunctionSetting::standard();
        s.mach_rate_per_s = 1.0;
        assert!(s.plan().is_err());
        s = FunctionSetting::standard();
        s.amplitude_rad = 0.4;
        assert!(s.plan().is_err());
    }
}
