//! Error budget of one channel: the gain and phase that each stage adds at a frequency.
//!
//! Stages in the order of the signal: multiplexer skew, aperture, conversion
//! (quantisation only), latency, digital lead, DAC conversion (quantisation only),
//! hold, settling. A stage that is switched off has gain 1 and phase 0 and is still
//! listed, so that two budgets can be laid side by side. Gains multiply and phases
//! add; noise variances add after the gain of the stages that follow is neglected
//! (it is 1 − O(x²)).

use super::{C64, hold, hold::Hold, noise};
use nalgebra::ComplexField;
use serde::Serialize;

/// A converter's resolution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// Bits, sign included.
    pub bits: u32,
    /// ± full scale, problem units.
    pub full_scale: f64,
}

/// One channel of the linkage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chain {
    /// Frame T, s.
    pub frame_s: f64,
    /// Delay of this channel's sample behind `t_n` (channel · δ), s.
    pub skew_s: f64,
    /// Averaging aperture of the track-and-hold, s.
    pub aperture_s: f64,
    /// ADC resolution.
    pub adc: Option<Resolution>,
    /// Latency τ from `t_n` to the transfer, conversion included, s.
    pub latency_s: f64,
    /// Digital lead, frames.
    pub lead_frames: f64,
    /// DAC resolution.
    pub dac: Option<Resolution>,
    /// Reconstruction.
    pub hold: Hold,
    /// Settling time constant of the DAC, s.
    pub settling_s: f64,
}

/// What one stage adds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BudgetRow {
    /// Stage.
    pub stage: &'static str,
    /// Gain, 1 for none.
    pub gain: f64,
    /// Phase, deg; negative is lag.
    pub phase_deg: f64,
    /// First-order delay, s; negative is lead.
    pub delay_s: f64,
    /// RMS noise added, problem units.
    pub noise_rms: f64,
}

impl Chain {
    /// A channel that adds nothing but a zero-order hold.
    pub fn ideal(frame_s: f64) -> Chain {
        Chain {
            frame_s,
            skew_s: 0.0,
            aperture_s: 0.0,
            adc: None,
            latency_s: 0.0,
            lead_frames: 0.0,
            dac: None,
            hold: Hold::ZeroOrder,
            settling_s: 0.0,
        }
    }

    /// Fundamental transfer of the whole channel.
    ///
    /// Latency runs from `t_n`, so a skewed sample has a channel-dependent *lead*
    /// against it: the sample is taken later and is younger at the transfer.
    pub fn transfer(&self, omega_rad_s: f64) -> C64 {
        self.stages(omega_rad_s).iter().map(|(_, h, _, _)| *h).product()
    }

    /// The budget, one row a stage and a last row `whole chain`.
    pub fn budget(&self, omega_rad_s: f64) -> Vec<BudgetRow> {
        let mut rows: Vec<BudgetRow> = self
            .stages(omega_rad_s)
            .into_iter()
            .map(|(stage, h, delay_s, noise_rms)| BudgetRow {
                stage,
                gain: h.modulus(),
                phase_deg: h.argument().to_degrees(),
                delay_s,
                noise_rms,
            })
            .collect();
        rows.push(BudgetRow {
            stage: "whole chain",
            gain: rows.iter().map(|r| r.gain).product(),
            // Summed, not taken from the product: a chain may turn by more than half a circle.
            phase_deg: rows.iter().map(|r| r.phase_deg).sum(),
            delay_s: rows.iter().map(|r| r.delay_s).sum(),
            noise_rms: rows.iter().map(|r| r.noise_rms.powi(2)).sum::<f64>().sqrt(),
        });
        rows
    }

    fn stages(&self, w: f64) -> [(&'static str, C64, f64, f64); 8] {
        let one = C64::new(1.0, 0.0);
        let noise_of = |r: Option<Resolution>| {
            r.map_or(0.0, |r| {
                noise::quantisation_variance(noise::quantum(r.bits, r.full_scale)).sqrt()
            })
        };
        let t = self.frame_s;
        [
            ("multiplexer skew", hold::delay(w, -self.skew_s), -self.skew_s, 0.0),
            ("aperture", hold::aperture(w, self.aperture_s), self.aperture_s / 2.0, 0.0),
            ("analog-to-digital", one, 0.0, noise_of(self.adc)),
            ("latency", hold::delay(w, self.latency_s), self.latency_s, 0.0),
            ("digital lead", hold::lead(w, t, self.lead_frames), -self.lead_frames * t, 0.0),
            ("digital-to-analog", one, 0.0, noise_of(self.dac)),
            ("hold", self.hold.transfer(w, t), self.hold.delay_frames() * t, 0.0),
            ("settling", hold::settling(w, self.settling_s), self.settling_s, 0.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_order_delays_are_the_slopes_of_the_phases() {
        let chain = Chain {
            frame_s: 0.01,
            skew_s: 1e-4,
            aperture_s: 2e-4,
            adc: Some(Resolution { bits: 14, full_scale: 100.0 }),
            latency_s: 0.004,
            lead_frames: 0.9,
            dac: None,
            hold: Hold::ZeroOrder,
            settling_s: 1e-4,
        };
        let w = 0.1;
        for row in chain.budget(w) {
            // Phases are odd in x = ωT = 1e-3: the next term is of relative order x² = 1e-6.
            let slope = -row.phase_deg.to_radians() / w;
            assert!((slope - row.delay_s).abs() < 2e-6 * chain.frame_s, "{row:?}");
        }
        let whole = chain.budget(w).pop().unwrap();
        assert!((whole.gain - chain.transfer(w).norm()).abs() < 1e-12);
        // 14 bits over ±100: q = 0.012207, q/√12 = 0.0035239.
        assert!((whole.noise_rms - 0.012_207_031_25 / 12f64.sqrt()).abs() < 1e-15);
    }
}
