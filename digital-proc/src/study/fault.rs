//! Why a study could not be completed.

use super::short_period::study_file::StudyError;
use crate::{
    flight::FlightFault,
    linkage::{console::ConsoleFault, launch::LaunchFault},
};
use desk::faults::FileFaults;
use vehicle::table::TableError;

/// What ends a study. A run that diverges, or a flight that is lost, does not.
#[derive(Debug, thiserror::Error)]
pub enum StudyFault {
    /// The machine or its link.
    #[error(transparent)]
    Console(#[from] ConsoleFault),
    /// Another machine could not be started beside the first.
    #[error(transparent)]
    Launch(#[from] LaunchFault),
    /// A flight could not be flown at all.
    #[error(transparent)]
    Flight(#[from] FlightFault),
    /// The trajectory points, or the nominal flight from which they are frozen.
    #[error(transparent)]
    Points(#[from] StudyError),
    /// A schedule that the vehicle refuses.
    #[error(transparent)]
    Vehicle(#[from] FileFaults),
    /// The wind of the vehicle's data.
    #[error("the wind profile cannot be made: {0}")]
    Wind(#[from] TableError),
    /// The flight that everything is measured against was lost.
    #[error("the undisturbed normal flight was lost: {0}; nothing can be compared with it")]
    NominalLost(String),
    /// A flight of the sound vehicle that all is about was lost.
    #[error(
        "the sound vehicle was lost in the design case: {0}; there is nothing to show beside it"
    )]
    SoundLost(String),
    /// A flight of the plan has no answer.
    #[error("a flight of the study was lost")]
    LostFlight,
    /// The vehicle's burn time.
    #[error("the vehicle's burn time of {0} s is out of range")]
    BurnTime(f64),
}
