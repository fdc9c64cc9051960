//! What is around a chart: title, legend, and two axes with their grid.

use maud::{Markup, html};

use super::axis::FittedAxis;
use super::chart::Size;
use super::pen::{Point, Px, markers, polyline};

/// Mean width of a character at the labels' size.
const CHARACTER: f64 = 6.8;
/// Height of a row of the legend.
const ROW: f64 = 20.0;

/// One entry of a legend.
pub(super) struct Key {
    pub(super) name: String,
    /// Which series of the chart it names.
    pub(super) series: usize,
    pub(super) style: usize,
    pub(super) line: bool,
    pub(super) marker: bool,
}

/// The plotting area inside the axes; its upper left corner is the origin.
pub(super) struct Area<'a> {
    pub(super) x: &'a FittedAxis,
    pub(super) y: &'a FittedAxis,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Area<'_> {
    /// Where mapped coordinates stand.
    pub(super) fn at(&self, x: f64, y: f64) -> Point {
        (self.x.share(x) * self.width, (1.0 - self.y.share(y)) * self.height)
    }

    /// Whether a place is inside or on the border.
    pub(super) fn holds(&self, (x, y): Point) -> bool {
        (0.0..=self.width).contains(&x) && (0.0..=self.height).contains(&y)
    }

    /// Grid, axes, tick marks and their labels.
    fn axes(&self) -> Markup {
        let (width, height) = (Px(self.width), Px(self.height));
        let across = |at: &f64| Px(self.at(*at, 0.0).0);
        let up = |at: &f64| Px(self.at(0.0, *at).1);
        html! {
            @for (class, x, y) in [("gm", &self.x.minor, &self.y.minor), ("gr", &self.x.ticks, &self.y.ticks)] {
                path class=(class) d={
                    @for at in x { "M" (across(at)) ",0V" (height) }
                    @for at in y { "M0," (up(at)) "H" (width) }
                } {}
            }
            path.ax d={
                "M0,0V" (height) "H" (width)
                @for at in &self.x.ticks { "M" (across(at)) "," (height) "v4" }
                @for at in &self.y.ticks { "M0," (up(at)) "h-4" }
            } {}
            g.tt text-anchor="middle" {
                @for (at, label) in self.x.ticks.iter().zip(&self.x.labels) {
                    text x=(across(at)) y=(Px(self.height + 17.0)) { (label) }
                }
            }
            g.tt text-anchor="end" {
                @for (at, label) in self.y.ticks.iter().zip(&self.y.labels) {
                    text x="-8" y=(up(at)) dy="4" { (label) }
                }
            }
        }
    }
}

/// A figure with a title, a legend and two axes. `draw` fills the plotting area.
pub(super) fn frame(
    title: &str,
    size: Size,
    (x, y): (&FittedAxis, &FittedAxis),
    keys: &[Key],
    draw: impl FnOnce(&Area<'_>) -> Markup,
) -> Markup {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let left = 36.0 + y.widest() as f64 * CHARACTER;
    let right = width - 16.0;
    let head = if title.is_empty() { 12.0 } else { 36.0 };
    let places = lay_out_legend(keys, left, right);
    let rows = places.last().map_or(0.0, |(_, row)| row + 1.0);
    let top = head + rows * ROW;
    let area = Area { x, y, width: right - left, height: height - 45.0 - top };
    let middle = Px(-(top + area.height / 2.0));
    html! {
        svg.chart viewBox={ "0 0 " (width) " " (height) } role="img" style={ "max-width:" (width) "px" } {
            title { @if title.is_empty() { (y.title) " against " (x.title) } @else { (title) } }
            text.ti x=(Px(left)) y="18" { (title) }
            @for (key, (x, row)) in keys.iter().zip(places) {
                g.key data-series=(key.series) transform={ "translate(" (Px(x)) "," (Px(head + row * ROW)) ")" } {
                    rect.hit y="-10" width=(Px(key.width())) height=(ROW) {}
                    @if key.line { (polyline(&format!("l{}", key.style), &[(0.0, 0.0), (36.0, 0.0)])) }
                    @if key.marker { (markers(key.style, &[(18.0, 0.0)])) }
                    text x="43" y="4" { (key.name) }
                }
            }
            text.at x=(Px((left + right) / 2.0)) y=(height - 6.0) text-anchor="middle" { (x.title) }
            text.at x=(middle) y="14" transform="rotate(-90)" text-anchor="middle" { (y.title) }
            g transform={ "translate(" (Px(left)) "," (Px(top)) ")" } {
                g.axes { (area.axes()) }
                (draw(&area))
            }
        }
    }
}

impl Key {
    fn width(&self) -> f64 {
        43.0 + self.name.chars().count() as f64 * CHARACTER
    }
}

/// The place of each entry of the legend: left edge and row.
fn lay_out_legend(keys: &[Key], left: f64, right: f64) -> Vec<(f64, f64)> {
    let (mut x, mut row) = (left, 0.0);
    keys.iter()
        .map(|key| {
            if x > left && x + key.width() > right {
                (x, row) = (left, row + 1.0);
            }
            let place = (x, row);
            x += key.width() + 22.0;
            place
        })
        .collect()
}
