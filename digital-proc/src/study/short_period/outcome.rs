//! Short-period runs for people and machines: a row a run, the runs held against linear theory,
//! the responses drawn.

use super::{
    agreement::{Agreement, Compared},
    control_loop::{Channel, ControlLoop, Response},
    linear::{ChannelGains, Root},
    measure::{LARGE_YAW_BAND, PITCH_BAND, ROLL_BAND_DEG, YAW_BAND},
    metrics::Oscillation,
    moment,
    results::{Results, Run},
};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Column, Table, anchor,
        plot::{Axis, Limit, LineChart, STYLES, Series, Size, line_chart},
    },
    run_dir::{Curves, TRACE_FILE},
};
use maud::html;

/// Runs beyond this many are tabulated and traced, and only the worst are drawn.
const MOST_DRAWN: usize = 48;

/// What `short-period` came to.
pub fn outcome(title: &str, results: &Results) -> Outcome {
    let mut out = Outcome::new(
        title,
        "The control loops at frozen trajectory points, patched on the analog processor; coefficients, initial conditions and modes set by the digital one, run after run in one session.",
    );
    for control_loop in ControlLoop::ALL {
        if results.of(control_loop).next().is_some() {
            let (name, caption, table) = runs(control_loop, results);
            out.section("Measures").table(name, caption, table);
        }
    }
    agreement(results, &mut out);
    moment::outcome::fill(results, &mut out);
    responses(results, &mut out);
    remarks(results, &mut out);
    out.traces.push((TRACE_FILE, curves(results)));
    out
}

/// What happened in the runs, and that a linear one must agree with its eigenvalues.
pub(super) fn remarks(results: &Results, out: &mut Outcome) {
    let (linear, disagree) = results.linear();
    if linear > 0 {
        let agree = linear - disagree;
        out.remarks.push(format!(
            "{agree} of {linear} undisturbed runs that stay linear agree with their eigenvalues."
        ));
    }
    if disagree > 0 {
        out.refused.push(format!("{disagree} linear runs do not agree with their eigenvalues"));
    }
    let left_out = results.plan.left_out.iter();
    out.remarks.extend(left_out.map(|why| format!("left out on this vehicle: {why}")));
    out.remarks.extend(results.remarks());
}

fn percent(value: Option<f64>) -> Cell {
    value.map(|v| 100.0 * v).into()
}

fn degrees(value: Option<f64>) -> Cell {
    value.map(f64::to_degrees).into()
}

