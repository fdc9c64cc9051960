//! `digital-proc sampling`: what an interface does to a loop, measured beside theory.

mod budget;
mod converters;
mod flight;
mod functions;
mod loops;
mod outcome;
mod study;

use self::outcome::Outcome;
use super::{Context, Failure, MachineArgs};
use crate::{
    console::Console,
    run_dir::{DEFAULT_BASE, UtcSecond},
    sampling::{
        bench::{Bench, BenchFault},
        plan::LabError,
        theory::{TheoryError, hold::Hold},
    },
};
use clap::{Args, Subcommand};
use interface::profile::Profile;
use std::{path::PathBuf, time::SystemTime};

/// Measure what sampling, holding and computing do to a loop, with theory beside every number.
///
/// Each experiment runs its patch on the analog side with real frames, prints a table, and leaves
/// a run directory with CSV files and a report with figures. It exits with 1 if a measurement
/// departs from the exact theory by more than it should.
///
///     digital-proc sampling circle                       growth of an oscillator per cycle
///     digital-proc sampling alpha                        the redundant integrator of figure 1
///     digital-proc sampling loop my-study.toml           a loop of your own
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Sampling {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Subcommand)]
enum Experiment {
    /// Gain and phase that each stage of a channel adds at one frequency
    Budget(Lab<budget::Budget>),
    /// Two integrators closed through the digital side: growth of the amplitude per cycle
    Circle(Lab<loops::Circle>),
    /// A second-order loop closed through the digital side: damping left, and compensations
    Root(Lab<loops::Root>),
    /// Angle of attack conventionally sampled against the redundant integrator
    Alpha(Lab<loops::Alpha>),
    /// All-digital, hybrid and local-cell function generation: lag and error
    FunctionGeneration(Lab<functions::FunctionGeneration>),
    /// Translation in body, flight-path and H axes: error of the flight-path angle
    Axes(Lab<functions::AxesOfTranslation>),
    /// Quantisation noise itself, through an integrator and through a lag
    Noise(Lab<converters::Noise>),
    /// Multiplexer skew on a resolver pair
    Skew(Lab<converters::Skew>),
    /// Staircase error of a digital coefficient
    Coefficients(Lab<converters::Coefficients>),
    /// The long-period flight with sampled alpha, redundant alpha and all control digital
    Flight(Lab<flight::Flight>),
    /// Your own loop: a patch and a digital law from a TOML file, over frames, latencies and bits
    Loop(Lab<study::Loop>),
}

/// What every experiment takes besides its own settings.
#[derive(Args)]
struct Lab<T: Args> {
    #[command(flatten)]
    own: T,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

/// One experiment: from its settings and a machine to tables, figures and checks.
trait Measure {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure>;
}

impl Sampling {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        match self.experiment {
            Experiment::Budget(lab) => lab.execute(context),
            Experiment::Circle(lab) => lab.execute(context),
            Experiment::Root(lab) => lab.execute(context),
            Experiment::Alpha(lab) => lab.execute(context),
            Experiment::FunctionGeneration(lab) => lab.execute(context),
            Experiment::Axes(lab) => lab.execute(context),
            Experiment::Noise(lab) => lab.execute(context),
            Experiment::Skew(lab) => lab.execute(context),
            Experiment::Coefficients(lab) => lab.execute(context),
            Experiment::Flight(lab) => lab.execute(context),
            Experiment::Loop(lab) => lab.execute(context),
        }
    }
}

impl<T: Args + Measure> Lab<T> {
    fn execute(self, context: &Context) -> Result<(), Failure> {
        let started = UtcSecond::from_system(SystemTime::now());
        let profile = Profile::load(&self.machine.profile).map_err(Failure::input)?;
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let outcome = self
            .own
            .measure(&mut Bench::new(&mut console, profile.clone()))?;
        let patch_hash = console.patch_hash().to_owned();
        console.bye()?;
        drop(machine);
        outcome.publish(&self.machine, &self.out, started, &profile.name, patch_hash)
    }
}

impl From<BenchFault> for Failure {
    fn from(fault: BenchFault) -> Failure {
        match fault {
            BenchFault::Console(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}

impl From<LabError> for Failure {
    fn from(fault: LabError) -> Failure {
        Failure::input(fault)
    }
}

impl From<TheoryError> for Failure {
    fn from(fault: TheoryError) -> Failure {
        Failure::input(fault)
    }
}

/// A hold by its name.
fn hold(text: &str) -> Result<Hold, String> {
    Hold::ALL
        .into_iter()
        .find(|h| h.name() == text)
        .ok_or_else(|| {
            format!(
                "no such hold; the holds are {}",
                Hold::ALL.map(Hold::name).join(", ")
            )
        })
}
