//! The paper's sentences about the long period, judged on the flown modes.
//!
//! A flight that was lost fails every claim it belongs to. Trajectories are compared with that of
//! the sound vehicle in the same wind and under the same misalignments: what these do by
//! themselves says nothing about the control system.

use super::results::{Flown, LongPeriodResults, ModeResult};
use desk::claim::{Claim, Evidence, Verdict};
use vehicle::flight_summary::FlightSample;

// Where the report shows them.
pub(super) const FIGURE_8: Evidence = Evidence::at("figure-8");
pub(super) const MODES: Evidence = Evidence::at("modes");
pub(super) const DEPARTURES: Evidence = Evidence::at("departures");
pub(super) const LOADS: Evidence = Evidence::at("loads");
pub(super) const Q_ALPHA: Evidence = Evidence::at("q-alpha");

/// The mode that the load profiles single out: without the electronics of its fin tips the vehicle
/// is held by the thrust vector alone, at one edge of its dead zone.
pub const SINGLED_OUT: &str = "ftc-electronics";

const NOT_SENSITIVE: &str = "Representative plots of the trajectory variables such as inertial velocity, altitude, flight path and range angles and load profiles shown in figure 6 indicate that the trajectory variables are not very sensitive to changes in the control system parameter values.";
const SINGLE_OUT: &str = "However, the load profiles single out a failure mode which generates an acceptable trajectory but violates the design structural load limit.";
const FEWER_SWITCHINGS: &str = "During the course of the trajectory simulation studies, an attempt has been made to obtain a schedule with reduced number of switchings, while retaining the trajectory profile within acceptable limits, (the violation of the structural load constraints being the critical element in this case).";

/// Judges L1, L2, L2b and L3.
pub fn judge(results: &LongPeriodResults) -> Vec<Claim> {
    vec![l1(results), l2(results), l2b(results), l3(results)]
}

