//! Sensitivity part: dispersions ranked, and tornado plots at the worst point.

use maud::{Markup, html};

use crate::report::plot::tornado;
use crate::report::sensitivity::{corner_table, ranking_table, tornado_of};
use crate::report::{Numbering, Section, anchor};
use crate::study::sensitivity::{
    dispersion_file::Dispersions,
    run::{Measure, PointSensitivity},
};

/// The section.
pub(super) fn section(
    numbering: &mut Numbering,
    points: &[PointSensitivity],
    dispersions: &Dispersions,
) -> Section {
    const DRAWN: [Measure; 3] = [Measure::Overshoot, Measure::Residual, Measure::BendingLeft];
    let mut rankings: Vec<Markup> = Vec::new();
    for measure in DRAWN {
        let (label, _) = measure.label();
        let id = format!("rank-{}", anchor(label));
        let caption = format!("{label}: dispersions ranked by span, each at its widest point.");
        let table = ranking_table(points, measure).markup();
        rankings.push(numbering.table(&id, &caption, table));
        if let Some(point) = widest(points, measure) {
            let spec = tornado_of(point, measure);
            let caption = format!(
                "{label} at {}, where its dispersions reach farthest; one at a time.",
                point.point
            );
            rankings.push(numbering.figure(&anchor(&spec.title), &caption, tornado(&spec)));
        }
    }
    let order: Vec<&str> = dispersions.all.iter().map(|d| d.title.as_str()).collect();
    let corners = numbering.table(
        "corners",
        &format!(
            "All corners by eigenvalues; the least damped of each point on the machine. Settings in the order {}.",
            order.join(", ")
        ),
        corner_table(points).markup(),
    );
    Section::new(
        "Sensitivity to dispersed parameters",
        html! { @for part in &rankings { (part) } (corners) },
    )
}

/// The point at which one dispersion alone spans most.
fn widest(points: &[PointSensitivity], measure: Measure) -> Option<&PointSensitivity> {
    points.iter().max_by(|a, b| {
        let span = |p: &PointSensitivity| {
            let first = p.ranked(measure).into_iter().next();
            first.map_or(0.0, |effect| effect.span(measure, &p.nominal))
        };
        span(a).total_cmp(&span(b))
    })
}
