//! P1 to P6: the pitch loop.

use super::super::control_loop::Test::{Disturbed, StepOnly};
use super::super::plan::PlannedPoint;
use super::super::results::{Results, Run};
use super::{
    BENDING, BENDING_GROWTH, FIGURE_4, FTC_GAIN_LOST, NORMAL, OVERSHOOTS, TVC_FAST, TVC_SLOW, Worst,
};
use desk::claim::{Claim, Verdict};

/// Overshoot up to which a response is satisfactory, as a fraction of the step (P1).
pub const OVERSHOOT_P1: f64 = 0.25;
/// Residual oscillation up to which it is, as a fraction of the step (P1).
pub const RESIDUAL_P1: f64 = 0.05;
/// Residual oscillation from which a response is oscillatory (P2, P3).
pub const OSCILLATORY: f64 = 0.20;
/// Bending envelope by 5–6.5 s up to which the mode attenuates, over its first (P5, P6).
pub const BENDING_MIDDLE: f64 = 0.35;
const BENDING_LATE: f64 = 0.20;
/// Reserve of tip authority over the static load below which the TVC is needed: a
/// quarter, since tips at their limit leave nothing for damping.
const AUTHORITY_NEEDED: f64 = 1.25;

const STEP_SENTENCE: &str = "For a step command in pitch, the normal mode response of θ is found to be quite satisfactory, whereas under two of the failure mode conditions (extreme reduction in FTC channel gain and TVC actuator time constant reduction to a low value), the response exhibits an unacceptable oscillatory behaviour.";
const BENDING_SENTENCE: &str =
    "The generalised co-ordinate associated with the first bending mode attenuates rapidly.";

pub(super) fn p1(results: &Results) -> Claim {
    let overshoot = Worst::greatest(results.under(NORMAL, StepOnly), |r| r.measures.overshoot);
    let residual = Worst::greatest(results.under(NORMAL, Disturbed), |r| r.measures.residual);
    let reduced = results.under("reduced-schedule", StepOnly);
    let reduced = Worst::greatest(reduced, |r| r.measures.overshoot);
    Claim {
        id: "P1".into(),
        evidence: OVERSHOOTS,
        sentence: STEP_SENTENCE.into(),
        criterion: format!(
            "normal mode, every point: overshoot ≤ {:.0} %, residual oscillation ≤ {:.0} % of the step",
            100.0 * OVERSHOOT_P1,
            100.0 * RESIDUAL_P1
        ),
        falsified_by: "a point where the normal mode overshoots or rings by more".into(),
        measured: format!("overshoot {}, residual {}", overshoot.percent(), residual.percent()),
        verdict: overshoot.against(OVERSHOOT_P1).and(residual.against(RESIDUAL_P1)),
        remark: (reduced.against(OVERSHOOT_P1) == Verdict::Fails).then(|| {
            format!("the reduced schedule does not meet it: overshoot {}", reduced.percent())
        }),
    }
}

/// Up to the greatest dynamic pressure the FTC-gain failure is claimed to oscillate. Later the
/// TVC alone is well damped, since its own lead is scheduled up as the thrust falls.
pub(super) fn p2(results: &Results) -> Claim {
    let q_pa = |p: &&PlannedPoint| p.slice.airframe.dynamic_pressure_pa;
    let peak = results.plan.points.iter().max_by(|a, b| q_pa(a).total_cmp(&q_pa(b)));
    // To the next half second, beyond the point itself.
    let until_s = peak.map_or(0.0, |p| (2.0 * p.slice.time_s).ceil() / 2.0);
    let runs = |within: bool| {
        results
            .under(FTC_GAIN_LOST, Disturbed)
            .filter(move |r| (r.case.frozen.time_s <= until_s) == within)
    };
    let claimed = Worst::least(runs(true), |r| r.measures.residual);
    let later: Vec<&str> = runs(false)
        .filter(|r| r.measures.residual.is_some_and(|v| v < OSCILLATORY))
        .map(|r| r.point.as_str())
        .collect();
    Claim {
        id: "P2".into(),
        evidence: FIGURE_4,
        sentence: STEP_SENTENCE.into(),
        criterion: format!(
            "FTC gain × 0.05: residual oscillation ≥ {:.0} % of the step from FTC switch-in to {until_s} s",
            100.0 * OSCILLATORY
        ),
        falsified_by: "a point in that time at which the response with the gain lost does not ring"
            .into(),
        measured: format!("least {}", claimed.percent()),
        verdict: claimed.against(OSCILLATORY),
        remark: (!later.is_empty()).then(|| {
            format!(
                "later the thrust vector alone is well damped: no oscillation at {}",
                later.join(", ")
            )
        }),
    }
}

