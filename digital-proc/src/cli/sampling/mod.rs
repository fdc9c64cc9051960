//! `digital-proc sampling`: what an interface does to a loop, measured beside theory.

mod alpha;
mod budget;
mod circle;
mod converters;
mod curve;
mod flight;
mod functions;
mod outcome;
mod root;
mod study;

use self::outcome::Outcome;
use super::{Context, MachineArgs};
use crate::{
    console::Console,
    sampling::{
        bench::{Bench, BenchFault},
        plan::LabError,
        theory::{TheoryError, hold::Hold},
    },
};
use clap::{Args, Subcommand};
use desk::failure::Failure;
use desk::run_dir::{DEFAULT_BASE, UtcSecond};
use interface::profile::Profile;
use std::{path::PathBuf, time::SystemTime};

/// Settings of the laboratory.
#[derive(Args)]
pub struct Sampling {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Subcommand)]
#[allow(rustdoc::invalid_rust_codeblocks, reason = "the help shows a TOML file")]
enum Experiment {
    /// Gain and phase that each stage of a channel adds at one frequency
    ///
    /// Gain and phase that each stage of a channel adds at one frequency, from theory and from runs.
    ///
    /// The linkage of a patch is put in loop-back: a sine on the ADC, passed on by the digital side to
    /// the DAC, taken by correlators over whole cycles. Each stage is measured alone against a bare
    /// zero-order hold, and the whole chain at once. Stages come from --profile and from the flags.
    ///
    ///     digital-proc sampling budget --frequency 1
    ///     digital-proc sampling budget --patch patch-files/long-period.toml --adc adc_alpha --profile ad4
    #[command(verbatim_doc_comment)]
    Budget(Lab<budget::Budget>),
    /// Two integrators closed through the digital side: growth of the amplitude per cycle
    ///
    /// Two integrators whose loop is closed through the digital side.
    ///
    /// Without an interface they draw a circle for ever. What is sampled, held and delayed turns it
    /// into a spiral: the growth of the amplitude over one cycle is compared with the exact discrete
    /// map and with the first-order formula exp(pi omega tau_e), tau_e = latency + delay of the hold.
    Circle(Lab<circle::Circle>),
    /// A second-order loop closed through the digital side: damping left, and compensations
    ///
    /// A second-order loop x'' + 2 zeta omega0 x' + omega0^2 x = 0 whose stiffness goes through the
    /// digital side.
    ///
    /// Its damping falls by about omega0 (T/2 + latency)/2. Damping and frequency from the run stand
    /// beside the exact eigenvalues of the sampled-data system and Howe's first-order shift, without
    /// and with each compensation: half-frame prediction, an extrapolating DAC, and a lead of T/2 + latency.
    Root(Lab<root::Root>),
    /// Angle of attack conventionally sampled against the redundant integrator
    ///
    /// The alpha loop of the rotational equations, alpha' = q - Z alpha, q' = -omega^2 alpha - D q with
    /// Z = 0.6 and D = 0.4, closed through a conventionally sampled alpha and through a redundant one.
    ///
    /// Conventional: the digital side samples q, integrates alpha in the slow frame and holds the
    /// moment. Redundant (figure 1 of the paper): an analog integrator turns with q, is sampled fast for
    /// the tables, and is only corrected slowly by K times the error of the digital alpha. Roots stand
    /// beside those of the multi-rate monodromy matrix; a sweep shows where each becomes unstable. The
    /// correction has its price: with K = 0.5 one frame late the loop is unstable.
    Alpha(Lab<alpha::Alpha>),
    /// All-digital, hybrid and local-cell function generation: lag and error
    ///
    /// One function C(alpha, M) generated three ways at once, beside the exact analog one.
    ///
    /// All-digital: alpha sampled, two-dimensional table look-up, DAC; alpha itself is late. Hybrid
    /// (Rubin): fixed analog hat functions of alpha weighted by ordinates of M in digital coefficients;
    /// only the slow M is late. Local cell: level and slope of the present cell, chosen by comparators.
    /// Lag and rms error are taken by correlators on the analog side, against frequency and period.
    FunctionGeneration(Lab<functions::FunctionGeneration>),
    /// Translation in body, flight-path and H axes: error of the flight-path angle
    ///
    /// Translation computed in body, flight-path and H axes from the same samples of an oscillating
    /// attitude, by RK4 with attitude and rate held over the digital step.
    ///
    /// In body axes the whole turn of the vehicle is an artificial acceleration q u, which a held rate
    /// makes wrong by the attitude's own lag; in flight-path and H axes only the true normal force is.
    Axes(Lab<functions::AxesOfTranslation>),
    /// Quantisation noise itself, through an integrator and through a lag
    ///
    /// A DAC of few bits driven with seeded random values that the digital side knows exactly.
    ///
    /// What is read back beyond the exact solution is noise: q^2/12 itself, q^2/12 T t through an
    /// integrator, and q^2/12 (1 - e)/(1 + e), e = exp(-a T), through a lag.
    Noise(Lab<converters::Noise>),
    /// Multiplexer skew on a resolver pair
    ///
    /// Sine and cosine of one angle read through a multiplexer, the cosine one skew later.
    ///
    /// The angle computed from them is too great by omega delta sin^2(angle): omega delta / 2 on average.
    Skew(Lab<converters::Skew>),
    /// Staircase error of a digital coefficient
    ///
    /// A digital coefficient that should follow a ramp and is renewed once a period.
    ///
    /// It is a staircase behind the ramp: late by T/2 + latency on average, with an rms error of
    /// rate sqrt(T^2/3 + T latency + latency^2).
    Coefficients(Lab<converters::Coefficients>),
    /// The long-period flight with sampled alpha, redundant alpha and all control digital
    ///
    /// The long-period flight on three machines, over the frame period: alpha redundant, alpha
    /// conventionally sampled, and all control digital.
    ///
    /// Wind and misalignments are those of the design case. The damping of the pitch loop comes from a
    /// small step of the attitude command at 20 s, as the difference of two flights. Digital parts take
    /// effect one frame late; the redundant machine has five fast frames in a frame. A flight is lost
    /// where the attitude leaves its command by 20 degrees.
    Flight(Lab<flight::Flight>),
    /// Your own loop: a patch and a digital law from a TOML file, over frames, latencies and bits
    ///
    /// A loop of your own: a patch with ADC and DAC lines, and a digital law, from one TOML file.
    ///
    ///     title = "My servo"
    ///     patch = "servo.toml"            # beside this file
    ///     stop = "20s"
    ///     measure = "x_adc"               # the ADC whose record is judged
    ///     from = "0.5s"                   # what of it, if not all of the run
    ///     until = "10s"
    ///
    ///     [params]                        # values for the patch's [params]
    ///     wn = 3.0
    ///
    ///     [sweep]
    ///     frame = ["20ms", "50ms"]
    ///     latency = [0.0, 1.0]            # in frames
    ///     bits = [8, 12, 0]               # 0: ideal converters; bits need `max` at ADC and DAC
    ///
    ///     [[law]]                         # one or more
    ///     kind = "gain-matrix"            # y = G x
    ///     inputs = ["x_adc"]
    ///     outputs = ["u"]
    ///     gain = [[9.0]]
    ///
    /// Other kinds, each with one `input` and one `output`: `difference-equation` (`numerator`,
    /// `denominator`), `delay` (`frames`, `gain`), `table` (`x`, `y`). A fault names file and line.
    ///
    /// The record must be a free decay, or a step response after the last change of the reference:
    /// state `from`. The column `fit` is what the modes found leave of it (rms over rms); where that
    /// is more than a linear loop and its converters leave, no damping is told, and a remark says why.
    /// A case that saturates is judged from there on.
    #[command(verbatim_doc_comment)]
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
        let profile = desk::profile::load(&self.machine.profile)?;
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(machine.port());
        let mut bench = Bench::new(&mut console, profile.clone());
        let mut outcome = self.own.measure(&mut bench)?;
        outcome.saturated = bench.saturated().to_vec();
        if profile.name != Profile::ideal().name {
            outcome.note_real_machine(&profile.name);
        }
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
    Hold::ALL.into_iter().find(|h| h.name() == text).ok_or_else(|| {
        format!("no such hold; the holds are {}", Hold::ALL.map(Hold::name).join(", "))
    })
}
