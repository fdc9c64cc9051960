//! The sampling laboratory: what an interface does to a loop, with theory beside measurement.
//!
//! Each experiment is a *setting* (what to vary), a *law* (a small state machine
//! `step(frame, adc, updates)` that the executive runs once a frame), a *plan*
//! (patch, parameters, frame, latency, hold) and *rows* (measured beside theory).
//! Nothing here knows how frames travel or prints a report.

pub mod alpha;
pub mod axes;
pub mod bench;
pub mod converter_error;
pub mod feedback;
pub mod flight;
pub mod function_generation;
pub mod identify;
pub mod loop_back;
pub mod loop_law;
pub mod loop_study;
pub mod modal_fit;
#[cfg(test)]
mod plain_machine;
pub mod plan;
pub mod table;
pub mod theory;