fn named<'a>(modes: impl Iterator<Item = &'a ModeResult>) -> String {
    let names: Vec<&str> = modes.map(|m| m.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// What is accepted at burn-out, in words.
fn accepted(results: &LongPeriodResults) -> String {
    let accept = &results.accept;
    format!(
        "{} % of velocity, {}° of flight-path angle, {} % of altitude, {} km of range",
        100.0 * accept.speed_fraction,
        accept.path_angle_deg,
        100.0 * accept.altitude_fraction,
        accept.range_km
    )
}

fn departure_words(results: &LongPeriodResults, flown: &Flown) -> String {
    match (results.departure(flown), &flown.ended) {
        (Some(d), _) => format!(
            "{:+.2} % velocity, {:+.2}° path angle, {:+.2} % altitude, {:+.2} km range",
            100.0 * d.speed_fraction,
            d.path_angle_deg,
            100.0 * d.altitude_fraction,
            d.range_km
        ),
        (None, Err(lost)) => format!("lost: {lost}"),
        (None, Ok(_)) => "nothing to compare it with: the sound vehicle was lost".to_owned(),
    }
}

/// Where a flight was flown, in words.
fn conditions(flown: &Flown) -> String {
    format!("{}, pitch misalignment {:+} × 3σ", flown.wind.words(), flown.misalignment[0])
}

fn l1(results: &LongPeriodResults) -> Claim {
    let severity = |m: &&ModeResult| results.severity(&m.design);
    let worst = results.modes.iter().max_by(|a, b| severity(a).total_cmp(&severity(b)));
    let holds = results.modes.iter().all(|m| severity(&m) <= 1.0);
    let all = || results.modes.iter().flat_map(|m| m.all_flights().map(move |f| (m, f)));
    let beyond: Vec<_> = all().filter(|(_, f)| results.severity(f) > 1.0).collect();
    let widest = all().max_by(|a, b| results.severity(a.1).total_cmp(&results.severity(b.1)));
    let remark = match (beyond.as_slice(), widest) {
        ([], Some((mode, flown))) => Some(format!(
            "so in every wind and under every misalignment that was flown: largest in {} ({}): {}",
            mode.name,
            conditions(flown),
            departure_words(results, flown)
        )),
        ([], None) => None,
        (beyond, _) => {
            let said = beyond.iter().map(|(mode, flown)| {
                let how = departure_words(results, flown);
                format!("{} ({}): {how}", mode.name, conditions(flown))
            });
            Some(format!("not in {}", said.collect::<Vec<_>>().join("; ")))
        }
    };
    Claim {
        id: "L1".into(),
        evidence: DEPARTURES,
        sentence: NOT_SENSITIVE.into(),
        criterion: format!(
            "in the design case all modes at burn-out within {} of the sound vehicle in the same wind; in part unless also with other misalignments, the wind reversed and 1.6 times as strong",
            accepted(results)
        ),
        falsified_by:
            "a mode whose burn-out in the design case leaves those limits, or that is lost".into(),
        measured: worst.map_or_else(
            || "nothing flown".to_owned(),
            |m| format!("largest in {}: {}", m.name, departure_words(results, &m.design)),
        ),
        verdict: worst
            .map_or(Verdict::NotJudged, |_| Verdict::of(holds))
            .in_part_unless(beyond.is_empty()),
        remark,
    }
}

/// What exceeds the load limit, and of the first such mode and the next below it the loads; whether
/// it is the one mode, with an acceptable trajectory in the flights asked for.
fn singled_out<'a, F: Iterator<Item = &'a Flown>>(
    results: &'a LongPeriodResults,
    flights: impl Fn(&'a ModeResult) -> F,
) -> (Verdict, String) {
    let accept = &results.accept;
    let load = |m: &'a ModeResult| flights(m).map(Flown::load_kpadeg).fold(0.0, f64::max);
    let exceeds = |m: &&'a ModeResult| flights(m).any(|f| f.exceeds(accept));
    let (over, within): (Vec<_>, Vec<_>) = results.modes.iter().partition(exceeds);
    let next = within.into_iter().max_by(|a, b| load(a).total_cmp(&load(b)));
    let told = |m: &ModeResult, load: f64| format!("{} {load:.1} kPa deg", m.name);
    let loads: Vec<String> = over.iter().map(|m| told(m, load(m))).collect();
    let above = if loads.is_empty() { "none".to_owned() } else { loads.join(", ") };
    let mut measured = format!("above the limit: {above}");
    let verdict = match over.as_slice() {
        _ if results.modes.iter().all(|m| m.name != SINGLED_OUT) => Verdict::NotJudged,
        [alone] => {
            let severity = flights(alone).map(|f| results.severity(f)).fold(0.0, f64::max);
            measured += &format!(", its trajectory at {severity:.2} of what is accepted");
            Verdict::of(alone.name == SINGLED_OUT && severity <= 1.0)
        }
        _ => Verdict::Fails,
    };
    if let Some(next) = next {
        measured += &format!("; next below it {}", told(next, load(next)));
    }
    (verdict, measured)
}

fn falsified_l2() -> String {
    format!(
        "no mode or a second one above the limit, another than `{SINGLED_OUT}`, or a trajectory of it outside L1"
    )
}

fn l2(results: &LongPeriodResults) -> Claim {
    let accept = &results.accept;
    let (verdict, measured) = singled_out(results, |m| std::iter::once(&m.design));
    let reversed: Vec<&ModeResult> = results
        .modes
        .iter()
        .filter(|m| m.reversed.as_ref().is_some_and(|f| f.exceeds(accept)))
        .collect();
    let was_reversed = results.modes.iter().any(|m| m.reversed.is_some());
    let in_part = verdict == Verdict::Holds && was_reversed && reversed.len() != 1;
    Claim {
        id: "L2".into(),
        evidence: Q_ALPHA,
        sentence: SINGLE_OUT.into(),
        criterion: format!(
            "in the design wind with nominal misalignments exactly one mode exceeds {:.0} kPa deg of Qα, it is the failure of the fin tips' electronics (`{SINGLED_OUT}`), and its trajectory keeps to L1; in part unless also with the wind reversed",
            accept.q_alpha_padeg / 1e3
        ),
        falsified_by: falsified_l2().into(),
        measured,
        verdict: verdict.in_part_unless(!in_part),
        remark: in_part.then(|| {
            format!(
                "not with the wind reversed: {} modes exceed the limit ({}){}",
                reversed.len(),
                named(reversed.iter().copied()),
                own_load(results, accept.q_alpha_padeg)
            )
        }),
    }
}

/// What the programmed flight's own incidence adds to one wind's load and takes from the other's.
fn own_load(results: &LongPeriodResults, limit_padeg: f64) -> String {
    let peak = results.sound.first().and_then(|f| f.ended.as_ref().ok()).map(|f| f.max_q_alpha);
    let own = peak.and_then(|peak| {
        let near = |s: &&FlightSample| (s.time_s - peak.time_s).abs();
        results.nominal_history.iter().min_by(|a, b| near(a).total_cmp(&near(b)))
    });
    own.map_or_else(String::new, |own| {
        format!(
            ": the programmed flight's own Qα of {:+.0} kPa deg at {:.1} s, {:.0} % of the limit, counts against the one wind and with the other",
            own.q_alpha_padeg() / 1e3,
            own.time_s,
            100.0 * own.q_alpha_padeg().abs() / limit_padeg
        )
    })
}

fn l2b(results: &LongPeriodResults) -> Claim {
    let (verdict, measured) = singled_out(results, ModeResult::in_design_wind);
    let first = results.modes.first();
    let mut points: Vec<f64> =
        first.into_iter().flat_map(|m| m.in_design_wind().map(|f| f.misalignment[0])).collect();
    points.sort_by(f64::total_cmp);
    let flown = results.modes.iter().any(|m| !m.envelope.is_empty());
    let (alone, not_alone) = pointwise(results);
    Claim {
        id: "L2b".into(),
        evidence: LOADS,
        sentence: SINGLE_OUT.into(),
        criterion: format!(
            "the same over the envelope of misalignments: in the design wind at pitch misalignments of {} × 3σ `{SINGLED_OUT}` alone exceeds {:.0} kPa deg, its trajectories within L1; in part unless at each of them",
            signed(&points),
            results.accept.q_alpha_padeg / 1e3
        ),
        falsified_by: falsified_l2().into(),
        measured,
        verdict: if flown { verdict } else { Verdict::NotJudged }
            .in_part_unless(not_alone.is_empty()),
        remark: (flown && !not_alone.is_empty()).then(|| {
            let alone = match alone.as_slice() {
                [] => "at none of them alone".to_owned(),
                alone => format!("at {} × 3σ", signed(alone)),
            };
            format!(
                "taken singly {alone} beside the design case, not at {} × 3σ, where another mode exceeds the limit or none does",
                signed(&not_alone)
            )
        }),
    }
}

fn signed(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:+}")).collect::<Vec<_>>().join(", ")
}

/// The misalignments of the envelope at which one mode alone exceeds the limit, and the others.
fn pointwise(results: &LongPeriodResults) -> (Vec<f64>, Vec<f64>) {
    let over = |i: usize| {
        let exceeds =
            |m: &&ModeResult| m.envelope.get(i).is_none_or(|f| f.exceeds(&results.accept));
        results.modes.iter().filter(exceeds).count()
    };
    let envelope = results.modes.first().map_or(&[][..], |m| &m.envelope);
    let (alone, not): (Vec<_>, Vec<_>) =
        envelope.iter().enumerate().partition(|(i, _)| over(*i) == 1);
    let points = |of: Vec<(usize, &Flown)>| of.iter().map(|(_, f)| f.misalignment[0]).collect();
    (points(alone), points(not))
}

fn l3(results: &LongPeriodResults) -> Claim {
    let reduced: Vec<&ModeResult> = results.modes.iter().filter(|m| m.reduced_schedule).collect();
    let holds = reduced
        .iter()
        .all(|m| !m.design.exceeds(&results.accept) && results.severity(&m.design) <= 1.0);
    let measured: Vec<String> = reduced
        .iter()
        .map(|m| {
            let load = m.design.load_kpadeg();
            format!("{}: {load:.1} kPa deg; {}", m.name, departure_words(results, &m.design))
        })
        .collect();
    Claim {
        id: "L3".into(),
        evidence: FIGURE_8,
        sentence: FEWER_SWITCHINGS.into(),
        criterion: format!(
            "the reduced schedule stays below {:.0} kPa deg and within L1; in part unless it also meets P1, by which the paper wants it re-evaluated",
            results.accept.q_alpha_padeg / 1e3
        ),
        falsified_by: "a load above the limit or a trajectory outside L1 on the reduced schedule"
            .into(),
        measured: if measured.is_empty() {
            "no mode flies the reduced schedule".to_owned()
        } else {
            measured.join("; ")
        },
        verdict: if reduced.is_empty() { Verdict::NotJudged } else { Verdict::of(holds) }
            .in_part_unless(false),
        remark: (!reduced.is_empty()).then(|| {
            "not re-evaluated with the short-period models here: `case-study` does".to_owned()
        }),
    }
}
