//! `digital-proc sampling`: the experiments of the laboratory, each on a machine of its own.

use super::{Context, MachineArgs};
use crate::{
    lab::{self, Experiment, bench::Bench},
    linkage::console::Console,
};
use clap::{Args, Subcommand};
use desk::{
    claim::Verdict,
    command_line::BAD_INPUT,
    failure::Failure,
    outcome::{Outcome, Run},
    run_dir::DEFAULT_BASE,
};
use interface::profile::Profile;
use std::path::PathBuf;

/// Settings of the laboratory.
#[derive(Args)]
pub struct Sampling {
    #[command(subcommand)]
    experiment: Experiments,
}

/// A command for each experiment; its doc comment is the help.
macro_rules! commands {
    ($($command:ident $file:ident::$experiment:ident)*) => {
        #[derive(Subcommand)]
        enum Experiments { $($command(Lab<lab::$file::$experiment>)),* }

        impl Sampling {
            pub fn execute(self, context: &Context) -> Result<(), Failure> {
                match self.experiment { $(Experiments::$command(lab) => lab.execute(context)),* }
            }
        }
    };
}
lab::experiments!(commands);

// What every experiment takes besides its own settings. (No doc comment: it would be the help.)
#[derive(Args)]
struct Lab<T: Args> {
    #[command(flatten)]
    own: T,
    /// Directory for runs; each run makes its own directory there
    #[arg(long, default_value = DEFAULT_BASE, value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    machine: MachineArgs,
}

impl<T: Experiment> Lab<T> {
    fn execute(self, context: &Context) -> Result<(), Failure> {
        let profile = desk::profile::load(&self.machine.profile)?;
        let mut machine = self.machine.start(context)?;
        let mut console = Console::new(&mut machine);
        let command = format!("sampling {}", T::NAME);
        let link = self.machine.join.link_name();
        let mut run = Run::begin(&self.out, &command, &profile.name, link)?;
        let mut bench = Bench::new(&mut console, profile);
        let outcome = match self.measure(&mut bench) {
            Ok(outcome) => outcome,
            Err(failure) => {
                // Nothing was run: its settings were not to be had. The partner has done no wrong.
                if failure.code == BAD_INPUT {
                    drop(std::fs::remove_dir_all(run.directory.path()));
                    drop(console.bye());
                }
                return Err(failure);
            }
        };
        let (patch, hash) = bench.patch();
        run.patch(patch, hash);
        console.bye()?;
        drop(machine);
        outcome.publish(&run, self.machine.json)
    }

    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(T::TITLE, T::LEAD);
        // Before its numbers a reader looks at the figures.
        outcome.section("Figures");
        self.own.measure(bench, &mut outcome)?;
        let profile = &bench.base().name;
        if *profile != Profile::ideal().name {
            for claim in outcome.claims.iter_mut().filter(|c| c.verdict == Verdict::Fails) {
                claim.verdict = Verdict::NotJudged;
                claim.remark = Some(format!(
                    "theory is that of ideal converters, which those of {profile} are not"
                ));
            }
        }
        if !bench.saturated().is_empty() {
            outcome.remarks.push(format!("saturated: {}", bench.saturated().join(", ")));
        }
        Ok(outcome)
    }
}
