//! Long-period part: figure 6 (trajectory variables), 7 and 8 (gain schedules), flights.

use maud::{Markup, html};

use crate::report::plot::{Axis, Limit, LineChart, Series, Size, line_chart};
use crate::report::{Cell, Heading, Numbering, Section, Table, side_by_side};
use crate::study::case_study::CaseResults;
use crate::study::long_period::results::{Flown, History, LongPeriodResults, ModeResult};
use crate::vehicle::ScheduleData;

/// One figure: quantity, unit, values of a history.
type Panel = (&'static str, &'static str, fn(&History) -> &[f64]);

const PANELS: [Panel; 10] = [
    ("Inertial velocity", "m/s", |h| &h.speed_mps),
    ("Flight-path angle", "°", |h| &h.path_angle_deg),
    ("Altitude", "km", |h| &h.altitude_km),
    ("Range angle", "°", |h| &h.range_angle_deg),
    ("Pitch angle of attack", "°", |h| &h.incidence_deg),
    ("Mach number", "", |h| &h.mach),
    ("Dynamic pressure Q", "kPa", |h| &h.q_kpa),
    ("Pitch angle", "°", |h| &h.pitch_deg),
    ("Roll angle", "°", |h| &h.roll_deg),
    ("TVC force, pitch", "kN", |h| &h.tvc_pitch_kn),
];

/// The sections in order.
pub(super) fn sections(numbering: &mut Numbering, results: &CaseResults) -> Vec<Section> {
    let long = &results.long;
    vec![
        Section::new(
            "Trajectories (figure 6 of the paper)",
            figure_6(numbering, long),
        ),
        Section::new("Flights and side-force fuel", flights(numbering, long)),
        Section::new(
            "Gain schedules (figures 7 and 8 of the paper)",
            schedules(numbering, long),
        ),
    ]
}

fn curves(long: &LongPeriodResults, of: fn(&History) -> &[f64]) -> Vec<Series> {
    let nominal = Series::line(
        "undisturbed",
        &long.nominal_history.time_s,
        of(&long.nominal_history),
    );
    let modes = long
        .modes
        .iter()
        .map(|m| Series::line(m.name.as_str(), &m.history.time_s, of(&m.history)));
    std::iter::once(nominal).chain(modes).collect()
}

fn figure_6(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let limit = long.accept.q_alpha_padeg / 1e3;
    let load = LineChart {
        limits: [(limit, "design limit"), (-limit, "design limit")]
            .map(|(value, name)| Limit {
                value,
                name: name.to_owned(),
            })
            .to_vec(),
        ..LineChart::new(
            "",
            Axis::new("Time", "s"),
            Axis::new("Load indicator Qα", "kPa·°"),
            curves(long, |h| &h.q_alpha_kpadeg),
        )
    };
    let load = numbering.figure(
        "load",
        "Load indicator Qα of every mode in the design wind with nominal misalignments; it is judged from the take-over of the fin tips on.",
        line_chart(&load),
    );
    let figures: Vec<Markup> = PANELS
        .iter()
        .enumerate()
        .map(|(n, &(label, unit, of))| {
            let chart = LineChart::new(
                "",
                Axis::new("Time", "s"),
                Axis::new(label, unit),
                curves(long, of),
            )
            .size(Size::HALF);
            let id = if n == 0 {
                "figure-6".to_owned()
            } else {
                format!("figure-6-{n}")
            };
            numbering.figure(&id, &format!("{label}, all modes."), line_chart(&chart))
        })
        .collect();
    html! {
        p { "Every mode in the design wind with nominal misalignments, and the undisturbed normal flight." }
        (load)
        (side_by_side(&figures))
    }
}

fn flights(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let departures = departures(long);
    let flown = flown(long);
    let fuel = long.worst_fuel();
    html! {
        (numbering.table("departures",
            "Departure of each mode's burn-out from that of the undisturbed normal flight, design case.",
            departures.markup()))
        (numbering.table("flights",
            "Every flight of the study: greatest |Qα| and the side-force fluid used.",
            flown.markup()))
        @if let Some(fuel) = fuel {
            p { "The greatest use of side-force fluid among these flights is "
                (format!("{:.1} kg of the {:.1} kg carried", fuel.injectant_kg, fuel.carried_kg))
                ": mode " (fuel.mode) ", " (fuel.wind.words()) ", pitch misalignment "
                (format!("{:+.1}", fuel.pitch_misalignment)) " × 3σ." }
        }
    }
}

