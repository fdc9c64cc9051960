//! The strokes of which symbols are made: outlines, small curves, boxes, flags.

use svg::node::element::{Circle, Group, Path, Rectangle, Text};

/// What draws a symbol: its group so far, its middle, and half of its size.
pub(crate) struct Pen {
    pub(crate) group: Group,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) half_width: f64,
    pub(crate) half_height: f64,
}

impl Pen {
    pub(crate) fn add(&mut self, node: impl Into<Box<dyn svg::node::Node>>) {
        let group = std::mem::take(&mut self.group);
        self.group = group.add(node);
    }

    pub(crate) fn text(&mut self, dx: f64, dy: f64, class: &str, text: &str) {
        let node = Text::new(text)
            .set("class", class)
            .set("x", round(self.x + dx))
            .set("y", round(self.y + dy));
        self.add(node);
    }

    /// A path through points about the middle, in halves of the symbol's size.
    pub(crate) fn outline(&mut self, class: &str, points: &[(f64, f64)], is_closed: bool) {
        let mut d = String::new();
        for (i, (px, py)) in points.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            let px = round(self.x + px * self.half_width);
            let py = round(self.y + py * self.half_height);
            d.push_str(&format!("{command}{px} {py}"));
        }
        if is_closed {
            d.push('Z');
        }
        self.add(Path::new().set("class", class).set("d", d));
    }

    /// A small curve in a square of ±14 about the middle; y upwards.
    pub(crate) fn curve(&mut self, class: &str, points: &[(f64, f64)]) {
        let mut d = String::new();
        for (i, (px, py)) in points.iter().enumerate() {
            let command = if i == 0 { 'M' } else { 'L' };
            let (px, py) = (round(self.x + px * 14.0), round(self.y - py * 14.0));
            d.push_str(&format!("{command}{px} {py}"));
        }
        self.add(Path::new().set("class", class).set("d", d));
    }

    pub(crate) fn frame(&mut self) {
        let node = Rectangle::new()
            .set("class", "body")
            .set("x", round(self.x - self.half_width))
            .set("y", round(self.y - self.half_height))
            .set("width", round(2.0 * self.half_width))
            .set("height", round(2.0 * self.half_height))
            .set("rx", 2);
        self.add(node);
    }

    pub(crate) fn circle(&mut self) {
        let node = Circle::new()
            .set("class", "body")
            .set("cx", round(self.x))
            .set("cy", round(self.y))
            .set("r", round(self.half_width));
        self.add(node);
    }

    pub(crate) fn triangle(&mut self) {
        self.outline("body", &[(-1.0, -1.0), (1.0, 0.0), (-1.0, 1.0)], true);
    }

    pub(crate) fn boxed(&mut self, sign: &str) {
        self.frame();
        let class = if sign.chars().count() > 2 { "word" } else { "sign" };
        let drop = if class == "sign" { 8.0 } else { 4.5 };
        self.text(0.0, drop, class, sign);
    }

    pub(crate) fn characteristic(&mut self, points: &[(f64, f64)]) {
        self.frame();
        self.curve("axis", &[(-1.1, 0.0), (1.1, 0.0)]);
        self.curve("axis", &[(0.0, -1.1), (0.0, 1.1)]);
        self.curve("plot", points);
    }

    /// A flag that points the way of the signal.
    pub(crate) fn flag(&mut self, text: &str) {
        let points = [(-1.0, -1.0), (0.6, -1.0), (1.0, 0.0), (0.6, 1.0), (-1.0, 1.0)];
        self.outline("body", &points, true);
        self.text(-4.0, 4.0, "tiny", text);
    }
}

/// A length to a tenth of a pixel.
pub(crate) fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
