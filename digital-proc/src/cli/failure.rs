//! Exit codes of this side's own faults.

use crate::{console::ConsoleFault, launch::LaunchFault, study::long_period::run::StudyFault};
use desk::failure::Failure;

impl From<ConsoleFault> for Failure {
    fn from(fault: ConsoleFault) -> Failure {
        match fault {
            ConsoleFault::Link(fault) => fault.into(),
            ConsoleFault::WrongReply { .. } => Failure::partner(fault),
            other => Failure::input(other),
        }
    }
}

impl From<LaunchFault> for Failure {
    fn from(fault: LaunchFault) -> Failure {
        match fault {
            LaunchFault::Link(fault) => fault.into(),
            LaunchFault::Spawn(_) => Failure::partner(fault),
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
