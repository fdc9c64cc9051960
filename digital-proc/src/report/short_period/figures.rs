//! Responses drawn: the variables of the paper's Table 1, several runs on one pair of axes.

use maud::Markup;

use crate::study::short_period::response::{
    Channel, PITCH_CHANNELS, PitchResponse, Response, YAW_ROLL_CHANNELS, YawRollResponse,
};
use desk::report::plot::{Axis, Limit, LineChart, STYLES, Series, Size, line_chart};
use desk::report::{Numbering, side_by_side};

/// A run with its name in the legend.
pub type Named<'a, R> = (String, &'a R);

/// Channels of a figure of their own, in its order.
const PITCH: [usize; 6] = [0, 1, 2, 3, 4, 5];
const PITCH_PAIR: [usize; 2] = [0, 3];
const YAW_ROLL: [usize; 12] = [0, 2, 10, 11, 9, 7, 8, 1, 3, 4, 5, 6];

/// Figures of the pitch loop's Table 1 variables, side by side.
pub fn pitch_figures(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    runs: &[Named<'_, PitchResponse>],
) -> Markup {
    panels(numbering, id, where_, &PITCH_CHANNELS, &PITCH, runs, &[])
}

/// Attitude and bending coordinate only.
pub fn pitch_pair(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    runs: &[Named<'_, PitchResponse>],
) -> Markup {
    panels(numbering, id, where_, &PITCH_CHANNELS, &PITCH_PAIR, runs, &[])
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
    let travel = tip_travel_rad.map(f64::to_degrees);
    let limits: Vec<(usize, f64, &str)> = travel
        .into_iter()
        .flat_map(|t| {
            [10, 11]
                .into_iter()
                .flat_map(move |channel| [(channel, t, "travel"), (channel, -t, "travel")])
        })
        .collect();
    panels(numbering, id, where_, &YAW_ROLL_CHANNELS, &YAW_ROLL, runs, &limits)
}

/// At most this many runs share a pair of axes, so that each has its own line style.
pub const MOST_RUNS: usize = STYLES;

fn panels<const N: usize>(
    numbering: &mut Numbering,
    id: &str,
    where_: &str,
    channels: &[Channel; N],
    drawn: &[usize],
    runs: &[Named<'_, Response<N>>],
    limits: &[(usize, f64, &str)],
) -> Markup {
    let figures: Vec<Markup> = drawn
        .iter()
        .enumerate()
        .map(|(n, &channel)| {
            let Channel { label, shown_unit, factor, .. } = channels[channel];
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
                ..LineChart::new("", Axis::new("Time", "s"), Axis::new(label, shown_unit), series)
            };
            let anchor = if n == 0 { id.to_owned() } else { format!("{id}-{n}") };
            numbering.figure(&anchor, &format!("{label}, {where_}."), line_chart(&chart))
        })
        .collect();
    side_by_side(&figures)
}
