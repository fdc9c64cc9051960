//! Closed-form and exact linear theory of sampled loops.
//!
//! Pure functions: no I/O, no clock, no machine. Everything here is what a run
//! of the laboratory is laid beside. It refuses to guess: a decomposition that
//! does not converge is a [`Refusal`].
//!
//! Notation: T frame period, τ latency from sample to transfer, x = ωT,
//! `s = ln z / T` the equivalent continuous root of a discrete root z, and
//! `ζ = −Re s / |s|`.

pub mod alpha;
pub mod budget;
pub mod feedback_loop;
pub mod hold;
pub mod noise;
pub mod period_map;
pub mod sampled_loop;

use nalgebra::{Complex, ComplexField};

/// A complex number.
///
/// Its elementary functions are those of [`ComplexField`], which take them from `libm`; the
/// inherent ones of the same names (and `norm`, `arg`, `from_polar`) take the C library's.
pub type C64 = Complex<f64>;

/// `e^{jφ}`.
pub fn phasor(angle_rad: f64) -> C64 {
    let (sin, cos) = libm::sincos(angle_rad);
    C64::new(cos, sin)
}

/// Why numbers were refused, or say nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    #[error("{what} is {value}; it must be {range}")]
    Setting { what: &'static str, value: f64, range: &'static str },
    #[error("the eigenvalues of a {order} by {order} matrix did not converge")]
    NoConvergence { order: usize },
    /// No root is left once those at the origin are dropped.
    #[error("the period map has no root away from the origin")]
    NoRoot,
    #[error("{found} samples are too few, {needed} are needed")]
    TooFew { found: usize, needed: usize },
    #[error("sample {index} is {value}: the run diverged or faulted")]
    NotFinite { index: usize, value: f64 },
    #[error("the record has no oscillatory mode")]
    NoOscillation,
    #[error("the decomposition of the record did not converge")]
    NoDecomposition,
    #[error(transparent)]
    Table(#[from] vehicle::table::TableError),
}

/// Damping ratio `−Re s / |s|`.
pub fn damping_ratio(s: C64) -> f64 {
    -s.re / s.modulus()
}

/// Growth of the amplitude over one cycle, `exp(2π Re s / |Im s|)`.
pub fn growth_per_cycle(s: C64) -> f64 {
    libm::exp(std::f64::consts::TAU * s.re / s.im.abs())
}

/// `s = ln z / T`, principal branch: |Im s| ≤ π/T.
pub fn equivalent_root(z: C64, period_s: f64) -> C64 {
    ComplexField::ln(z) / period_s
}

/// The root nearest to `target`; `None` for an empty slice.
///
/// Roots of a real map come in conjugate pairs, so the target picks the half plane.
pub fn nearest_root(roots: &[C64], target: C64) -> Option<C64> {
    roots.iter().copied().min_by(|a, b| (a - target).modulus().total_cmp(&(b - target).modulus()))
}

/// A value that is finite and fits its range.
pub(crate) fn require(
    what: &'static str,
    value: f64,
    ok: bool,
    range: &'static str,
) -> Result<f64, Refusal> {
    if ok && value.is_finite() { Ok(value) } else { Err(Refusal::Setting { what, value, range }) }
}

/// A frame period above zero and a latency of at most one frame, s.
pub(crate) fn frame_and_latency(frame_s: f64, latency_s: f64) -> Result<(f64, f64), Refusal> {
    let frame = require("the frame", frame_s, frame_s > 0.0, "> 0 s")?;
    let latency =
        require("the latency", latency_s, (0.0..=frame).contains(&latency_s), "0 to one frame")?;
    Ok((frame, latency))
}
