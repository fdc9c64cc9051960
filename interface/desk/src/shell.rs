//! The frame of a command line: arguments read, a command executed, its end told.

use crate::{
    command_line::{end_without_reader, exit},
    failure::Failure,
    outcome::Outcome,
    say,
};
use clap::{CommandFactory, Parser};
use std::{path::PathBuf, process::ExitCode};

/// Reads the arguments of this process, executes and ends. Whatever fails is told on standard
/// error and, where `--json` is among the arguments, by [`Outcome::json`] on standard output.
pub fn main<C: Parser>(execute: impl FnOnce(C) -> Result<(), Failure>) -> ExitCode {
    end_without_reader();
    let (done, is_printed) = match C::try_parse() {
        Ok(cli) => (execute(cli), false),
        // Help and version are what was asked for.
        Err(error) if !error.use_stderr() => (error.print().map_err(Failure::output), false),
        Err(error) => {
            // In colours where there are any; nobody could be told that it cannot be printed.
            let _ = error.print();
            (Err(Failure::input(error.render())), true)
        }
    };
    let Err(failure) = done else {
        return exit(0, "");
    };
    if !failure.is_told && std::env::args_os().any(|word| word == "--json") {
        let run = failure.run.as_deref();
        say!("{:#}", Outcome::default().json(&command::<C>(), run, Some(&failure)));
    }
    exit(failure.code, if is_printed { "" } else { &failure.text })
}

/// The command of this process by its names, `sampling circle`.
fn command<C: CommandFactory>() -> String {
    let mut command = C::command();
    let mut names = Vec::new();
    for word in std::env::args_os().skip(1) {
        let Some(found) = command.find_subcommand(&word).cloned() else { break };
        names.push(found.get_name().to_owned());
        command = found;
    }
    names.join(" ")
}

/// What a shell and a reader of manuals need of a command line.
#[derive(clap::Subcommand)]
pub enum Manual {
    /// Print a script that completes this command line in a shell
    ///
    /// For example, in ~/.bashrc: source <(digital-proc completions bash)
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, or write the pages of all commands into a directory
    Manual {
        /// Directory for the pages, named like digital-proc-fly.1; it is made if need be
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

impl Manual {
    /// Prints or writes what is asked for of `C`.
    pub fn execute<C: CommandFactory>(self) -> Result<(), Failure> {
        let mut command = C::command();
        let mut text = Vec::new();
        match self {
            Manual::Completions { shell } => {
                let name = command.get_name().to_owned();
                clap_complete::generate(shell, &mut command, name, &mut text);
            }
            Manual::Manual { out: Some(folder) } => {
                let written = std::fs::create_dir_all(&folder)
                    .and_then(|()| clap_mangen::generate_to(command, &folder));
                return written.map_err(|e| {
                    Failure::output(format!("cannot write into `{}`: {e}", folder.display()))
                });
            }
            Manual::Manual { out: None } => {
                clap_mangen::Man::new(command).render(&mut text).map_err(Failure::output)?;
            }
        }
        say!("{}", String::from_utf8_lossy(&text).trim_end());
        Ok(())
    }
}
