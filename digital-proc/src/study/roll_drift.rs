//! Small uncorrected roll drift in the long-period flight (paper, §4.2): "it becomes necessary to
//! resolve the pitch loop error function along the inertial axes, when the pitch error function gets
//! coupled to the yaw attitude".
//!
//! The reference of the roll loop starts off by an angle and drifts at a rate, so that the vehicle
//! rolls with it and nobody corrects that. Flown without drift, with the attitude errors resolved
//! through the roll angle, and unresolved: then the tips of the pitch channel, which have turned
//! with the body, push the vehicle in yaw by sin φ of what they should do in pitch. Beside each
//! flight of the machine stands that of the second formulation, which shares no code with the patch
//! and its engine.

use super::{
    fault::StudyFault,
    long_period::run::{Answer, LongPeriodPlan, fly_all},
};
use crate::linkage::console::Console;
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Column, Table,
        plot::{Axis, Draw, LineChart, Series, Size, line_chart},
    },
};
use vehicle::{
    Vehicle,
    flight_mode::FlightScript,
    flight_summary::{FlightSample, FlightSummary},
    reference::{self, FlightCase, LEAST_STEPS_PER_SECOND, RollDrift},
};

/// The flights in order.
const NAMES: [&str; 3] = ["no drift", "resolved", "unresolved"];
/// Number of them.
pub const FLIGHTS: usize = NAMES.len();
/// Steps of the second formulation between two of its points in a figure.
const REFERENCE_EVERY: u32 = LEAST_STEPS_PER_SECOND;

/// One flight, by the machine and by the second formulation.
#[derive(Clone, Debug, PartialEq)]
struct Flown {
    name: &'static str,
    summary: FlightSummary,
    history: Vec<FlightSample>,
    /// Once a second.
    reference: Vec<FlightSample>,
    reference_summary: FlightSummary,
    /// Largest change of yaw by the drift, in the machine and in the second formulation, deg.
    yaw_change_deg: [f64; 2],
}

/// All of them.
#[derive(Clone, Debug, PartialEq)]
pub struct RollDriftResults {
    flown: Vec<Flown>,
    drift: RollDrift,
}

/// Flies the sound vehicle in the design case without the drift, and with it resolved and not.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    how: &LongPeriodPlan,
    drift: RollDrift,
    progress: impl FnMut(usize),
) -> Result<RollDriftResults, StudyFault> {
    let drifts = [
        RollDrift::NONE,
        RollDrift { resolved: true, ..drift },
        RollDrift { resolved: false, ..drift },
    ];
    let design = FlightCase::design(vehicle, &FlightScript::sound())?;
    let cases = drifts.map(|roll_drift| FlightCase { roll_drift, ..design.clone() });
    let answers = fly_all(console, vehicle, how, (&cases, true), progress)?;
    let mut flown: Vec<Flown> = Vec::with_capacity(FLIGHTS);
    for ((name, case), answer) in NAMES.into_iter().zip(&cases).zip(answers) {
        let Answer { ended, history, .. } = answer;
        let mut reference = Vec::new();
        let mut step = 0;
        let summary = reference::fly(vehicle, case, LEAST_STEPS_PER_SECOND, |sample| {
            if step % REFERENCE_EVERY == 0 {
                reference.push(*sample);
            }
            step += 1;
        });
        let sound = flown.first();
        let yaw_change_deg = [
            largest_change(&history, sound.map_or(&history, |f| &f.history)),
            largest_change(&reference, sound.map_or(&reference, |f| &f.reference)),
        ];
        flown.push(Flown {
            name,
            yaw_change_deg,
            summary: ended.map_err(StudyFault::SoundLost)?,
            history,
            reference,
            reference_summary: summary.map_err(|lost| StudyFault::SoundLost(lost.to_string()))?,
        });
    }
    Ok(RollDriftResults { flown, drift })
}

