//! The exponential of a square matrix.
//!
//! Scaling and squaring with the diagonal Padé approximant of degree 13: N. J. Higham, "The
//! Scaling and Squaring Method for the Matrix Exponential Revisited", SIAM J. Matrix Anal.
//! Appl. 26 (2005), algorithm 2.3. Sums and products only; nalgebra's own comes with its `std`,
//! whose powers, logarithms and products of matrices depend on the processor.

use nalgebra::DMatrix;

/// Coefficients b₀ … b₁₃ of the numerator; the denominator's alternate in sign.
const PADE: [f64; 14] = [
    64_764_752_532_480_000.0,
    32_382_376_266_240_000.0,
    7_771_770_303_897_600.0,
    1_187_353_796_428_800.0,
    129_060_195_264_000.0,
    10_559_470_521_600.0,
    670_442_572_800.0,
    33_522_128_640.0,
    1_323_241_920.0,
    40_840_800.0,
    960_960.0,
    16_380.0,
    182.0,
    1.0,
];
/// Up to this 1-norm the approximant is exact to rounding (θ₁₃, table 2.3).
const LARGEST_NORM: f64 = 5.371_920_351_148_152;

/// `e^A`; not a number throughout where an entry of A is not finite.
///
/// # Panics
/// Where A is not square.
pub(crate) fn matrix_exp(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let not_a_number = || DMatrix::from_element(n, n, f64::NAN);
    let norm = a.column_iter().map(|c| c.iter().map(|v| v.abs()).sum()).fold(0.0, f64::max);
    if !a.iter().all(|v| v.is_finite()) || f64::is_infinite(norm) {
        return not_a_number();
    }
    let (mut scale, mut squarings) = (1.0, 0);
    while norm * scale > LARGEST_NORM {
        scale *= 0.5;
        squarings += 1;
    }
    let a = a * scale;
    let a2 = &a * &a;
    let a4 = &a2 * &a2;
    let a6 = &a4 * &a2;
    let b = &PADE;
    // b[k] 1 + b[k+2] A² + b[k+4] A⁴ + b[k+6] A⁶ + A⁶ (b[k+8] A² + b[k+10] A⁴ + b[k+12] A⁶).
    let half = |k: usize| {
        let high = &a2 * b[k + 8] + &a4 * b[k + 10] + &a6 * b[k + 12];
        &a6 * high
            + &a6 * b[k + 6]
            + &a4 * b[k + 4]
            + &a2 * b[k + 2]
            + DMatrix::identity(n, n) * b[k]
    };
    let (even, odd) = (half(0), &a * half(1));
    // Within the norm above the denominator's condition number is below 18 (table 2.3).
    let Some(mut e) = (&even - &odd).lu().solve(&(even + odd)) else {
        return not_a_number();
    };
    for _ in 0..squarings {
        e = &e * &e;
    }
    e
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damped_rotations_small_and_large() {
        // exp [[-a, -w], [w, -a]] is a rotation by w, shrunk by e^{-a}.
        for (a, w) in [(1e-9, 2e-9), (0.1, 0.7), (2.0, 3.0), (0.5, 40.0), (-3.0, 300.0_f64)] {
            let e = matrix_exp(&DMatrix::from_row_slice(2, 2, &[-a, -w, w, -a]));
            let (sin, cos) = w.sin_cos();
            let expected = [cos, -sin, sin, cos].map(|v| v * (-a).exp());
            // A rounding of A turns by as much as its norm; squaring keeps that.
            let tolerance = 8.0 * f64::EPSILON * (1.0 + a.abs() + w) * (-a).exp();
            for (found, expected) in e.transpose().iter().zip(expected) {
                assert!((found - expected).abs() < tolerance, "{a} {w}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_chain_of_integrators_gives_powers_over_factorials() {
        let e = matrix_exp(&DMatrix::from_fn(6, 6, |i, j| if j == i + 1 { 3.0 } else { 0.0 }));
        for (k, expected) in [1.0, 3.0, 4.5, 4.5, 3.375, 2.025].into_iter().enumerate() {
            // Some ten sums of terms no greater than the result.
            assert!((e[(0, k)] / expected - 1.0).abs() < 16.0 * f64::EPSILON, "{k}: {}", e[(0, k)]);
        }
    }

    #[test]
    fn what_is_not_finite_stays_visible() {
        for bad in [f64::NAN, f64::INFINITY] {
            let e = matrix_exp(&DMatrix::from_element(2, 2, bad));
            assert!(e.iter().all(|v| v.is_nan()));
        }
    }
}
