//! Gyro stations and margins for people and machines.

use super::{
    flexible::Actuator,
    run::{FilterChoice, LoopMargin, Station, Survey, nominal_station_m, slope_pm},
};
use crate::study::short_period::metrics::worst_of;
use desk::{
    outcome::Outcome,
    report::{
        Cell, Column, Heading, Table,
        plot::{Axis, Draw, LineChart, Series},
    },
};
use vehicle::{Vehicle, beam_shape::MODES};

/// Least damping ratio that a bending mode must keep, that of the shipped design's criteria.
const LEAST_DAMPING: f64 = 0.004;
/// The machine's linear model and the matrix are the same equations: what their results may differ
/// by, relative. Entries up to K_T/τ_T = 3e6 leave 1e-9 1/s and some tens of that of a real part of
/// 0.2 1/s.
const MACHINE_WITHIN: f64 = 1e-5;

const MODE_NAMES: [&str; MODES] = ["first", "second", "third"];

/// What `gyro-location` came to.
pub fn outcome(survey: &Survey, vehicle: &Vehicle) -> Outcome {
    let nominal_m = nominal_station_m(vehicle);
    let mut out = Outcome::new(
        "Gyro location and bending filter",
        "Damping of the bending modes against the station of the rate gyro, and the margins of the bending modes with the loop opened at an actuator. The second and third mode are those of a uniform free-free beam: estimates.",
    );
    out.set("gyro-station-m", nominal_m);
    stations(survey, vehicle, nominal_m, &mut out);
    margins(survey, &mut out);
    filters(survey, vehicle, &mut out);
    checks(survey, &mut out);
    out
}

fn points(survey: &Survey) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for station in &survey.stations {
        if names.last() != Some(&station.point.as_str()) {
            names.push(&station.point);
        }
    }
    names
}

/// The least damping over the modes.
fn least(station: &Station) -> Option<f64> {
    let all = station.damping.iter().copied().collect::<Option<Vec<f64>>>()?;
    all.into_iter().min_by(f64::total_cmp)
}

/// The stations of a point.
fn of<'s>(survey: &'s Survey, name: &'s str) -> impl Iterator<Item = &'s Station> {
    survey.stations.iter().filter(move |s| s.point == name)
}

