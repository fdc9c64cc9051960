//! Sensitivities ranked: the most influential dispersion on top.

use maud::{Markup, html};

use super::super::format::typeset;
use super::axis::Axis;

/// One dispersion and what it does to the result.
#[derive(Clone, Debug, PartialEq)]
pub struct TornadoBar {
    /// What is dispersed, and by how much (`Bending frequency ±10 %`).
    pub name: String,
    /// The result at the lower setting.
    pub low: f64,
    /// The result at the upper setting.
    pub high: f64,
}

/// What a tornado plot shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Tornado {
    /// Heading inside the figure.
    pub title: String,
    /// The result and its unit.
    pub x: Axis,
    /// The result without dispersion.
    pub nominal: f64,
    /// In any order; they are ranked here by their total span.
    pub bars: Vec<TornadoBar>,
}

/// The plot as SVG.
pub fn tornado(spec: &Tornado) -> Markup {
    let mut bars: Vec<&TornadoBar> = spec.bars.iter().collect();
    let span = |bar: &TornadoBar| {
        let reach = [bar.low, bar.high, spec.nominal].map(|v| spec.x.map(v));
        let all = reach.iter().flatten();
        let (low, high) =
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        high - low
    };
    bars.sort_by(|a, b| span(b).total_cmp(&span(a)));
    let values = bars.iter().flat_map(|bar| [bar.low, bar.high]);
    let mut axis = spec.x.clone();
    axis.range = None;
    let fitted = axis.fit(values.chain([spec.nominal]).filter_map(|v| axis.map(v)), 7, 0.0);
    // Room for the values written outside the bars' ends.
    let room = (fitted.high - fitted.low) * 0.16;
    let (low, high) = (fitted.low - room, fitted.high + room);
    let longest = bars.iter().map(|b| b.name.chars().count()).max().unwrap_or(0);
    let left = (longest as f64 * 7.6 + 24.0).clamp(120.0, 374.0);
    let right = 745.0;
    let (top, pitch) = (84.0, 27.0);
    let bottom = top + pitch * bars.len() as f64 + 6.0;
    let at = |v: f64| left + (v - low) / (high - low) * (right - left);
    let tenth = |v: f64| format!("{v:.1}");
    let nominal = axis.map(spec.nominal).map(at);
    html! {
        svg.chart viewBox=(format!("0 0 7600 {:.0}", (bottom + 52.0) * 10.0)) role="img"
            aria-label=(spec.title) style="max-width:760px" {
            g transform="scale(10)" {
                text.ti.px x=(tenth(left)) y="18" { (spec.title) }
                rect.b0 x=(tenth(left)) y="33" width="16" height="12" {}
                text.lg.px x=(tenth(left + 22.0)) y="43" { "lower setting" }
                rect.b1 x=(tenth(left + 130.0)) y="33" width="16" height="12" {}
                text.lg.px x=(tenth(left + 152.0)) y="43" { "upper setting" }
                @for (tick, label) in fitted.ticks.iter().zip(&fitted.labels) {
                    line.gr.px x1=(tenth(at(*tick))) x2=(tenth(at(*tick))) y1=(tenth(top - 6.0)) y2=(tenth(bottom)) {}
                    text.tt.px x=(tenth(at(*tick))) y=(tenth(bottom + 16.0)) text-anchor="middle" { (label) }
                }
                text.at.px x=(tenth((left + right) / 2.0)) y=(tenth(bottom + 40.0)) text-anchor="middle" { (fitted.title) }
                @for (row, bar) in bars.iter().enumerate() {
                    @let y = top + pitch * row as f64;
                    text.lg.px x=(tenth(left - 10.0)) y=(tenth(y + 14.0)) text-anchor="end" { (shortened(&bar.name, 46)) }
                    @if let Some(middle) = nominal {
                        @for (style, value, other) in [(0, bar.low, bar.high), (1, bar.high, bar.low)] {
                            @if let Some(end) = axis.map(value).map(at) {
                                // Both settings on one side: they share the bar's height.
                                @let together = axis.map(other).map(at).is_some_and(|o| (o - middle) * (end - middle) > 0.0);
                                @let (dy, height) = match (together, style) { (false, _) => (0.0, 19.0), (true, 0) => (0.0, 9.0), (true, _) => (10.0, 9.0) };
                                rect.{ "b" (style) } x=(tenth(end.min(middle))) y=(tenth(y + dy)) width=(tenth((end - middle).abs())) height=(tenth(height)) {}
                                @if !together || (end - middle).abs() >= axis.map(other).map(at).map_or(0.0, |o| (o - middle).abs()) {
                                    @let before = end < middle || (end == middle && style == 0);
                                    text.tt.px x=(tenth(if before { end - 5.0 } else { end + 5.0 })) y=(tenth(y + 14.0))
                                        text-anchor=(if before { "end" } else { "start" }) { (typeset(value, 3)) }
                                }
                            }
                        }
                    }
                }
                @if let Some(middle) = nominal {
                    line.ax.px x1=(tenth(middle)) x2=(tenth(middle)) y1=(tenth(top - 6.0)) y2=(tenth(bottom)) {}
                    text.mt.px x=(tenth(middle)) y=(tenth(top - 10.0)) text-anchor="middle" { "nominal " (typeset(spec.nominal, 3)) }
                }
            }
        }
    }
}

/// At most `most` characters, the cut shown.
fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    name.chars().take(most - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn bars_are_ranked_by_span() {
        let bar = |name: &str, low, high| TornadoBar { name: name.to_owned(), low, high };
        let svg = tornado(&Tornado {
            title: "t".to_owned(),
            x: Axis::new("Overshoot", "%"),
            nominal: 10.0,
            bars: vec![bar("small", 9.0, 11.0), bar("large", 2.0, 19.0)],
        })
        .into_string();
        assert!(svg.find("large").unwrap() < svg.find("small").unwrap());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_bars_draw(nominal: f64, ends: Vec<(f64, f64)>, log: bool) {
            let x = Axis::new("x", "");
            let svg = tornado(&Tornado {
                title: String::new(),
                x: if log { x.log() } else { x },
                nominal,
                bars: ends
                    .into_iter()
                    .map(|(low, high)| TornadoBar { name: "n".repeat(60), low, high })
                    .collect(),
            })
            .into_string();
            prop_assert!(svg.ends_with("</svg>") && !svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}
