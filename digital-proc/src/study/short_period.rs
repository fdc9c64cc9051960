//! Short-period study (paper §4.1): the control loops at frozen trajectory points.
//!
//! Points are found on the vehicle's flight ([`places`]); their coefficients are frozen
//! ([`point`]), changed by an operating condition ([`study_file`]), turned into settings
//! of the patches `pitch-loop.toml` and `yaw-roll-loop.toml` ([`coefficients`]), and the
//! answers ([`response`]) are measured ([`metrics`]) and judged against the paper's
//! sentences ([`claims`]). Beside them stand the eigenvalues of the linearised
//! loops ([`linear`]) and a second formulation in plain Rust ([`mod@reference`]).
//! Only [`machine`] and its [`mod@bench`] know of the hybrid machine that runs the patches;
//! nothing does file I/O but the readers of a study.

pub mod agreement;
pub mod bench;
pub mod claims;
pub mod coefficients;
pub mod linear;
pub mod machine;
pub mod measure;
pub mod metrics;
pub mod outcome;
pub mod places;
pub mod plan;
pub mod point;
pub mod quantity;
pub mod reference;
pub mod response;
mod study_check;
pub mod study_file;
