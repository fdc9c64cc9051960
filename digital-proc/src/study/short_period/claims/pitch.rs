//! P1 to P7: the pitch loop.

use super::super::control_loop::Test::{Disturbed, StepOnly};
use super::super::plan::PlannedPoint;
use super::super::results::{Results, Run};
use super::{
    BENDING, FIGURE_4, FTC_GAIN_LOST, GAINS_EARLY, NORMAL, OVERSHOOTS, RESIDUALS, TVC_FAST,
    TVC_SLOW, Worst,
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
/// By when a disturbed response has settled, s (P1): the window of the residual ends there, and no
/// interval between gain switchings is longer.
const SETTLED_BY_S: f64 = 10.0;
/// Part of its points at which another condition may ring before it counts as a third failure
/// mode (P4).
const SOME_POINTS: f64 = 0.5;
/// Reserve of tip authority over the static load below which the TVC is needed: a
/// quarter, since tips at their limit leave nothing for damping.
const AUTHORITY_NEEDED: f64 = 1.25;

const STEP_SENTENCE: &str = "For a step command in pitch, the normal mode response of θ is found to be quite satisfactory, whereas under two of the failure mode conditions (extreme reduction in FTC channel gain and TVC actuator time constant reduction to a low value), the response exhibits an unacceptable oscillatory behaviour.";
const BENDING_SENTENCE: &str =
    "The generalised co-ordinate associated with the first bending mode attenuates rapidly.";

/// What "quite satisfactory" is taken to mean. At its core: no point overshoots the step or rings.
/// Under disturbances the law, which has no integral term, must stand off: 3σ misalignment and the
/// whole gust at once then push θ beyond the command whatever the gains. There it is asked what the
/// vehicle's own data allow: settled before the gains change again, an error no larger than the
/// path may have at burn-out, and incidence within the load limit.
pub(super) fn p1(results: &Results) -> Claim {
    let (normal, disturbed) =
        (results.under(NORMAL, StepOnly), || results.under(NORMAL, Disturbed));
    let overshoot = Worst::greatest(normal, |r| r.measures.overshoot);
    let residual = Worst::greatest(disturbed(), |r| r.measures.residual);
    let settling = Worst::greatest(disturbed(), |r| r.measures.settling_s);
    let standing = Worst::greatest(disturbed(), |r| Some(r.measures.standing_error_rad?.abs()));
    let peak = Worst::greatest(disturbed(), |r| r.measures.peak);
    let load = |r: &Run| Some(r.case.frozen.q_pa * r.measures.greatest_incidence_rad?.to_degrees());
    let loads = Worst::greatest(disturbed(), load);
    let limits = &results.plan.limits;
    let kpadeg = |v: f64| format!("{:.0} kPa deg", v / 1e3);
    let degrees = |v: f64| format!("{:.2}°", v.to_degrees());
    let beyond: Vec<String> = disturbed()
        .filter_map(|r| Some((r, load(r).filter(|v| *v > limits.q_alpha_padeg)?)))
        .map(|(r, load)| format!("{} ({})", r.point, kpadeg(load)))
        .collect();
    let everywhere = [
        settling.against(SETTLED_BY_S),
        standing.against(limits.path_angle_rad),
        loads.against(limits.q_alpha_padeg),
    ];
    let mut remarks = Vec::new();
    if !beyond.is_empty() {
        remarks.push(format!(
            "not for the load of the disturbed test at {}: the step, 3σ misalignment and the whole gust at once are more than a flight meets, and α peaks before a law without integral term and with tips at their limit can turn the vehicle back",
            beyond.join(", ")
        ));
    }
    if standing.against(limits.path_angle_rad) == Verdict::Fails {
        remarks.push(format!("not for the standing error: {}", standing.text(degrees)));
    }
    if settling.against(SETTLED_BY_S) == Verdict::Fails {
        remarks.push(format!("not for the settling: {}", settling.seconds()));
    }
    remarks.extend(reduced_against_p1(results).filter(|(meets, _)| !meets).map(|(_, found)| found));
    Claim {
        id: "P1".into(),
        evidence: OVERSHOOTS,
        sentence: STEP_SENTENCE.into(),
        criterion: format!(
            "normal mode, every point: without disturbances overshoot ≤ {:.0} %, with them residual oscillation ≤ {:.0} % of the step; in part unless with them it also settles (to 5 %) within {SETTLED_BY_S} s, stands off by no more than the {} that the path may be off at burn-out, and Qα keeps to its limit of {}",
            100.0 * OVERSHOOT_P1,
            100.0 * RESIDUAL_P1,
            degrees(limits.path_angle_rad),
            kpadeg(limits.q_alpha_padeg)
        ),
        falsified_by: "a point where the normal mode overshoots or rings by more".into(),
        measured: format!(
            "overshoot {}, residual {}; disturbed: settling {}, standing error {}, peak {}, Qα {}",
            overshoot.percent(),
            residual.percent(),
            settling.seconds(),
            standing.text(degrees),
            peak.text(|v| format!("{v:.2} × the step")),
            loads.text(kpadeg)
        ),
        verdict: overshoot
            .against(OVERSHOOT_P1)
            .and(residual.against(RESIDUAL_P1))
            .in_part_unless(everywhere.iter().all(|v| *v == Verdict::Holds)),
        remark: (!remarks.is_empty()).then(|| remarks.join("; ")),
    }
}

/// What the re-evaluation of the reduced schedule finds against P1, if anything.
pub fn reduced_against_p1(results: &Results) -> Option<(bool, String)> {
    let runs = results.under("reduced-schedule", StepOnly);
    let overshoot = Worst::greatest(runs, |r| r.measures.overshoot);
    let meets = match overshoot.against(OVERSHOOT_P1) {
        Verdict::NotJudged => return None,
        verdict => verdict != Verdict::Fails,
    };
    let does = if meets { "meets" } else { "does not meet" };
    Some((meets, format!("the reduced schedule {does} it: overshoot {}", overshoot.percent())))
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
        remark: elsewhere.found.map(|_| {
            format!("where the tips suffice at most {}{}", elsewhere.percent(), literally(results))
        }),
    }
}

