//! What a good pitch loop is: the measures of two runs, their allowances, a cost.

use crate::{
    linkage::console::Console,
    study::{
        fault::StudyFault,
        short_period::{
            coefficients::{Disturbance, Plane, Settings},
            control_loop::Response,
            linear::{ChannelGains, plane_matrix, plane_roots, roots},
            machine::Bench,
            measure::{ENVELOPES, PITCH_BAND, RESIDUAL, SATURATED},
            metrics::{detrended_peak_to_peak, envelope, overshoot, settling_s},
            point::FrozenPoint,
        },
    },
};
use desk::report::{Cell, Column, Heading, Table};
use interface::{Tick, side_by_side};

/// Sampling interval of a run.
const SAMPLE: Tick = Tick(10_000_000);
/// Step command of the design runs, rad (2°, that of the pitch test).
const STEP_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Duration of the disturbed run, s: to the end of the residual's window.
const DISTURBED_S: f64 = 10.0;
/// Duration of the undisturbed run, s: the first swing of any acceptable loop is over.
const UNDISTURBED_S: f64 = 5.0;

/// What is measured of a loop at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Damping ratio of the attitude oscillation in the linearised loop.
    pub attitude_damping: Option<f64>,
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

/// A measure that a design is judged by.
struct Criterion {
    /// In the heading of a column.
    label: &'static str,
    /// In the table of criteria.
    text: &'static str,
    unit: &'static str,
    of: fn(&LoopQuality) -> Option<f64>,
    bound: Bound,
}

/// What is allowed, or must be left.
enum Bound {
    AtMost(f64),
    AtLeast(f64),
}
use Bound::{AtLeast, AtMost};

