//! Short-period study (paper §4.1): the control loops at frozen trajectory points.
//!
//! Points are found on the vehicle's flight ([`places`]); their coefficients are frozen
//! ([`point`]), changed by an operating condition ([`study_file`]), turned into settings of the
//! patches `pitch-loop.toml` and `yaw-roll-loop.toml` ([`coefficients`]), and run on the machine
//! ([`machine`]). A run ([`results`]) is its case, its answer and what that measures ([`measure`],
//! with the eigenvalues of the linearised loop beside, [`linear`]); the runs are judged against
//! the paper's sentences ([`claims`]) and shown ([`outcome`], [`paper`]). A second formulation
//! in plain Rust ([`mod@reference`]) is there for tests. Beside the study stand the two models of
//! the paper's §2 ([`forms`]) and offsets in attitude and rate ([`offsets`]).

pub mod agreement;
pub mod claims;
pub mod coefficients;
pub mod control_loop;
pub(crate) mod forms;
pub mod higher_modes;
pub mod inexact;
pub mod linear;
pub mod machine;
pub mod measure;
pub mod metrics;
pub mod moment;
pub(crate) mod offsets;
pub mod outcome;
pub mod paper;
pub mod places;
pub mod plan;
pub mod point;
pub mod reference;
pub mod results;
mod study_check;
pub mod study_file;
