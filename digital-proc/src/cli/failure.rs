//! Why a command did not do what it was asked, with its exit code.

use crate::{console::ConsoleFault, launch::LaunchFault, study::long_period::run::StudyFault};
use desk::command_line::{BAD_INPUT, CHECK_FAILED, INTERRUPTED, OUTPUT_FAILED, PARTNER_FAILED};
use desk::run_dir::{RunDirError, TraceError};
use interface::link::LinkFault;

/// A message for the terminal and an exit code.
#[derive(Debug)]
pub struct Failure {
    /// Exit code.
    pub code: u8,
    /// What to print on standard error.
    pub text: String,
}

impl Failure {
    /// Bad input or usage.
    pub fn input(error: impl std::fmt::Display) -> Failure {
        Failure { code: BAD_INPUT, text: error.to_string() }
    }

    /// Output that could not be written.
    pub fn output(error: impl std::fmt::Display) -> Failure {
        Failure { code: OUTPUT_FAILED, text: error.to_string() }
    }

    /// A claim or check that failed: what befell, and which, if they have names.
    pub fn failed(what: &str, items: &[&str]) -> Failure {
        let colon = if items.is_empty() { "" } else { ": " };
        Failure { code: CHECK_FAILED, text: format!("{what}{colon}{}", items.join(", ")) }
    }

    /// The same failure with a further line.
    pub fn and(mut self, line: impl std::fmt::Display) -> Failure {
        self.text = format!("{}\n{line}", self.text.trim_end());
        self
    }
}

impl From<RunDirError> for Failure {
    fn from(error: RunDirError) -> Failure {
        match error {
            RunDirError::Write { .. } => Failure::output(error),
            other => Failure::input(other),
        }
    }
}

impl From<TraceError> for Failure {
    fn from(error: TraceError) -> Failure {
        match error {
            TraceError::Write { .. } => Failure::output(error),
            other => Failure::input(other),
        }
    }
}

impl From<LinkFault> for Failure {
    fn from(fault: LinkFault) -> Failure {
        let code = match fault {
            LinkFault::Interrupted { .. } => INTERRUPTED,
            _ => PARTNER_FAILED,
        };
        Failure { code, text: fault.to_string() }
    }
}

impl From<ConsoleFault> for Failure {
    fn from(fault: ConsoleFault) -> Failure {
        match fault {
            ConsoleFault::Link(fault) => fault.into(),
            ConsoleFault::WrongReply { .. } => {
                Failure { code: PARTNER_FAILED, text: fault.to_string() }
            }
            other => Failure::input(other),
        }
    }
}

impl From<LaunchFault> for Failure {
    fn from(fault: LaunchFault) -> Failure {
        match fault {
            LaunchFault::Link(fault) => fault.into(),
            LaunchFault::Spawn(_) => Failure { code: PARTNER_FAILED, text: fault.to_string() },
            LaunchFault::Session(fault) => Failure::input(fault),
            LaunchFault::Files(text) => Failure::input(text),
        }
    }
}

impl From<StudyFault> for Failure {
    fn from(fault: StudyFault) -> Failure {
        match fault {
            StudyFault::Flight(fault) => fault.into(),
            other => Failure::input(other),
        }
    }
}
