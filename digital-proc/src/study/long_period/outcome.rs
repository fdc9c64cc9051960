//! The long-period study for people and machines: tables of its flights, figures 6 to 8 of the
//! paper, the monitored variables against time.

use super::{
    claims::{DEPARTURES, FIGURE_8, LOADS, MODES, Q_ALPHA, judge},
    moment,
    results::{Departure, Flown, LongPeriodResults, ModeResult},
};
use crate::{
    report::impact::{IMPACT_CAPTION, impact_chart},
    study::gain_design::schedule::charts,
};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Column, Heading, Table, definition_list,
        plot::{Axis, LineChart, Series, Size, line_chart},
    },
    run_dir::{Curves, TRACE_FILE},
};
use interface::Tick;
use vehicle::{
    flight_summary::{FlightSample, FlightSummary},
    range_safety::GroundPoint,
};

/// Curves that one chart can carry before they hide each other.
const MOST_CURVES: usize = 6;

/// What `long-period` came to; `step` is that of the trajectory.
pub fn outcome(results: &LongPeriodResults, step: Tick) -> Outcome {
    let mut out = Outcome::new(
        "Long-period study",
        "Modes of operation flown to burn-out: control dynamics on the analog processor, trajectory on the digital one.",
    );
    fill(results, step, &mut out);
    out
}

/// Adds figures, tables and claims.
pub fn fill(results: &LongPeriodResults, step: Tick, out: &mut Outcome) {
    variables(results, out);
    let modes: Vec<(String, String)> =
        results.modes.iter().map(|m| (m.name.clone(), m.text.clone())).collect();
    out.section("Flights and side-force fuel")
        .markup(definition_list(&modes))
        .table(
            MODES.anchor(),
            "Departure of each mode's burn-out from that of the sound vehicle in the same wind and under the same misalignments, its load and its fluid; design case.",
            mode_table(results),
        )
        .table(
            DEPARTURES.anchor(),
            "Departure of burn-out from that of the sound vehicle in the same wind and under the same misalignments: the largest of its parts (velocity, path angle, altitude, range) over what is accepted, by wind and pitch misalignment, the latter in fractions of 3σ.",
            by_flight(results, ModeResult::all_flights, "of what is accepted", |f| {
                results.departure(f).map(|d| d.severity(&results.accept))
            }),
        )
        .table(
            LOADS.anchor(),
            "Largest Qα over wind and pitch misalignment, the latter in fractions of 3σ.",
            by_flight(results, ModeResult::flights, "kPa·°", |f| {
                Some(f.ended.as_ref().ok()?.max_q_alpha.value / 1e3)
            }),
        )
        .table(
            "fuel",
            "Side-force fluid over wind and pitch misalignment, the latter in fractions of 3σ.",
            by_flight(results, ModeResult::flights, "kg", |f| {
                Some(f.ended.as_ref().ok()?.injectant_kg)
            }),
        )
        .long_table("flights", "Every flight at burn-out.", flight_table(results));
    moment::fill(results, out);
    range_safety(results, out);
    schedules(results, out);
    let undisturbed_kg = results.nominal.injectant_kg;
    let label = "Side-force fluid, undisturbed";
    out.results.add("fluid_undisturbed_kg", label, undisturbed_kg, 3, "kg", "");
    for (mode, flown) in results.modes.iter().flat_map(|m| m.all_flights().map(move |f| (m, f))) {
        if let Err(lost) = &flown.ended {
            out.remarks.push(format!(
                "{} ({}, misalignment {:+} × 3σ in pitch) was lost: {lost}",
                mode.name,
                flown.wind.words(),
                flown.misalignment[0]
            ));
        }
    }
    out.claims.extend(judge(results));
    out.traces.push((TRACE_FILE, curves(results, step)));
}

