//! A matrix of conditions against points, coloured by value, each cell a link.
//!
//! It is a table, not a picture: it can be read aloud, copied and searched, and its text
//! stays legible in print, because the tint is light and every cell bears its number. A
//! cell outside its criterion bears a mark as well, never colour alone.

use maud::{Markup, html};

use super::super::format::typeset;

/// Significant digits.
const DIGITS: usize = 2;

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatCell {
    /// Its value; not finite shows as a dash.
    pub value: f64,
    /// Whether it violates its criterion.
    pub violated: bool,
    /// Where it leads (`#response-3`).
    pub href: Option<String>,
}

impl HeatCell {
    /// A cell without a link that violates nothing.
    pub fn new(value: f64) -> HeatCell {
        HeatCell { value, violated: false, href: None }
    }
}

/// The matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// What the values are, with unit and criterion.
    pub quantity: String,
    /// Heading of the corner (`Condition`).
    pub corner: String,
    pub rows: Vec<String>,
    pub columns: Vec<String>,
    /// Cells by row; a short or missing row is filled with dashes.
    pub cells: Vec<Vec<HeatCell>>,
    /// Values of the palest and the deepest tint; the data's extremes when absent.
    pub scale: Option<(f64, f64)>,
}

/// The matrix as a table with its colour scale.
pub fn heat_map(map: &HeatMap) -> Markup {
    let finite = map.cells.iter().flatten().map(|c| c.value).filter(|v| v.is_finite());
    let (low, high) = map.scale.unwrap_or_else(|| {
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    });
    // Half before subtracting: the span of two finite numbers may overflow.
    let tint = |value: f64| {
        let share = (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0);
        if share.is_finite() { (share.clamp(0.0, 1.0) * 100.0).round() } else { 0.0 }
    };
    let blank = HeatCell::new(f64::NAN);
    html! {
        div.wide {
            table.heat {
                thead { tr {
                    th scope="col" { (map.corner) }
                    @for column in &map.columns { th scope="col" { (column) } }
                } }
                tbody {
                    @for (r, row) in map.rows.iter().enumerate() {
                        tr {
                            th scope="row" { (row) }
                            @for c in 0..map.columns.len() {
                                @let cell = map.cells.get(r).and_then(|cells| cells.get(c)).unwrap_or(&blank);
                                td.violated[cell.violated] style=(format!("--v:{}%", tint(cell.value))) {
                                    @if let Some(href) = &cell.href {
                                        a href=(href) { (content(cell)) }
                                    } @else {
                                        (content(cell))
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
        p.scale {
            (map.quantity) ". "
            @if low < high && low.is_finite() && high.is_finite() {
                span.nobreak { (typeset(low, DIGITS)) " " span.ramp {} " " (typeset(high, DIGITS)) }
                " "
            }
            @if map.cells.iter().flatten().any(|cell| cell.violated) {
                span.nobreak { "✗ outside the criterion" }
            }
        }
    }
}

fn content(cell: &HeatCell) -> Markup {
    html! { @if cell.violated { "✗\u{202f}" } (typeset(cell.value, DIGITS)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_violated_cell_is_marked_in_text_and_linked() {
        let html = heat_map(&HeatMap {
            quantity: "Residual".to_owned(),
            corner: String::new(),
            rows: vec!["normal".to_owned()],
            columns: vec!["2 s".to_owned()],
            cells: vec![vec![HeatCell {
                value: 31.0,
                violated: true,
                href: Some("#r1".to_owned()),
            }]],
            scale: Some((0.0, 100.0)),
        })
        .into_string();
        assert!(
            html.contains("--v:31%") && html.contains("<a href=\"#r1\">✗\u{202f}31</a>"),
            "{html}"
        );
    }
}
