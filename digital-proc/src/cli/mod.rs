//! The command line of `digital-proc`.
//!
//! Exit codes stand in [`desk::command_line`].

mod case_study;
mod catalogue;
mod design_gains;
mod failure;
mod failures;
mod fly;
mod gyro_location;
mod long_period;
mod replay;
mod resume;
mod roll_drift;
mod runs;
mod sampling;
mod sensitivity;
mod short_period;
mod study;
mod vehicle_args;

use crate::linkage::launch::{AnalogEntry, LinkChoice, Started};
use clap::{Args, Parser, Subcommand, ValueEnum};
use desk::{
    command_line,
    failure::Failure,
    shell::{self, Manual},
};
use std::{
    path::Path,
    process::ExitCode,
    sync::{Arc, atomic::AtomicBool},
};
use vehicle::failure_file::FailureFile;

/// The digital processor: flies the first stage of a launch vehicle on a hybrid computer.
///
/// It starts its partner `analog-proc` by itself; always two processes, joined by shared memory.
///
///     digital-proc case-study               the whole paper, claim by claim
///     digital-proc short-period pitch       step responses at all trajectory points
///     digital-proc fly                      the normal long-period flight, 49 s
///     digital-proc fly --mode roll-lost     with a failure of the roll control
///     digital-proc list                     the runs so far
#[derive(Parser)]
#[command(name = "digital-proc", version, verbatim_doc_comment, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run the paper's case study and say of each claim whether it holds
    CaseStudy(case_study::CaseStudy),
    /// Fly the first stage: trajectory here, control dynamics on the analog side
    Fly(fly::Fly),
    /// Repeat a recorded flight in lock-step and compare it to the last bit
    Replay(replay::Replay),
    Resume(resume::Resume),
    /// The runs so far, oldest first, or the quantities that a study may change
    List(runs::List),
    /// A run's trace as comma-separated values
    Export(runs::Export),
    /// Every column of a run against time, as one HTML page
    Plot(runs::Plot),
    /// Study the control loops at frozen trajectory points, run after run in one session
    ShortPeriod(short_period::ShortPeriod),
    /// The sampling laboratory: what an interface does to a loop, measured beside theory
    ///
    /// Measure what sampling, holding and computing do to a loop, with theory beside every number.
    ///
    /// Each experiment runs its patch on the analog side with real frames, prints a table, and leaves
    /// a run directory with CSV files and a report with figures. It exits with 1 if a measurement
    /// departs from the exact theory by more than it should.
    ///
    ///     digital-proc sampling circle                       growth of an oscillator per cycle
    ///     digital-proc sampling alpha                        the redundant integrator of figure 1
    ///     digital-proc sampling loop patch-files/studies/servo-loop.toml   a loop of your own
    #[command(verbatim_doc_comment)]
    Sampling(sampling::Sampling),
    /// Fly every mode of the failure file and judge the claims about trajectory and loads
    LongPeriod(long_period::LongPeriod),
    /// Catalogue what becomes of each failure at each time of its occurrence
    Catalogue(catalogue::Catalogue),
    /// Fly with a roll drift that nobody corrects, attitude errors resolved and not
    RollDrift(roll_drift::RollDrift),
    /// List the modes of a failure file, or print the shipped one to start from
    Failures(failures::Failures),
    /// Design the gain schedules on the machine: intervals, fewer switchings, re-evaluation
    DesignGains(design_gains::DesignGains),
    /// Disperse the pitch loop one parameter at a time and at the corners, and rank them
    Sensitivity(sensitivity::Sensitivity),
    /// Damping of the bending modes against the gyro's station; margins of the bending filter
    GyroLocation(gyro_location::GyroLocation),
    #[command(flatten)]
    Manual(Manual),
}

/// The link between the two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LinkName {
    /// Two processes joined by shared memory
    Shm,
    /// One thread, no waiting; the same numbers to the last bit
    Memory,
}

// How the machine is put together. (No doc comment: it would be the help of who flattens it.)
#[derive(Args)]
#[command(next_help_heading = "Machine")]
struct JoinArgs {
    /// How the two sides are joined
    #[arg(long, value_enum, default_value = "shm", conflicts_with = "attach")]
    link: LinkName,
    /// Join the session of an `analog-proc serve --session NAME` that runs already
    #[arg(long, value_name = "SESSION")]
    attach: Option<String>,
}

// What every command that runs the machine takes.
#[derive(Args)]
struct MachineArgs {
    #[command(flatten)]
    join: JoinArgs,
    /// Machine profile: ideal, paper-class, ad4, or a file
    #[arg(long, default_value = "ideal", help_heading = "Machine")]
    profile: String,
    /// Print the result as JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// What a command gets from the process it runs in.
#[derive(Clone)]
struct Context {
    analog: AnalogEntry,
    interrupted: Arc<AtomicBool>,
}

impl JoinArgs {
    /// Name of the link in records.
    fn link_name(&self) -> &'static str {
        match (&self.attach, self.link) {
            (Some(_), _) | (None, LinkName::Shm) => "shm",
            (None, LinkName::Memory) => "memory",
        }
    }

    fn start(&self, context: &Context) -> Result<Started, Failure> {
        let link = match (&self.attach, self.link) {
            (Some(session), _) => LinkChoice::Attach(session.clone()),
            (None, LinkName::Shm) => LinkChoice::Shm,
            (None, LinkName::Memory) => LinkChoice::Memory,
        };
        Ok(Started::new(&link, context.analog, context.interrupted.clone())?)
    }
}

impl MachineArgs {
    fn start(&self, context: &Context) -> Result<Started, Failure> {
        self.join.start(context)
    }
}

/// A user's own file, or the shipped one.
fn own_or<T, F>(
    own: Option<&Path>,
    load: impl FnOnce(&Path) -> Result<T, F>,
    shipped: impl FnOnce() -> Result<T, F>,
) -> Result<T, Failure>
where
    Failure: From<F>,
{
    Ok(own.map_or_else(shipped, load)?)
}

/// The modes of a user's own failure file, or the shipped ones.
fn failure_file(own: Option<&Path>) -> Result<FailureFile, Failure> {
    own_or(own, FailureFile::load, || Ok(FailureFile::shipped().clone()))
}

/// Runs `digital-proc` on this process' arguments.
pub fn main(analog: AnalogEntry) -> ExitCode {
    shell::main(|cli: Cli| {
        let interrupted = command_line::interrupt_flag()
            .map_err(|error| Failure::input(format!("cannot catch signals: {error}")))?;
        let context = Context { analog, interrupted };
        match cli.command {
            Command::CaseStudy(c) => c.execute(&context),
            Command::Fly(c) => c.execute(&context),
            Command::Replay(c) => c.execute(&context),
            Command::Resume(c) => c.execute(&context),
            Command::List(c) => c.execute(),
            Command::Export(c) => c.execute(),
            Command::Plot(c) => c.execute(),
            Command::ShortPeriod(c) => c.execute(&context),
            Command::Sampling(c) => c.execute(&context),
            Command::LongPeriod(c) => c.execute(&context),
            Command::Catalogue(c) => c.execute(&context),
            Command::RollDrift(c) => c.execute(&context),
            Command::Failures(c) => c.execute(),
            Command::DesignGains(c) => c.execute(&context),
            Command::Sensitivity(c) => c.execute(&context),
            Command::GyroLocation(c) => c.execute(&context),
            Command::Manual(c) => c.execute::<Cli>(),
        }
    })
}