/// The other reading of the same words, the time constant itself reduced (10 → 200 rad/s): no claim,
/// since its θ does not ring and it contradicts the attenuation of the bending mode.
fn literally(results: &Results) -> String {
    // Growth: each window above the one before.
    let grows = |r: &&Run| {
        let [middle, late] = [1, 2].map(|window| r.measures.bending_ratio(window));
        matches!((middle, late), (Some(middle), Some(late)) if middle > 1.0 && late > middle)
    };
    let theta = Worst::greatest(results.under(TVC_FAST, Disturbed), |r| r.measures.residual);
    let growing: Vec<&str> =
        results.under(TVC_FAST, Disturbed).filter(grows).map(|r| r.point.as_str()).collect();
    if theta.found.is_none() || growing.is_empty() {
        return String::new();
    }
    format!(
        "; read literally (0.1 → 0.005 s) it is no such failure: θ ripples by at most {}, and what grows is the bending mode, which the paper sees attenuate, at {}",
        theta.text(|v| format!("{:.1} % of the step", 100.0 * v)),
        growing.join(", ")
    )
}

/// "Two of the failure mode conditions": no other rings. The literal reading of the slow actuator
/// is the second of the two, not a third.
pub(super) fn p4(results: &Results) -> Claim {
    let rings = |r: &&Run| r.measures.residual.is_none_or(|v| v >= OSCILLATORY);
    let the_two = [FTC_GAIN_LOST, TVC_SLOW, TVC_FAST];
    let (mut others, mut quietest) = (Vec::new(), None);
    let mut widespread = Vec::new();
    for condition in &results.plan.conditions {
        let runs = || results.under(&condition.name, Disturbed);
        if the_two.contains(&condition.name.as_str()) || runs().next().is_none() {
            continue;
        }
        let worst = Worst::greatest(runs(), |r| r.measures.residual);
        let at: Vec<&str> = runs().filter(rings).map(|r| r.point.as_str()).collect();
        if at.len() as f64 > SOME_POINTS * runs().count() as f64
            || (condition.name == NORMAL && !at.is_empty())
        {
            widespread.push(condition.name.as_str());
        }
        if at.is_empty() {
            let more = |(most, _): &(f64, String)| worst.found.is_some_and(|(v, _)| v > *most);
            if let Some((v, point)) = worst.found
                && quietest.as_ref().is_none_or(more)
            {
                quietest = Some((v, format!("{} at {point}", condition.name)));
            }
        } else {
            let places = format!("{} ({})", at.join(", "), worst.percent());
            others.push((condition.name.as_str(), places));
        }
    }
    let judged =
        [FTC_GAIN_LOST, TVC_SLOW].iter().all(|c| results.under(c, Disturbed).next().is_some());
    Claim {
        id: "P4".into(),
        evidence: RESIDUALS,
        sentence: STEP_SENTENCE.into(),
        criterion: format!(
            "two of the conditions, and no other: residual oscillation < {:.0} % of the step under every other condition at every point; in part while but one more reaches it, at no more than half of its points",
            100.0 * OSCILLATORY
        ),
        falsified_by: "the normal mode ringing anywhere, a third condition that rings at most of its points, or a fourth that rings at all".into(),
        measured: match (others.is_empty(), &quietest) {
            (true, Some((most, at))) => format!("no other; most under {at}: {:.1} %", 100.0 * most),
            (true, None) => "no other condition was run".to_owned(),
            (false, _) => {
                let told = others.iter().map(|(name, at)| format!("{name} at {at}"));
                format!("also under {}", told.collect::<Vec<_>>().join("; "))
            }
        },
        verdict: match quietest {
            _ if !judged => Verdict::NotJudged,
            None if others.is_empty() => Verdict::NotJudged,
            _ => Verdict::of(widespread.is_empty() && others.len() <= 1)
                .in_part_unless(others.is_empty()),
        },
        remark: matches!(others[..], [(GAINS_EARLY, _)]).then(|| {
            "not there: gains of another interval meet a vehicle they were not designed for, which the paper lists as a failure mode of its own and does not show".to_owned()
        }),
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

/// The same under the slow thrust vector. Where the attitude swings ever wider, the envelope is the
/// mode's answer to the thrust vector's swing; the mode itself is damped or not by its eigenvalue.
pub(super) fn p7(results: &Results) -> Claim {
    let ratio = |r: &Run| r.measures.bending_ratio(1);
    let runs = || results.under(TVC_SLOW, Disturbed);
    let worst = Worst::greatest(runs(), ratio);
    let over: Vec<&str> = runs()
        .filter(|r| ratio(r).is_none_or(|v| v > BENDING_MIDDLE))
        .map(|r| r.point.as_str())
        .collect();
    let damping = Worst::least(runs(), |r| r.measures.roots.bending.map(|root| root.damping()));
    let all = runs().count();
    Claim {
        id: "P7".into(),
        evidence: BENDING,
        sentence: BENDING_SENTENCE.into(),
        criterion: format!(
            "TVC pole 10 → 1 rad/s, every point: bending envelope ≤ {:.0} % of its first by 5–6.5 s; in part where some points keep to it and the mode itself is damped at all",
            100.0 * BENDING_MIDDLE
        ),
        falsified_by: "no point that keeps to it, or a bending mode without damping".into(),
        measured: format!("{}, above it at {} of {all} points", worst.percent(), over.len()),
        verdict: match worst.against(BENDING_MIDDLE) {
            Verdict::Fails if over.len() < all && damping.against(0.0) == Verdict::Holds => {
                Verdict::InPart
            }
            verdict => verdict,
        },
        remark: (!over.is_empty()).then(|| {
            format!(
                "not at {}: the swing of the attitude drives the coordinate; the mode itself stays damped (ζ least {})",
                over.join(", "),
                damping.text(|v| format!("{v:.4}"))
            )
        }),
    }
}