/// Name, caption and table of a loop's runs.
pub(super) fn runs(control_loop: ControlLoop, results: &Results) -> (&'static str, String, Table) {
    let mut columns: Vec<Column<Run>> = vec![
        Column::new("Point", "", |r| r.point.as_str().into()),
        Column::new("Condition", "", |r| r.condition.as_str().into()),
    ];
    let (name, caption) = match control_loop {
        ControlLoop::Pitch => {
            columns.extend([
                Column::new("Test", "", |r: &Run| r.case.test.words().into()),
                Column::new("Overshoot", "%", |r| percent(r.measures.overshoot)),
                Column::new("Settling", "s", |r| r.measures.settling_s.into()),
                Column::new("Residual", "%", |r| percent(r.measures.residual)),
                Column::new("η by 6.5 s", "%", |r| percent(r.measures.bending_ratio(1))),
                Column::new("η by 9.5 s", "%", |r| percent(r.measures.bending_ratio(2))),
                Column::new("Tips limited", "s", |r| r.measures.tip_saturation_s.into()),
                Column::new("TVC limited", "s", |r| r.measures.tvc_saturation_s.into()),
                Column::new("Greatest α", "deg", |r| degrees(r.measures.greatest_incidence_rad)),
                Column::new("ω, attitude", "rad/s", |r| {
                    r.measures.roots.attitude.map(|r| r.frequency_radps()).into()
                }),
                Column::new("ζ, attitude", "", |r| {
                    r.measures.roots.attitude.map(|r| r.damping()).into()
                }),
                Column::new("ζ, bending", "", |r| {
                    r.measures.roots.bending.map(|r| r.damping()).into()
                }),
                Column::new("Peak θ", "of the step", |r| r.measures.peak.into()),
                Column::new("Standing error", "deg", |r| degrees(r.measures.standing_error_rad)),
            ]);
            if results.plan.modes > 1 {
                columns.extend([
                    Column::new("ζ, bending 2", "", |r: &Run| {
                        r.measures.roots.higher[0].map(|r| r.damping()).into()
                    }),
                    Column::new("ζ, bending 3", "", |r: &Run| {
                        r.measures.roots.higher[1].map(|r| r.damping()).into()
                    }),
                ]);
            }
            let caption = format!(
                "Measures of each pitch run. Settling is to {:.0} % of the step about the final value; the residual is the peak-to-peak attitude from 5 to 10 s without its parabolic trend; η is the bending envelope over that of the first 2 s. Eigenvalues are those of the loop with both channels linear.",
                100.0 * PITCH_BAND
            );
            ("pitch", caption)
        }
        ControlLoop::YawRoll => {
            columns.extend([
                Column::new("Tips", "", |r: &Run| r.case.test.words().into()),
                Column::new("Given to roll", "s", |r| r.measures.tips_given_to_roll_s.into()),
                Column::new("Tips short", "s", |r| r.measures.tips_short_s.into()),
                Column::new("TVC begins", "s", |r| r.measures.tvc_begins_s.into()),
                Column::new("TVC called", "s", |r| r.measures.tvc_called_s.into()),
                Column::new("TVC peak", "N", |r| r.measures.tvc_peak_n.into()),
                Column::new("Roll fallen", "s", |r| r.measures.roll_fallen_s.into()),
                Column::new("Yaw share before", "%", |r| percent(r.measures.yaw_share_before)),
                Column::new("Yaw share then", "%", |r| percent(r.measures.yaw_share_after)),
                Column::new("Yaw settling", "s", |r| r.measures.settling_s.into()),
                Column::new("Roll settling", "s", |r| r.measures.roll_settling_s.into()),
                Column::new("Final yaw", "deg", |r| degrees(r.measures.final_rad.map(|f| f[0]))),
                Column::new("Final roll", "deg", |r| degrees(r.measures.final_rad.map(|f| f[1]))),
                Column::new("ω, yaw", "rad/s", |r| {
                    r.measures.roots.attitude.map(|r| r.frequency_radps()).into()
                }),
                Column::new("ζ, yaw", "", |r| {
                    r.measures.roots.attitude.map(|r| r.damping()).into()
                }),
            ]);
            let caption = format!(
                "Measures of each yaw–roll run. Settling is to {:.0} % of the yaw offset ({:.0} % of the large one) in yaw and to {ROLL_BAND_DEG}° in roll about the final value; the tips are short where, less what roll has of them, they cannot give what their gain asks for the yaw offset.",
                100.0 * YAW_BAND,
                100.0 * LARGE_YAW_BAND
            );
            ("yaw_roll", caption)
        }
    };
    let columns: Vec<_> = columns.into_iter().map(|column| column.digits(3)).collect();
    (name, caption, Table::of(&columns, results.of(control_loop)))
}

/// The runs held against linear theory.
pub(super) fn agreement(results: &Results, out: &mut Outcome) {
    if results.of(ControlLoop::Pitch).next().is_none() {
        return;
    }
    let section = out.section("Agreement with the linearised loop");
    if results.linear().0 == 0 {
        section.words(
            "No undisturbed pitch run stays in a linear range: nothing to compare with eigenvalues.",
        );
        return;
    }
    let columns: [Column<Run>; 10] = [
        Column::new("Run", "", |r| r.name.as_str().into()),
        Column::new("Linear range", "", |r| r.linear.map_or("", |a| range(a.gains)).into()),
        Column::of("Attitude differs by", "% of the step", 2, |r| {
            match r.linear.map(|a| a.compared) {
                Some(Compared::Response { attitude, .. }) => percent(Some(attitude)),
                _ => Cell::Missing,
            }
        }),
        Column::new("ω, eigenvalue", "rad/s", |r| decay(r).map(|d| d.1.frequency_radps()).into()),
        Column::new("ω, measured", "rad/s", |r| decay(r).map(|d| d.0.frequency_radps).into()),
        Column::of("ζ, eigenvalue", "", 3, |r| decay(r).map(|d| d.1.damping()).into()),
        Column::of("ζ, measured", "", 3, |r| decay(r).map(|d| d.0.damping).into()),
        Column::of("Allowed", "% of the step; of ω", 2, |r| {
            percent(r.linear.map(|a| a.within[0]))
        }),
        Column::of("Allowed for ζ", "%", 2, |r| match r.linear {
            Some(Agreement { compared: Compared::Decay { .. }, within, .. }) => {
                percent(Some(within[1]))
            }
            _ => Cell::Missing,
        }),
        Column::new("Agrees", "", |r| {
            if r.linear.is_some_and(|a| a.agrees()) { "yes" } else { "NO" }.into()
        }),
    ];
    section.table(
        "linear_agreement",
        "Undisturbed pitch runs that stay linear. Where every channel keeps to one range from the start, the whole response is held against the matrix exponential; where it does so from 4 s on, the decay of the bending coordinate is held against its eigenvalue. Allowed is what integration and measuring leave and three standard deviations of what the errors of the machine's components and converters do.",
        Table::of(&columns, results.runs.iter().filter(|r| r.linear.is_some())),
    );
}

