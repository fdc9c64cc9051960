//! `digital-proc failures`: the modes of a failure file, or its text to start from.

use desk::failure::Failure;
use desk::report::{Heading, Table};
use desk::say;
use std::path::PathBuf;
use vehicle::{
    failure_file::{FailureFile, SHIPPED_TEXT},
    flight_mode::{Action, Effect, Schedule},
};

/// List the modes of a failure file and what happens in each; a faulty file is
/// reported with its lines.
#[derive(clap::Args)]
pub struct Failures {
    /// Failure file of your own [default: the shipped one]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Print the shipped file, as a start for your own
    #[arg(long, conflicts_with = "file")]
    text: bool,
    /// Print the modes as JSON
    #[arg(long)]
    json: bool,
}

impl Failures {
    pub fn execute(self) -> Result<(), Failure> {
        if self.text {
            say!("{}", SHIPPED_TEXT.trim_end());
            return Ok(());
        }
        let own =
            self.file.as_deref().map(FailureFile::load).transpose().map_err(Failure::input)?;
        let file = own.as_ref().unwrap_or_else(|| FailureFile::shipped());
        let mut table = Table::new(vec![
            Heading::new("Mode", ""),
            Heading::new("What happens", ""),
            Heading::new("Text", ""),
        ]);
        for mode in &file.modes {
            let mut events: Vec<String> = mode.actions.iter().map(words).collect();
            if mode.schedule == Schedule::Reduced {
                events.push("reduced schedule throughout".to_owned());
            }
            table.row([
                mode.name.as_str().into(),
                events.join(", ").into(),
                mode.text.as_str().into(),
            ]);
        }
        if self.json {
            say!("{:#}", table.json());
        } else {
            say!("{}", table.text());
        }
        Ok(())
    }
}

fn words(action: &Action) -> String {
    let what = match action.effect {
        Effect::Factor(part, factor) => format!("{} × {factor}", part.words()),
        Effect::FreezeSequencer => "sequencer frozen".to_owned(),
        Effect::RunSequencer => "sequencer running".to_owned(),
    };
    format!("{} s: {what}", action.at_s)
}
