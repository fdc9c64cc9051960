//! Figures as SVG text, to be set into a page whose style sheet colours them.
//!
//! The drawing itself knows roles (axis, grid, third line), never colours, so that one
//! figure serves light, dark and paper; lines differ by dash and markers by shape as well
//! as by colour. Values that are not finite leave gaps. No input makes a figure panic: a
//! chart with nothing to draw says so in its frame.

mod axis;
mod category_map;
mod chart;
mod compared;
mod curve;
mod decimate;
mod frame;
mod heat_map;
mod histogram;
mod line_chart;
mod pen;
mod tornado;

pub use axis::{Axis, Scale};
pub use category_map::{CategoryMap, category_map};
pub use chart::{Draw, Limit, LineChart, Series, Size};
pub use compared::{Compared, measured_vs_theory};
pub use heat_map::{HeatCell, HeatMap, heat_map};
pub use histogram::histogram;
pub use line_chart::line_chart;
pub use tornado::{Tornado, TornadoBar, tornado};

/// Number of line styles before they repeat.
pub const STYLES: usize = 8;

/// Magnitudes beyond this are drawn as gaps: their spans would overflow.
const LARGEST: f64 = 1e150;

/// `value` when it can be drawn.
fn drawable(value: f64) -> Option<f64> {
    (value.abs() <= LARGEST).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_values() -> impl Strategy<Value = Vec<f64>> {
        let value =
            prop_oneof![any::<f64>(), Just(f64::NAN), Just(f64::INFINITY), Just(0.0), -1e3..1e3];
        proptest::collection::vec(value, 0..1_200)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        /// Every figure of any data is whole and shows no value that is none.
        #[test]
        fn any_data_draw(
            xs in any_values(), ys in any_values(), at: f64, bins: usize, log: bool,
            range: Option<(f64, f64)>, style in 0..4_usize, rows in 0..6_usize, columns in 0..6_usize,
        ) {
            let scale = if log { Scale::Log } else { Scale::Linear };
            let axis = || Axis { range, scale, ..Axis::new("x", "m/s²") };
            let draw = [Draw::Line, Draw::Step, Draw::Markers, Draw::LineAndMarkers][style];
            let series = vec![Series::line("", &xs, &ys).draw(draw); style];
            let title = String::new;
            let lines = LineChart::new("t", axis(), axis(), series).limit(at, "limit");
            let ends = xs.iter().zip(&ys);
            let effects = Tornado {
                title: title(),
                x: axis(),
                nominal: at,
                bars: ends.map(|(&low, &high)| TornadoBar { name: "n".repeat(60), low, high }).collect(),
            };
            let cells = HeatMap {
                quantity: title(),
                corner: title(),
                rows: (0..rows).map(|n| n.to_string()).collect(),
                columns: (0..columns).map(|n| n.to_string()).collect(),
                cells: xs.chunks(5).map(|row| row.iter().map(|&v| HeatCell::new(v)).collect()).collect(),
                scale: range,
            };
            let cells = heat_map(&cells).into_string();
            prop_assert_eq!(cells.matches("<td").count(), rows * columns);
            prop_assert!(!cells.contains("NaN"));
            for (figure, end) in [
                (line_chart(&lines), "</svg>"),
                (histogram(&axis(), ys.iter().copied(), bins), "</svg>"),
                (tornado(&effects), "</div>"),
            ] {
                let figure = figure.into_string();
                prop_assert!(figure.ends_with(end), "{}", figure);
                prop_assert!(!figure.contains("NaN") && !figure.contains("inf"), "{}", figure);
            }
        }
    }
}
