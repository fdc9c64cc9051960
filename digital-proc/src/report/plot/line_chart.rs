//! Curves over one pair of axes: time histories, sweeps, theory against measurement.

use maud::Markup;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{CHARACTER, Canvas, Key, Role, frame};
use super::{STYLES, decimate};

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
    #[must_use]
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series {
            name: name.into(),
            x: x.to_vec(),
            y: y.to_vec(),
            draw: Draw::Line,
            style: None,
        }
    }

    /// Points drawn as markers.
    #[must_use]
    pub fn markers(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Markers)
    }

    /// A sampled and held curve.
    #[must_use]
    pub fn step(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Step)
    }

    /// The same, drawn otherwise.
    #[must_use]
    pub fn draw(mut self, draw: Draw) -> Series {
        self.draw = draw;
        self
    }

    /// The same in a given style, to pair curves that belong together.
    #[must_use]
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
    pub const FULL: Size = Size {
        width: 760,
        height: 400,
    };
    /// One of two side by side.
    pub const HALF: Size = Size {
        width: 540,
        height: 330,
    };
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
    #[must_use]
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
    #[must_use]
    pub fn limit(mut self, value: f64, name: impl Into<String>) -> LineChart {
        self.limits.push(Limit {
            value,
            name: name.into(),
        });
        self
    }

    /// The same with an event mark.
    #[must_use]
    pub fn mark(mut self, x: f64, name: impl Into<String>) -> LineChart {
        self.marks.push(Mark {
            x,
            name: name.into(),
        });
        self
    }

    /// The same at another size.
    #[must_use]
    pub fn size(mut self, size: Size) -> LineChart {
        self.size = size;
        self
    }
}

/// Theory as lines and measurement as markers, pair by pair in one style.
/// Each pair is (name, theory x, theory y, measured x, measured y).
#[must_use]
pub fn measured_vs_theory(
    title: &str,
    x: Axis,
    y: Axis,
    pairs: &[(&str, &[f64], &[f64], &[f64], &[f64])],
) -> LineChart {
    let named = |name: &str, what: &str| {
        if name.is_empty() {
            what.to_owned()
        } else {
            format!("{name}, {what}")
        }
    };
    let series = pairs
        .iter()
        .enumerate()
        .flat_map(|(i, (name, tx, ty, mx, my))| {
            [
                Series::line(named(name, "theory"), tx, ty).style(i),
                Series::markers(named(name, "measured"), mx, my).style(i),
            ]
        })
        .collect();
    LineChart::new(title, x, y, series)
}

/// The chart as SVG for [`crate::report::page`].
#[must_use]
pub fn line_chart(chart: &LineChart) -> Markup {
    let curves: Vec<Curve> = chart
        .series
        .iter()
        .enumerate()
        .map(|(i, series)| Curve::new(chart, series, series.style.unwrap_or(i) % STYLES))
        .collect();
    let points = || curves.iter().flat_map(|curve| curve.runs.iter().flatten());
    let marked = chart
        .series
        .iter()
        .any(|series| series.draw == Draw::Markers);
    let limits: Vec<f64> = chart
        .limits
        .iter()
        .filter_map(|limit| chart.y.map(limit.value))
        .collect();
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
    frame(&chart.title, chart.size, &x, &y, &keys, |canvas| {
        draw_marks(canvas, chart);
        draw_limits(canvas, chart);
        for curve in &curves {
            curve.draw(canvas);
        }
        if points().next().is_none() {
            let (left, top, right, bottom) = canvas.area;
            let middle = ((left + right) / 2, (top + bottom) / 2);
            canvas.text(
                "no data",
                middle,
                Role::MarkText,
                HPos::Center,
                VPos::Center,
            );
        }
    })
}

/// A series in mapped coordinates, cut at its gaps.
struct Curve {
    runs: Vec<Vec<(f64, f64)>>,
    draw: Draw,
    style: usize,
    ascending: bool,
}

