//! Responses drawn: the variables of the paper's Table 1, several runs on one pair of axes.

use maud::Markup;

use crate::report::plot::{Axis, Limit, LineChart, STYLES, Series, Size, line_chart};
use crate::report::{Numbering, side_by_side};
use crate::study::short_period::response::{PitchResponse, Response, YawRollResponse};

/// A run with its name in the legend.
pub type Named<'a, R> = (String, &'a R);

/// One figure: quantity, unit, factor from SI, channel.
type Panel = (&'static str, &'static str, f64, usize);

const DEG: f64 = 180.0 / std::f64::consts::PI;

const PITCH: [Panel; 6] = [
    ("Pitch attitude θ", "°", DEG, 0),
    ("Pitch rate", "°/s", DEG, 1),
    ("Angle of attack α", "°", DEG, 2),
    ("First bending coordinate η", "mm", 1e3, 3),
    ("FTC force", "kN", 1e-3, 4),
    ("TVC force", "kN", 1e-3, 5),
];

const YAW_ROLL: [Panel; 12] = [
    ("Yaw error ψ", "°", DEG, 0),
    ("Roll error φ", "°", DEG, 2),
    ("Tip 2", "°", DEG, 10),
    ("Tip 4", "°", DEG, 11),
    ("TVC force, yaw", "kN", 1e-3, 9),
    ("FTC force, yaw", "kN", 1e-3, 7),
    ("FTC force, roll", "kN", 1e-3, 8),
    ("Yaw rate", "°/s", DEG, 1),
    ("Roll rate", "°/s", DEG, 3),
    ("Yaw angle of attack", "°", DEG, 4),
    ("Yaw angle-of-attack rate", "°/s", DEG, 5),
    ("First bending coordinate η", "mm", 1e3, 6),
];

/// Figures of the pitch loop's Table 1 variables, side by side.
pub fn pitch_figures(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    runs: &[Named<'_, PitchResponse>],
) -> Markup {
    panels(numbering, id, where_, &PITCH, runs, &[])
}

/// Attitude and bending coordinate only.
pub fn pitch_pair(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    runs: &[Named<'_, PitchResponse>],
) -> Markup {
    panels(numbering, id, where_, &[PITCH[0], PITCH[3]], runs, &[])
}

/// Figures of the yaw and roll loops' Table 1 variables; `tip_travel_rad` is drawn as
/// the tips' limit.
pub fn yaw_roll_figures(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    runs: &[Named<'_, YawRollResponse>],
    tip_travel_rad: Option<f64>,
) -> Markup {
    let travel = tip_travel_rad.map(|t| t * DEG);
    let limits: Vec<(usize, f64, &str)> = travel
        .into_iter()
        .flat_map(|t| {
            [10, 11]
                .into_iter()
                .flat_map(move |channel| [(channel, t, "travel"), (channel, -t, "travel")])
        })
        .collect();
    panels(numbering, id, where_, &YAW_ROLL, runs, &limits)
}

/// At most this many runs share a pair of axes, so that each has its own line style.
pub const MOST_RUNS: usize = STYLES;

fn panels<const N: usize>(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    panels: &[Panel],
    runs: &[Named<'_, Response<N>>],
    limits: &[(usize, f64, &str)],
) -> Markup {
    let figures: Vec<Markup> = panels
        .iter()
        .enumerate()
        .map(|(n, &(label, unit, factor, channel))| {
            let series = runs
                .iter()
                .map(|(name, response)| {
                    let time: Vec<f64> = (0..response.len()).map(|i| response.time_s(i)).collect();
                    let values: Vec<f64> =
                        response.channel(channel).iter().map(|v| v * factor).collect();
                    let name = if runs.len() > 1 { name.as_str() } else { "" };
                    Series::line(name, &time, &values)
                })
                .collect();
            let chart = LineChart {
                limits: limits
                    .iter()
                    .filter(|limit| limit.0 == channel)
                    .map(|&(_, value, name)| Limit { value, name: name.to_owned() })
                    .collect(),
                size: Size::HALF,
                ..LineChart::new("", Axis::new("Time", "s"), Axis::new(label, unit), series)
            };
            let anchor = if n == 0 { id.to_owned() } else { format!("{id}-{n}") };
            numbering.figure(&anchor, &format!("{label}, {where_}."), line_chart(&chart))
        })
        .collect();
    side_by_side(&figures)
}
