//! Error budget of one channel: the gain and phase that each stage adds at a frequency.
//!
//! Stages in the order of the signal: multiplexer skew, aperture, conversion
//! (quantisation only), latency, digital lead, DAC conversion (quantisation only),
//! hold, settling. A stage that is switched off has gain 1 and phase 0 and is still
//! listed, so that two budgets can be laid side by side. Gains multiply and phases
//! add; noise variances add after the gain of the stages that follow is neglected
//! (it is 1 − O(x²)).

use super::{C64, hold, hold::Hold, noise};
use interface::Tick;
use nalgebra::ComplexField;

/// One channel of the linkage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain {
    /// Place of the channel in the scan.
    pub place: i64,
    /// ± full scale of its converters, problem units.
    pub full_scale: f64,
    pub frame: Tick,
    /// Latency τ from `t_n` to the transfer, conversion included.
    pub latency: Tick,
    /// Skew δ between neighbouring channels.
    pub skew: Tick,
    /// Averaging aperture of the track-and-hold.
    pub aperture: Tick,
    /// Bits of the ADC, sign included.
    pub adc_bits: Option<u32>,
    /// Bits of the DAC.
    pub dac_bits: Option<u32>,
    pub hold: Hold,
    /// Settling time constant of the DAC.
    pub settling: Tick,
    pub lead_frames: f64,
}

/// What one stage adds.
#[derive(Clone, Debug, PartialEq)]
pub struct BudgetRow {
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
    /// A zero-order hold and nothing else.
    pub fn bare(place: i64, full_scale: f64, frame: Tick) -> Chain {
        Chain {
            place,
            full_scale,
            frame,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            aperture: Tick::ZERO,
            adc_bits: None,
            dac_bits: None,
            hold: Hold::ZeroOrder,
            settling: Tick::ZERO,
            lead_frames: 0.0,
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
        let noise_of = |bits: Option<u32>| {
            let step = bits.map(|bits| noise::quantum(bits, self.full_scale));
            step.map_or(0.0, |step| noise::quantisation_variance(step).sqrt())
        };
        let t = self.frame.secs();
        let skew = (self.skew * self.place).secs();
        let [aperture, latency, settling] =
            [self.aperture, self.latency, self.settling].map(Tick::secs);
        let lead = self.lead_frames;
        [
            ("multiplexer skew", hold::delay(w, -skew), -skew, 0.0),
            ("aperture", hold::aperture(w, aperture), aperture / 2.0, 0.0),
            ("analog-to-digital", one, 0.0, noise_of(self.adc_bits)),
            ("latency", hold::delay(w, latency), latency, 0.0),
            ("digital lead", hold::lead(w, t, lead), -lead * t, 0.0),
            ("digital-to-analog", one, 0.0, noise_of(self.dac_bits)),
            ("hold", self.hold.transfer(w, t), self.hold.delay_frames() * t, 0.0),
            ("settling", hold::settling(w, settling), settling, 0.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_order_delays_are_the_slopes_of_the_phases() {
        let us = Tick(1000);
        let chain = Chain {
            skew: us * 100,
            aperture: us * 200,
            adc_bits: Some(14),
            latency: us * 4000,
            lead_frames: 0.9,
            settling: us * 100,
            ..Chain::bare(1, 100.0, us * 10_000)
        };
        let w = 0.1;
        for row in chain.budget(w) {
            // Phases are odd in x = ωT = 1e-3: the next term is of relative order x² = 1e-6.
            let slope = -row.phase_deg.to_radians() / w;
            assert!((slope - row.delay_s).abs() < 2e-6 * chain.frame.secs(), "{row:?}");
        }
        let whole = chain.budget(w).pop().unwrap();
        assert!((whole.gain - chain.transfer(w).norm()).abs() < 1e-12);
        // 14 bits over ±100: q = 0.012207, q/√12 = 0.0035239.
        assert!((whole.noise_rms - 0.012_207_031_25 / 12f64.sqrt()).abs() < 1e-15);
    }
}