impl Curve {
    fn new(chart: &LineChart, series: &Series, style: usize) -> Curve {
        let mut runs = vec![Vec::new()];
        for (&x, &y) in series.x.iter().zip(&series.y) {
            match chart.x.map(x).zip(chart.y.map(y)) {
                Some(point) => {
                    if let Some(run) = runs.last_mut() {
                        run.push(point);
                    }
                }
                None => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        let ascending = runs.iter().flatten().is_sorted_by(|a, b| a.0 <= b.0);
        Curve {
            runs,
            draw: series.draw,
            style,
            ascending,
        }
    }

    fn draw(&self, canvas: &Canvas<'_>) {
        let mut markers = Vec::new();
        for run in &self.runs {
            let mut points: Vec<(i32, i32)> = if self.ascending {
                let heights: Vec<f64> = run.iter().map(|point| point.1).collect();
                decimate::extremes(&heights)
                    .into_iter()
                    .map(|i| canvas.at(run[i].0, run[i].1))
                    .collect()
            } else {
                let all: Vec<(i32, i32)> = run.iter().map(|p| canvas.at(p.0, p.1)).collect();
                decimate::spaced(&all, 5)
                    .into_iter()
                    .map(|i| all[i])
                    .collect()
            };
            if matches!(self.draw, Draw::Markers | Draw::LineAndMarkers) {
                markers.extend_from_slice(&points);
            }
            if self.draw == Draw::Step {
                points = held(&points);
            }
            if self.draw != Draw::Markers {
                if let [only] = points[..] {
                    // A lone point between gaps would leave no trace as a line.
                    points = vec![(only.0 - 10, only.1), (only.0 + 10, only.1)];
                }
                for piece in clipped(&points, canvas.area) {
                    canvas.path(piece, Role::Line(self.style));
                }
            }
        }
        let (left, top, right, bottom) = canvas.area;
        for (x, y) in markers {
            if (left..=right).contains(&x) && (top..=bottom).contains(&y) {
                canvas.marker((x, y), self.style);
            }
        }
    }
}

/// The corners of a staircase through `points`.
fn held(points: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let mut corners = Vec::with_capacity(points.len() * 2);
    for (i, &(x, y)) in points.iter().enumerate() {
        if i > 0 {
            corners.push((x, points[i - 1].1));
        }
        corners.push((x, y));
    }
    corners
}

/// The parts of a path inside the area, cut where it crosses the border.
fn clipped(points: &[(i32, i32)], area: (i32, i32, i32, i32)) -> Vec<Vec<(i32, i32)>> {
    let (left, top, right, bottom) = area;
    let inside = |&(x, y): &(i32, i32)| (left..=right).contains(&x) && (top..=bottom).contains(&y);
    if points.iter().all(inside) {
        return vec![points.to_vec()];
    }
    let mut pieces: Vec<Vec<(i32, i32)>> = Vec::new();
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
        // The share of the segment between each pair of parallel borders.
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (start, delta, low, high) in [(from.0, dx, left, right), (from.1, dy, top, bottom)] {
            let (low, high) = (f64::from(low - start), f64::from(high - start));
            if delta == 0.0 {
                if low > 0.0 || high < 0.0 {
                    leave = -1.0;
                }
            } else {
                let (a, b) = (low / delta, high / delta);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        if enter > leave {
            continue;
        }
        let at = |share: f64| {
            (
                from.0 + (dx * share).round() as i32,
                from.1 + (dy * share).round() as i32,
            )
        };
        let (start, end) = (at(enter), at(leave));
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&start) => piece.push(end),
            _ => pieces.push(vec![start, end]),
        }
    }
    pieces
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
        canvas.text(
            &limit.name,
            (right - 40, at),
            Role::LimitText,
            HPos::Right,
            anchor,
        );
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
    // Labels run along the foot of the chart, in as many rows as keep them apart.
    let mut row_ends: Vec<i32> = Vec::new();
    for (x, name) in marks {
        canvas.path(vec![(x, top), (x, bottom)], Role::Mark);
        let width = name.chars().count() as i32 * CHARACTER;
        let before = x + 40 + width > right;
        let (start, end) = if before {
            (x - 40 - width, x)
        } else {
            (x, x + 80 + width)
        };
        let row = row_ends
            .iter()
            .position(|&row_end| row_end <= start)
            .unwrap_or(row_ends.len());
        if row == row_ends.len() {
            row_ends.push(end);
        } else {
            row_ends[row] = end;
        }
        let at = bottom - 40 - row as i32 * 150;
        let (at_x, anchor) = if before {
            (x - 30, HPos::Right)
        } else {
            (x + 30, HPos::Left)
        };
        canvas.text(name, (at_x, at), Role::MarkText, anchor, VPos::Bottom);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Scale;
    use super::*;

    fn any_chart() -> impl Strategy<Value = LineChart> {
        let value = prop_oneof![
            any::<f64>(),
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(0.0),
            -1e3..1e3
        ];
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
        (
            axis.clone(),
            axis,
            proptest::collection::vec(series, 0..4),
            any::<f64>(),
        )
            .prop_map(|(x, y, series, at)| {
                LineChart::new("t", x, y, series)
                    .limit(at, "limit")
                    .mark(at, "mark")
            })
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
    fn a_path_is_cut_at_the_border() {
        let path = [(0, 50), (200, 50), (200, 80), (50, 80)];
        assert_eq!(
            clipped(&path, (10, 0, 100, 100)),
            [vec![(10, 50), (100, 50)], vec![(100, 80), (50, 80)]]
        );
    }

    #[test]
    fn an_empty_chart_says_so() {
        let chart = LineChart::new("t", Axis::new("x", ""), Axis::new("y", ""), Vec::new());
        assert!(line_chart(&chart).into_string().contains("no data"));
    }
}
