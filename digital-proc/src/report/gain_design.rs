//! Gain schedules as figures (7 and 8 of the paper) and the tables of their design.

use crate::study::gain_design::{
    criteria::{Criteria, LoopQuality},
    design::Design,
    evaluate::PointQuality,
    merge::Trial,
};
use desk::report::{
    Cell, Heading, Numbering, Section, Table,
    plot::{Axis, LineChart, Series, Size, line_chart},
    side_by_side,
};
use maud::{Markup, html};
use vehicle::ScheduleData;

/// The gains of schedules against flight time, each held from switch to switch.
pub fn schedule_charts(schedules: &[(&str, &ScheduleData)], end_s: f64) -> Vec<Markup> {
    type Row = (&'static str, &'static str, fn(&ScheduleData) -> &[f64]);
    let rows: [Row; 5] = [
        ("FTC gain K_F", "° fin/°", |s| &s.ftc_gain),
        ("FTC rate gain T_F", "s", |s| &s.ftc_lead_s),
        ("TVC gain K_T", "kN/°", |s| &s.tvc_gain_npdeg),
        ("TVC rate gain T_T", "s", |s| &s.tvc_lead_s),
        ("TVC dead zone", "°", |s| &s.dead_zone_deg),
    ];
    rows.iter()
        .map(|(label, unit, values)| {
            let factor = if *unit == "kN/°" { 1e-3 } else { 1.0 };
            let series = schedules
                .iter()
                .map(|(name, schedule)| {
                    let mut x = schedule.switch_time_s.clone();
                    let mut y: Vec<f64> = values(schedule).iter().map(|v| v * factor).collect();
                    x.push(end_s);
                    y.extend(y.last().copied());
                    Series::step(*name, &x, &y)
                })
                .collect();
            line_chart(&LineChart {
                size: Size::HALF,
                ..LineChart::new(
                    *label,
                    Axis::new("Flight time", "s"),
                    Axis::new(*label, *unit),
                    series,
                )
            })
        })
        .collect()
}

fn number(value: Option<f64>) -> Cell {
    value.map_or_else(|| Cell::Text("diverged".into()), Cell::Number)
}

fn quality_headings() -> [Heading; 8] {
    [
        Heading::new("Overshoot", "%").digits(3),
        Heading::new("Settling", "s").digits(3),
        Heading::new("Residual", "%").digits(3),
        Heading::new("Error", "%").digits(3),
        Heading::new("Bending left", "%").digits(3),
        Heading::new("Least bending damping", "").digits(2),
        Heading::new("Gain margin", "dB").digits(2),
        Heading::new("TVC use", "%").digits(3),
    ]
}

fn quality_cells(q: &LoopQuality) -> [Cell; 8] {
    let percent = |v: Option<f64>| number(v.map(|v| 100.0 * v));
    [
        percent(q.overshoot),
        number(q.settling_s),
        percent(q.residual),
        percent(q.error),
        percent(q.bending_decay),
        q.bending_damping.into(),
        q.gain_margin_db.into(),
        (100.0 * q.tvc_use).into(),
    ]
}

/// How each interval's gains came out, a row an end of the interval.
pub fn design_table(design: &Design) -> Table {
    let mut headings = vec![
        Heading::new("Interval from", "s"),
        Heading::new("judged at", "s"),
        Heading::new("Cost at start", "").digits(3),
        Heading::new("designed", "").digits(3),
    ];
    headings.extend(quality_headings());
    headings.push(Heading::new("Criteria", ""));
    let mut table = Table::new(headings);
    for (i, interval) in design.intervals.iter().enumerate() {
        for (place, quality) in interval.judged_s.iter().zip(&interval.quality) {
            let met = if design.criteria.met(quality) { "met" } else { "not met" };
            let start: [Cell; 4] = [
                design.schedule.switch_time_s[i].into(),
                (*place).into(),
                interval.first_cost.into(),
                interval.cost.into(),
            ];
            table.row(start.into_iter().chain(quality_cells(quality)).chain([met.into()]));
        }
    }
    table
}

/// The criteria of a design.
pub fn criteria_table(criteria: &Criteria) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Criterion", ""),
        Heading::new("at most", "").digits(3),
        Heading::new("Unit", ""),
    ]);
    for (name, value, unit) in [
        ("overshoot, undisturbed 2° step", 100.0 * criteria.overshoot, "%"),
        ("settling to 5 %, undisturbed", criteria.settling_s, "s"),
        ("residual oscillation 5–10 s, misalignment and gust", 100.0 * criteria.residual, "%"),
        ("attitude error from 2 s on, misalignment and gust", 100.0 * criteria.error, "%"),
        (
            "bending envelope at 5–6.5 s over that after the step",
            100.0 * criteria.bending_decay,
            "%",
        ),
        ("mean TVC force over its maximum", 100.0 * criteria.tvc_use, "%"),
        ("bending damping ratio, linearised loop (at least)", criteria.bending_damping, ""),
        ("gain margin, linearised loop (at least)", criteria.gain_margin_db, "dB"),
    ] {
        table.row([name.into(), value.into(), unit.into()]);
    }
    table
}

