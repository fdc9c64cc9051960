//! Short-period part: figures 4 and 5, the condition matrix, linear agreement.

use crate::study::evidence;
use maud::{Markup, html};

use crate::report::short_period::{
    Measure, Named, agreement_section, matrix, pitch_figures, pitch_pair, remarks, yaw_roll_figures,
};
use crate::study::case_study::CaseResults;
use crate::study::short_period::claims::{
    BENDING_MIDDLE, FTC_GAIN_LOST, NORMAL, OSCILLATORY, OVERSHOOT_P1, TVC_FAST, TVC_SLOW,
};
use crate::study::short_period::measure::YAW_BAND_DEG;
use crate::study::short_period::outcome::{Outcome, Run, YawRollRun};
use crate::study::short_period::response::PitchResponse;
use desk::report::{Numbering, Section, anchor};

/// Cells of the matrix that get a figure of their own.
const WORST: usize = 10;

/// The sections in order.
pub(super) fn sections(numbering: &mut Numbering, results: &CaseResults) -> Vec<Section> {
    let outcome = &results.short;
    let mut sections = Vec::new();
    if let Some(figure) = figure_4(numbering, results) {
        sections.push(Section::new("Pitch loop (figure 4 of the paper)", figure));
    }
    if let Some(figure) = figure_5(numbering, results) {
        sections.push(Section::new("Yaw and roll loops (figure 5 of the paper)", figure));
    }
    let (worst, drawn) = worst_responses(numbering, outcome);
    let tables = matrices(numbering, outcome, &drawn);
    sections.push(Section::new("Conditions and trajectory points", tables));
    if !drawn.is_empty() {
        sections.push(Section::new("Worst responses", worst));
    }
    sections.push(Section::new(
        "Agreement with the linearised loop",
        agreement_section(numbering, outcome),
    ));
    sections
}

fn place(outcome: &Outcome, point: usize) -> String {
    let point = &outcome.plan.points[point];
    format!("{} ({:.1} s)", point.name, point.slice.time_s)
}

/// Disturbed runs at a point under some conditions, named by their titles.
fn pitch_runs<'a>(
    outcome: &'a Outcome,
    point: usize,
    conditions: &[&str],
) -> Vec<Named<'a, PitchResponse>> {
    conditions
        .iter()
        .filter_map(|name| {
            let run = outcome.pitch_under(name, true).find(|r| r.case.point == point)?;
            let title = &outcome.plan.conditions[run.case.condition].title;
            let title = if title.is_empty() { *name } else { title.as_str() };
            Some((title.to_owned(), &run.response))
        })
        .collect()
}

fn figure_4(numbering: &mut Numbering, results: &CaseResults) -> Option<Markup> {
    let outcome = &results.short;
    let point = results.most_telling_point(&[FTC_GAIN_LOST, TVC_SLOW])?;
    let runs = pitch_runs(outcome, point, &[NORMAL, FTC_GAIN_LOST, TVC_SLOW]);
    let at = place(outcome, point);
    let step = outcome.plan.step_rad.to_degrees();
    let figures = pitch_figures(numbering, evidence::FIGURE_4.anchor(), &format!("at {at}"), &runs);
    let growth = growth(numbering, outcome);
    Some(html! {
        p { "Step command of " (format!("{step:.1}")) "° in pitch with thrust misalignment and a step gust at t = 0, at " (at)
            ": the normal mode, the fin-tip gain all but lost, and the thrust-vector pole slowed. It is the point at which both failures ring most." }
        (figures)
        @if let Some(growth) = growth {
            h3 { "The other reading of the slow actuator" }
            p { "Read literally, a thrust-vector time constant reduced to a low value excites the bending mode, whose coordinate then grows instead of attenuating." }
            (growth)
        }
    })
}

