//! Quantisation noise, multiplexer skew and staircase coefficients.
//!
//! Three small experiments, a file each, on `lab/quantisation.toml`, `lab/skew.toml` and
//! `lab/coefficient.toml`: what a converter or a coefficient unit adds to a signal, beside
//! the closed formulae of [`theory::noise`](super::theory::noise).

mod quantisation;
mod skew;
mod staircase;

pub use quantisation::{QuantisationLaw, QuantisationSetting, VarianceRow};
pub use skew::{SkewLaw, SkewRow, SkewSetting};
pub use staircase::{CoefficientLaw, CoefficientRow, CoefficientSetting};