pub(super) fn p3(results: &Results) -> Claim {
    let residual = |upper: bool, needed: bool| {
        let runs = results
            .under(TVC_SLOW, Disturbed)
            .filter(|r| (r.measures.tip_authority < AUTHORITY_NEEDED) == needed);
        Worst::of(upper, runs, |r| r.measures.residual)
    };
    let (needed, elsewhere) = (residual(false, true), residual(true, false));
    Claim {
        id: "P3".into(),
        evidence: FIGURE_4,
        sentence: STEP_SENTENCE.into(),
        criterion: format!(
            "TVC pole 10 → 1 rad/s: residual oscillation ≥ {:.0} % of the step wherever the TVC is \
             needed (no fin tips, or tip authority below {AUTHORITY_NEEDED} of the static load)",
            100.0 * OSCILLATORY
        ),
        falsified_by: "a point that needs the TVC and does not ring with its pole at 1 rad/s"
            .into(),
        measured: format!("least {}", needed.percent()),
        verdict: needed.against(OSCILLATORY),
        remark: elsewhere
            .found
            .map(|_| format!("where the tips suffice at most {}", elsewhere.percent())),
    }
}

pub(super) fn p4(results: &Results) -> Claim {
    // Growth: each window above the one before; the least of the two ratios counts.
    let growth = |r: &Run| {
        let middle = r.measures.bending_ratio(1)?;
        let late = r.measures.bending_ratio(2)?;
        Some(middle.min(late / middle))
    };
    let runs = |tips: bool| {
        results
            .under(TVC_FAST, Disturbed)
            .filter(move |r| (r.case.settings.plane.ftc_gain != 0.0) == tips)
    };
    let claimed = Worst::least(runs(false), growth);
    // A ratio of exactly one is no growth.
    let verdict = claimed.against(1.0_f64.next_up());
    let later: Vec<&str> = runs(true)
        .filter(|r| growth(r).is_some_and(|g| g > 1.0))
        .map(|r| r.point.as_str())
        .collect();
    Claim {
        id: "P4".into(),
        evidence: BENDING_GROWTH,
        sentence: STEP_SENTENCE.into(),
        criterion: "TVC time constant 0.1 → 0.005 s: the bending envelope grows from window to \
                    window before the fin tips are switched in"
            .to_owned(),
        falsified_by: "a point without tips at which the bending mode decays".into(),
        measured: format!("least growth {}", claimed.text(|v| format!("× {v:.2}"))),
        verdict,
        remark: Some(format!(
            "this reading contradicts the rapid attenuation of the mode; it also grows at {}",
            if later.is_empty() { "no later point".to_owned() } else { later.join(", ") }
        )),
    }
}

fn bending<'a>(results: &'a Results, condition: &str, window: usize) -> Worst<'a> {
    let runs = results.under(condition, Disturbed);
    Worst::greatest(runs, |r| r.measures.bending_ratio(window))
}

pub(super) fn p5(results: &Results) -> Claim {
    let (middle, late) = (bending(results, NORMAL, 1), bending(results, NORMAL, 2));
    Claim {
        id: "P5".into(),
        evidence: BENDING,
        sentence: BENDING_SENTENCE.into(),
        criterion: format!(
            "normal mode, every point: bending envelope ≤ {:.0} % of its first by 5–6.5 s and ≤ {:.0} % by 8–9.5 s",
            100.0 * BENDING_MIDDLE,
            100.0 * BENDING_LATE
        ),
        falsified_by: "a point in normal mode at which the bending coordinate keeps more".into(),
        measured: format!("{}, {}", middle.percent(), late.percent()),
        verdict: middle.against(BENDING_MIDDLE).and(late.against(BENDING_LATE)),
        remark: None,
    }
}

pub(super) fn p6(results: &Results) -> Claim {
    let middle = bending(results, FTC_GAIN_LOST, 1);
    Claim {
        id: "P6".into(),
        evidence: BENDING,
        sentence: BENDING_SENTENCE.into(),
        criterion: format!(
            "FTC gain × 0.05, every point with fin tips: bending envelope ≤ {:.0} % of its first by 5–6.5 s",
            100.0 * BENDING_MIDDLE
        ),
        falsified_by: "a point with the FTC gain lost at which the bending coordinate keeps more"
            .into(),
        measured: middle.percent(),
        verdict: middle.against(BENDING_MIDDLE),
        remark: None,
    }
}