fn stations(survey: &Survey, vehicle: &Vehicle, nominal_m: f64, out: &mut Outcome) {
    for (mode, words) in MODE_NAMES.into_iter().enumerate() {
        let series = points(survey).into_iter().map(|name| {
            let curve =
                of(survey, name).map(|s| (s.station_m, s.damping[mode].unwrap_or(f64::NAN)));
            Series::of(name, curve)
        });
        let chart = LineChart::new(
            format!("Damping of the {words} bending mode"),
            Axis::new("station of the rate gyro from the nozzle exit", "m"),
            Axis::new("least damping ratio ζ", ""),
            series.collect(),
        );
        let caption = format!(
            "The least damping ratio over what the channels may show: both at work, or either alone. The gyro stands at {nominal_m:.1} m; structural damping is {}.",
            vehicle.data().bending.damping_ratio
        );
        out.section("Damping against the station").chart(
            format!("damping-{words}"),
            caption.as_str(),
            &chart.limit(LEAST_DAMPING, "criterion of the design").limit(0.0, "stability"),
        );
    }
    let mut table = Table::new(
        [
            "Point",
            "Time",
            "First mode",
            "Second mode",
            "Third mode",
            "Stations that keep all modes",
        ]
        .into_iter()
        .zip(["", "s", "", "", "", "m"])
        .map(|(label, unit)| Heading::new(label, unit).digits(3))
        .collect(),
    );
    let mut good: Vec<f64> = survey.stations.iter().map(|s| s.station_m).collect();
    for name in points(survey) {
        let off = |s: &&Station| (s.station_m - nominal_m).abs();
        let Some(here) = of(survey, name).min_by(|a, b| off(a).total_cmp(&off(b))) else {
            continue;
        };
        let kept: Vec<f64> = of(survey, name)
            .filter(|s| least(s).is_some_and(|z| z >= LEAST_DAMPING))
            .map(|s| s.station_m)
            .collect();
        good.retain(|x| kept.contains(x));
        let all: Vec<f64> = of(survey, name).map(|s| s.station_m).collect();
        let dampings = here.damping.map(Cell::from);
        table.row(
            [name.into(), here.time_s.into()]
                .into_iter()
                .chain(dampings)
                .chain([ranges(&kept, &all).into()]),
        );
    }
    good.sort_by(f64::total_cmp);
    good.dedup();
    let mut all: Vec<f64> = survey.stations.iter().map(|s| s.station_m).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    let columns = [
        Column::new("Point", "", |s: &Station| s.point.as_str().into()),
        Column::new("Time", "s", |s| s.time_s.into()),
        Column::new("Station", "m", |s| s.station_m.into()),
        Column::of("First mode", "", 3, |s| s.damping[0].into()),
        Column::of("Second mode", "", 3, |s| s.damping[1].into()),
        Column::of("Third mode", "", 3, |s| s.damping[2].into()),
        Column::of("First, machine", "", 6, |s| s.machine[0].into()),
        Column::of("First, matrix of one mode", "", 6, |s| s.machine[1].into()),
    ];
    let slopes: Vec<String> =
        (0..MODES).map(|mode| format!("{:.3}", slope_pm(vehicle, mode, nominal_m))).collect();
    out.section("Damping against the station")
        .table(
            "stations",
            format!(
                "Damping ratios at the station nearest to {nominal_m:.1} m (slopes there {} 1/m), and where every mode keeps at least {LEAST_DAMPING}.",
                slopes.join(", ")
            ),
            table,
        )
        .words(format!(
            "At every point every mode keeps a damping ratio of {LEAST_DAMPING} with the gyro at {}.",
            ranges(&good, &all)
        ))
        .long_table(
            "damping",
            "Damping ratios at every station, the least over what the channels may show; beside the first mode's with both channels at work, by the machine's linear model and by the matrix of one mode.",
            Table::of(&columns, &survey.stations),
        );
}

/// The runs of `some` within `all`, both ascending: `1.5 to 11 m, 12.5 m`.
fn ranges(some: &[f64], all: &[f64]) -> String {
    let mut runs: Vec<[f64; 2]> = Vec::new();
    let mut before = false;
    for x in all {
        let inside = some.contains(x);
        match (inside, runs.last_mut()) {
            (true, Some(run)) if before => run[1] = *x,
            (true, _) => runs.push([*x, *x]),
            _ => {}
        }
        before = inside;
    }
    if runs.is_empty() {
        return "none".to_owned();
    }
    let words = |[low, high]: &[f64; 2]| {
        if low == high { format!("{low}") } else { format!("{low} to {high}") }
    };
    runs.iter().map(words).collect::<Vec<_>>().join(", ")
}

/// How a mode is kept from growing.
fn stabilised(m: &LoopMargin) -> &'static str {
    match (m.margin.gain_db > 0.0, m.closed_damping) {
        (true, _) => "gain",
        (false, Some(zeta)) if zeta > 0.0 => "phase",
        _ => "not",
    }
}