fn departures(long: &LongPeriodResults) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Mode", ""),
        Heading::new("What fails", ""),
        Heading::new("Velocity", "%").digits(3),
        Heading::new("Flight-path angle", "°").digits(3),
        Heading::new("Altitude", "%").digits(3),
        Heading::new("Range", "km").digits(3),
        Heading::new("Part of what is accepted", "").digits(3),
    ]);
    for mode in &long.modes {
        let mut row: Vec<Cell> = vec![mode.name.as_str().into(), mode.text.as_str().into()];
        match &mode.departure {
            Some(d) => row.extend([
                Cell::Number(100.0 * d.speed_fraction),
                d.path_angle_deg.into(),
                Cell::Number(100.0 * d.altitude_fraction),
                d.range_km.into(),
                d.severity(&long.accept).into(),
            ]),
            None => row.push("lost".into()),
        }
        table.row(row);
    }
    table
}

fn flown(long: &LongPeriodResults) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Mode", ""),
        Heading::new("Wind", ""),
        Heading::new("Pitch misalignment", "× 3σ").digits(2),
        Heading::new("Greatest |Qα|", "kPa·°"),
        Heading::new("at", "s").digits(3),
        Heading::new("Within the limit", ""),
        Heading::new("Greatest roll", "°").digits(3),
        Heading::new("Fluid used", "kg").digits(3),
    ]);
    let mut add = |mode: &ModeResult, flown: &Flown| {
        let mut row: Vec<Cell> = vec![
            mode.name.as_str().into(),
            flown.wind.words().into(),
            flown.pitch_misalignment.into(),
        ];
        match (&flown.figures, &flown.lost) {
            (Some(f), _) => {
                let within = f.max_q_alpha_padeg <= long.accept.q_alpha_padeg;
                row.extend([
                    Cell::Number(f.max_q_alpha_padeg / 1e3),
                    f.max_q_alpha_time_s.into(),
                    if within { "yes" } else { "✗ no" }.into(),
                    f.max_roll_deg.into(),
                    f.injectant_kg.into(),
                ]);
            }
            (None, lost) => row.push(Cell::Text(format!(
                "lost: {}",
                lost.as_deref().unwrap_or("no reason given")
            ))),
        }
        table.row(row);
    };
    for mode in &long.modes {
        for flown in mode.flights() {
            add(mode, flown);
        }
    }
    table
}

/// One gain: quantity, unit, values of a schedule.
type Gain = (&'static str, &'static str, fn(&ScheduleData) -> &[f64]);

const GAINS: [Gain; 5] = [
    ("FTC gain K_F", "° / °", |s| &s.ftc_gain),
    ("FTC rate gain T_F", "s", |s| &s.ftc_lead_s),
    ("TVC gain K_T", "N/°", |s| &s.tvc_gain_npdeg),
    ("TVC rate gain T_T", "s", |s| &s.tvc_lead_s),
    ("TVC dead zone", "°", |s| &s.dead_zone_deg),
];

fn schedules(numbering: &mut Numbering, long: &LongPeriodResults) -> Markup {
    let end_s = long.nominal_history.time_s.last().copied().unwrap_or(0.0);
    let curve = |name: &str, schedule: &ScheduleData, of: fn(&ScheduleData) -> &[f64]| {
        let mut time = schedule.switch_time_s.clone();
        let mut values = of(schedule).to_vec();
        if let Some(&last) = values.last() {
            time.push(end_s);
            values.push(last);
        }
        Series::step(name, &time, &values)
    };
    let mut set = |id: &str, what: &str, own: &ScheduleData, beside: Option<&ScheduleData>| {
        let figures: Vec<Markup> = GAINS
            .iter()
            .enumerate()
            .map(|(n, &(label, unit, of))| {
                let name = if beside.is_some() { "reduced" } else { "" };
                let mut series = vec![curve(name, own, of)];
                series.extend(beside.map(|b| curve("designed", b, of)));
                let chart =
                    LineChart::new("", Axis::new("Time", "s"), Axis::new(label, unit), series)
                        .size(Size::HALF);
                let id = if n == 0 {
                    id.to_owned()
                } else {
                    format!("{id}-{n}")
                };
                numbering.figure(&id, &format!("{label}, {what}."), line_chart(&chart))
            })
            .collect();
        side_by_side(&figures)
    };
    let switchings = |s: &ScheduleData| s.switch_time_s.len().saturating_sub(1);
    let designed = set("figure-7", "designed schedule", &long.designed, None);
    let reduced = set(
        "figure-8",
        "reduced schedule",
        &long.reduced,
        Some(&long.designed),
    );
    html! {
        h3 { "Designed with the short-period models (" (switchings(&long.designed)) " switchings)" }
        (designed)
        h3 { "Reduced by long-period trials (" (switchings(&long.reduced)) " switchings)" }
        (reduced)
    }
}
