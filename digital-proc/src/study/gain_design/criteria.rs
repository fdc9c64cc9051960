//! What a good pitch loop is: the measures of two runs, their allowances, a cost.

use crate::study::short_period::{
    coefficients::{Disturbance, PitchSettings, Plane},
    linear::{ChannelGains, plane_matrix, plane_roots, roots},
    measure::{ENVELOPES, PITCH_BAND, RESIDUAL, SATURATED},
    metrics::{detrended_peak_to_peak, envelope, overshoot, settling_s},
    point::FrozenPoint,
    response::PitchResponse,
};
use serde::Serialize;

/// Step command of the design runs, rad (2°, that of the pitch test).
pub const STEP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Duration of the disturbed run, s: to the end of the residual's window.
pub const DISTURBED_S: f64 = 10.0;
/// Duration of the undisturbed run, s: the first swing of any acceptable loop is over.
pub const UNDISTURBED_S: f64 = 5.0;

/// What is measured of a loop at one point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopQuality {
    /// Overshoot of the undisturbed step, fraction of it.
    pub overshoot: Option<f64>,
    /// Settling to 5 % of the undisturbed step, s.
    pub settling_s: Option<f64>,
    /// Residual oscillation of the disturbed run, fraction of the step.
    pub residual: Option<f64>,
    /// Greatest |θ − θ_c| of the disturbed run from 2 s on, fraction of the step.
    pub error: Option<f64>,
    /// Bending envelope at 5–6.5 s over that just after the step.
    pub bending_decay: Option<f64>,
    /// Least damping ratio of the bending mode in the linearised loop, with both
    /// channels at work or one alone.
    pub bending_damping: f64,
    /// Factor in dB, up to 12, by which the loop gains may rise before an oscillation grows.
    pub gain_margin_db: f64,
    /// Mean |F_T| of the disturbed run over its maximum.
    pub tvc_use: f64,
    /// Part of the disturbed run for which the tips are saturated.
    pub tip_saturation: f64,
}

/// Allowances: a measure at its allowance costs 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Of the overshoot.
    pub overshoot: f64,
    /// Of the settling time, s.
    pub settling_s: f64,
    /// Of the residual oscillation.
    pub residual: f64,
    /// Of the error under disturbance.
    pub error: f64,
    /// Of the bending envelope left at 5–6.5 s.
    pub bending_decay: f64,
    /// Bending damping ratio that must be left.
    pub bending_damping: f64,
    /// Gain margin that must be left, dB.
    pub gain_margin_db: f64,
    /// Of the mean thrust-vector force.
    pub tvc_use: f64,
}

impl Criteria {
    /// Those of the shipped design: below the claims' limits, so that a dispersed
    /// vehicle still meets them.
    pub const DESIGN: Criteria = Criteria {
        overshoot: 0.20,
        settling_s: 3.0,
        residual: 0.03,
        error: 0.60,
        bending_decay: 0.30,
        bending_damping: 0.004,
        gain_margin_db: 6.0,
        tvc_use: 0.25,
    };