fn margins(survey: &Survey, out: &mut Outcome) {
    let columns = [
        Column::new("Point", "", |m: &LoopMargin| m.point.as_str().into()),
        Column::of("Time", "s", 3, |m| m.time_s.into()),
        Column::new("Opened at", "", |m| m.actuator.words().into()),
        Column::new("Filter", "", |m| {
            match (m.actuator, m.filtered) {
                (Actuator::Injection, _) => "",
                (_, true) => "in",
                (_, false) => "out",
            }
            .into()
        }),
        Column::new("Mode", "", |m| (m.mode as f64 + 1.0).into()),
        Column::of("Peak at", "rad/s", 4, |m| m.margin.peak_radps.into()),
        Column::of("Gain margin", "dB", 3, |m| m.margin.gain_db.into()),
        Column::of("Phase at the peak", "deg", 3, |m| m.margin.phase_deg.into()),
        Column::of("Phase margin", "deg", 3, |m| m.margin.phase_margin_deg.into()),
        Column::new("Stabilised by", "", |m| stabilised(m).into()),
        Column::of("Damping, closed", "", 3, |m| m.closed_damping.into()),
        Column::of("Phase margin of the attitude", "deg", 3, |m| m.attitude_margin_deg.into()),
    ];
    let first = survey.margins.iter().filter(|m| m.mode == 0);
    out.section("Margins of the bending modes")
        .table("margins-first", "The first mode.", Table::of(&columns, first))
        .long_table(
        "margins",
        "The loop opened at an actuator, the other channel at work. Gain margin: −20 lg of the greatest |L| in the band of the mode. A mode whose |L| stays below 1 is gain-stabilised; one that passes 1 and is damped is phase-stabilised, by the least angle to −1.",
        Table::of(&columns, &survey.margins),
    );
    let series = survey.bode.iter().map(|(name, curve)| Series::of(*name, curve.iter().copied()));
    let chart = LineChart::new(
        "Fin-tip loop at the greatest dynamic pressure, opened at the tips",
        Axis::new("frequency", "rad/s").log(),
        Axis::new("|L|", "dB"),
        series.collect(),
    );
    out.section("Margins of the bending modes").chart(
        "bode",
        "The bending filter takes the modes below 0 dB or leaves them above it; the injection inside its dead zone.",
        &chart.limit(0.0, "|L| = 1"),
    );
}

fn filters(survey: &Survey, vehicle: &Vehicle, out: &mut Outcome) {
    let corner = vehicle.data().bending.filter_corner_radps;
    let curve = |name: &str, of: fn(&FilterChoice) -> f64| {
        Series::of(name, survey.filters.iter().map(|f| (f.corner_radps, of(f))))
            .draw(Draw::LineAndMarkers)
    };
    let chart = |title: &str, y: Axis, series: Vec<Series>| {
        LineChart::new(title, Axis::new("corner of the filter", "rad/s").log(), y, series)
    };
    let gains = chart(
        "Gain margins of the modes",
        Axis::new("least gain margin", "dB"),
        vec![
            curve("first", |f| f.gain_db[0]),
            curve("second", |f| f.gain_db[1]),
            curve("third", |f| f.gain_db[2]),
        ],
    );
    let phase = chart(
        "Phase margin of the attitude",
        Axis::new("least phase margin", "°"),
        vec![curve("attitude", |f| f.attitude_margin_deg)],
    );
    let columns = [
        Column::of("Corner", "rad/s", 3, |f: &FilterChoice| f.corner_radps.into()),
        Column::of("Gain margin, first mode", "dB", 3, |f| f.gain_db[0].into()),
        Column::of("Gain margin, second mode", "dB", 3, |f| f.gain_db[1].into()),
        Column::of("Gain margin, third mode", "dB", 3, |f| f.gain_db[2].into()),
        Column::of("Phase margin, attitude", "deg", 3, |f| f.attitude_margin_deg.into()),
        Column::of("Least damping, first mode", "", 3, |f| f.damping.into()),
    ];
    out.section("The choice of the filter")
        .chart("filter-gain", "What a slower filter gives to the bending modes.", &gains.limit(0.0, "|L| = 1"))
        .chart("filter-phase", "What it takes from the attitude.", &phase)
        .table(
            "filters",
            format!("The least margins of the tips' loop over all points against the corner of the filter, which is {corner} rad/s; the last is as good as none."),
            Table::of(&columns, &survey.filters),
        );
}

fn checks(survey: &Survey, out: &mut Outcome) {
    let worst = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        worst_of(pairs.map(|(a, b)| ((a - b) / b).abs()))
    };
    let dampings = &mut survey.stations.iter().filter_map(|s| Some((s.machine[0]?, s.machine[1]?)));
    let apart = worst(dampings);
    out.check(
        "machine-damping",
        format!("the machine's own linear model of the patch has the damping of the first mode that the matrix has: worst {apart:.1e}"),
        apart < MACHINE_WITHIN,
    );
    let gains = &mut survey.margins.iter().filter_map(|m| m.machine_gain_db).map(|[a, b]| (a, b));
    let apart = worst(gains);
    out.check(
        "machine-margin",
        format!("and, opened at tips and injection, its gain margins: worst {apart:.1e}"),
        apart < MACHINE_WITHIN,
    );
}
