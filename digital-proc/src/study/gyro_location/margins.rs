//! Margins of a loop opened at an actuator.
//!
//! L(jω) is followed through the band of each mode. A mode is *gain-stabilised* where |L| stays
//! below 1 there: its gain margin −20 lg |L| at the peak is what the gain may rise whatever the
//! phase. Where |L| passes 1 it is *phase-stabilised* if its closed-loop root is damped: its phase
//! margin is the least angle between L and −1 where |L| = 1.

use super::flexible::OpenLoop;
use nalgebra::{Complex, ComplexField, DMatrix};
use std::f64::consts::PI;

/// Half the band of a mode, as a fraction of its frequency: the loop shifts it by less, and the
/// next mode is almost three times as fast.
const BAND: f64 = 0.2;
/// Points of a band, ten within the half width of a mode of ζ = 0.01.
const POINTS: u32 = 401;
/// The attitude loop crosses |L| = 1 above the slow drift of the flight path.
const LOWEST_RADPS: f64 = 0.5;

/// The frequency response L(jω) = −c (jω − A)⁻¹ b; none where it is a pole.
pub fn response(open: &OpenLoop, omega_radps: f64) -> Option<Complex<f64>> {
    let order = open.a.nrows();
    let complex = |x: f64| Complex::new(x, 0.0);
    let left = DMatrix::from_fn(order, order, |i, j| {
        Complex::new(-open.a[(i, j)], if i == j { omega_radps } else { 0.0 })
    });
    let x = left.lu().solve(&open.b.map(complex))?;
    Some(-(open.c.map(complex) * x)[0])
}

/// What a loop leaves to a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeMargin {
    /// Where |L| is greatest in its band, rad/s.
    pub peak_radps: f64,
    /// −20 lg |L| there, dB: positive where the mode is gain-stabilised.
    pub gain_db: f64,
    /// arg L there, degrees.
    pub phase_deg: f64,
    /// Least angle between L and −1 where |L| = 1 in the band, degrees; none where it is not.
    pub phase_margin_deg: Option<f64>,
}

/// Degrees from −1, 0 to 180.
fn from_minus_one_deg(l: Complex<f64>) -> f64 {
    (PI - libm::atan2(l.im, l.re).abs()).to_degrees()
}

/// The least angle to −1 where |L| passes 1 between neighbours.
fn phase_margin_deg(band: &[(f64, Complex<f64>)]) -> Option<f64> {
    band.windows(2)
        .filter(|w| (w[0].1.modulus() - 1.0) * (w[1].1.modulus() - 1.0) < 0.0)
        .map(|w| {
            // Straight between them: a thousandth of ω apart.
            let [a, b] = [w[0].1, w[1].1];
            let part = (1.0 - a.modulus()) / (b.modulus() - a.modulus());
            from_minus_one_deg(a + (b - a) * part)
        })
        .min_by(f64::total_cmp)
}

fn over(open: &OpenLoop, low: f64, high: f64, points: u32) -> Vec<(f64, Complex<f64>)> {
    (0..points)
        .map(|i| low * libm::pow(high / low, f64::from(i) / f64::from(points - 1)))
        .filter_map(|omega| response(open, omega).map(|l| (omega, l)))
        .collect()
}

/// The margin of a mode of a natural frequency.
pub fn of_mode(open: &OpenLoop, frequency_radps: f64) -> Option<ModeMargin> {
    let low = frequency_radps * (1.0 - BAND);
    let band = over(open, low, frequency_radps * (1.0 + BAND), POINTS);
    let (peak_radps, l) = *band.iter().max_by(|a, b| a.1.modulus().total_cmp(&b.1.modulus()))?;
    Some(ModeMargin {
        peak_radps,
        gain_db: -20.0 * libm::log10(l.modulus()),
        phase_deg: libm::atan2(l.im, l.re).to_degrees(),
        phase_margin_deg: phase_margin_deg(&band),
    })
}

/// Phase margin of the attitude loop, degrees: the least at its crossings of |L| = 1 from the drift
/// of the path to half the first mode.
pub fn of_attitude_deg(open: &OpenLoop, first_mode_radps: f64) -> Option<f64> {
    phase_margin_deg(&over(open, LOWEST_RADPS, first_mode_radps / 2.0, POINTS))
}

/// |L| over frequency, dB, for a figure.
pub fn bode(open: &OpenLoop) -> Vec<(f64, f64)> {
    let all = over(open, LOWEST_RADPS, 300.0, 1200);
    all.into_iter().map(|(omega, l)| (omega, 20.0 * libm::log10(l.modulus()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L = k ω₀²/(s² + 2ζω₀s + ω₀²) behind a pole at a: closed forms at resonance.
    #[test]
    fn a_resonance_has_the_margins_of_its_closed_form() {
        let (k, zeta, w) = (0.1, 0.01, 25.0);
        let open = OpenLoop {
            a: DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -w * w, -2.0 * zeta * w]),
            b: DMatrix::from_row_slice(2, 1, &[0.0, 1.0]),
            c: DMatrix::from_row_slice(1, 2, &[-k * w * w, 0.0]),
        };
        let margin = of_mode(&open, w).unwrap();
        // At its peak |L| = k/(2ζ√(1−ζ²)) = 5, the grid a thousandth of ω: (0.001/0.02)² below.
        assert!((margin.gain_db + 20.0 * 5f64.log10()).abs() < 0.02, "{margin:?}");
        // |L| = 1 at (1−r²)² + 4ζ²r² = k², r above 1: arg L = −π + atan(2ζr/(r²−1)).
        let r2 =
            (1.0 - 2.0 * zeta * zeta) + ((1.0 - 2.0 * zeta * zeta).powi(2) - 1.0 + k * k).sqrt();
        let truth = (2.0 * zeta * r2.sqrt() / (r2 - 1.0)).atan().to_degrees();
        let found = margin.phase_margin_deg.unwrap();
        assert!((found - truth).abs() < 0.02, "{found} {truth}");
        // A quarter of a hundredth of the gain leaves nothing to cross.
        let weak = OpenLoop { c: open.c.clone() * 0.1, ..open };
        let margin = of_mode(&weak, w).unwrap();
        assert!(margin.gain_db > 6.0 && margin.phase_margin_deg.is_none(), "{margin:?}");
    }
}
