//! What a line chart shows: series and limits on two axes.

use super::axis::Axis;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Draw {
    Line,
    /// Each value held until the next point, as a converter holds it.
    Step,
    Markers,
    LineAndMarkers,
}

impl Draw {
    pub(super) fn line(self) -> bool {
        self != Draw::Markers
    }

    pub(super) fn marker(self) -> bool {
        matches!(self, Draw::Markers | Draw::LineAndMarkers)
    }
}

/// One curve. Where `x` or `y` is not finite (or the shorter of them ends) it has a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub name: String,
    /// Abscissae, in the axis's unit.
    pub x: Vec<f64>,
    /// Ordinates, in the axis's unit.
    pub y: Vec<f64>,
    pub draw: Draw,
    /// Colour, dash and marker; its place in the chart when absent.
    pub style: Option<usize>,
}

impl Series {
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series { name: name.into(), x: x.to_vec(), y: y.to_vec(), draw: Draw::Line, style: None }
    }

    /// Points (x, y) joined by lines.
    pub fn of(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Series {
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        Series { name: name.into(), x, y, draw: Draw::Line, style: None }
    }

    pub fn markers(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Markers)
    }

    /// A sampled and held curve.
    pub fn step(name: impl Into<String>, x: &[f64], y: &[f64]) -> Series {
        Series::line(name, x, y).draw(Draw::Step)
    }

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
    pub name: String,
}

/// Size of a figure, CSS pixels at full width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u16,
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
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub limits: Vec<Limit>,
    pub size: Size,
}

impl LineChart {
    /// A chart without limits, at full size.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, series: Vec<Series>) -> LineChart {
        LineChart { title: title.into(), x, y, series, limits: Vec::new(), size: Size::FULL }
    }

    pub fn limit(mut self, value: f64, name: impl Into<String>) -> LineChart {
        self.limits.push(Limit { value, name: name.into() });
        self
    }

    pub fn size(mut self, size: Size) -> LineChart {
        self.size = size;
        self
    }
}
