//! Curves over one pair of axes: time histories, sweeps, theory against measurement.

use maud::Markup;
use plotters::style::text_anchor::{HPos, VPos};

use super::STYLES;
use super::axis::Axis;
use super::canvas::{CHARACTER, Canvas, Key, Role, frame};
use super::curve::Curve;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Draw {
    /// Straight lines from point to point.
    Line,
    /// Each value held until the next point, as a converter holds it.
    Step,
    /// A marker a point.
    Markers,
    /// Both.
    LineAndMarkers,
}

/// One curve. Where `x` or `y` is not finite (or the shorter of them ends) it has a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Abscissae, in the axis's unit.
    pub x: Vec<f64>,
    /// Ordinates, in the axis's unit.
    pub y: Vec<f64>,
    /// Line or markers.
    pub draw: Draw,
    /// Colour, dash and marker; its place in the chart when absent.
    pub style: Option<usize>,
}

impl Series {
    /// A curve drawn as a line.
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series { name: name.into(), x: x.to_vec(), y: y.to_vec(), draw: Draw::Line, style: None }
    }

    /// Points drawn as markers.
    pub fn markers(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Markers)
    }

    /// A sampled and held curve.
    pub fn step(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Step)
    }

    /// The same, drawn otherwise.
    pub fn draw(mut self, draw: Draw) -> Series {
        self.draw = draw;
        self
    }

    /// The same in a given style, to pair curves that belong together.
    pub fn style(mut self, style: usize) -> Series {
        self.style = Some(style);
        self
    }
}

/// A horizontal line that must not be crossed.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Where, in the ordinate's unit.
    pub value: f64,
    /// What it limits.
    pub name: String,
}

/// A vertical line at an event.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where, in the abscissa's unit.
    pub x: f64,
    /// What happens there.
    pub name: String,
}

/// Size of a figure, CSS pixels at full width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width.
    pub width: u16,
    /// Height.
    pub height: u16,
}

impl Size {
    /// A figure of its own.
    pub const FULL: Size = Size { width: 760, height: 400 };
    /// One of two side by side.
    pub const HALF: Size = Size { width: 540, height: 330 };
}

/// What a chart shows.
#[derive(Clone, Debug, PartialEq)]
pub struct LineChart {
    /// Heading inside the figure; may be empty.
    pub title: String,
    /// The abscissa.
    pub x: Axis,
    /// The ordinate.
    pub y: Axis,
    /// The curves, in the order of the legend.
    pub series: Vec<Series>,
    /// Horizontal limits.
    pub limits: Vec<Limit>,
    /// Vertical event marks.
    pub marks: Vec<Mark>,
    /// Size.
    pub size: Size,
}

impl LineChart {
    /// A chart without limits and marks, at full size.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, series: Vec<Series>) -> LineChart {
        LineChart {
            title: title.into(),
            x,
            y,
            series,
            limits: Vec::new(),
            marks: Vec::new(),
            size: Size::FULL,
        }
    }

    /// The same with a limit line.
    pub fn limit(mut self, value: f64, name: impl Into<String>) -> LineChart {
        self.limits.push(Limit { value, name: name.into() });
        self
    }

    /// The same with an event mark.
    pub fn mark(mut self, x: f64, name: impl Into<String>) -> LineChart {
        self.marks.push(Mark { x, name: name.into() });
        self
    }

    /// The same at another size.
    pub fn size(mut self, size: Size) -> LineChart {
        self.size = size;
        self
    }
}

/// Height of a row of event labels, in drawing units.
const MARK_ROW: i32 = 150;

/// The chart as SVG for [`mod@crate::report::page`].
pub fn line_chart(chart: &LineChart) -> Markup {
    let curves: Vec<Curve> = chart
        .series
        .iter()
        .enumerate()
        .map(|(i, series)| Curve::new(chart, series, series.style.unwrap_or(i) % STYLES))
        .collect();
    let points = || curves.iter().flat_map(|curve| curve.runs.iter().flatten());
    let marked = chart.series.iter().any(|series| series.draw == Draw::Markers);
    let limits: Vec<f64> =
        chart.limits.iter().filter_map(|limit| chart.y.map(limit.value)).collect();
    let x = chart.x.fit(
        points().map(|point| point.0),
        usize::from(chart.size.width) / 80,
        if marked { 0.02 } else { 0.0 },
    );
    let y = chart.y.fit(
        points().map(|point| point.1).chain(limits),
        usize::from(chart.size.height) / 55,
        0.05,
    );
    let keys: Vec<Key> = chart
        .series
        .iter()
        .zip(&curves)
        .filter(|(series, _)| !series.name.is_empty())
        .map(|(series, curve)| Key {
            name: series.name.clone(),
            line: (series.draw != Draw::Markers).then_some(curve.style),
            marker: matches!(series.draw, Draw::Markers | Draw::LineAndMarkers)
                .then_some(curve.style),
            bar: None,
        })
        .collect();
    let headroom = if chart.marks.is_empty() { 0 } else { MARK_ROW };
    frame(&chart.title, chart.size, &x, &y, &keys, headroom, |canvas| {
        draw_marks(canvas, chart);
        draw_limits(canvas, chart);
        for curve in &curves {
            curve.draw(canvas);
        }
        if points().next().is_none() {
            let (left, top, right, bottom) = canvas.area;
            let middle = ((left + right) / 2, (top + bottom) / 2);
            canvas.text("no data", middle, Role::MarkText, HPos::Center, VPos::Center);
        }
    })
}