/// The point without tips at which the fast actuator lets the bending coordinate grow most.
fn growth(numbering: &mut Numbering, outcome: &Outcome) -> Option<Markup> {
    let (point, _) = outcome
        .pitch_under(TVC_FAST, true)
        .filter(|r| r.case.settings.plane.ftc_gain == 0.0)
        .filter_map(|r| Some((r.case.point, r.measures.bending_ratio(2)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let runs = pitch_runs(outcome, point, &[NORMAL, TVC_FAST]);
    let at = format!("at {}", place(outcome, point));
    Some(pitch_pair(numbering, evidence::BENDING_GROWTH.anchor(), &at, &runs))
}

fn yaw_roll_run(outcome: &Outcome, point: usize, dedicated: bool) -> Option<&YawRollRun> {
    outcome.yaw_roll_under(NORMAL, dedicated).find(|r| r.case.point == point)
}

fn figure_5(numbering: &mut Numbering, results: &CaseResults) -> Option<Markup> {
    let outcome = &results.short;
    let has_both = |point: &usize| {
        [false, true]
            .into_iter()
            .all(|dedicated| yaw_roll_run(outcome, *point, dedicated).is_some())
    };
    let point = results
        .most_telling_point(&[FTC_GAIN_LOST, TVC_SLOW])
        .filter(has_both)
        .or_else(|| (0..outcome.plan.points.len()).find(has_both))
        .or_else(|| outcome.plan.yaw_roll.first().map(|c| c.point))?;
    let runs: Vec<_> = [(false, "tips shared"), (true, "tips for roll only")]
        .into_iter()
        .filter_map(|(dedicated, name)| {
            Some((name.to_owned(), yaw_roll_run(outcome, point, dedicated)?))
        })
        .collect();
    let travel = runs.first().map(|(_, run)| run.case.settings.plane.tip_travel);
    let named: Vec<_> = runs.into_iter().map(|(name, run)| (name, &run.response)).collect();
    let at = place(outcome, point);
    let figures = yaw_roll_figures(
        numbering,
        evidence::FIGURE_5.anchor(),
        &format!("at {at}"),
        &named,
        travel,
    );
    Some(html! {
        p { "Initial offsets in yaw and roll with fin cant, thrust misalignment and a step gust, at " (at)
            ": the loops coupled by the shared tips (sum to one tip, difference to the other), and decoupled (tips for roll, thrust vector for yaw)." }
        (figures)
    })
}

/// Cells of the matrix with a figure: condition, point, anchor.
type Drawn = Vec<(usize, usize, String)>;

fn worst_responses(numbering: &mut Numbering, outcome: &Outcome) -> (Markup, Drawn) {
    let plan = &outcome.plan;
    let mut cells: Vec<(usize, usize, f64)> = outcome
        .pitch
        .iter()
        .filter(|r| r.case.disturbed && r.condition != NORMAL)
        .map(|Run { case, measures, .. }| {
            let residual = measures.residual.map_or(f64::INFINITY, |r| 100.0 * r);
            (case.condition, case.point, residual)
        })
        .collect();
    cells.sort_by(|a, b| b.2.total_cmp(&a.2));
    cells.truncate(WORST);
    let mut drawn = Drawn::new();
    let mut parts = Vec::new();
    for (condition, point, residual) in cells {
        let entry = &plan.conditions[condition];
        let name = format!("{} at {}", entry.name, place(outcome, point));
        let id =
            format!("response-{}", anchor(&format!("{} {}", entry.name, plan.points[point].name)));
        let runs = pitch_runs(outcome, point, &[NORMAL, &entry.name]);
        let figures = pitch_pair(numbering, &id, &name, &runs);
        parts.push((name, residual, figures));
        drawn.push((condition, point, id));
    }
    let body = html! {
        p { "The " (parts.len()) " cells of the matrix with the largest residual oscillation, each beside the normal mode at its point." }
        @for (name, residual, figures) in &parts {
            h3 { (name) ": residual " (desk::report::format::with_unit(*residual, 3, "%")) }
            (figures)
        }
    };
    (body, drawn)
}

fn matrices(numbering: &mut Numbering, outcome: &Outcome, drawn: &Drawn) -> Markup {
    let plan = &outcome.plan;
    let href = |condition: usize, point: usize| {
        drawn
            .iter()
            .find(|(c, p, _)| (*c, *p) == (condition, point))
            .map(|(_, _, id)| format!("#{id}"))
    };
    let pitch = |condition: usize, point: usize, disturbed: bool| {
        let run = outcome
            .pitch_under(&plan.conditions[condition].name, disturbed)
            .find(|r| r.case.point == point)?;
        Some(&run.measures)
    };
    let percent = |v: Option<f64>| 100.0 * v.unwrap_or(f64::NAN);
    let residual = |c: usize, p: usize| pitch(c, p, true).map(|m| percent(m.residual));
    let overshoot = |c: usize, p: usize| pitch(c, p, false).map(|m| percent(m.overshoot));
    let bending = |c: usize, p: usize| pitch(c, p, true).map(|m| percent(m.bending_ratio(1)));
    let yaw = |condition: usize, point: usize| {
        let run = outcome
            .yaw_roll_under(&plan.conditions[condition].name, false)
            .find(|r| r.case.point == point)?;
        Some(run.measures.yaw_settling_s.unwrap_or(f64::NAN))
    };
    let nowhere = |_: usize, _: usize| None;
    let [oscillatory, overshot, bent] =
        [OSCILLATORY, OVERSHOOT_P1, BENDING_MIDDLE].map(|fraction| 100.0 * fraction);
    let tables = [
        (
            "matrix-residual",
            "Residual oscillation of θ in the disturbed pitch runs; the worst cells lead to their responses.",
            Measure {
                quantity: format!(
                    "Peak-to-peak θ from 5 to 10 s without its parabolic trend, % of the step; outside from {oscillatory:.0} % on"
                ),
                limit: oscillatory,
                scale: (0.0, 100.0),
                value: &residual,
                href: &href,
            },
        ),
        (
            evidence::OVERSHOOTS.anchor(),
            "Overshoot of θ in the pitch runs without disturbances.",
            Measure {
                quantity: format!("Overshoot, % of the step; outside above {overshot:.0} %"),
                limit: overshot,
                scale: (0.0, 50.0),
                value: &overshoot,
                href: &nowhere,
            },
        ),
        (
            evidence::BENDING.anchor(),
            "Decay of the first bending coordinate in the disturbed pitch runs.",
            Measure {
                quantity: format!(
                    "Bending envelope from 5 to 6.5 s over that of the first 2 s, %; outside above {bent:.0} %"
                ),
                limit: bent,
                scale: (0.0, 100.0),
                value: &bending,
                href: &href,
            },
        ),
        (
            "matrix-yaw",
            "Yaw settling with shared tips.",
            Measure {
                quantity: format!(
                    "Time to stay within {YAW_BAND_DEG}° of the final yaw, s; a dash did not settle within {} s",
                    plan.duration_s
                ),
                limit: plan.duration_s,
                scale: (0.0, plan.duration_s),
                value: &yaw,
                href: &nowhere,
            },
        ),
    ];
    html! {
        @for (id, caption, measure) in &tables {
            (numbering.table(id, caption, matrix(outcome, measure)))
        }
        (remarks(outcome))
    }
}
