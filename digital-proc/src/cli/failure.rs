//! Exit codes of this side's own faults.

use crate::{
    linkage::{console::ConsoleFault, launch::LaunchFault},
    study::{fault::StudyFault, short_period::study_file::StudyError},
};
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
            StudyFault::Console(fault) => fault.into(),
            StudyFault::Launch(fault) => fault.into(),
            StudyFault::Flight(fault) => fault.into(),
            StudyFault::Points(fault) => fault.into(),
            StudyFault::Vehicle(faults) => faults.into(),
            other => Failure::input(other),
        }
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Failure {
        match error {
            StudyError::File(faults) => faults.into(),
            other => Failure::input(other),
        }
    }
}