fn draw_limits(canvas: &Canvas<'_>, chart: &LineChart) {
    let (left, top, right, bottom) = canvas.area;
    let mut labelled: Vec<i32> = Vec::new();
    for limit in &chart.limits {
        let Some(value) = chart.y.map(limit.value) else {
            continue;
        };
        let (_, y) = canvas.at(0.0, value);
        if !(top..=bottom).contains(&y) {
            continue;
        }
        canvas.path(vec![(left, y), (right, y)], Role::Limit);
        // Above the line unless a label stands there already or the frame ends.
        let above = y - 30;
        let taken = |at: i32| labelled.iter().any(|other| (other - at).abs() < 150);
        let (at, anchor) = if above - 120 < top || taken(above) {
            (y + 30, VPos::Top)
        } else {
            (above, VPos::Bottom)
        };
        labelled.push(at);
        canvas.text(&limit.name, (right - 40, at), Role::LimitText, HPos::Right, anchor);
    }
}

fn draw_marks(canvas: &Canvas<'_>, chart: &LineChart) {
    let (left, top, right, bottom) = canvas.area;
    let mut marks: Vec<(i32, &str)> = chart
        .marks
        .iter()
        .filter_map(|mark| Some((canvas.at(chart.x.map(mark.x)?, 0.0).0, mark.name.as_str())))
        .filter(|(x, _)| (left..=right).contains(x))
        .collect();
    marks.sort_by_key(|(x, _)| *x);
    // Labels stand above the plotting area; those that would touch move down a row.
    let mut row_ends: Vec<i32> = Vec::new();
    for (x, name) in marks {
        canvas.path(vec![(x, top), (x, bottom)], Role::Mark);
        let width = name.chars().count() as i32 * CHARACTER;
        let before = x + 40 + width > right;
        let (start, end) = if before { (x - 40 - width, x) } else { (x, x + 80 + width) };
        let row = row_ends.iter().position(|&row_end| row_end <= start).unwrap_or(row_ends.len());
        if row == row_ends.len() {
            row_ends.push(end);
        } else {
            row_ends[row] = end;
        }
        let at = top - 30 + row as i32 * MARK_ROW;
        let (at_x, anchor) = if before { (x - 30, HPos::Right) } else { (x + 30, HPos::Left) };
        canvas.text(name, (at_x, at), Role::MarkText, anchor, VPos::Bottom);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Scale;
    use super::*;

    fn any_chart() -> impl Strategy<Value = LineChart> {
        let value =
            prop_oneof![any::<f64>(), Just(f64::NAN), Just(f64::INFINITY), Just(0.0), -1e3..1e3];
        let values = || proptest::collection::vec(value.clone(), 0..1_200);
        let series = (values(), values(), 0..4_usize).prop_map(|(x, y, draw)| {
            let draw = [Draw::Line, Draw::Step, Draw::Markers, Draw::LineAndMarkers][draw];
            Series::line("a<b>&\"c\"", &x, &y).draw(draw)
        });
        let axis = (any::<bool>(), any::<Option<(f64, f64)>>()).prop_map(|(log, range)| Axis {
            range,
            scale: if log { Scale::Log } else { Scale::Linear },
            ..Axis::new("x", "m/s²")
        });
        (axis.clone(), axis, proptest::collection::vec(series, 0..4), any::<f64>()).prop_map(
            |(x, y, series, at)| {
                LineChart::new("t", x, y, series).limit(at, "limit").mark(at, "mark")
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn any_data_draws(chart in any_chart()) {
            let svg = line_chart(&chart).into_string();
            prop_assert!(svg.starts_with("<svg") && svg.ends_with("</svg>"));
            prop_assert!(!svg.contains("NaN") && !svg.contains("#01"));
        }
    }

    #[test]
    fn an_empty_chart_says_so() {
        let chart = LineChart::new("t", Axis::new("x", ""), Axis::new("y", ""), Vec::new());
        assert!(line_chart(&chart).into_string().contains("no data"));
    }
}
