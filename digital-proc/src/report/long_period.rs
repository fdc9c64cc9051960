//! The long-period study as tables and figures 6 to 8 of the paper.

use super::gain_design::schedule_charts;
use crate::study::evidence;
use crate::study::long_period::{
    history::{VARIABLES, Variable},
    results::{FlightFigures, FlightWind, Flown, LongPeriodResults, ModeResult},
};
use desk::claim::Claim;
use desk::report::{
    Cell, Heading, Numbering, Section, Table, claims_table,
    plot::{Axis, LineChart, Series, Size, line_chart},
    side_by_side,
};
use maud::{Markup, html};
use vehicle::ScheduleData;

/// Curves that one chart can carry before they hide each other.
const MOST_CURVES: usize = 6;

/// Burn-out, load and fuel of every mode in the design case.
pub fn mode_table(results: &LongPeriodResults) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Mode", ""),
        Heading::new("ΔV", "%").digits(3),
        Heading::new("Δγ", "°").digits(3),
        Heading::new("Δh", "%").digits(3),
        Heading::new("Δrange", "km").digits(3),
        Heading::new("Max Qα", "kPa·°"),
        Heading::new("at", "s").digits(3),
        Heading::new("of the limit", "%").digits(3),
        Heading::new("Max roll", "°").digits(3),
        Heading::new("Injectant", "kg").digits(3),
    ]);
    for mode in &results.modes {
        let name = Cell::from(mode.name.as_str());
        match (&mode.design.figures, &mode.departure) {
            (Some(f), Some(d)) => table.row([
                name,
                (100.0 * d.speed_fraction).into(),
                d.path_angle_deg.into(),
                (100.0 * d.altitude_fraction).into(),
                d.range_km.into(),
                (f.max_q_alpha_padeg / 1e3).into(),
                f.max_q_alpha_time_s.into(),
                (100.0 * f.max_q_alpha_padeg / results.accept.q_alpha_padeg).into(),
                f.max_roll_deg.into(),
                f.injectant_kg.into(),
            ]),
            _ => table.row([name, lost(&mode.design)]),
        }
    }
    table
}

fn lost(flown: &Flown) -> Cell {
    format!("lost: {}", flown.lost.as_deref().unwrap_or("no reason given")).into()
}

/// Largest Qα (kPa·°) of every mode over winds and misalignments (fractions of 3σ).
pub fn load_table(results: &LongPeriodResults) -> Table {
    by_flight(results, "kPa·°", |f| f.max_q_alpha_padeg / 1e3)
}

/// Side-force fluid (kg) of every mode over winds and misalignments (fractions of 3σ).
pub fn fuel_table(results: &LongPeriodResults) -> Table {
    by_flight(results, "kg", |f| f.injectant_kg)
}

fn by_flight(results: &LongPeriodResults, unit: &str, of: fn(&FlightFigures) -> f64) -> Table {
    let mut headings = vec![Heading::new("Mode", "")];
    if let Some(first) = results.modes.first() {
        headings.extend(first.flights().map(|f| {
            Heading::new(format!("{} {:+}", short(f.wind), f.pitch_misalignment), unit).digits(3)
        }));
    }
    let mut table = Table::new(headings);
    for mode in &results.modes {
        let cells = mode.flights().map(|flown| match &flown.figures {
            Some(f) => Cell::Number(of(f)),
            None => Cell::Text("lost".into()),
        });
        table.row(std::iter::once(Cell::from(mode.name.as_str())).chain(cells));
    }
    table
}

/// A wind in a heading.
fn short(wind: FlightWind) -> &'static str {
    match wind {
        FlightWind::Calm => "calm",
        FlightWind::DesignCase => "design",
        FlightWind::Reversed => "reversed",
    }
}

/// The fuel sentence (objective v).
pub fn fuel_words(results: &LongPeriodResults) -> String {
    results.worst_fuel().map_or_else(
        || "no flight reached burn-out".to_owned(),
        |f| {
            format!(
                "Side-force fluid: undisturbed flight {:.1} kg; worst case {:.1} kg of {:.0} kg carried ({}, {}, misalignment {:+} × 3σ in pitch)",
                results.nominal.injectant_kg,
                f.injectant_kg,
                f.carried_kg,
                f.mode,
                f.wind.words(),
                f.pitch_misalignment
            )
        },
    )
}

