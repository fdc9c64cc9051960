//! The sampling laboratory: what an interface does to a loop, with theory beside measurement.
//!
//! An [`Experiment`] is one file: its settings as the user gives them, the *cases* that they
//! make, each of which runs a plan and a digital law on a [`plan::Machine`], the *rows* that
//! come of them, and the columns, checks and figures of the report. Theory that several share
//! stands in [`theory`]. Nothing here knows how frames travel or results leave the program.

pub mod alpha;
pub mod axes;
pub mod bench;
pub mod budget;
pub mod circle;
pub mod coefficients;
mod feedback;
pub mod flight;
pub mod function_generation;
mod identify;
mod loop_law;
pub mod loop_study;
mod modal_fit;
pub mod noise;
mod plan;
pub mod root;
pub mod skew;
mod theory;

/// The list of experiments: the name of the command, and where its type is.
macro_rules! experiments {
    ($then:ident) => {
        $then! {
            Budget budget::Budget
            Circle circle::Circle
            Root root::Root
            Alpha alpha::Alpha
            FunctionGeneration function_generation::FunctionGeneration
            Axes axes::AxesOfTranslation
            Noise noise::Noise
            Skew skew::Skew
            Coefficients coefficients::Coefficients
            Flight flight::Flight
            Loop loop_study::Loop
        }
    };
}
pub(crate) use experiments;

// What an experiment needs, for its `use super::*`.
use bench::Bench;
use desk::{
    failure::Failure,
    outcome::Outcome,
    report::{
        Cell, Column, Table,
        plot::{Axis, Compared, Draw, LineChart, Series, measured_vs_theory},
    },
};
use interface::Tick;
use nalgebra::ComplexField;
use plan::{LabError, Machine, RunPlan, lock_step, require_latency};
use std::f64::consts::TAU;
use theory::{C64, damping_ratio, hold::Hold, require};

/// A measurement with its theory. Its doc comment is the help of its command, its fields are
/// the settings.
pub trait Experiment: clap::Args {
    /// Its name in the run's record, `circle`.
    const NAME: &'static str;
    /// Heading of its report.
    const TITLE: &'static str;
    /// What the reader sees, in a sentence or two.
    const LEAD: &'static str;

    /// Runs all cases and fills the outcome.
    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure>;
}

/// Points of a curve of theory.
const POINTS: u32 = 60;

/// The greatest of what must be small; not a number if one of them is not.
fn worst(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().map(f64::abs).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a })
}

/// `count` values from `low` to `high` in equal ratios.
fn ratios(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let last = f64::from(count - 1);
    (0..count).map(move |i| low * libm::pow(high / low, f64::from(i) / last))
}

/// First and last, or the one.
fn ends(values: &[f64]) -> Vec<f64> {
    match values {
        [first, .., last] => vec![*first, *last],
        few => few.to_vec(),
    }
}

/// The axis of damping ratios.
fn damping_axis() -> Axis {
    Axis::new("damping ratio ζ", "")
}
