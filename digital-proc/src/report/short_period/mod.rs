//! The report of short-period runs, and the parts that the case study's report shares.

mod figures;
mod matrix;
mod tables;

pub use figures::{MOST_RUNS, Named, pitch_figures, pitch_pair, yaw_roll_figures};
pub use matrix::{Measure, matrix};
pub use tables::{agreement_table, allocation, dashed, pitch_table, yaw_roll_table};

use maud::{Markup, html};

use crate::study::short_period::measure::{PITCH_BAND, ROLL_BAND_DEG, YAW_BAND_DEG};
use crate::study::short_period::outcome::{Outcome, Run};
use desk::report::{Numbering, Section, anchor, page, provenance};
use desk::run_dir::RunRecord;

/// Runs beyond this many are tabulated and traced, and only the worst are drawn.
const MOST_DRAWN: usize = 48;

/// The report as a page.
pub fn short_period_report(title: &str, outcome: &Outcome, record: &RunRecord) -> String {
    let mut numbering = Numbering::new();
    let mut sections = Vec::new();
    let measures = html! {
        @if !outcome.plan.pitch.is_empty() {
            (numbering.table("pitch-measures",
                &format!("Measures of each pitch run. Settling is to {:.0} % of the step about the final value; the residual is the peak-to-peak attitude from 5 to 10 s without its parabolic trend; η is the bending envelope over that of the first 2 s. Eigenvalues are those of the loop with both channels linear.", 100.0 * PITCH_BAND),
                pitch_table(outcome).markup()))
        }
        @if !outcome.plan.yaw_roll.is_empty() {
            (numbering.table("yaw-roll-measures",
                &format!("Measures of each yaw–roll run. Settling is to {YAW_BAND_DEG}° in yaw and {ROLL_BAND_DEG}° in roll about the final value."),
                yaw_roll_table(outcome).markup()))
        }
        (remarks(outcome))
    };
    sections.push(Section::new("Measures", measures));
    if !outcome.plan.pitch.is_empty() {
        sections.push(Section::new(
            "Agreement with the linearised loop",
            agreement_section(&mut numbering, outcome),
        ));
    }
    sections.push(Section::new("Responses", responses(&mut numbering, outcome)));
    sections.push(Section::new("Provenance", provenance(record)));
    page(
        title,
        "The control loops at frozen trajectory points, patched on the analog processor; coefficients, initial conditions and modes set by the digital one, run after run in one session.",
        &sections,
    )
}

/// What the machine remarked, if anything.
pub fn remarks(outcome: &Outcome) -> Markup {
    let remarks = outcome.remarks();
    html! {
        @if !remarks.is_empty() {
            p { strong { "Remarked during the runs:" } }
            ul { @for remark in &remarks { li { (remark) } } }
        }
    }
}

/// The table of linear agreement with its explanation.
pub fn agreement_section(numbering: &mut Numbering, outcome: &Outcome) -> Markup {
    if outcome.agreement.is_empty() {
        return html! { p { "No undisturbed pitch run stays in a linear range: nothing to compare." } };
    }
    html! {
        (numbering.table("linear-agreement",
            "Undisturbed pitch runs that stay linear. Where every channel keeps to one range from the start, the whole response is held against the matrix exponential; where it does so from 4 s on, the decay of the bending coordinate is held against its eigenvalue.",
            agreement_table(outcome).markup()))
    }
}

fn responses(numbering: &mut Numbering, outcome: &Outcome) -> Markup {
    let plan = &outcome.plan;
    let all = plan.pitch.len() + plan.yaw_roll.len();
    let drawn = drawn_points(outcome);
    let mut parts: Vec<(String, Markup)> = Vec::new();
    for &point in &drawn {
        let place =
            format!("{} ({:.1} s)", plan.points[point].name, plan.points[point].slice.time_s);
        let id = anchor(&plan.points[point].name);
        let pitch: Vec<Named<'_, _>> = outcome
            .pitch
            .iter()
            .filter(|r| r.case.point == point)
            .map(|Run { condition, case, response, .. }| {
                let test = if case.disturbed { "" } else { ", step only" };
                (format!("{condition}{test}"), response)
            })
            .collect();
        for (n, group) in pitch.chunks(MOST_RUNS).enumerate() {
            let figures = pitch_figures(numbering, &format!("{id}-pitch-{n}"), &place, group);
            parts.push((format!("Pitch loop at {place}"), figures));
        }
        let yaw_roll: Vec<Named<'_, _>> = outcome
            .yaw_roll
            .iter()
            .filter(|r| r.case.point == point)
            .map(|Run { condition, case, response, .. }| {
                (format!("{condition}, tips {}", allocation(case)), response)
            })
            .collect();
        for (n, group) in yaw_roll.chunks(MOST_RUNS).enumerate() {
            let figures =
                yaw_roll_figures(numbering, &format!("{id}-yaw-roll-{n}"), &place, group, None);
            parts.push((format!("Yaw and roll loops at {place}"), figures));
        }
    }
    html! {
        @if drawn.len() < plan.points.len() && all > MOST_DRAWN {
            p { "Of " (all) " runs those at the point with the largest residual oscillation are drawn; the trace holds all of them. Name a point or a condition to see others." }
        }
        @for (title, figures) in &parts { h3 { (title) } (figures) }
    }
}

/// Points whose responses are drawn: all that have runs, or the worst one of very many runs.
fn drawn_points(outcome: &Outcome) -> Vec<usize> {
    let plan = &outcome.plan;
    let has_runs = |p: &usize| {
        plan.pitch.iter().any(|c| c.point == *p) || plan.yaw_roll.iter().any(|c| c.point == *p)
    };
    if plan.pitch.len() + plan.yaw_roll.len() <= MOST_DRAWN {
        return (0..plan.points.len()).filter(has_runs).collect();
    }
    let worst = outcome.pitch.iter().max_by(|a, b| {
        let residual = |m: Option<f64>| m.unwrap_or(f64::INFINITY);
        residual(a.measures.residual).total_cmp(&residual(b.measures.residual))
    });
    worst
        .map(|r| r.case.point)
        .or_else(|| plan.yaw_roll.first().map(|c| c.point))
        .into_iter()
        .collect()
}
