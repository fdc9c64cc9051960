//! `digital-proc failures`: the modes of a failure file, or its text to start from.

use super::failure_file;
use desk::{
    failure::Failure,
    outcome::Outcome,
    report::{Column, Table},
    say,
};
use std::path::PathBuf;
use vehicle::{
    failure_file::SHIPPED_TEXT,
    flight_mode::{Action, Effect, FlightScript, Schedule},
};

/// List the modes of a failure file and what happens in each; a faulty file is
/// reported with its lines.
#[derive(clap::Args)]
pub struct Failures {
    /// Failure file of your own [default: the shipped one]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Print the shipped file, as a start for your own
    #[arg(long, conflicts_with_all = ["file", "json"])]
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
        let file = failure_file(self.file.as_deref())?;
        let columns = [
            Column::new("Mode", "", |mode: &FlightScript| mode.name.as_str().into()),
            Column::new("What happens", "", |mode: &FlightScript| {
                let mut events: Vec<String> = mode.actions.iter().map(words).collect();
                if mode.schedule == Schedule::Reduced {
                    events.push("reduced schedule throughout".to_owned());
                }
                events.join(", ").into()
            }),
            Column::new("Text", "", |mode: &FlightScript| mode.text.as_str().into()),
        ];
        let mut outcome = Outcome::default();
        let modes = Table::of(&columns, &file.modes);
        outcome.section("").table("modes", "Modes of the failure file", modes);
        outcome.tell("failures", None, self.json)
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
