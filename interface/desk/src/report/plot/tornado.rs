//! Sensitivities ranked: the most influential dispersion on top.

use maud::{Markup, html};

use super::super::format::{typeset, with_unit};
use super::axis::Axis;

/// One dispersion and what it does to the result.
#[derive(Clone, Debug, PartialEq)]
pub struct TornadoBar {
    /// What is dispersed, and by how much (`Bending frequency ±10 %`).
    pub name: String,
    pub low: f64,
    pub high: f64,
}

/// What a tornado plot shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Tornado {
    pub title: String,
    pub x: Axis,
    pub nominal: f64,
    /// In any order; they are ranked here by their total span.
    pub bars: Vec<TornadoBar>,
}

/// The plot as a table: both results as numbers, and their bars from the nominal one.
pub fn tornado(spec: &Tornado) -> Markup {
    let extent = |values: &mut dyn Iterator<Item = f64>| {
        let mapped = values.filter_map(|value| spec.x.map(value));
        mapped.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    };
    let span = |bar: &TornadoBar| {
        let (low, high) = extent(&mut [bar.low, bar.high, spec.nominal].into_iter());
        high - low
    };
    let mut bars: Vec<&TornadoBar> = spec.bars.iter().collect();
    bars.sort_by(|a, b| span(b).total_cmp(&span(a)));
    let ends = bars.iter().flat_map(|bar| [bar.low, bar.high]);
    let (low, high) = extent(&mut ends.chain([spec.nominal]));
    // Percent of the bars' column; in the middle where nothing differs.
    let place = |value: f64| {
        let share = (spec.x.map(value)? - low) / (high - low);
        Some(if share.is_finite() { 100.0 * share } else { 50.0 })
    };
    let nominal = place(spec.nominal);
    let unit = &spec.x.unit;
    html! {
        div.wide {
            table.tornado {
                caption { b { (spec.title) } }
                thead { tr {
                    th scope="col" { "Dispersion" }
                    th.n scope="col" { "Lower setting" small { (unit) } }
                    th scope="col" {
                        (spec.x.label) small { "nominal " (with_unit(spec.nominal, 3, unit)) }
                    }
                    th.n scope="col" { "Upper setting" small { (unit) } }
                } }
                tbody {
                    @for bar in bars {
                        tr {
                            th scope="row" { (bar.name) }
                            td.n { (typeset(bar.low, 3)) }
                            td.bars style=[nominal.map(|at| format!("--n:{at:.1}%"))] {
                                @for (class, value) in [("lower", bar.low), ("upper", bar.high)] {
                                    @if let Some((from, to)) = nominal.zip(place(value)) {
                                        i class=(class) style=(format!("left:{:.1}%;width:{:.1}%", from.min(to), (to - from).abs())) {}
                                    }
                                }
                            }
                            td.n { (typeset(bar.high, 3)) }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_ranked_by_span() {
        let bar = |name: &str, low, high| TornadoBar { name: name.to_owned(), low, high };
        let html = tornado(&Tornado {
            title: "t".to_owned(),
            x: Axis::new("Overshoot", "%"),
            nominal: 10.0,
            bars: vec![bar("slight", 9.0, 11.0), bar("large", 2.0, 19.0)],
        })
        .into_string();
        assert!(html.find("large").unwrap() < html.find("slight").unwrap());
        // From 2 to 19 the nominal 10 stands at 8/17, the slight bar’s end at 7/17.
        assert!(html.contains("--n:47.1%") && html.contains("left:41.2%;width:5.9%"), "{html}");
        assert!(html.contains("left:0.0%;width:47.1%"), "{html}");
    }
}