const fn criterion(
    [label, text, unit]: [&'static str; 3],
    of: fn(&LoopQuality) -> Option<f64>,
    bound: Bound,
) -> Criterion {
    Criterion { label, text, unit, of, bound }
}

/// The criteria of the shipped design: below the claims' limits, so that a dispersed vehicle
/// still meets them.
#[rustfmt::skip]
const CRITERIA: [Criterion; 8] = [
    criterion(["Overshoot", "overshoot, undisturbed 2° step", "%"], |q| q.overshoot, AtMost(0.20)),
    criterion(["Settling", "settling to 5 %, undisturbed", "s"], |q| q.settling_s, AtMost(3.0)),
    criterion(["Residual", "residual oscillation 5–10 s, misalignment and gust", "%"], |q| q.residual, AtMost(0.03)),
    criterion(["Error", "attitude error from 2 s on, misalignment and gust", "%"], |q| q.error, AtMost(0.60)),
    criterion(["Bending left", "bending envelope at 5–6.5 s over that after the step", "%"], |q| q.bending_decay, AtMost(0.30)),
    criterion(["Least bending damping", "bending damping ratio, linearised loop (at least)", ""], |q| Some(q.bending_damping), AtLeast(0.004)),
    criterion(["Gain margin", "gain margin, linearised loop (at least)", "dB"], |q| Some(q.gain_margin_db), AtLeast(6.0)),
    criterion(["TVC use", "mean TVC force over its maximum", "%"], |q| Some(q.tvc_use), AtMost(0.25)),
];

impl Criterion {
    /// Shown units in one unit.
    fn factor(&self) -> f64 {
        if self.unit == "%" { 100.0 } else { 1.0 }
    }
}

/// The criteria for people.
pub(super) fn table() -> Table {
    let columns: [Column<Criterion>; 3] = [
        Column::new("Criterion", "", |c| c.text.into()),
        Column::of("at most", "", 3, |c| match c.bound {
            AtMost(bound) | AtLeast(bound) => (c.factor() * bound).into(),
        }),
        Column::new("Unit", "", |c| c.unit.into()),
    ];
    Table::of(&columns, &CRITERIA)
}

/// Headings of a loop's measures.
pub(crate) fn headings() -> impl Iterator<Item = Heading> {
    let criteria = CRITERIA.iter().map(|c| Heading::new(c.label, c.unit).digits(3));
    criteria.chain([Heading::new("Tips saturated", "%").digits(3)])
}

impl LoopQuality {
    /// Under [`headings`]; a measure that a run does not yield is missing.
    pub(crate) fn cells(&self) -> impl Iterator<Item = Cell> {
        let criteria = CRITERIA.iter().map(|c| (c.of)(self).map(|v| c.factor() * v).into());
        criteria.chain([(100.0 * self.tip_saturation).into()])
    }

    /// Cost of a loop: the sum of measures over allowances, and ten times what exceeds an
    /// allowance, so that meeting all comes before bettering one. A measure that a run does not
    /// yield (a diverged attitude) counts as ten allowances.
    pub fn cost(&self) -> f64 {
        const EXCESS: f64 = 10.0;
        const MISSING: f64 = 10.0;
        let (mut used, mut missing) = (0.0, 0.0);
        for criterion in &CRITERIA {
            let value = (criterion.of)(self);
            match criterion.bound {
                AtMost(allowance) => {
                    let ratio = value.map_or(MISSING, |v| v / allowance);
                    used += ratio + EXCESS * (ratio - 1.0).max(0.0);
                }
                AtLeast(least) => missing += (1.0 - value.unwrap_or(0.0) / least).max(0.0),
            }
        }
        used + EXCESS * missing
    }

    /// Whether every criterion is met.
    pub fn met(&self) -> bool {
        CRITERIA.iter().all(|criterion| {
            (criterion.of)(self).is_some_and(|value| match criterion.bound {
                AtMost(allowance) => value <= allowance,
                AtLeast(least) => value >= least,
            })
        })
    }
}

/// Least bending damping ratio of the linearised loop: both channels, the tips
/// alone (inside the dead zone), the thrust vector alone (the tips saturated).
pub(crate) fn least_bending_damping(plane: &Plane) -> f64 {
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
fn gain_margin_db(plane: &Plane) -> f64 {
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

/// Runs the loop at frozen points without disturbances and with them, and measures it there;
/// `progress` is told the number of points done.
///
/// # Errors
/// [`StudyFault`]: the machine or its link, but not a diverging run.
pub(crate) fn measure(
    console: &mut Console<'_>,
    bench: &Bench,
    points: &[FrozenPoint],
    mut progress: impl FnMut(usize),
) -> Result<Vec<LoopQuality>, StudyFault> {
    let full = Disturbance { misalignment: 1.0, gust: 1.0, cant: 0.0 };
    let asked = points.iter().flat_map(|point| {
        [(Disturbance::NONE, UNDISTURBED_S), (full, DISTURBED_S)].map(|(disturbance, stop_s)| {
            let settings = Settings::pitch(point, &disturbance, STEP_RAD);
            (settings, Tick::from_secs(stop_s).unwrap_or(Tick::ZERO))
        })
    });
    let mut responses = Vec::with_capacity(2 * points.len());
    bench.run(console, SAMPLE, asked, |response, _| {
        responses.push(response);
        progress(responses.len() / 2);
    })?;
    Ok(side_by_side::map(points.len(), |i| {
        LoopQuality::new(&points[i], &responses[2 * i], &responses[2 * i + 1])
    }))
}

impl LoopQuality {
    fn new(point: &FrozenPoint, undisturbed: &Response, disturbed: &Response) -> LoopQuality {
        let plane = &Plane::new(point, &Disturbance::NONE);
        let sample_s = disturbed.sample_s;
        let period_s = std::f64::consts::TAU / point.bending_frequency_radps;
        let whole = |r: &Response, duration_s: f64| {
            r.is_finite() && r.len() > (duration_s / r.sample_s).round() as usize
        };
        let steady = whole(undisturbed, UNDISTURBED_S).then(|| undisturbed.attitude_rad());
        let shaken = whole(disturbed, DISTURBED_S).then(|| disturbed.attitude_rad());
        let from = (2.0 / sample_s).round() as usize;
        let mean = |column: &[f64]| {
            column.iter().map(|v| v.abs()).sum::<f64>() / column.len().max(1) as f64
        };
        let saturated = disturbed
            .of("tip_deflection")
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
            attitude_damping: plane_roots(plane, ChannelGains::BOTH).attitude.map(|r| r.damping()),
            bending_damping: least_bending_damping(plane),
            gain_margin_db: gain_margin_db(plane),
            tvc_use: mean(disturbed.of("tvc_force")) / plane.tvc_limit,
            tip_saturation: saturated as f64 / disturbed.len().max(1) as f64,
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::study::short_period::point::tests::frozen;

    fn plane() -> Plane {
        Plane::new(&frozen(32.5), &Disturbance::NONE)
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

    /// Every measure at its allowance.
    pub fn kept() -> LoopQuality {
        LoopQuality {
            overshoot: Some(0.2),
            settling_s: Some(3.0),
            residual: Some(0.03),
            error: Some(0.6),
            bending_decay: Some(0.3),
            attitude_damping: None,
            bending_damping: 0.004,
            gain_margin_db: 6.0,
            tvc_use: 0.25,
            tip_saturation: 0.0,
        }
    }

    #[test]
    fn a_missing_measure_costs_more_than_any_kept_allowance() {
        let kept = kept();
        // Six measures, each at its allowance.
        assert_eq!(kept.cost(), 6.0);
        assert!(kept.met());
        for worse in [
            LoopQuality { residual: None, ..kept },
            LoopQuality { overshoot: Some(0.21), ..kept },
            LoopQuality { gain_margin_db: 5.0, ..kept },
            LoopQuality { bending_damping: 0.0, ..kept },
        ] {
            assert!(!worse.met());
            assert!(worse.cost() > 6.0);
        }
    }
}