/// Lateral trajectory and impact point of every mode's design case.
fn range_safety(results: &LongPeriodResults, out: &mut Outcome) {
    fn flight(mode: &ModeResult, of: fn(&FlightSummary) -> f64) -> Cell {
        mode.design.ended.as_ref().ok().map(of).into()
    }
    fn if_ever(mode: &ModeResult, of: fn(&FlightSummary) -> Option<f64>) -> Cell {
        mode.design.ended.as_ref().ok().and_then(of).into()
    }
    let columns: [Column<ModeResult>; 8] = [
        Column::new("Mode", "", |m| m.name.as_str().into()),
        Column::of("Cross-range", "m", 4, |m| flight(m, |f| f.cross_range_m)),
        Column::of("Azimuth off by", "°", 3, |m| {
            if_ever(m, |f| f.end.azimuth_departure_rad().map(f64::to_degrees))
        }),
        Column::new("Impact point down the track", "km", |m| {
            if_ever(m, |f| f.impact.map(|i| i.downrange_m / 1e3))
        }),
        Column::of("across it", "km", 3, |m| if_ever(m, |f| f.impact.map(|i| i.cross_m / 1e3))),
        Column::of("Corridor used", "%", 3, |m| flight(m, |f| 100.0 * f.corridor_used)),
        Column::of("Corridor left at", "s", 4, |m| if_ever(m, |f| f.corridor_left_s)),
        Column::of("Control lost at", "s", 4, |m| if_ever(m, |f| f.control_lost_s)),
    ];
    let tracks: Vec<(&str, [Vec<f64>; 2])> = shown(results)
        .into_iter()
        .map(|mode| {
            let track = |of: fn(&GroundPoint) -> f64| {
                mode.history.iter().map(|s| s.impact.as_ref().map_or(f64::NAN, of)).collect()
            };
            (mode.name.as_str(), [track(|i| i.downrange_m), track(|i| i.cross_m)])
        })
        .collect();
    let safety = &results.range_safety;
    out.section("Range safety")
        .words(format!(
            "The corridor of the impact point: {:.1} km either side at the launch point, opening by {}° a side, closed {:.1} km behind it; control is lost where the nose is {}° from its command. Design case; starboard positive.",
            safety.half_width_m / 1e3,
            safety.opening_deg,
            safety.behind_m / 1e3,
            safety.control_lost_deg
        ))
        .figure(Figure::new("impact", IMPACT_CAPTION, line_chart(&impact_chart(&tracks, safety))))
        .table(
            "range_safety",
            "Lateral trajectory at burn-out, and the impact point of every mode; 100 % of its corridor is the edge.",
            Table::of(&columns, &results.modes),
        );
}

/// A mode with what it is held against.
type Row<'a> = (&'a ModeResult, &'a LongPeriodResults);

/// Burn-out, load and fuel of every mode in the design case.
fn mode_table(results: &LongPeriodResults) -> Table {
    fn flight(row: &Row<'_>, of: fn(&FlightSummary) -> f64) -> Cell {
        row.0.design.ended.as_ref().ok().map(of).into()
    }
    fn departure(row: &Row<'_>, of: fn(&Departure) -> f64) -> Cell {
        row.1.departure(&row.0.design).as_ref().map(of).into()
    }
    let columns: [Column<Row<'_>>; 11] = [
        Column::new("Mode", "", |r| r.0.name.as_str().into()),
        Column::of("ΔV", "%", 3, |r| departure(r, |d| 100.0 * d.speed_fraction)),
        Column::of("Δγ", "°", 3, |r| departure(r, |d| d.path_angle_deg)),
        Column::of("Δh", "%", 3, |r| departure(r, |d| 100.0 * d.altitude_fraction)),
        Column::of("Δrange", "km", 3, |r| departure(r, |d| d.range_km)),
        Column::new("Max Qα", "kPa·°", |r| flight(r, |f| f.max_q_alpha.value / 1e3)),
        Column::of("at", "s", 3, |r| flight(r, |f| f.max_q_alpha.time_s)),
        Column::of("of the limit", "%", 3, |r: &Row<'_>| {
            let flight = r.0.design.ended.as_ref().ok();
            flight.map(|f| 100.0 * f.max_q_alpha.value / r.1.accept.q_alpha_padeg).into()
        }),
        Column::new("Total", "kPa·°", |r| flight(r, |f| f.max_total_q_alpha.value / 1e3)),
        Column::of("Max roll", "°", 3, |r| flight(r, |f| f.max_roll_rad.to_degrees())),
        Column::of("Injectant", "kg", 3, |r| flight(r, |f| f.injectant_kg)),
    ];
    let rows: Vec<Row<'_>> = results.modes.iter().map(|m| (m, results)).collect();
    Table::of(&columns, &rows)
}

