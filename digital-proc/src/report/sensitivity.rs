//! Sensitivities as ranked tables and tornado plots.

use crate::study::sensitivity::{
    dispersion_file::Dispersions,
    run::{Measure, PointSensitivity},
};
use desk::report::anchor;
use desk::report::{
    Cell, Heading, Numbering, Section, Table,
    plot::{Axis, Tornado, TornadoBar, tornado},
};
use maud::{Markup, html};

/// Dispersions ranked by the span of a measure at the point where it is widest.
pub fn ranking_table(points: &[PointSensitivity], measure: Measure) -> Table {
    let (label, unit) = measure.label();
    let mut table = Table::new(vec![
        Heading::new("Dispersion", ""),
        Heading::new("Point", ""),
        Heading::new(format!("{label} at low"), unit).digits(3),
        Heading::new("nominal", unit).digits(3),
        Heading::new("at high", unit).digits(3),
        Heading::new("Span", unit).digits(3),
    ]);
    let mut rows: Vec<(f64, [Cell; 6])> = Vec::new();
    let count = points.first().map_or(0, |p| p.effects.len());
    for i in 0..count {
        let widest = points
            .iter()
            .map(|p| (p.effects[i].span(measure, &p.nominal), p))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((span, point)) = widest else {
            continue;
        };
        let effect = &point.effects[i];
        rows.push((
            span,
            [
                effect.dispersion.as_str().into(),
                point.point.as_str().into(),
                measure.of(&effect.low).into(),
                measure.of(&point.nominal).into(),
                measure.of(&effect.high).into(),
                span.into(),
            ],
        ));
    }
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, row) in rows {
        table.row(row);
    }
    table
}

/// The corners that were run, beside the nominal loop.
pub fn corner_table(points: &[PointSensitivity]) -> Table {
    let mut headings = vec![
        Heading::new("Point", ""),
        Heading::new("Loop", ""),
        Heading::new("Upper settings", ""),
    ];
    headings.extend(Measure::ALL.map(|m| {
        let (label, unit) = m.label();
        Heading::new(label, unit).digits(3)
    }));
    headings.push(Heading::new("Growing corners", ""));
    let mut table = Table::new(headings);
    for point in points {
        let nominal = ("nominal".to_owned(), String::new(), &point.nominal);
        let corners = point.worst_corners.iter().map(|c| {
            let high: String = c.high.iter().map(|h| if *h { '+' } else { '−' }).collect();
            (format!("worst {}", c.worst_in), high, &c.answer)
        });
        for (name, high, answer) in std::iter::once(nominal).chain(corners) {
            let start: [Cell; 3] = [point.point.as_str().into(), name.into(), high.into()];
            let count = format!("{} of {}", point.unstable_corners, point.corners);
            table.row(
                start
                    .into_iter()
                    .chain(Measure::ALL.map(|m| m.of(answer).into()))
                    .chain([count.into()]),
            );
        }
    }
    table
}

/// The tornado of a measure at one point; a diverged run has no bar end there.
pub fn tornado_of(point: &PointSensitivity, measure: Measure) -> Tornado {
    let (label, unit) = measure.label();
    Tornado {
        title: format!("{label}, {} ({:.1} s)", point.point, point.time_s),
        x: Axis::new(label, unit),
        nominal: measure.of(&point.nominal),
        bars: point
            .ranked(measure)
            .iter()
            .map(|effect| TornadoBar {
                name: effect.dispersion.clone(),
                low: measure.of(&effect.low),
                high: measure.of(&effect.high),
            })
            .collect(),
    }
}

/// A measure's ranking on a page.
pub(super) fn ranking(
    numbering: &mut Numbering,
    points: &[PointSensitivity],
    measure: Measure,
) -> Markup {
    let (label, _) = measure.label();
    numbering.table(
        &format!("rank-{}", anchor(label)),
        &format!("{label}: dispersions ranked by span, each at its widest point."),
        ranking_table(points, measure).markup(),
    )
}

/// The corners on a page.
pub(super) fn corners(
    numbering: &mut Numbering,
    points: &[PointSensitivity],
    dispersions: &Dispersions,
) -> Markup {
    let order: Vec<&str> = dispersions.all.iter().map(|d| d.title.as_str()).collect();
    numbering.table(
        "corners",
        &format!(
            "All corners by eigenvalues; the least damped of each point on the machine. Settings in the order {}.",
            order.join(", ")
        ),
        corner_table(points).markup(),
    )
}

/// The sections of the page: rankings, tornado plots, corners.
pub fn sensitivity_sections(
    points: &[PointSensitivity],
    dispersions: &Dispersions,
) -> Vec<Section> {
    let mut numbering = Numbering::new();
    let rankings = Measure::ALL.map(|measure| ranking(&mut numbering, points, measure));
    let mut tornados = Vec::new();
    for point in points {
        for measure in [Measure::Overshoot, Measure::BendingLeft] {
            // A loop that never overshoots shows nothing to rank.
            let widest =
                point.ranked(measure).first().map_or(0.0, |e| e.span(measure, &point.nominal));
            if widest == 0.0 {
                continue;
            }
            let spec = tornado_of(point, measure);
            tornados.push(numbering.figure(
                &anchor(&spec.title),
                &format!("{}; one dispersion at a time.", spec.title),
                tornado(&spec),
            ));
        }
    }
    let corners = corners(&mut numbering, points, dispersions);
    vec![
        Section::new("Ranking", html! { @for r in &rankings { (r) } }),
        Section::new("One at a time", html! { @for t in &tornados { (t) } }),
        Section::new("Corners", corners),
    ]
}