/// A decay as measured, and its eigenvalue.
fn decay(run: &Run) -> Option<(Oscillation, Root)> {
    match run.linear?.compared {
        Compared::Decay { measured, root } => Some((measured, root)),
        Compared::Response { .. } => None,
    }
}

fn range(gains: ChannelGains) -> &'static str {
    match (gains.ftc > 0.0, gains.tvc > 0.0) {
        (true, true) => "tips and thrust vector",
        (true, false) => "tips alone, in the dead zone",
        (false, true) => "thrust vector alone",
        (false, false) => "no control, in the dead zone",
    }
}

/// Every response as columns of one trace, named by run and channel.
pub(super) fn curves(results: &Results) -> Curves {
    let mut curves = Curves::new(results.plan.sample);
    for run in &results.runs {
        // A point and condition has both loops: their bending coordinates are two.
        let within = match run.control_loop() {
            ControlLoop::Pitch => "",
            ControlLoop::YawRoll => ".yaw-roll",
        };
        for (channel, values) in run.response.columns() {
            curves.add(format!("{}{within}.{}", run.name, channel.adc), channel.unit, values);
        }
    }
    curves
}

/// Name and time of a point.
pub(super) fn place(results: &Results, point: usize) -> String {
    let point = &results.plan.points[point];
    format!("{} ({:.1} s)", point.name, point.slice.time_s)
}

fn responses(results: &Results, out: &mut Outcome) {
    let (plan, all) = (&results.plan, results.runs.len());
    if all > MOST_DRAWN {
        out.section("Responses").aside(format!(
            "Of {all} runs those at the point with the largest residual oscillation are drawn; the trace holds all of them. Name a point or a condition to see others."
        ));
    }
    let residual = |r: &Run| r.measures.residual.unwrap_or(f64::INFINITY);
    let worst = results.runs.iter().max_by(|a, b| residual(a).total_cmp(&residual(b)));
    let worst = worst.map(|run| run.case.point);
    for point in (0..plan.points.len()).filter(|p| all <= MOST_DRAWN || worst == Some(*p)) {
        for control_loop in ControlLoop::ALL {
            let here: Vec<(String, &Response)> = results
                .of(control_loop)
                .filter(|run| run.case.point == point)
                .map(|run| (format!("{}, {}", run.condition, run.case.test.words()), &run.response))
                .collect();
            for (n, group) in here.chunks(STYLES).enumerate() {
                let (title, place) = (control_loop.title(), place(results, point));
                let id = anchor(&format!("{} {title} {n}", plan.points[point].name));
                let figures = figures(&id, &place, group, control_loop.drawn(), None);
                out.section("Responses")
                    .markup(html! { h3 { (title) " at " (place) } })
                    .beside(figures);
            }
        }
    }
}

/// Figures of some channels, several runs on one pair of axes; `travel_rad` is drawn as the
/// limit of the tips.
pub(super) fn figures(
    id: &str,
    place: &str,
    runs: &[(String, &Response)],
    channels: &[&str],
    travel_rad: Option<f64>,
) -> Vec<Figure> {
    let of = |adc: &str, response: &Response| -> Option<(&'static Channel, Vec<f64>)> {
        let (channel, values) = response.columns().find(|(channel, _)| channel.adc == adc)?;
        Some((channel, values.iter().map(|v| v * channel.factor).collect()))
    };
    let figure = |(n, adc): (usize, &&str)| {
        let (channel, _) = of(adc, runs.first()?.1)?;
        let curve = |(name, response): &(String, &Response)| {
            let (_, values) = of(adc, response)?;
            let time: Vec<f64> = (0..values.len()).map(|i| i as f64 * response.sample_s).collect();
            Some(Series::line(if runs.len() > 1 { name.as_str() } else { "" }, &time, &values))
        };
        let travel = travel_rad.filter(|_| adc.starts_with("tip")).map(f64::to_degrees);
        let limit = |value: f64| Limit { value, name: "travel".to_owned() };
        let chart = LineChart {
            limits: travel.into_iter().flat_map(|t| [limit(t), limit(-t)]).collect(),
            size: Size::HALF,
            ..LineChart::new(
                "",
                Axis::new("Time", "s"),
                Axis::new(channel.label, channel.shown_unit),
                runs.iter().filter_map(curve).collect(),
            )
        };
        let id = if n == 0 { id.to_owned() } else { format!("{id}-{n}") };
        Some(Figure::new(id, format!("{}, {place}.", channel.label), line_chart(&chart)))
    };
    channels.iter().enumerate().filter_map(figure).collect()
}
