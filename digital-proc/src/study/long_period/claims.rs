//! The paper's sentences about the long period, judged on the flown modes.
//!
//! A flight that was lost fails every claim it belongs to.

use super::results::{Flown, LongPeriodResults, ModeResult};
use desk::claim::{Claim, Evidence, Verdict};

// Where the report shows them.
pub(super) const FIGURE_8: Evidence = Evidence::at("figure-8");
pub(super) const MODES: Evidence = Evidence::at("modes");
pub(super) const LOADS: Evidence = Evidence::at("loads");
pub(super) const Q_ALPHA: Evidence = Evidence::at("q-alpha");

/// Judges L1, L2, L2b and L3.
pub fn judge(results: &LongPeriodResults) -> Vec<Claim> {
    vec![l1(results), l2(results), l2b(results), l3(results)]
}

fn verdict(holds: bool) -> Verdict {
    if holds { Verdict::Holds } else { Verdict::Fails }
}

fn named<'a>(modes: impl Iterator<Item = &'a ModeResult>) -> String {
    let names: Vec<&str> = modes.map(|m| m.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Severity of a mode's design-case burn-out; above 1 is not accepted.
fn severity(results: &LongPeriodResults, mode: &ModeResult) -> f64 {
    mode.departure.map_or(f64::INFINITY, |d| d.severity(&results.accept))
}

fn departure_words(mode: &ModeResult) -> String {
    match (&mode.departure, &mode.design.ended) {
        (Some(d), _) => format!(
            "{:+.2} % velocity, {:+.2}° path angle, {:+.2} % altitude, {:+.2} km range",
            100.0 * d.speed_fraction,
            d.path_angle_deg,
            100.0 * d.altitude_fraction,
            d.range_km
        ),
        (None, lost) => format!("lost: {}", lost.as_ref().err().map_or("no reason given", |l| l)),
    }
}

fn l1(results: &LongPeriodResults) -> Claim {
    let accept = &results.accept;
    let worst =
        results.modes.iter().max_by(|a, b| severity(results, a).total_cmp(&severity(results, b)));
    let holds = results.modes.iter().all(|m| severity(results, m) <= 1.0);
    Claim {
        id: "L1".into(),
        evidence: MODES,
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

/// What exceeds the load limit, and of the first such mode and the next below it the loads.
fn loads(
    results: &LongPeriodResults,
    exceeds: impl Fn(&ModeResult) -> bool,
    shown: impl Fn(&ModeResult) -> (f64, String),
) -> (bool, String) {
    let (over, within): (Vec<_>, Vec<_>) = results.modes.iter().partition(|m| exceeds(m));
    let next = within.into_iter().max_by(|a, b| shown(a).0.total_cmp(&shown(b).0));
    let mut measured = format!("above the limit: {}", named(over.iter().copied()));
    for mode in over.iter().copied().take(1).chain(next) {
        measured += &format!("; {} {} kPa deg", mode.name, shown(mode).1);
    }
    (over.len() == 1, measured)
}

fn l2(results: &LongPeriodResults) -> Claim {
    let accept = &results.accept;
    let (holds, measured) = loads(
        results,
        |m| m.design.exceeds(accept),
        |m| {
            let load = m.design.load_kpadeg();
            (load, format!("{load:.1}"))
        },
    );
    let reversed: Vec<&ModeResult> = results
        .modes
        .iter()
        .filter(|m| m.reversed.as_ref().is_some_and(|f| f.exceeds(accept)))
        .collect();
    let in_part = reversed.len() != 1 && results.modes.iter().any(|m| m.reversed.is_some());
    Claim {
        id: "L2".into(),
        evidence: Q_ALPHA,
        sentence: "the load profiles single out a failure mode which generates an acceptable trajectory but violates the design structural load limit".into(),
        criterion: format!(
            "exactly one mode exceeds {:.0} kPa deg of Qα in the design wind with nominal misalignments",
            accept.q_alpha_padeg / 1e3
        ),
        measured,
        verdict: judged(results, holds),
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
    let accept = &results.accept;
    let (holds, measured) = loads(
        results,
        |m| m.in_design_wind().any(|f| f.exceeds(accept)),
        |m| {
            let worst = m.in_design_wind().map(Flown::load_kpadeg).fold(0.0, f64::max);
            (worst, format!("up to {worst:.1}"))
        },
    );
    let first = results.modes.first();
    let mut points: Vec<f64> =
        first.into_iter().flat_map(|m| m.in_design_wind().map(|f| f.misalignment[0])).collect();
    points.sort_by(f64::total_cmp);
    let flown = results.modes.iter().any(|m| !m.envelope.is_empty());
    Claim {
        id: "L2b".into(),
        evidence: LOADS,
        sentence: "the same over the envelope of misalignments".into(),
        criterion: format!(
            "exactly one mode exceeds {:.0} kPa deg in the design wind at pitch misalignments of {} × 3σ",
            accept.q_alpha_padeg / 1e3,
            signed(&points)
        ),
        measured,
        verdict: if flown { judged(results, holds) } else { Verdict::NotJudged },
        remark: flown.then(|| pointwise(results)),
    }
}

fn signed(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:+}")).collect::<Vec<_>>().join(", ")
}

/// At which misalignments one mode alone exceeds the limit.
fn pointwise(results: &LongPeriodResults) -> String {
    let over = |i: usize| {
        let exceeds =
            |m: &&ModeResult| m.envelope.get(i).is_none_or(|f| f.exceeds(&results.accept));
        results.modes.iter().filter(exceeds).count()
    };
    let envelope = results.modes.first().map_or(&[][..], |m| &m.envelope);
    let alone = envelope.iter().enumerate().filter(|(i, _)| over(*i) == 1);
    let found: Vec<f64> = alone.map(|(_, flown)| flown.misalignment[0]).collect();
    if found.is_empty() {
        "pointwise at none of them".to_owned()
    } else {
        format!("pointwise beside the design case at {} × 3σ", signed(&found))
    }
}

/// With a single mode there is nothing to single out.
fn judged(results: &LongPeriodResults, holds: bool) -> Verdict {
    if results.modes.len() < 2 { Verdict::NotJudged } else { verdict(holds) }
}

fn l3(results: &LongPeriodResults) -> Claim {
    let reduced: Vec<&ModeResult> = results.modes.iter().filter(|m| m.reduced_schedule).collect();
    let holds =
        reduced.iter().all(|m| !m.design.exceeds(&results.accept) && severity(results, m) <= 1.0);
    let measured: Vec<String> = reduced
        .iter()
        .map(|m| {
            format!("{}: {:.1} kPa deg; {}", m.name, m.design.load_kpadeg(), departure_words(m))
        })
        .collect();
    Claim {
        id: "L3".into(),
        evidence: FIGURE_8,
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
