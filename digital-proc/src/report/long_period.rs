//! The long-period study as tables and figures 6 to 8 of the paper.

use super::{
    Cell, Heading, Numbering, Section, Table,
    gain_design::schedule_charts,
    plot::{Axis, Limit, LineChart, Series, Size, line_chart},
    side_by_side,
};
use crate::study::long_period::results::{
    FlightWind, Flown, History, LongPeriodResults, ModeResult,
};
use maud::{Markup, html};

/// Curves that one chart can carry before they hide each other.
const MOST_CURVES: usize = 6;

/// Burn-out, load and fuel of every mode in the design case.
#[must_use]
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
    format!(
        "lost: {}",
        flown.lost.as_deref().unwrap_or("no reason given")
    )
    .into()
}

/// Largest Qα (kPa·°) of every mode over winds and misalignments (fractions of 3σ).
#[must_use]
pub fn load_table(results: &LongPeriodResults) -> Table {
    by_flight(results, "kPa·°", |f| f.max_q_alpha_padeg / 1e3)
}

/// Side-force fluid (kg) of every mode over winds and misalignments (fractions of 3σ).
#[must_use]
pub fn fuel_table(results: &LongPeriodResults) -> Table {
    by_flight(results, "kg", |f| f.injectant_kg)
}

fn by_flight(
    results: &LongPeriodResults,
    unit: &str,
    of: fn(&crate::study::long_period::results::FlightFigures) -> f64,
) -> Table {
    let mut headings = vec![Heading::new("Mode", "")];
    if let Some(first) = results.modes.first() {
        headings.extend(first.flights().map(|f| {
            Heading::new(
                format!("{} {:+}", short(f.wind), f.pitch_misalignment),
                unit,
            )
            .digits(3)
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
#[must_use]
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

/// One of the monitored variables: anchor, label, unit, and where it lies.
type Variable = (
    &'static str,
    &'static str,
    &'static str,
    fn(&History) -> &[f64],
);

/// The paper's ten variables; pitch and roll are the two of its (ix).
const VARIABLES: [Variable; 11] = [
    ("velocity", "Inertial velocity", "m/s", |h| &h.speed_mps),
    ("path-angle", "Inertial flight-path angle", "°", |h| {
        &h.path_angle_deg
    }),
    ("altitude", "Altitude", "km", |h| &h.altitude_km),
    ("range-angle", "Range angle", "°", |h| &h.range_angle_deg),
    ("alpha", "Pitch angle of attack", "°", |h| &h.incidence_deg),
    ("mach", "Mach number", "", |h| &h.mach),
    ("q", "Dynamic pressure", "kPa", |h| &h.q_kpa),
    ("q-alpha", "Load indicator Qα", "kPa·°", |h| {
        &h.q_alpha_kpadeg
    }),
    ("pitch", "Pitch angle", "°", |h| &h.pitch_deg),
    ("roll", "Roll angle", "°", |h| &h.roll_deg),
    ("tvc", "TVC force, pitch loop", "kN", |h| &h.tvc_pitch_kn),
];

/// The ten variables against time, a curve a mode (after the paper's figure 6).
/// Of more modes than a chart can carry, the single variants go first.
#[must_use]
pub fn variable_charts(results: &LongPeriodResults) -> Vec<(&'static str, &'static str, Markup)> {
    let variants: Vec<&ModeResult> = results
        .modes
        .iter()
        .filter(|m| !m.history.time_s.is_empty())
        .collect();
    let mut shown = variants.clone();
    if shown.len() > MOST_CURVES {
        let is_variant = |m: &&ModeResult| m.text.contains("alone");
        shown.retain(|m| !is_variant(m));
        shown.truncate(MOST_CURVES);
    }
    VARIABLES
        .iter()
        .map(|(id, label, unit, of)| {
            let series = shown
                .iter()
                .map(|m| Series::line(m.name.as_str(), &m.history.time_s, of(&m.history)))
                .collect();
            let limit = results.accept.q_alpha_padeg / 1e3;
            let limits = if *id == "q-alpha" {
                [limit, -limit]
                    .map(|value| Limit {
                        value,
                        name: "design limit".to_owned(),
                    })
                    .to_vec()
            } else {
                Vec::new()
            };
            let chart = line_chart(&LineChart {
                limits,
                size: if *id == "q-alpha" {
                    Size::FULL
                } else {
                    Size::HALF
                },
                ..LineChart::new(
                    *label,
                    Axis::new("Flight time", "s"),
                    Axis::new(*label, *unit),
                    series,
                )
            });
            (*id, *label, chart)
        })
        .collect()
}

/// The sections of the study's page. `claims` is its table of claims.
#[must_use]
pub fn long_period_sections(
    results: &LongPeriodResults,
    claims: Markup,
    end_s: f64,
) -> Vec<Section> {
    let mut numbering = Numbering::new();
    let caption = |label: &str| {
        format!("{label} against time, all modes in the design case (after the paper's figure 6).")
    };
    let (loads, others): (Vec<_>, Vec<_>) = variable_charts(results)
        .into_iter()
        .partition(|(id, _, _)| *id == "q-alpha");
    let mut figure =
        |(id, label, chart): (&str, &str, Markup)| numbering.figure(id, &caption(label), chart);
    let loads: Vec<Markup> = loads.into_iter().map(&mut figure).collect();
    let charts: Vec<Markup> = others.into_iter().map(&mut figure).collect();
    let designed = schedule_charts(&[("designed", &results.designed)], end_s);
    let reduced = schedule_charts(
        &[
            ("fewer switchings", &results.reduced),
            ("designed", &results.designed),
        ],
        end_s,
    );
    vec![
        Section::new("Claims", claims),
        Section::new(
            "Modes",
            html! {
                (numbering.table("modes", "Burn-out departure from the undisturbed flight, load and fuel, design case.", mode_table(results).markup()))
                (numbering.table("loads", "Largest Qα over wind and pitch misalignment, the latter in fractions of 3σ.", load_table(results).markup()))
                (numbering.table("fuel", "Side-force fluid over wind and pitch misalignment, the latter in fractions of 3σ.", fuel_table(results).markup()))
                p { (fuel_words(results)) "." }
            },
        ),
        Section::new("Load profiles", html! { @for load in &loads { (load) } }),
        Section::new("Monitored variables", side_by_side(&charts)),
        Section::new(
            "Gain schedules",
            html! {
                (numbering.figure("designed-gains", "Designed gain schedules of the control loops (after the paper's figure 7).", side_by_side(&designed)))
                (numbering.figure("reduced-gains", "Gain schedules with fewer switchings (after the paper's figure 8).", side_by_side(&reduced)))
            },
        ),
    ]
}
