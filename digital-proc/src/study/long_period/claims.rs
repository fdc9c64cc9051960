//! The paper's sentences about the long period, judged on the flown modes.
//!
//! A flight that was lost fails every claim it belongs to.

use super::results::{Flown, LongPeriodResults, ModeResult};
use crate::study::evidence;
use desk::claim::{Claim, Verdict};

/// Judges L1, L2, L2b and L3.
pub fn judge(results: &LongPeriodResults) -> Vec<Claim> {
    vec![l1(results), l2(results), l2b(results), l3(results)]
}

fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Holds } else { Verdict::Fails }
}

/// Whether a flight breaks the load limit; a lost one does.
fn exceeds(results: &LongPeriodResults, flown: &Flown) -> bool {
    flown
        .figures
        // A peak that is no number must not pass.
        .is_none_or(|f| {
            f.max_q_alpha_padeg.is_nan() || f.max_q_alpha_padeg > results.accept.q_alpha_padeg
        })
}

fn named<'a>(modes: impl Iterator<Item = &'a ModeResult>) -> String {
    let names: Vec<&str> = modes.map(|m| m.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn load_kpadeg(flown: &Flown) -> f64 {
    flown.figures.map_or(f64::INFINITY, |f| f.max_q_alpha_padeg / 1e3)
}

/// Severity of a mode's design-case burn-out; above 1 is not accepted.
fn severity(results: &LongPeriodResults, mode: &ModeResult) -> f64 {
    mode.departure.map_or(f64::INFINITY, |d| d.severity(&results.accept))
}

fn departure_words(mode: &ModeResult) -> String {
    match (&mode.departure, &mode.design.lost) {
        (Some(d), _) => format!(
            "{:+.2} % velocity, {:+.2}° path angle, {:+.2} % altitude, {:+.2} km range",
            100.0 * d.speed_fraction,
            d.path_angle_deg,
            100.0 * d.altitude_fraction,
            d.range_km
        ),
        (None, lost) => format!("lost: {}", lost.as_deref().unwrap_or("no reason given")),
    }
}

fn l1(results: &LongPeriodResults) -> Claim {
    let accept = &results.accept;
    let worst =
        results.modes.iter().max_by(|a, b| severity(results, a).total_cmp(&severity(results, b)));
    let holds = results.modes.iter().all(|m| severity(results, m) <= 1.0);
    Claim {
        id: "L1".into(),
        evidence: evidence::MODES,
        sentence: "the trajectory variables are not very sensitive to changes in the control system parameter values".into(),
        criterion: format!(
            "all modes at burn-out within {} % of velocity, {}° of flight-path angle, {} % of altitude, {} km of range of the undisturbed flight",
            100.0 * accept.speed_fraction,
            accept.path_angle_deg,
            100.0 * accept.altitude_fraction,
            accept.range_km
        ),
        measured: worst.map_or_else(
            || "nothing flown".to_owned(),
            |m| format!("largest in {}: {}", m.name, departure_words(m)),
        ),
        verdict: worst.map_or(Verdict::NotJudged, |_| verdict(holds)),
        remark: None,
    }
}

fn l2(results: &LongPeriodResults) -> Claim {
    let over = || results.modes.iter().filter(|m| exceeds(results, &m.design));
    let next = results
        .modes
        .iter()
        .filter(|m| !exceeds(results, &m.design))
        .max_by(|a, b| load_kpadeg(&a.design).total_cmp(&load_kpadeg(&b.design)));
    let mut measured = format!("above the limit: {}", named(over()));
    for mode in over().take(1).chain(next) {
        measured += &format!("; {} {:.1} kPa deg", mode.name, load_kpadeg(&mode.design));
    }
    let reversed: Vec<&ModeResult> = results
        .modes
        .iter()
        .filter(|m| m.reversed.as_ref().is_some_and(|f| exceeds(results, f)))
        .collect();
    let in_part = reversed.len() != 1 && results.modes.iter().any(|m| m.reversed.is_some());
    Claim {
        id: "L2".into(),
        evidence: evidence::Q_ALPHA,
        sentence: "the load profiles single out a failure mode which generates an acceptable trajectory but violates the design structural load limit".into(),
        criterion: format!(
            "exactly one mode exceeds {:.0} kPa deg of Qα in the design wind with nominal misalignments",
            results.accept.q_alpha_padeg / 1e3
        ),
        measured,
        verdict: judged(results, over().count() == 1),
        remark: in_part.then(|| {
            format!(
                "in part: with the wind reversed {} modes exceed the limit ({})",
                reversed.len(),
                named(reversed.iter().copied())
            )
        }),
    }
}

fn l2b(results: &LongPeriodResults) -> Claim {
    let flights = |m: &ModeResult| -> Vec<Flown> {
        std::iter::once(&m.design).chain(&m.envelope).cloned().collect()
    };
    let over = || results.modes.iter().filter(|m| flights(m).iter().any(|f| exceeds(results, f)));
    let worst = |m: &ModeResult| flights(m).iter().map(load_kpadeg).fold(0.0, f64::max);
    let next = results
        .modes
        .iter()
        .filter(|m| flights(m).iter().all(|f| !exceeds(results, f)))
        .max_by(|a, b| worst(a).total_cmp(&worst(b)));
    let mut points: Vec<f64> = results
        .modes
        .first()
        .map(|m| flights(m).iter().map(|f| f.pitch_misalignment).collect())
        .unwrap_or_default();
    points.sort_by(f64::total_cmp);
    let points: Vec<String> = points.iter().map(|p| format!("{p:+}")).collect();
    let mut measured = format!("above the limit: {}", named(over()));
    for mode in over().take(1).chain(next) {
        measured += &format!("; {} up to {:.1} kPa deg", mode.name, worst(mode));
    }
    let flown = results.modes.iter().any(|m| !m.envelope.is_empty());
    Claim {
        id: "L2b".into(),
        evidence: evidence::LOADS,
        sentence: "the same over the envelope of misalignments".into(),
        criterion: format!(
            "exactly one mode exceeds {:.0} kPa deg in the design wind at pitch misalignments of {} × 3σ",
            results.accept.q_alpha_padeg / 1e3,
            points.join(", ")
        ),
        measured,
        verdict: if flown { judged(results, over().count() == 1) } else { Verdict::NotJudged },
        remark: flown.then(|| pointwise(results)),
    }
}

/// At which misalignments one mode alone exceeds the limit.
fn pointwise(results: &LongPeriodResults) -> String {
    let mut found: Vec<f64> = Vec::new();
    if let Some(first) = results.modes.first() {
        for (i, flown) in first.envelope.iter().enumerate() {
            let over = results
                .modes
                .iter()
                .filter(|m| m.envelope.get(i).is_none_or(|f| exceeds(results, f)));
            if over.count() == 1 {
                found.push(flown.pitch_misalignment);
            }
        }
    }
    let found: Vec<String> = found.iter().map(|m| format!("{m:+}")).collect();
    if found.is_empty() {
        "pointwise at none of them".to_owned()
    } else {
        format!("pointwise beside the design case at {} × 3σ", found.join(", "))
    }
}

/// With a single mode there is nothing to single out.
fn judged(results: &LongPeriodResults, holds: bool) -> Verdict {
    if results.modes.len() < 2 { Verdict::NotJudged } else { verdict(holds) }
}

fn l3(results: &LongPeriodResults) -> Claim {
    let reduced: Vec<&ModeResult> = results.modes.iter().filter(|m| m.reduced_schedule).collect();
    let holds = reduced.iter().all(|m| !exceeds(results, &m.design) && severity(results, m) <= 1.0);
    let measured: Vec<String> = reduced
        .iter()
        .map(|m| {
            format!("{}: {:.1} kPa deg; {}", m.name, load_kpadeg(&m.design), departure_words(m))
        })
        .collect();
    Claim {
        id: "L3".into(),
        evidence: evidence::FIGURE_8,
        sentence: "a schedule with reduced number of switchings retains the trajectory profile within acceptable limits".into(),
        criterion: format!(
            "the reduced schedule stays below {:.0} kPa deg and within L1",
            results.accept.q_alpha_padeg / 1e3
        ),
        measured: if measured.is_empty() {
            "no mode flies the reduced schedule".to_owned()
        } else {
            measured.join("; ")
        },
        verdict: if reduced.is_empty() { Verdict::NotJudged } else { verdict(holds) },
        remark: None,
    }
}
