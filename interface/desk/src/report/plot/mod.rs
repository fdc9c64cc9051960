//! Figures as SVG text, to be set into a page whose style sheet colours them.
//!
//! The drawing itself knows roles (axis, grid, third line), never colours, so that one
//! figure serves light, dark and paper; lines differ by dash and markers by shape as well
//! as by colour. Values that are not finite leave gaps. No input makes a figure panic: a
//! chart with nothing to draw says so in its frame.

mod axis;
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
