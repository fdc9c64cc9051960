//! Curves over one pair of axes: time histories, sweeps, theory against measurement.

use maud::{Markup, html};

use super::STYLES;
use super::chart::{Draw, LineChart};
use super::curve::Curve;
use super::frame::{Area, Key, frame};
use super::pen::{Px, polyline};

/// Height of a label.
const LABEL_ROW: f64 = 15.0;

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
        .enumerate()
        .filter(|(_, (series, _))| !series.name.is_empty())
        .map(|(i, (series, curve))| Key {
            name: series.name.clone(),
            series: i,
            style: curve.style,
            line: series.draw.line(),
            marker: series.draw.marker(),
        })
        .collect();
    frame(&chart.title, chart.size, (&x, &y), &keys, |area| {
        let cut = points().any(|&(x, y)| !area.holds(area.at(x, y)));
        let limits = limits_in(area, chart);
        html! {
            svg.plot.cut[cut] width=(Px(area.width)) height=(Px(area.height)) data-x=(x.ends()) data-y=(y.ends()) {
                @for limit in &limits { (polyline("li", &[(0.0, limit.y), (area.width, limit.y)])) }
                @for (curve, series) in curves.iter().zip(&chart.series) {
                    g.series data-name=(if series.name.is_empty() { &y.title } else { &series.name }) { (curve.draw(area)) }
                }
            }
            @for limit in &limits {
                text.lt x=(Px(area.width)) y=(Px(limit.y)) dx="-4" dy=(limit.dy) text-anchor="end" { (limit.text) }
            }
            @if points().next().is_none() {
                text.mt x=(Px(area.width / 2.0)) y=(Px(area.height / 2.0)) text-anchor="middle" { "no data" }
            }
        }
    })
}

/// The label of a limit: the height of its line, and how far from it the text stands.
struct Label<'a> {
    text: &'a str,
    y: f64,
    dy: f64,
}

fn limits_in<'a>(area: &Area<'_>, chart: &'a LineChart) -> Vec<Label<'a>> {
    let mut labels: Vec<Label<'a>> = Vec::new();
    for limit in &chart.limits {
        let Some(value) = chart.y.map(limit.value) else {
            continue;
        };
        let (_, y) = area.at(0.0, value);
        if !(0.0..=area.height).contains(&y) {
            continue;
        }
        // Above the line unless a label stands there already or the frame ends.
        let taken = labels.iter().any(|other| (other.y + other.dy - (y - 3.0)).abs() < LABEL_ROW);
        let dy = if y < LABEL_ROW || taken { 13.0 } else { -3.0 };
        labels.push(Label { text: &limit.name, y, dy });
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Series};
    use super::*;

    /// The points of every line of the series, as written.
    fn lines(svg: &str) -> Vec<&str> {
        let (_, series) = svg.split_once("class=\"series\"").unwrap();
        let points = series.split("points=\"").skip(1);
        points.map(|rest| rest.split_once('"').unwrap().0).collect()
    }

    #[test]
    fn a_known_point_lands_at_its_place() {
        let chart = |x: Axis, at: [f64; 3]| {
            let y = Axis::new("y", "").range(-1.0, 1.0);
            LineChart::new("t", x, y, vec![Series::line("s", &at, &[-1.0, 0.5, 1.0])])
        };
        // `−0.5` is the longest label: 36 + 4 · 6.8 on the left, 16 on the right; title, legend and
        // abscissa take 36, 20 and 45.
        let (width, height) = (760.0 - 36.0 - 4.0 * 6.8 - 16.0, 400.0 - 36.0 - 20.0 - 45.0);
        let place = format!("0,{height} {:.1},{:.1} {width},0", width / 4.0, height / 4.0);
        let linear = line_chart(&chart(Axis::new("x", "s").range(10.0, 50.0), [10.0, 20.0, 50.0]));
        assert_eq!(lines(&linear.into_string()), [place.as_str()]);
        let log = line_chart(&chart(Axis::new("x", "s").log(), [1e-2, 1e-1, 1e2]));
        assert_eq!(lines(&log.into_string()), [place.as_str()]);
    }

    #[test]
    fn a_gap_breaks_the_line() {
        let nan = f64::NAN;
        let (x, y) = ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 1.0, nan, 1.0, nan, 1.0]);
        let axes = || (Axis::new("x", ""), Axis::new("y", ""));
        let drawn = |draw: Draw| {
            let series = vec![Series::line("", &x, &y).draw(draw)];
            line_chart(&LineChart::new("", axes().0, axes().1, series)).into_string()
        };
        let svg = drawn(Draw::Line);
        let counts: Vec<usize> = lines(&svg).iter().map(|line| line.split(' ').count()).collect();
        // Two points, then one between gaps, drawn as a short stroke, and one at the end.
        assert_eq!(counts, [2, 2, 2]);
        assert_eq!(drawn(Draw::Markers).matches("m-3.6,0a").count(), 4);
        // A value that is held makes a corner before the next.
        assert_eq!(lines(&drawn(Draw::Step))[0].split(' ').count(), 3);
    }

    #[test]
    fn only_what_leaves_a_given_range_is_cut() {
        let chart = |high: f64| {
            let y = Axis::new("y", "").range(0.0, high);
            LineChart::new(
                "",
                Axis::new("x", ""),
                y,
                vec![Series::line("", &[0.0, 1.0], &[0.0, 2.0])],
            )
        };
        assert!(line_chart(&chart(2.0)).into_string().contains("<svg class=\"plot\""));
        assert!(line_chart(&chart(1.5)).into_string().contains("<svg class=\"plot cut\""));
    }

    #[test]
    fn names_are_escaped() {
        let name = "a<b>&\"c\"";
        let axis = || Axis::new(name, "");
        let series = vec![Series::line(name, &[0.0, 1.0], &[0.0, 1.0])];
        let svg = line_chart(&LineChart::new(name, axis(), axis(), series).limit(0.5, name));
        let svg = svg.into_string();
        assert!(!svg.contains("<b>") && !svg.contains("&\""), "{svg}");
        // Title twice, legend, both axes, limit, and the series itself.
        assert_eq!(svg.matches("a&lt;b&gt;&amp;&quot;c&quot;").count(), 7, "{svg}");
    }

    #[test]
    fn an_empty_chart_says_so() {
        let chart = LineChart::new("t", Axis::new("x", ""), Axis::new("y", ""), Vec::new());
        assert!(line_chart(&chart).into_string().contains("no data"));
    }
}
