//! The short period in the case study: the paper's figures 4 and 5, the conditions against the
//! trajectory points, the worst responses.

use super::{
    claims::{
        BENDING, BENDING_GROWTH, BENDING_MIDDLE, FIGURE_4, FIGURE_5, FTC_GAIN_LOST, NORMAL,
        OSCILLATORY, OVERSHOOT_P1, OVERSHOOTS, RESIDUALS, TVC_FAST, TVC_SLOW, judge,
    },
    control_loop::{ControlLoop, Offset, Response, Test},
    measure::{Measures, YAW_BAND},
    moment,
    outcome::{agreement, curves, figures, place, remarks, runs},
    results::{Results, Run},
};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        anchor,
        format::with_unit,
        plot::{HeatCell, HeatMap, heat_map},
    },
};
use maud::html;

/// Cells of the matrix that get a figure of their own.
const WORST: usize = 10;
/// Attitude and bending coordinate, where two figures suffice.
const PAIR: [&str; 2] = ["pitch_attitude", "bending"];
/// Where the larger yaw offset differs.
const LARGE_YAW: [&str; 4] = ["yaw_attitude", "roll_attitude", "tip2_deflection", "tvc_yaw_force"];
/// Trace of every run.
const TRACE: &str = "short-period.arrow";

/// Adds figures, tables and claims.
pub fn fill(results: &Results, out: &mut Outcome) {
    figure_4(results, out);
    figure_5(results, out);
    let worst = worst(results);
    matrices(results, &worst, out);
    for control_loop in ControlLoop::ALL {
        let (name, caption, table) = runs(control_loop, results);
        out.section("Conditions and trajectory points").long_table(name, caption, table);
    }
    worst_responses(results, &worst, out);
    moment::outcome::fill(results, out);
    agreement(results, out);
    remarks(results, out);
    out.claims.extend(judge(results));
    out.traces.push((TRACE, curves(results)));
}

/// The pitch responses at a point under some conditions, named by their titles.
fn named<'a>(
    results: &'a Results,
    point: usize,
    conditions: &[&str],
) -> Vec<(String, &'a Response)> {
    let of = |name: &&str| {
        let run = results.at(point, name, Test::Disturbed)?;
        Some((title(results, run.case.condition), &run.response))
    };
    conditions.iter().filter_map(of).collect()
}

fn title(results: &Results, condition: usize) -> String {
    results.plan.conditions[condition].title().to_owned()
}

/// The point at which both failures ring most (the less of them counts), among those that also
/// have a normal run.
fn most_telling_point(results: &Results) -> Option<usize> {
    let residual = |point, condition| {
        let run = results.at(point, condition, Test::Disturbed)?;
        Some(run.measures.residual.unwrap_or(f64::INFINITY))
    };
    let least = |run: &Run| {
        let point = run.case.point;
        Some((point, residual(point, FTC_GAIN_LOST)?.min(residual(point, TVC_SLOW)?)))
    };
    results
        .under(NORMAL, Test::Disturbed)
        .filter_map(least)
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(point, _)| point)
}

