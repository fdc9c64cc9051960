//! Why a command did not do what it was asked, with its exit code.

use crate::command_line::{BAD_INPUT, CHECK_FAILED, INTERRUPTED, OUTPUT_FAILED, PARTNER_FAILED};
use crate::faults::{FileFault, FileFaults};
use interface::link::LinkFault;
use serde_json::{Value, json};
use std::{fmt, path::PathBuf};

/// A message for the terminal and an exit code.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    pub code: u8,
    /// What to print on standard error.
    pub text: String,
    /// The faults of a user's file, where it was one.
    pub faults: Vec<FileFault>,
    /// The directory of the run that failed, where one was begun.
    pub run: Option<PathBuf>,
    /// Whether the command's JSON, already printed, has told of it.
    pub is_told: bool,
}

impl Failure {
    fn new(code: u8, text: impl fmt::Display) -> Failure {
        let (text, faults) = (text.to_string(), Vec::new());
        Failure { code, text, faults, run: None, is_told: false }
    }

    /// Bad input or usage.
    pub fn input(error: impl fmt::Display) -> Failure {
        Failure::new(BAD_INPUT, error)
    }

    /// Output that could not be written.
    pub fn output(error: impl fmt::Display) -> Failure {
        Failure::new(OUTPUT_FAILED, error)
    }

    /// The partner process, or the link to it.
    pub fn partner(error: impl fmt::Display) -> Failure {
        Failure::new(PARTNER_FAILED, error)
    }

    /// A signal that ends a run.
    pub fn interrupted(error: impl fmt::Display) -> Failure {
        Failure::new(INTERRUPTED, error)
    }

    /// A claim or check that failed: what befell, and which, if they have names.
    pub fn failed(what: &str, items: &[&str]) -> Failure {
        let colon = if items.is_empty() { "" } else { ": " };
        Failure::new(CHECK_FAILED, format!("{what}{colon}{}", items.join(", ")))
    }

    /// The same failure with a further line.
    pub fn and(mut self, line: impl fmt::Display) -> Failure {
        self.text = format!("{}\n{line}", self.text.trim_end());
        self
    }

    /// The `error` of a command's JSON.
    pub fn json(&self) -> Value {
        json!({"exit_code": self.code, "text": self.text.trim_end(), "faults": self.faults})
    }
}

impl From<FileFaults> for Failure {
    fn from(faults: FileFaults) -> Failure {
        Failure { faults: faults.0.clone(), ..Failure::input(&faults) }
    }
}

impl From<LinkFault> for Failure {
    fn from(fault: LinkFault) -> Failure {
        match fault {
            LinkFault::Interrupted { .. } => Failure::interrupted(fault),
            _ => Failure::partner(fault),
        }
    }
}

#[cfg(feature = "runs")]
impl From<crate::run_dir::RunDirError> for Failure {
    fn from(error: crate::run_dir::RunDirError) -> Failure {
        match error {
            crate::run_dir::RunDirError::Write { .. } => Failure::output(error),
            other => Failure::input(other),
        }
    }
}