    /// Named measures with their allowances, for a table: label, value, allowance.
    pub fn listed(&self, q: &LoopQuality) -> [(&'static str, Option<f64>, f64); 6] {
        [
            ("overshoot", q.overshoot, self.overshoot),
            ("settling, s", q.settling_s, self.settling_s),
            ("residual", q.residual, self.residual),
            ("error", q.error, self.error),
            ("bending left", q.bending_decay, self.bending_decay),
            ("TVC use", Some(q.tvc_use), self.tvc_use),
        ]
    }

    /// Cost of a loop: the sum of measures over allowances, and ten times what
    /// exceeds an allowance, so that meeting all comes before bettering one. A
    /// measure that a run does not yield (a diverged attitude) counts as ten
    /// allowances.
    pub fn cost(&self, q: &LoopQuality) -> f64 {
        const EXCESS: f64 = 10.0;
        const MISSING: f64 = 10.0;
        let part = |ratio: f64| ratio + EXCESS * (ratio - 1.0).max(0.0);
        let measured: f64 = self
            .listed(q)
            .iter()
            .map(|(_, value, allowance)| part(value.map_or(MISSING, |v| v / allowance)))
            .sum();
        let missing = (1.0 - q.bending_damping / self.bending_damping).max(0.0)
            + (1.0 - q.gain_margin_db / self.gain_margin_db).max(0.0);
        measured + EXCESS * missing
    }

    /// Whether every allowance is kept.
    pub fn met(&self, q: &LoopQuality) -> bool {
        q.bending_damping >= self.bending_damping
            && q.gain_margin_db >= self.gain_margin_db
            && self
                .listed(q)
                .iter()
                .all(|(_, value, allowance)| value.is_some_and(|v| v <= *allowance))
    }
}

/// Settings of the undisturbed and the disturbed run at a point.
pub fn test_runs(point: &FrozenPoint) -> [PitchSettings; 2] {
    let full = Disturbance { misalignment: 1.0, gust: 1.0, cant: 0.0 };
    [Disturbance::NONE, full].map(|d| PitchSettings::new(point, &d, STEP_RAD))
}

/// Least bending damping ratio of the linearised loop: both channels, the tips
/// alone (inside the dead zone), the thrust vector alone (the tips saturated).
pub fn least_bending_damping(plane: &Plane) -> f64 {
    let mut states = vec![ChannelGains::BOTH, ChannelGains::TVC_ONLY];
    if plane.ftc_gain != 0.0 {
        states.push(ChannelGains::FTC_ONLY);
    }
    states
        .into_iter()
        .filter_map(|gains| plane_roots(plane, gains).bending)
        .map(|root| root.damping())
        .fold(f64::INFINITY, f64::min)
}

/// Gain margin of the linearised loop, dB: the factor by which all its gains may
/// rise before a root faster than the drift grows, looked for up to 12 dB. Both
/// channels together, and the tips alone where there are tips; the injection alone
/// is a failure state there and has no margin to keep.
pub fn gain_margin_db(plane: &Plane) -> f64 {
    const MOST_DB: f64 = 12.0;
    /// Roots below this are the slow drift of the flight path.
    const DRIFT_RADPS: f64 = 0.5;
    /// Halvings of 12 dB: to 0.05 dB.
    const HALVINGS: usize = 8;
    let mut states = vec![ChannelGains::BOTH];
    if plane.ftc_gain != 0.0 {
        states.push(ChannelGains::FTC_ONLY);
    }
    let grows = |margin_db: f64| {
        let factor = libm::pow(10.0, margin_db / 20.0);
        states.iter().any(|state| {
            let raised = ChannelGains { ftc: factor * state.ftc, tvc: factor * state.tvc };
            roots(&plane_matrix(plane, raised))
                .iter()
                .any(|r| r.real > 0.0 && r.frequency_radps() > DRIFT_RADPS)
        })
    };
    if !grows(MOST_DB) {
        return MOST_DB;
    }
    let (mut stable, mut unstable) = (0.0, MOST_DB);
    if grows(stable) {
        return 0.0;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (stable + unstable);
        if grows(middle) {
            unstable = middle;
        } else {
            stable = middle;
        }
    }
    stable
}

impl LoopQuality {
    /// Measures the two runs of [`test_runs`].
    pub fn new(
        point: &FrozenPoint,
        settings: &PitchSettings,
        undisturbed: &PitchResponse,
        disturbed: &PitchResponse,
    ) -> LoopQuality {
        let plane = &settings.plane;
        let sample_s = disturbed.sample_s;
        let period_s = std::f64::consts::TAU / point.bending_frequency_radps;
        let whole = |r: &PitchResponse, duration_s: f64| {
            r.is_finite() && r.len() > (duration_s / r.sample_s).round() as usize
        };
        let steady = whole(undisturbed, UNDISTURBED_S).then(|| undisturbed.theta_rad());
        let shaken = whole(disturbed, DISTURBED_S).then(|| disturbed.theta_rad());
        let from = (2.0 / sample_s).round() as usize;
        let mean = |column: &[f64]| {
            column.iter().map(|v| v.abs()).sum::<f64>() / column.len().max(1) as f64
        };
        let saturated = disturbed
            .tip_rad()
            .iter()
            .filter(|d| plane.ftc_gain != 0.0 && d.abs() >= SATURATED * plane.tip_travel)
            .count();
        LoopQuality {
            overshoot: steady.and_then(|theta| overshoot(theta, STEP_RAD)),
            settling_s: steady.and_then(|theta| {
                let end = *theta.last()?;
                settling_s(theta, sample_s, end, PITCH_BAND * STEP_RAD)
            }),
            residual: shaken
                .and_then(|theta| detrended_peak_to_peak(theta, sample_s, RESIDUAL))
                .map(|r| r / STEP_RAD),
            error: shaken.map(|theta| {
                theta[from..].iter().fold(0.0, |worst: f64, t| worst.max((t - STEP_RAD).abs()))
                    / STEP_RAD
            }),
            bending_decay: (|| {
                let at = |w: usize| envelope(disturbed.eta_m(), sample_s, period_s, ENVELOPES[w]);
                let first = at(0).filter(|e| *e > 0.0)?;
                Some(at(1)? / first)
            })(),
            bending_damping: least_bending_damping(plane),
            gain_margin_db: gain_margin_db(plane),
            tvc_use: mean(disturbed.tvc_force_n()) / plane.tvc_limit,
            tip_saturation: saturated as f64 / disturbed.len().max(1) as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::point::tests::numbered;

    fn plane() -> Plane {
        Plane::new(&numbered(), &Disturbance::NONE)
    }

    #[test]
    fn the_gain_margin_is_where_an_oscillation_begins_to_grow() {
        let raised = |by_db: f64| {
            let mut plane = plane();
            let factor = 10f64.powf(by_db / 20.0);
            plane.ftc_gain *= factor;
            plane.tvc_gain *= factor;
            gain_margin_db(&plane)
        };
        // As designed the loop has more margin than is looked for.
        assert_eq!(raised(0.0), 12.0);
        let margin_db = raised(9.0);
        assert!(margin_db > 3.0 && margin_db < 12.0, "{margin_db}");
        // Raising every gain by 3 dB takes 3 dB of the margin, to the bisection's
        // last half, 12/2⁸ dB, on either side.
        let left_db = raised(12.0);
        assert!((margin_db - left_db - 3.0).abs() < 0.1, "{margin_db} {left_db}");
        let mut reversed = plane();
        reversed.ftc_lead = -reversed.ftc_lead;
        assert_eq!(gain_margin_db(&reversed), 0.0);
    }

    #[test]
    fn a_missing_measure_costs_more_than_any_kept_allowance() {
        let kept = LoopQuality {
            overshoot: Some(0.2),
            settling_s: Some(3.0),
            residual: Some(0.03),
            error: Some(0.6),
            bending_decay: Some(0.3),
            bending_damping: 0.004,
            gain_margin_db: 6.0,
            tvc_use: 0.25,
            tip_saturation: 0.0,
        };
        let criteria = Criteria::DESIGN;
        // Six measures, each at its allowance.
        assert_eq!(criteria.cost(&kept), 6.0);
        assert!(criteria.met(&kept));
        for worse in [
            LoopQuality { residual: None, ..kept },
            LoopQuality { overshoot: Some(0.21), ..kept },
            LoopQuality { gain_margin_db: 5.0, ..kept },
            LoopQuality { bending_damping: 0.0, ..kept },
        ] {
            assert!(!criteria.met(&worse));
            assert!(criteria.cost(&worse) > 6.0);
        }
    }
}
