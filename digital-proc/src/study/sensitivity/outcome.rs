//! Sensitivities for people and machines: ranked tables, tornado charts, the corners.

use super::{
    dispersion_file::Dispersions,
    pairs::{self, Pair},
    run::{Measure, PointSensitivity},
};
use crate::study::gain_design::criteria::{self, LoopQuality};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Heading, Table, anchor,
        plot::{Axis, Tornado, TornadoBar, tornado},
    },
};

/// What `sensitivity` came to.
pub fn outcome(points: &[PointSensitivity], dispersions: &Dispersions, pairs: &[Pair]) -> Outcome {
    let mut out = Outcome::new(
        "Sensitivity of the pitch loop",
        "Dispersions one at a time and at the corners, measured on the patched pitch loop at frozen trajectory points, with linear eigenvalues beside.",
    );
    for measure in Measure::ALL {
        ranking(points, measure, "Ranking", &mut out);
    }
    for point in points {
        for measure in [
            Measure::OVERSHOOT,
            Measure::BENDING_LEFT,
            Measure::ATTITUDE_DAMPING,
            Measure::BENDING_DAMPING,
        ] {
            // A loop that never overshoots shows nothing to rank.
            if point.widest_span(measure) != 0.0 {
                out.section("One at a time").figure(tornado_of(point, measure));
            }
        }
    }
    pairs::fill(pairs, &mut out);
    corners(points, dispersions, "Corners", &mut out);
    out
}

/// Adds rankings, each with the point at which one dispersion alone spans most, and corners.
pub fn fill(points: &[PointSensitivity], dispersions: &Dispersions, out: &mut Outcome) {
    const SECTION: &str = "Sensitivity to dispersed parameters";
    for measure in [Measure::OVERSHOOT, Measure::RESIDUAL, Measure::BENDING_LEFT] {
        ranking(points, measure, SECTION, out);
        let span = |p: &&PointSensitivity| p.widest_span(measure);
        if let Some(point) = points.iter().max_by(|a, b| span(a).total_cmp(&span(b))) {
            out.section(SECTION).figure(tornado_of(point, measure));
        }
    }
    corners(points, dispersions, SECTION, out);
}

/// Dispersions ranked by the span of a measure, each at the point where it is widest.
fn ranking(points: &[PointSensitivity], measure: Measure, section: &str, out: &mut Outcome) {
    let Measure { label, unit, of } = measure;
    let mut table = Table::new(vec![
        Heading::new("Dispersion", ""),
        Heading::new("Point", ""),
        Heading::new(format!("{label} at low"), unit).digits(3),
        Heading::new("nominal", unit).digits(3),
        Heading::new("at high", unit).digits(3),
        Heading::new("Span", unit).digits(3),
    ]);
    let span = |p: &PointSensitivity, i: usize| p.effects[i].span(measure, &p.nominal);
    let widest = |i: usize| {
        let point = points.iter().max_by(|a, b| span(a, i).total_cmp(&span(b, i)))?;
        Some((span(point, i), &point.effects[i], point))
    };
    let count = points.first().map_or(0, |p| p.effects.len());
    let mut rows: Vec<_> = (0..count).filter_map(widest).collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (span, effect, point) in rows {
        let numbers = [of(&effect.low), of(&point.nominal), of(&effect.high), span];
        let names: [Cell; 2] = [effect.dispersion.as_str().into(), point.point.as_str().into()];
        table.row(names.into_iter().chain(numbers.map(Cell::Number)));
    }
    out.section(section).table(
        format!("rank_{}", anchor(label).replace('-', "_")),
        format!("{label}: dispersions ranked by span, each at its widest point."),
        table,
    );
}

/// The tornado of a measure at one point; a diverged run has no bar end there.
fn tornado_of(point: &PointSensitivity, measure: Measure) -> Figure {
    let Measure { label, unit, of } = measure;
    let bar = |effect: &super::run::Effect| TornadoBar {
        name: effect.dispersion.clone(),
        low: of(&effect.low),
        high: of(&effect.high),
    };
    let title = format!("{label}, {} ({:.1} s)", point.point, point.time_s);
    let spec = Tornado {
        x: Axis::new(label, unit),
        nominal: of(&point.nominal),
        bars: point.ranked(measure).into_iter().map(bar).collect(),
        title: title.clone(),
    };
    Figure::new(anchor(&title), format!("{title}; one dispersion at a time."), tornado(&spec))
}

/// The corners that were run beside the nominal loop, and everything that was run.
fn corners(
    points: &[PointSensitivity],
    dispersions: &Dispersions,
    section: &str,
    out: &mut Outcome,
) {
    let names = ["Point", "Loop", "Upper settings"].map(|label| Heading::new(label, ""));
    let measures = Measure::ALL.map(|m| Heading::new(m.label, m.unit).digits(3));
    let mut corners = Table::new(
        names.into_iter().chain(measures).chain([Heading::new("Growing corners", "")]).collect(),
    );
    let start = [("Point", ""), ("Time", "s"), ("Dispersion", ""), ("Setting", "")];
    let start = start.map(|(label, unit)| Heading::new(label, unit));
    let last = Heading::new("Attitude damping", "").digits(3);
    let mut all = Table::new(start.into_iter().chain(criteria::headings()).chain([last]).collect());
    for point in points {
        let name = point.point.as_str();
        let mut corner = |what: String, high: String, quality: &LoopQuality| {
            let start: [Cell; 3] = [name.into(), what.into(), high.into()];
            let measures = Measure::ALL.map(|m| (m.of)(quality).into());
            let count: Cell = format!("{} of {}", point.unstable_corners, point.corners).into();
            corners.row(start.into_iter().chain(measures).chain([count]));
        };
        corner("nominal".to_owned(), String::new(), &point.nominal);
        for worst in &point.worst_corners {
            let high: String = worst.high.iter().map(|h| if *h { '+' } else { '−' }).collect();
            corner(format!("worst {}", worst.worst_in), high, &worst.quality);
        }
        let mut run = |dispersion: &str, setting: &str, quality: &LoopQuality| {
            let start: [Cell; 4] =
                [name.into(), point.time_s.into(), dispersion.into(), setting.into()];
            let damping = quality.attitude_damping.into();
            all.row(start.into_iter().chain(quality.cells()).chain([damping]));
        };
        run("", "nominal", &point.nominal);
        for effect in &point.effects {
            run(&effect.dispersion, "low", &effect.low);
            run(&effect.dispersion, "high", &effect.high);
        }
    }
    let order: Vec<&str> = dispersions.all.iter().map(|d| d.title.as_str()).collect();
    out.section(section)
        .table(
            "corners",
            format!(
                "All corners by eigenvalues; the least damped of each point on the machine. Settings in the order {}.",
                order.join(", ")
            ),
            corners,
        )
        .long_table("dispersed", "Every dispersion at both its settings.", all);
}
