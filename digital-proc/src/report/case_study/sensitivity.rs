//! Sensitivity part: dispersions ranked, and tornado plots at the worst point.

use maud::{Markup, html};

use crate::report::sensitivity::{corners, ranking, tornado_of};
use crate::study::sensitivity::{
    dispersion_file::Dispersions,
    run::{Measure, PointSensitivity},
};
use desk::report::plot::tornado;
use desk::report::{Numbering, Section, anchor};

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
        rankings.push(ranking(numbering, points, measure));
        if let Some(point) = widest(points, measure) {
            let spec = tornado_of(point, measure);
            let caption = format!(
                "{label} at {}, where its dispersions reach farthest; one at a time.",
                point.point
            );
            rankings.push(numbering.figure(&anchor(&spec.title), &caption, tornado(&spec)));
        }
    }
    let corners = corners(numbering, points, dispersions);
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
