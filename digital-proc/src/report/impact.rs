//! Tracks of the instantaneous impact point over the ground, and the corridor about them.

use desk::report::plot::{Axis, LineChart, Series};
use vehicle::RangeSafety;

/// What the chart shows.
pub const IMPACT_CAPTION: &str = "Instantaneous impact point (in vacuum, non-rotating Earth) over the ground, along and across the track of the launch plane, starboard positive, and the edges of its corridor.";

/// Tracks by name, each as distances down the range and across it in m.
pub fn impact_chart<V: AsRef<[f64]>>(
    tracks: &[(&str, [V; 2])],
    corridor: &RangeSafety,
) -> LineChart {
    let km = |values: &V| values.as_ref().iter().map(|v| v / 1e3).collect::<Vec<f64>>();
    let mut series: Vec<Series> = tracks
        .iter()
        .map(|(name, [down, across])| Series::line(*name, &km(down), &km(across)))
        .collect();
    let down = tracks.iter().flat_map(|(_, [down, _])| down.as_ref().iter().copied());
    let far_m = down.filter(|d| d.is_finite()).fold(0.0, f64::max);
    let (near_m, far_km) = (-corridor.behind_m, far_m / 1e3);
    for (name, side) in [("edge of the corridor", 1.0), ("", -1.0)] {
        let half = |at_m| side * corridor.half_width_m(at_m) / 1e3;
        let edge = Series::line(
            name,
            &[near_m / 1e3, 0.0, far_km],
            &[half(near_m), half(0.0), half(far_m)],
        );
        series.push(edge.style(tracks.len()));
    }
    let axes = (Axis::new("Down the track", "km"), Axis::new("Across it", "km"));
    LineChart::new("", axes.0, axes.1, series)
}