fn figure_4(results: &Results, out: &mut Outcome) {
    let Some(point) = most_telling_point(results) else { return };
    let runs = named(results, point, &[NORMAL, FTC_GAIN_LOST, TVC_SLOW]);
    let (at, step) = (place(results, point), results.plan.step_rad.to_degrees());
    let drawn = ControlLoop::Pitch.drawn();
    let section = out
        .section("Pitch loop (figure 4 of the paper)")
        .aside(format!(
            "Step command of {step:.1}° in pitch with thrust misalignment and a step gust at t = 0, at {at}: the normal mode, the fin-tip gain all but lost, and the thrust-vector pole slowed. It is the point at which both failures ring most."
        ))
        .beside(figures(FIGURE_4.anchor(), &format!("at {at}"), &runs, drawn, None));
    // The point without tips at which the fast actuator lets the bending coordinate grow most.
    let growth = results
        .under(TVC_FAST, Test::Disturbed)
        .filter(|r| r.case.settings.plane.ftc_gain == 0.0)
        .filter_map(|r| Some((r.case.point, r.measures.bending_ratio(2)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((point, _)) = growth {
        let runs = named(results, point, &[NORMAL, TVC_FAST]);
        let at = format!("at {}", place(results, point));
        section
            .markup(html! { h3 { "The other reading of the slow actuator" } })
            .aside("Read literally, a thrust-vector time constant reduced to a low value excites the bending mode, whose coordinate then grows instead of attenuating.")
            .beside(figures(BENDING_GROWTH.anchor(), &at, &runs, &PAIR, None));
    }
}

/// The yaw offset within the tips' authority, and the larger one.
fn figure_5(results: &Results, out: &mut Outcome) {
    let of = |point, offset| {
        [Test::Shared(offset), Test::Dedicated(offset)].map(|test| results.at(point, NORMAL, test))
    };
    let has_both = |point: &usize| of(*point, Offset::Both).iter().all(Option::is_some);
    let point = most_telling_point(results)
        .filter(has_both)
        .or_else(|| (0..results.plan.points.len()).find(has_both))
        .or_else(|| results.of(ControlLoop::YawRoll).next().map(|r| r.case.point));
    let Some(point) = point else { return };
    let runs_of = |offset| -> Vec<&Run> { of(point, offset).into_iter().flatten().collect() };
    let mut small = runs_of(Offset::Both);
    // What roll does is seen beside the run without it.
    small.extend(results.at(point, NORMAL, Test::Shared(Offset::YawAlone)));
    let travel = small.first().map(|run| run.case.settings.plane.tip_travel);
    let at = place(results, point);
    let drawn = |id: &str, what: &str, runs: &[&Run], channels| {
        let of = |run: &&'_ Run| format!("tips {}", run.case.test.words());
        let named: Vec<_> = runs.iter().map(|run| (of(run), &run.response)).collect();
        figures(id, &format!("{what} at {at}"), &named, channels, travel)
    };
    let yaw_deg = results.plan.yaw_rad.to_degrees();
    let section = out
        .section("Yaw and roll loops (figure 5 of the paper)")
        .aside(format!(
            "Initial offsets in yaw and roll with fin cant, thrust misalignment and a step gust, at {at}: the loops coupled by the shared tips (sum to one tip, difference to the other), and decoupled (tips for roll, thrust vector for yaw). The yaw offset of {yaw_deg}° lies within what the tips can do by themselves: without the roll offset (yaw alone) the thrust vector is not called."
        ))
        .beside(drawn(FIGURE_5.anchor(), "from both offsets", &small, ControlLoop::YawRoll.drawn()));
    let large = runs_of(Offset::LargeYaw);
    if !large.is_empty() {
        section.markup(html! { h3 { "A yaw offset beyond the tips' authority" } }).beside(drawn(
            "figure-5-large",
            "from a large yaw offset",
            &large,
            &LARGE_YAW,
        ));
    }
}

/// The disturbed pitch runs with the largest residual oscillation, normal ones apart.
fn worst(results: &Results) -> Vec<&Run> {
    let residual = |r: &Run| r.measures.residual.unwrap_or(f64::INFINITY);
    let mut runs: Vec<&Run> = results
        .runs
        .iter()
        .filter(|r| r.case.test == Test::Disturbed && r.condition != NORMAL)
        .collect();
    runs.sort_by(|a, b| residual(b).total_cmp(&residual(a)));
    runs.truncate(WORST);
    runs
}

fn response_id(run: &Run) -> String {
    format!("response-{}", anchor(&format!("{} {}", run.condition, run.point)))
}

fn worst_responses(results: &Results, worst: &[&Run], out: &mut Outcome) {
    if worst.is_empty() {
        return;
    }
    let mut section = out.section("Worst responses").aside(format!(
        "The {} cells of the matrix with the largest residual oscillation, each beside the normal mode at its point.",
        worst.len()
    ));
    for run in worst {
        let name = format!("{} at {}", run.condition, place(results, run.case.point));
        let residual = 100.0 * run.measures.residual.unwrap_or(f64::INFINITY);
        let runs = named(results, run.case.point, &[NORMAL, &run.condition]);
        section = section
            .markup(html! { h3 { (name) ": residual " (with_unit(residual, 3, "%")) } })
            .beside(figures(&response_id(run), &name, &runs, &PAIR, None));
    }
}

/// One measure over all conditions and points.
struct Matrix {
    id: &'static str,
    caption: &'static str,
    /// With unit and criterion.
    quantity: String,
    test: Test,
    of: fn(&Measures) -> Option<f64>,
    /// Above this a cell is marked.
    limit: f64,
    /// Value of the deepest tint.
    deepest: f64,
}

fn matrices(results: &Results, worst: &[&Run], out: &mut Outcome) {
    let duration_s = results.plan.duration_s;
    let [oscillatory, overshot, bent] =
        [OSCILLATORY, OVERSHOOT_P1, BENDING_MIDDLE].map(|fraction| 100.0 * fraction);
    let matrices = [
        Matrix {
            id: RESIDUALS.anchor(),
            caption: "Residual oscillation of θ in the disturbed pitch runs; the worst cells lead to their responses.",
            quantity: format!(
                "Peak-to-peak θ from 5 to 10 s without its parabolic trend, % of the step; outside from {oscillatory:.0} % on"
            ),
            test: Test::Disturbed,
            of: |m| m.residual.map(|v| 100.0 * v),
            limit: oscillatory,
            deepest: 100.0,
        },
        Matrix {
            id: OVERSHOOTS.anchor(),
            caption: "Overshoot of θ in the pitch runs without disturbances.",
            quantity: format!("Overshoot, % of the step; outside above {overshot:.0} %"),
            test: Test::StepOnly,
            of: |m| m.overshoot.map(|v| 100.0 * v),
            limit: overshot,
            deepest: 50.0,
        },
        Matrix {
            id: BENDING.anchor(),
            caption: "Decay of the first bending coordinate in the disturbed pitch runs.",
            quantity: format!(
                "Bending envelope from 5 to 6.5 s over that of the first 2 s, %; outside above {bent:.0} %"
            ),
            test: Test::Disturbed,
            of: |m| m.bending_ratio(1).map(|v| 100.0 * v),
            limit: bent,
            deepest: 100.0,
        },
        Matrix {
            id: "matrix-yaw",
            caption: "Yaw settling with shared tips.",
            quantity: format!(
                "Time to stay within {:.2}° of the final yaw, s; a dash did not settle within {duration_s} s",
                YAW_BAND * results.plan.yaw_rad.to_degrees()
            ),
            test: Test::Shared(Offset::Both),
            of: |m| m.settling_s,
            limit: duration_s,
            deepest: duration_s,
        },
    ];
    for matrix in matrices {
        let figure = matrix.figure(results, worst);
        out.section("Conditions and trajectory points").figure(figure);
    }
}

impl Matrix {
    /// Conditions without such a run are left out.
    fn figure(self, results: &Results, worst: &[&Run]) -> Figure {
        let plan = &results.plan;
        let cell = |run: Option<&Run>| {
            let Some(run) = run else { return HeatCell::new(f64::NAN) };
            let value = (self.of)(&run.measures).unwrap_or(f64::NAN);
            let drawn = worst.iter().find(|w| w.name == run.name && w.case.test == run.case.test);
            HeatCell {
                value,
                // A measure that is no number is outside.
                violated: value.is_nan() || value > self.limit,
                href: drawn.map(|run| format!("#{}", response_id(run))),
            }
        };
        let (mut rows, mut cells) = (Vec::new(), Vec::new());
        for (n, condition) in plan.conditions.iter().enumerate() {
            if results.under(&condition.name, self.test).next().is_some() {
                rows.push(title(results, n));
                let at = |point| cell(results.at(point, &condition.name, self.test));
                cells.push((0..plan.points.len()).map(at).collect());
            }
        }
        let map = HeatMap {
            quantity: self.quantity,
            corner: "Condition".to_owned(),
            rows,
            columns: (0..plan.points.len())
                .map(|p| format!("{} {:.1} s", plan.points[p].name, plan.points[p].slice.time_s))
                .collect(),
            cells,
            scale: Some((0.0, self.deepest)),
        };
        Figure::new(self.id, self.caption, heat_map(&map))
    }
}
