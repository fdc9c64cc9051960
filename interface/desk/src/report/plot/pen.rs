//! What figures are written with: lengths to a tenth of a pixel, runs of points, markers.
//!
//! Elements and attributes are maud's, which escapes them. A shape says by its class what it is;
//! the page's style sheet says how that looks.

use std::fmt::Write as _;

use maud::{Markup, Render, html};

/// Pixels from the left and from the top.
pub(super) type Point = (f64, f64);

/// A length, written to a tenth of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Px(pub(super) f64);

impl Render for Px {
    fn render_to(&self, text: &mut String) {
        // Zero is added for its sign: no `-0`. Writing to a String cannot fail.
        let _ = write!(text, "{}", ((self.0 * 10.0).round() + 0.0) / 10.0);
    }
}

/// A line through `points`, as `class`.
pub(super) fn polyline(class: &str, points: &[Point]) -> Markup {
    html! {
        polyline class=(class)
            points={ @for (n, &(x, y)) in points.iter().enumerate() { @if n > 0 { " " } (Px(x)) "," (Px(y)) } } {}
    }
}

/// Markers at `points`, all in one path; every style has its shape. Only their places are
/// written in absolute coordinates, which is how the page's script moves them.
pub(super) fn markers(style: usize, points: &[Point]) -> Markup {
    const SHAPES: [&str; 4] = [
        "m-3.6,0a3.6,3.6,0,1,0,7.2,0a3.6,3.6,0,1,0,-7.2,0z",
        "m-3.4,-3.4h6.8v6.8h-6.8z",
        "m0,-4.4l4.2,7.6h-8.4z",
        "m0,-4.6l4.6,4.6l-4.6,4.6l-4.6,-4.6z",
    ];
    html! {
        path.{ "m" (style) }
            d={ @for &(x, y) in points { "M" (Px(x)) "," (Px(y)) (SHAPES[style % 4]) } } {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_written_to_a_tenth() {
        let points = [(0.0, -0.04), (1.0 / 3.0, 99.96), (-12.25, 1e7)];
        assert_eq!(
            polyline("l0", &points).into_string(),
            "<polyline class=\"l0\" points=\"0,0 0.3,100 -12.3,10000000\"></polyline>"
        );
        let squares = markers(5, &[(1.0, 2.0), (3.0, 4.0)]).into_string();
        assert!(squares.contains("d=\"M1,2m-3.4,-3.4h6.8v6.8h-6.8zM3,4m"), "{squares}");
    }
}
