//! The bending moments of the short-period runs: a row a run, conditions against points, the point
//! of the greatest moment drawn.

use super::super::{
    claims::NORMAL,
    control_loop::{ControlLoop, Offset, Test},
    outcome::place,
    results::{Results, Run},
};
use super::moments;
use crate::study::bending_moment::outcome::{EXPLAINED, along, envelope, headings, history, over};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Heading, Table,
        plot::{HeatCell, HeatMap, heat_map},
    },
};

/// Runs in one figure.
const DRAWN: usize = 5;

/// Adds tables and figures of both loops.
pub fn fill(results: &Results, out: &mut Outcome) {
    for control_loop in ControlLoop::ALL {
        // An undisturbed step bends little.
        let runs: Vec<&Run> =
            results.of(control_loop).filter(|r| r.case.test != Test::StepOnly).collect();
        // Only one condition has the other offsets; what is compared starts from the same one.
        let alike: Vec<&Run> = runs.iter().copied().filter(|r| starts_like_all(r)).collect();
        let Some(worst) = worst(&alike) else { continue };
        let (key, plane) = match control_loop {
            ControlLoop::Pitch => ("pitch", "pitch"),
            ControlLoop::YawRoll => ("yaw_roll", "yaw"),
        };
        out.section("Bending moment").aside(EXPLAINED);
        if results.plan.conditions.len() > 1 && results.plan.points.len() > 1 {
            let figure = matrix(&format!("matrix-moment-{plane}"), plane, results, &alike);
            out.section("Bending moment").figure(figure);
        }
        let figures = figures(plane, results, &alike, worst);
        out.section("Bending moment").beside(figures).long_table(
            format!("{key}_moments"),
            format!("Greatest bending moment of each run in {plane}, with the modes and without, and with them at ten stations."),
            table(&runs),
        );
    }
}

fn starts_like_all(run: &Run) -> bool {
    match run.case.test {
        Test::Disturbed | Test::StepOnly => true,
        Test::Shared(offset) | Test::Dedicated(offset) => offset == Offset::Both,
    }
}

fn greatest_nm(run: &Run) -> f64 {
    run.moment.map_or(f64::NAN, |m| m.whole.moment_nm)
}

/// The run with the greatest moment, of the normal condition if there is one.
fn worst<'a>(runs: &[&'a Run]) -> Option<&'a Run> {
    let with = || runs.iter().copied().filter(|run| run.moment.is_some());
    let by = |a: &&Run, b: &&Run| greatest_nm(a).total_cmp(&greatest_nm(b));
    with().filter(|run| run.condition == NORMAL).max_by(by).or_else(|| with().max_by(by))
}

fn table(runs: &[&Run]) -> Table {
    let words = ["Point", "Condition", "Test"].map(|word| Heading::new(word, ""));
    let mut table = Table::new(words.into_iter().chain(headings()).collect());
    for run in runs {
        let test = run.case.test.words();
        let named = [run.point.as_str(), &run.condition, &test].map(Cell::from);
        table.row(named.into_iter().chain(run.moment.iter().flat_map(|m| m.cells())));
    }
    table
}

/// Conditions against points, the worse of the two tests of yaw.
fn matrix(id: &str, plane: &str, results: &Results, runs: &[&Run]) -> Figure {
    let plan = &results.plan;
    let cell = |condition: usize, point: usize| {
        let here = runs.iter().filter(|r| (r.case.condition, r.case.point) == (condition, point));
        HeatCell::new(here.map(|r| greatest_nm(r) / 1e3).fold(f64::NAN, f64::max))
    };
    let present = |n: &usize| runs.iter().any(|r| r.case.condition == *n);
    let conditions: Vec<usize> = (0..plan.conditions.len()).filter(present).collect();
    let map = HeatMap {
        quantity: format!("Greatest bending moment in {plane}, kN·m"),
        corner: "Condition".to_owned(),
        rows: conditions.iter().map(|&n| plan.conditions[n].title().to_owned()).collect(),
        columns: plan
            .points
            .iter()
            .map(|p| format!("{} {:.1} s", p.name, p.slice.time_s))
            .collect(),
        cells: conditions
            .iter()
            .map(|&condition| (0..plan.points.len()).map(|p| cell(condition, p)).collect())
            .collect(),
        scale: None,
    };
    Figure::new(id, format!("Greatest bending moment of the runs in {plane}."), heat_map(&map))
}

/// Along the vehicle and over time, at the point of the worst run: that run with and without the
/// modes, and the conditions that bend most there.
fn figures(plane: &str, results: &Results, runs: &[&Run], worst: &Run) -> Vec<Figure> {
    let same = |r: &&&Run| {
        r.case.point == worst.case.point && r.case.test == worst.case.test && r.name != worst.name
    };
    let mut others: Vec<&Run> = runs.iter().filter(same).copied().collect();
    others.sort_by(|a, b| greatest_nm(b).total_cmp(&greatest_nm(a)));
    let (mut of_stations, mut of_time) = (Vec::new(), Vec::new());
    for run in std::iter::once(worst).chain(others).take(DRAWN) {
        let Ok(Some(found)) = moments(&results.plan, &run.case, &run.response) else { continue };
        of_stations.push(envelope(run.condition.as_str(), &found.whole));
        of_time.push(history(run.condition.as_str(), &found.whole));
        if run.name == worst.name {
            let name = format!("{}, quasi-static", run.condition);
            of_stations.push(envelope(name.as_str(), &found.quasi_static));
            of_time.push(history(name, &found.quasi_static));
        }
    }
    let at = place(results, worst.case.point);
    let runs = format!("{} and the conditions that bend most, {at}", worst.condition);
    vec![
        along(
            format!("moment-along-{plane}"),
            format!("Greatest bending moment in {plane} at each station: {runs}."),
            of_stations,
        ),
        over(
            format!("moment-over-{plane}"),
            format!("Greatest bending moment in {plane} along the vehicle: {runs}."),
            of_time,
        ),
    ]
}