/// A number of every mode over winds and misalignments.
fn by_flight<'a, F: Iterator<Item = &'a Flown>>(
    results: &'a LongPeriodResults,
    flights: impl Fn(&'a ModeResult) -> F,
    unit: &str,
    of: impl Fn(&Flown) -> Option<f64>,
) -> Table {
    let mut headings = vec![Heading::new("Mode", "")];
    if let Some(first) = results.modes.first() {
        headings.extend(flights(first).map(|f| {
            let wind = f.wind.words().trim_end_matches(" wind");
            Heading::new(format!("{wind} {:+}", f.misalignment[0]), unit).digits(3)
        }));
    }
    let mut table = Table::new(headings);
    for mode in &results.modes {
        let cells = flights(mode).map(|flown| of(flown).map_or("lost".into(), Cell::Number));
        table.row(std::iter::once(Cell::from(mode.name.as_str())).chain(cells));
    }
    table
}

/// Every flight with all that it came to.
fn flight_table(results: &LongPeriodResults) -> Table {
    type Row<'a> = (&'a ModeResult, &'a Flown);
    fn flight(row: &Row<'_>, of: fn(&FlightSummary) -> f64) -> Cell {
        row.1.ended.as_ref().ok().map(of).into()
    }
    let columns: [Column<Row<'_>>; 22] = [
        Column::new("Mode", "", |r| r.0.name.as_str().into()),
        Column::new("Wind", "", |r| r.1.wind.words().into()),
        Column::of("Misalignment in pitch", "3σ", 2, |r: &Row<'_>| r.1.misalignment[0].into()),
        Column::of("in yaw", "3σ", 2, |r: &Row<'_>| r.1.misalignment[1].into()),
        Column::new("Velocity", "m/s", |r| flight(r, |f| f.end.speed_mps)),
        Column::new("Path angle", "deg", |r| flight(r, |f| f.end.path_angle_rad.to_degrees())),
        Column::new("Altitude", "m", |r| flight(r, |f| f.end.altitude_m)),
        Column::new("Range", "m", |r| flight(r, |f| f.range_m)),
        Column::of("Cross-range", "m", 4, |r| flight(r, |f| f.cross_range_m)),
        Column::of("Azimuth off by", "deg", 3, |r| {
            let end = r.1.ended.as_ref().ok().map(|f| f.end);
            end.and_then(|e| e.azimuth_departure_rad()).map(f64::to_degrees).into()
        }),
        Column::of("Corridor used", "%", 3, |r| flight(r, |f| 100.0 * f.corridor_used)),
        Column::new("Max Qα", "Pa deg", |r| flight(r, |f| f.max_q_alpha.value)),
        Column::new("Max Qα at", "s", |r| flight(r, |f| f.max_q_alpha.time_s)),
        Column::new("Max Qα at Mach", "", |r| flight(r, |f| f.max_q_alpha.mach)),
        Column::new("Max total Qα", "Pa deg", |r| flight(r, |f| f.max_total_q_alpha.value)),
        Column::new("Max Q", "Pa", |r| flight(r, |f| f.max_dynamic_pressure.value)),
        Column::new("Max roll", "deg", |r| flight(r, |f| f.max_roll_rad.to_degrees())),
        Column::new("TVC impulse in pitch", "N s", |r| flight(r, |f| f.tvc_pitch_impulse_ns)),
        Column::new("TVC impulse in yaw", "N s", |r| flight(r, |f| f.tvc_yaw_impulse_ns)),
        Column::new("Injectant", "kg", |r| flight(r, |f| f.injectant_kg)),
        Column::new("Table edge", "", |r| {
            let left = r.1.ended.as_ref().is_ok_and(|f| !f.edges.is_empty());
            if left { "left" } else { "" }.into()
        }),
        Column::new("Lost", "", |r| r.1.ended.as_ref().err().map_or("", |l| l.as_str()).into()),
    ];
    let rows: Vec<Row<'_>> =
        results.modes.iter().flat_map(|m| m.all_flights().map(move |f| (m, f))).collect();
    Table::of(&columns, &rows)
}

/// One of the monitored variables: what a trace and what a figure call it, and where it lies.
struct Variable {
    /// Column of a trace, and its unit.
    column: [&'static str; 2],
    /// Anchor of its figure.
    anchor: &'static str,
    label: &'static str,
    unit: &'static str,
    of: fn(&FlightSample) -> f64,
}

/// The paper's ten variables, pitch and roll being the two of its (ix); the load with the yaw
/// incidence, and the way across.
const VARIABLES: [Variable; 14] = [
    variable(["velocity_m_s", "m/s"], ["velocity", "Inertial velocity", "m/s"], |s| {
        s.trajectory.speed_mps
    }),
    variable(
        ["flight_path_angle_deg", "deg"],
        ["path-angle", "Inertial flight-path angle", "°"],
        |s| s.trajectory.path_angle_rad.to_degrees(),
    ),
    variable(["altitude_km", "km"], ["altitude", "Altitude", "km"], |s| {
        s.trajectory.altitude_m / 1e3
    }),
    variable(["range_angle_deg", "deg"], ["range-angle", "Range angle", "°"], |s| {
        s.trajectory.range_angle_rad.to_degrees()
    }),
    variable(["alpha_deg", "deg"], ["alpha", "Pitch angle of attack", "°"], |s| {
        s.incidence_rad.to_degrees()
    }),
    variable(["mach", ""], ["mach", "Mach number", ""], |s| s.mach),
    variable(["dynamic_pressure_kpa", "kPa"], ["q", "Dynamic pressure", "kPa"], |s| {
        s.dynamic_pressure_pa / 1e3
    }),
    variable(
        ["q_alpha_kpa_deg", "kPa deg"],
        [Q_ALPHA.anchor(), "Load indicator Qα", "kPa·°"],
        |s| s.q_alpha_padeg() / 1e3,
    ),
    variable(
        ["q_alpha_total_kpa_deg", "kPa deg"],
        ["q-alpha-total", "Total Q√(α² + α_y²)", "kPa·°"],
        |s| s.total_q_alpha_padeg() / 1e3,
    ),
    variable(["cross_range_m", "m"], ["cross-range", "Distance from the launch plane", "m"], |s| {
        s.trajectory.cross_m
    }),
    variable(
        ["azimuth_departure_deg", "deg"],
        ["azimuth", "Azimuth off that of the launch", "°"],
        |s| s.trajectory.azimuth_departure_rad().map_or(f64::NAN, f64::to_degrees),
    ),
    variable(["theta_deg", "deg"], ["pitch", "Pitch angle", "°"], |s| s.angle_rad[0].to_degrees()),
    variable(["phi_deg", "deg"], ["roll", "Roll angle", "°"], |s| s.angle_rad[2].to_degrees()),
    variable(["tvc_pitch_force_kn", "kN"], ["tvc", "TVC force, pitch loop", "kN"], |s| {
        s.tvc_n[0] / 1e3
    }),
];

const fn variable(
    column: [&'static str; 2],
    [anchor, label, unit]: [&'static str; 3],
    of: fn(&FlightSample) -> f64,
) -> Variable {
    Variable { column, anchor, label, unit, of }
}

/// The variables of every mode, columns named by mode and variable.
fn curves(results: &LongPeriodResults, step: Tick) -> Curves {
    let flights = std::iter::once(("undisturbed", &results.nominal_history))
        .chain(results.modes.iter().map(|m| (m.name.as_str(), &m.history)));
    let mut curves = Curves::new(step);
    // The last sample stands at burn-out, which need not be a multiple of the step.
    let end = results.nominal_history.last().and_then(|s| Tick::from_secs(s.time_s));
    curves.end = end.unwrap_or(curves.end);
    for (flight, history) in flights {
        for Variable { column: [name, unit], of, .. } in VARIABLES {
            let values: Vec<f64> = history.iter().map(of).collect();
            curves.add(format!("{flight}.{name}"), unit, &values);
        }
    }
    curves
}

/// The modes whose curves are drawn. Of more than a chart can carry, the single variants go first.
fn shown(results: &LongPeriodResults) -> Vec<&ModeResult> {
    let mut shown: Vec<&ModeResult> =
        results.modes.iter().filter(|m| !m.history.is_empty()).collect();
    if shown.len() > MOST_CURVES {
        shown.retain(|m| !m.text.contains("alone"));
        shown.truncate(MOST_CURVES);
    }
    shown
}

/// The variables of the modes that were flown (after the paper's figure 6).
fn variables(results: &LongPeriodResults, out: &mut Outcome) {
    let shown = shown(results);
    let limit = results.accept.q_alpha_padeg / 1e3;
    let figure = |v: &Variable| {
        let curve = |mode: &&ModeResult| {
            let time: Vec<f64> = mode.history.iter().map(|s| s.time_s).collect();
            let values: Vec<f64> = mode.history.iter().map(v.of).collect();
            Series::line(mode.name.as_str(), &time, &values)
        };
        let series = shown.iter().map(curve).collect();
        let axes = (Axis::new("Flight time", "s"), Axis::new(v.label, v.unit));
        let chart = LineChart::new(v.label, axes.0, axes.1, series);
        let (caption, chart) = if v.anchor == Q_ALPHA.anchor() {
            (
                "Load indicator Qα of the modes in the design case against its design limit, judged from the take-over of the fin tips on.".to_owned(),
                chart.size(Size::FULL).limit(limit, "design limit").limit(-limit, "design limit"),
            )
        } else {
            let caption = format!(
                "{} against time, all modes in the design case (after the paper's figure 6).",
                v.label
            );
            (caption, chart.size(Size::HALF))
        };
        Figure::new(v.anchor, caption, line_chart(&chart))
    };
    let (load, others): (Vec<_>, Vec<_>) =
        VARIABLES.iter().partition(|v| v.anchor == Q_ALPHA.anchor());
    let mut section = out
        .section("Trajectories (figure 6 of the paper)")
        .aside("The modes of operation in the design wind with nominal misalignments.");
    for variable in load {
        section = section.figure(figure(variable));
    }
    section.beside(others.into_iter().map(figure).collect());
}

/// The paper's figures 7 and 8: the schedule as designed, and with fewer switchings.
fn schedules(results: &LongPeriodResults, out: &mut Outcome) {
    let end_s = results.nominal.end_time_s;
    let (designed, reduced) = (&results.designed, &results.reduced);
    out.section("Gain schedules (figures 7 and 8 of the paper)")
        .figure(Figure::new(
            "figure-7",
            format!(
                "The designed gain schedules, {} switchings (after the paper's figure 7).",
                designed.switch_time_s.len().saturating_sub(1)
            ),
            charts(&[("designed", designed)], end_s),
        ))
        .figure(Figure::new(
            FIGURE_8.anchor(),
            format!(
                "The gain schedules reduced by long-period trials to {} switchings, beside the designed ones (after the paper's figure 8).",
                reduced.switch_time_s.len().saturating_sub(1)
            ),
            charts(&[("reduced", reduced), ("designed", designed)], end_s),
        ));
}
