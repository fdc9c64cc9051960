//! Transfer functions of the reconstruction: holds, delay, and digital lead.
//!
//! Symbols: x = ωT. `sinc(y) = sin y / y`. Each function is the ratio of the
//! fundamental at ω in the output of a sampled channel to the continuous input;
//! the images at `ω + 2πk/T` are left out.

use super::{C64, phasor};
use interface::hold::HoldKind;

interface::named! {
    /// How a DAC fills the time between transfers; the doc comments are the help.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
    pub enum Hold, name {
        /// The last value is held
        ZeroOrder "zero-order"
        /// The line through the last two values is continued
        Extrapolating "extrapolating"
        /// The line from the last value but one to the last is drawn, one frame late
        Interpolating "interpolating"
    }
}

impl From<Hold> for HoldKind {
    fn from(hold: Hold) -> HoldKind {
        match hold {
            Hold::ZeroOrder => HoldKind::ZeroOrder,
            Hold::Extrapolating => HoldKind::Extrapolating,
            Hold::Interpolating => HoldKind::Interpolating,
        }
    }
}

impl From<HoldKind> for Hold {
    fn from(kind: HoldKind) -> Hold {
        match kind {
            HoldKind::ZeroOrder => Hold::ZeroOrder,
            HoldKind::Extrapolating => Hold::Extrapolating,
            HoldKind::Interpolating => Hold::Interpolating,
        }
    }
}

impl Hold {
    /// Transfer function at ω:
    /// zero-order `sinc(x/2) e^{−jx/2}`,
    /// extrapolating `(1 + jx) [sinc(x/2) e^{−jx/2}]²`,
    /// interpolating `[sinc(x/2) e^{−jx/2}]²`.
    pub fn transfer(self, omega_rad_s: f64, frame_s: f64) -> C64 {
        let x = omega_rad_s * frame_s;
        let zero_order = phasor(-x / 2.0) * sinc(x / 2.0);
        match self {
            Hold::ZeroOrder => zero_order,
            Hold::Extrapolating => C64::new(1.0, x) * zero_order * zero_order,
            Hold::Interpolating => zero_order * zero_order,
        }
    }

    /// First-order effective delay in frames: ½, 0 and 1.
    pub fn delay_frames(self) -> f64 {
        match self {
            Hold::ZeroOrder => 0.5,
            Hold::Extrapolating => 0.0,
            Hold::Interpolating => 1.0,
        }
    }
}

/// `sin y / y`, 1 at the origin.
pub fn sinc(y: f64) -> f64 {
    // Below 1e-4 the series 1 − y²/6 is exact to y⁴/120 < 1e-18.
    if y.abs() < 1e-4 { 1.0 - y * y / 6.0 } else { libm::sin(y) / y }
}

/// A pure delay `e^{−jωτ}`.
pub fn delay(omega_rad_s: f64, delay_s: f64) -> C64 {
    phasor(-omega_rad_s * delay_s)
}

/// Digital lead of `a` frames, `r_n + a (r_n − r_{n−1})`: `1 + a (1 − e^{−jx})`.
///
/// Half a frame (a = ½) cancels the lag of a zero-order hold to first order;
/// with a latency τ the lead for cancellation is `a = ½ + τ/T`.
pub fn lead(omega_rad_s: f64, frame_s: f64, frames: f64) -> C64 {
    C64::new(1.0, 0.0) + (C64::new(1.0, 0.0) - phasor(-omega_rad_s * frame_s)) * frames
}

/// Track-and-hold that averages over an aperture ending at the sample: `sinc(ωa/2) e^{−jωa/2}`.
pub fn aperture(omega_rad_s: f64, aperture_s: f64) -> C64 {
    let y = omega_rad_s * aperture_s / 2.0;
    phasor(-y) * sinc(y)
}

/// First-order settling of a DAC, `1/(1 + jωτ)`.
pub fn settling(omega_rad_s: f64, time_constant_s: f64) -> C64 {
    C64::new(1.0, omega_rad_s * time_constant_s).inv()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The small-x forms of the holds: gain and phase to the first order that the theory prints.
    #[test]
    fn low_frequency_gain_and_phase() {
        let frame = 0.01;
        for x in [0.02_f64, 0.05, 0.1] {
            let omega = x / frame;
            // The next terms are of relative order x⁴ in gain and x⁵ in phase, with coefficients
            // below one in every case here.
            let (g, p) = (x * x * x * x, x.powi(5));
            let z = Hold::ZeroOrder.transfer(omega, frame);
            assert!((z.norm() - (1.0 - x * x / 24.0)).abs() < g);
            assert!((z.arg() + x / 2.0).abs() < 1e-15);
            let e = Hold::Extrapolating.transfer(omega, frame);
            assert!((e.norm() - (1.0 + 5.0 * x * x / 12.0)).abs() < g);
            assert!((e.arg() + x.powi(3) / 3.0).abs() < p);
            let i = Hold::Interpolating.transfer(omega, frame);
            assert!((i.arg() + x).abs() < 1e-15);
            let h = lead(omega, frame, 0.5) * z;
            assert!((h.norm() - (1.0 + x * x / 3.0)).abs() < g);
            // −x³/4 is the leading term; its printed value −0.24 x³ is the mean over x ≤ 0.5.
            assert!((h.arg() + x.powi(3) / 4.0).abs() < p);
        }
    }
}