/// A schedule judged point by point.
pub fn evaluation_table(points: &[PointQuality]) -> Table {
    let mut headings = vec![Heading::new("Point", ""), Heading::new("Time", "s")];
    headings.extend(quality_headings());
    headings.push(Heading::new("P1", ""));
    let mut table = Table::new(headings);
    for point in points {
        let accepted = if point.accepted() { "accepted" } else { "exceeded" };
        let start: [Cell; 2] = [point.point.as_str().into(), point.time_s.into()];
        table.row(start.into_iter().chain(quality_cells(&point.quality)).chain([accepted.into()]));
    }
    table
}

/// The mergers with their flights and their re-evaluation.
pub fn merging_table(levels: &[(&Trial, &[PointQuality])]) -> Table {
    let mut table = Table::new(vec![
        Heading::new("Switchings", "").digits(2),
        Heading::new("Switch times", "s"),
        Heading::new("Largest Qα", "kPa·°"),
        Heading::new("Burn-out departure over accepted", "").digits(3),
        Heading::new("Largest overshoot", "%").digits(3),
        Heading::new("at", ""),
        Heading::new("Short period", ""),
    ]);
    for (trial, points) in levels {
        let worst = crate::study::gain_design::evaluate::worst(points);
        let exceeded = points.iter().filter(|p| !p.accepted()).count();
        let times: Vec<String> =
            trial.schedule.switch_time_s[1..].iter().map(f64::to_string).collect();
        table.row([
            (times.len() as f64).into(),
            times.join(", ").into(),
            (trial.max_q_alpha_padeg / 1e3).into(),
            trial.severity.into(),
            number(worst.and_then(|w| w.quality.overshoot).map(|v| 100.0 * v)),
            worst.map_or("", |w| w.point.as_str()).into(),
            if exceeded == 0 {
                "accepted at all points".into()
            } else {
                format!("exceeded at {exceeded} of {} points", points.len()).into()
            },
        ]);
    }
    table
}

/// The sections of the design's page.
pub fn gain_design_sections(
    design: &Design,
    levels: &[(&Trial, &[PointQuality])],
    shipped: (&ScheduleData, &ScheduleData),
    shipped_reduced: &[PointQuality],
    end_s: f64,
    none_accepted: Option<&str>,
) -> Vec<Section> {
    let mut numbering = Numbering::new();
    let designed = side_by_side(&schedule_charts(
        &[("designed here", &design.schedule), ("shipped", shipped.0)],
        end_s,
    ));
    let fewest = levels.last().map(|(trial, _)| &trial.schedule);
    let mut reduced = vec![("shipped", shipped.1)];
    if let Some(fewest) = fewest {
        reduced.insert(0, ("merged here", fewest));
    }
    let reduced = side_by_side(&schedule_charts(&reduced, end_s));
    vec![
        Section::new(
            "Criteria",
            numbering.table(
                "criteria",
                "Allowances of the design. The cost of a loop is the sum of measures over allowances, and ten times what exceeds one.",
                criteria_table(&design.criteria).markup(),
            ),
        ),
        Section::new(
            "Designed schedule",
            html! {
                (numbering.figure("designed", "Gain schedules designed from the short-period model (after the paper's figure 7).", designed))
                (numbering.table("design", "Designed gains at both ends of each interval.", design_table(design).markup()))
            },
        ),
        Section::new(
            "Fewer switchings",
            html! {
                @for line in none_accepted.into_iter().flat_map(str::lines) { p { (line) } }
                (numbering.figure("reduced", "Schedules with fewer switchings, from long-period flights (after the paper's figure 8).", reduced))
                (numbering.table("merging", "Mergers accepted by long-period flights, and what the short-period model says of them.", merging_table(levels).markup()))
            },
        ),
        Section::new(
            "Re-evaluation of the shipped reduced schedule",
            numbering.table(
                "reduced-points",
                "The shipped schedule with fewer switchings at the trajectory points; accepted are 25 % overshoot and 5 % residual.",
                evaluation_table(shipped_reduced).markup(),
            ),
        ),
    ]
}