/// A table a question: burn-out, loads and fuel, with the fuel in words below.
pub(super) fn mode_tables(numbering: &mut Numbering, results: &LongPeriodResults) -> Markup {
    html! {
        (numbering.table(evidence::MODES.anchor(),
            "Departure of each mode's burn-out from that of the undisturbed normal flight, its load and its fluid; design case.",
            mode_table(results).markup()))
        (numbering.table(evidence::LOADS.anchor(),
            "Largest Qα over wind and pitch misalignment, the latter in fractions of 3σ.",
            load_table(results).markup()))
        (numbering.table("fuel",
            "Side-force fluid over wind and pitch misalignment, the latter in fractions of 3σ.",
            fuel_table(results).markup()))
        p { (fuel_words(results)) "." }
    }
}

/// The variable that has a limit, and a figure of full size.
const LOAD: &str = evidence::Q_ALPHA.anchor();

/// Figures of the ten variables (after the paper's figure 6): the load, and the others.
pub(super) fn variable_figures(
    numbering: &mut Numbering,
    results: &LongPeriodResults,
) -> (Markup, Markup) {
    let shown = drawn_modes(results);
    let (load, others): (Vec<_>, Vec<_>) = VARIABLES.iter().partition(|v| v.anchor == LOAD);
    let load = load.iter().map(|variable| {
        let limit = results.accept.q_alpha_padeg / 1e3;
        let chart = variable_chart(variable, &shown)
            .size(Size::FULL)
            .limit(limit, "design limit")
            .limit(-limit, "design limit");
        numbering.figure(
            variable.anchor,
            "Load indicator Qα of the modes in the design case against its design limit, judged from the take-over of the fin tips on.",
            line_chart(&chart),
        )
    });
    let load = html! { @for figure in load { (figure) } };
    let others: Vec<Markup> = others
        .iter()
        .map(|variable| {
            let chart = variable_chart(variable, &shown).size(Size::HALF);
            let caption = format!(
                "{} against time, all modes in the design case (after the paper's figure 6).",
                variable.label
            );
            numbering.figure(variable.anchor, &caption, line_chart(&chart))
        })
        .collect();
    (load, side_by_side(&others))
}

/// The modes that were flown. Of more than a chart can carry, the single variants go first.
fn drawn_modes(results: &LongPeriodResults) -> Vec<&ModeResult> {
    let mut shown: Vec<&ModeResult> =
        results.modes.iter().filter(|m| !m.history.time_s.is_empty()).collect();
    if shown.len() > MOST_CURVES {
        shown.retain(|m| !m.text.contains("alone"));
        shown.truncate(MOST_CURVES);
    }
    shown
}

/// A variable against time, a curve a mode.
fn variable_chart(variable: &Variable, shown: &[&ModeResult]) -> LineChart {
    let series = shown
        .iter()
        .map(|m| Series::line(m.name.as_str(), &m.history.time_s, (variable.of)(&m.history)))
        .collect();
    LineChart::new(
        variable.label,
        Axis::new("Flight time", "s"),
        Axis::new(variable.label, variable.unit),
        series,
    )
}

/// The paper's figures 7 and 8: the schedule as designed, and with fewer switchings.
pub(super) fn schedule_figures(numbering: &mut Numbering, results: &LongPeriodResults) -> Markup {
    let end_s = results.nominal_history.time_s.last().copied().unwrap_or(0.0);
    let switchings = |s: &ScheduleData| s.switch_time_s.len().saturating_sub(1);
    let designed = schedule_charts(&[("designed", &results.designed)], end_s);
    let reduced =
        schedule_charts(&[("reduced", &results.reduced), ("designed", &results.designed)], end_s);
    html! {
        (numbering.figure("figure-7",
            &format!("The designed gain schedules, {} switchings (after the paper's figure 7).", switchings(&results.designed)),
            side_by_side(&designed)))
        (numbering.figure(evidence::FIGURE_8.anchor(),
            &format!("The gain schedules reduced by long-period trials to {} switchings, beside the designed ones (after the paper's figure 8).", switchings(&results.reduced)),
            side_by_side(&reduced)))
    }
}

/// The sections of the study's page.
pub fn long_period_sections(results: &LongPeriodResults, claims: &[Claim]) -> Vec<Section> {
    let mut numbering = Numbering::new();
    let modes = mode_tables(&mut numbering, results);
    let (load, others) = variable_figures(&mut numbering, results);
    let schedules = schedule_figures(&mut numbering, results);
    vec![
        Section::new("Claims", claims_table(claims, &numbering)),
        Section::new("Modes", modes),
        Section::new("Load profiles", load),
        Section::new("Monitored variables", others),
        Section::new("Gain schedules", schedules),
    ]
}