/// θ − θ_c, deg.
fn pitch_error_deg(sample: &FlightSample) -> f64 {
    (sample.angle_rad[0] - sample.pitch_command_rad).to_degrees()
}

fn yaw_deg(sample: &FlightSample) -> f64 {
    sample.angle_rad[1].to_degrees()
}

fn roll_deg(sample: &FlightSample) -> f64 {
    sample.angle_rad[2].to_degrees()
}

/// Of yaw, deg, between flights sampled at the same instants.
fn largest_change(history: &[FlightSample], sound: &[FlightSample]) -> f64 {
    let changes = history.iter().zip(sound).map(|(a, b)| (yaw_deg(a) - yaw_deg(b)).abs());
    changes.fold(0.0, f64::max)
}

fn largest(history: &[FlightSample], of: fn(&FlightSample) -> f64) -> f64 {
    history.iter().map(|sample| of(sample).abs()).fold(0.0, f64::max)
}

impl RollDriftResults {
    /// What a terminal and a page show.
    pub fn outcome(&self) -> Outcome {
        let mut out = Outcome::new(
            "Roll drift that nobody corrects",
            format!(
                "The sound vehicle in the design case, its roll reference off by {}° at lift-off and drifting by {}°/s: attitude errors of pitch and yaw resolved through the roll angle, and not.",
                self.drift.initial_rad.to_degrees(),
                self.drift.rate_radps.to_degrees()
            ),
        );
        let columns: [Column<Flown>; 10] = [
            Column::new("Errors", "", |f| f.name.into()),
            Column::of("Roll at burn-out", "°", 4, |f| f.history.last().map(roll_deg).into()),
            Column::of("Largest pitch error", "°", 3, |f| {
                largest(&f.history, pitch_error_deg).into()
            }),
            Column::of("Largest change of yaw", "°", 3, |f| f.yaw_change_deg[0].into()),
            Column::new("Max Qα", "kPa·°", |f| (f.summary.max_q_alpha.value / 1e3).into()),
            Column::new("Total", "kPa·°", |f| (f.summary.max_total_q_alpha.value / 1e3).into()),
            Column::of("Cross-range", "m", 4, |f| f.summary.cross_range_m.into()),
            Column::of("Injectant", "kg", 3, |f| f.summary.injectant_kg.into()),
            Column::of("Second formulation: largest change of yaw", "°", 3, |f| {
                f.yaw_change_deg[1].into()
            }),
            Column::of("cross-range", "m", 4, |f| f.reference_summary.cross_range_m.into()),
        ];
        let chart = |id, label: &str, unit, of: fn(&FlightSample) -> f64| {
            let curve = |name: String, samples: &[FlightSample], style| {
                Series::of(name, samples.iter().map(|s| (s.time_s, of(s)))).style(style)
            };
            let machine = self.flown.iter().enumerate();
            let machine = machine.map(|(i, f)| curve(f.name.to_owned(), &f.history, i));
            let second = self.flown.iter().enumerate().map(|(i, f)| {
                let name = if i == 0 { "second formulation".to_owned() } else { String::new() };
                curve(name, &f.reference, i).draw(Draw::Markers)
            });
            let axes = (Axis::new("Flight time", "s"), Axis::new(label, unit));
            let chart = LineChart::new("", axes.0, axes.1, machine.chain(second).collect());
            Figure::new(id, format!("{label} against time."), line_chart(&chart.size(Size::HALF)))
        };
        let figures = vec![
            chart("roll", "Roll", "°", roll_deg),
            chart("yaw", "Yaw", "°", yaw_deg),
            chart("pitch-error", "Pitch less its command", "°", pitch_error_deg),
            chart("cross-range", "Distance from the launch plane", "m", |s| s.trajectory.cross_m),
        ];
        out.section("Errors resolved and unresolved").beside(figures).table(
            "roll_drift",
            "What the drift does to the flight, resolved and unresolved, and the second formulation (one system, 1 ms, nothing sampled or held).",
            Table::of(&columns, &self.flown),
        );
        out
    }
}
