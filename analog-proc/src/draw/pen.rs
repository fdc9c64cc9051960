//! The strokes of which symbols are made: outlines, small curves, boxes, flags.

use maud::{Markup, PreEscaped, html};

/// What draws a symbol: the elements so far, its middle, and half of its size.
pub(crate) struct Pen {
    pub(super) elements: String,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) half_width: f64,
    pub(crate) half_height: f64,
}

impl Pen {
    fn add(&mut self, element: Markup) {
        self.elements.push_str(&element.0);
    }

    pub(super) fn markup(self) -> Markup {
        PreEscaped(self.elements)
    }

    /// A body with an outline of its own, in the commands of an SVG path.
    pub(crate) fn body(&mut self, d: &str) {
        self.add(html! { path class="body" d=(d) {} });
    }

    pub(crate) fn text(&mut self, dx: f64, dy: f64, class: &str, content: &str) {
        self.add(text(self.x + dx, self.y + dy, class, content));
    }

    /// A path through points about the middle, in halves of the symbol's size.
    pub(crate) fn outline(&mut self, class: &str, points: &[(f64, f64)], is_closed: bool) {
        let (x, y) = (self.x, self.y);
        let at = |(px, py): &(f64, f64)| (x + px * self.half_width, y + py * self.half_height);
        let d = path(points.iter().map(at)) + if is_closed { "Z" } else { "" };
        self.add(html! { path class=(class) d=(d) {} });
    }

    /// A small curve in a square of ±14 about the middle; y upwards.
    pub(crate) fn curve(&mut self, class: &str, points: &[(f64, f64)]) {
        let (x, y) = (self.x, self.y);
        let d = path(points.iter().map(|(px, py)| (x + px * 14.0, y - py * 14.0)));
        self.add(html! { path class=(class) d=(d) {} });
    }

    pub(crate) fn frame(&mut self) {
        let (w, h) = (self.half_width, self.half_height);
        self.add(rect("body", [self.x - w, self.y - h, 2.0 * w, 2.0 * h], 2.0));
    }

    /// A circle `dx` halves of the symbol's width right of its middle, `radius` of them wide.
    pub(crate) fn circle(&mut self, dx: f64, radius: f64) {
        let x = self.x + dx * self.half_width;
        self.add(circle("body", x, self.y, round(radius * self.half_width)));
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

/// An open path through points of the page.
pub(super) fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let step = |(i, (x, y))| format!("{}{} {}", if i == 0 { 'M' } else { 'L' }, round(x), round(y));
    points.enumerate().map(step).collect()
}

pub(super) fn text(x: f64, y: f64, class: &str, content: &str) -> Markup {
    html! { text class=(class) x=(round(x)) y=(round(y)) { (content) } }
}

pub(super) fn circle(class: &str, x: f64, y: f64, radius: f64) -> Markup {
    html! { circle class=(class) cx=(round(x)) cy=(round(y)) r=(radius) {} }
}

/// A rectangle of left edge, top, width and height.
pub(super) fn rect(class: &str, [x, y, width, height]: [f64; 4], radius: f64) -> Markup {
    html! {
        rect class=(class) x=(round(x)) y=(round(y)) width=(round(width)) height=(round(height)) rx=(radius) {}
    }
}

/// A length to a tenth of a pixel.
pub(crate) fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
