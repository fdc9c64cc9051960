//! Identification of what a run did, without a word from theory.
//!
//! [`poles`] is the matrix pencil: it finds every mode of a sampled free response, so that the
//! settled and the dying modes are told apart rather than fitted together.

use super::{
    modal_fit::ModalFit,
    theory::{C64, Refusal, equivalent_root, nearest_root},
};
use nalgebra::{ComplexField, DMatrix, Schur};

/// Phase of `sin` and `cos` correlations `∫y sin ωt dt`, `∫y cos ωt dt` over whole periods, rad.
pub fn correlated_phase_rad(sine: f64, cosine: f64) -> f64 {
    libm::atan2(cosine, sine)
}

/// Difference of two angles brought to (−π, π].
pub fn angle_difference_rad(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(std::f64::consts::TAU);
    if d > std::f64::consts::PI { d - std::f64::consts::TAU } else { d }
}

/// Longest record that [`poles`] takes; further samples are left out.
pub const LONGEST: usize = 320;
/// Greatest number of modes sought.
const MODES: usize = 12;
/// Shortest record: five modes and twice as many equations.
pub const SHORTEST: usize = 18;

/// Equivalent roots `ln z / T` of every mode above `floor` (relative to the largest singular
/// value; 1e-9 for a noise-free record, more for a quantised one), by the matrix pencil.
pub fn poles(samples: &[f64], period_s: f64, floor: f64) -> Result<Vec<C64>, Refusal> {
    Ok(factors(samples, floor)?
        .iter()
        .filter(|z| z.modulus() > 1e-9)
        .map(|z| equivalent_root(*z, period_s))
        .collect())
}

/// Factors z of a frame of every mode above `floor`, as [`poles`]; those at zero are what is over
/// after a few frames, such as a delay of the law that fills.
///
/// The Hankel matrix `Y[i][j] = y_{i+j}` of a sum of p exponentials has rank p and its row space
/// is spanned by Vandermonde rows, whose shift has the z as eigenvalues.
pub fn factors(samples: &[f64], floor: f64) -> Result<Vec<C64>, Refusal> {
    check(samples, SHORTEST)?;
    let y = &samples[..samples.len().min(LONGEST)];
    let columns = (y.len() / 3).clamp(5, 3 * MODES) + 1;
    let rows = y.len() + 1 - columns;
    let hankel = DMatrix::from_fn(rows, columns, |i, j| y[i + j]);
    let (singular, v) = right_singular_vectors(hankel).ok_or(Refusal::NoDecomposition)?;
    let largest = singular.first().copied().unwrap_or(0.0);
    let keep: Vec<usize> = (0..singular.len())
        .filter(|i| singular[*i] > floor * largest)
        // Noise fills the whole rank; the shift needs a row more than it has modes.
        .take(MODES.min(columns - 1))
        .collect();
    if keep.is_empty() || largest == 0.0 {
        return Err(Refusal::NoOscillation);
    }
    // Columns of `first` and `second` are the kept right vectors without last and first entry.
    let first = DMatrix::from_fn(columns - 1, keep.len(), |i, k| v[(i, keep[k])]);
    let second = DMatrix::from_fn(columns - 1, keep.len(), |i, k| v[(i + 1, keep[k])]);
    let qr = first.qr();
    let shift = qr
        .r()
        .solve_upper_triangular(&(qr.q().transpose() * second))
        .ok_or(Refusal::NoDecomposition)?;
    let order = keep.len();
    let z = Schur::try_new(shift, f64::EPSILON, 500 * order)
        .ok_or(Refusal::NoDecomposition)?
        .complex_eigenvalues();
    Ok(z.iter().copied().collect())
}

/// Of `candidates`, the equivalent root whose mode has the most energy in the record, by a
/// least-squares fit of `Σ c_k z_k^n` with all of `roots`.
pub fn strongest(
    samples: &[f64],
    period_s: f64,
    roots: &[C64],
    candidates: impl Fn(&C64) -> bool,
) -> Option<C64> {
    let z: Vec<C64> = roots.iter().map(|s| ComplexField::exp(s * period_s)).collect();
    let energy = ModalFit::new(samples, &z)?.energy;
    (0..roots.len())
        .filter(|k| candidates(&roots[*k]))
        .max_by(|a, b| energy[*a].total_cmp(&energy[*b]))
        .map(|k| roots[k])
}

/// Singular values, greatest first, and right singular vectors, by one-sided Jacobi rotations.
///
/// The bidiagonal method of the matrix library loses small singular vectors of graded matrices,
/// which cost 2e-4 of a root on a record of rounding noise only; Jacobi keeps each to the last bits.
fn right_singular_vectors(matrix: DMatrix<f64>) -> Option<(Vec<f64>, DMatrix<f64>)> {
    const MOST_SWEEPS: usize = 60;
    // The triangular factor has the same right vectors in a smaller matrix.
    let mut a = matrix.qr().r();
    let n = a.ncols();
    let mut v = DMatrix::<f64>::identity(n, n);
    // Columns of squared norm below this are rounding of the greatest.
    let nothing = (f64::EPSILON * 1e-3 * a.norm()).powi(2);
    for _ in 0..MOST_SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let (alpha, beta) = (a.column(p).norm_squared(), a.column(q).norm_squared());
                let gamma = a.column(p).dot(&a.column(q));
                if alpha.min(beta) <= nothing
                    || gamma.abs() <= 4.0 * f64::EPSILON * (alpha * beta).sqrt()
                {
                    continue;
                }
                rotated = true;
                let zeta = (beta - alpha) / (2.0 * gamma);
                let t = zeta.signum() / (zeta.abs() + libm::hypot(zeta, 1.0));
                let c = 1.0 / libm::hypot(t, 1.0);
                let s = c * t;
                for m in [&mut a, &mut v] {
                    for i in 0..m.nrows() {
                        let (x, y) = (m[(i, p)], m[(i, q)]);
                        m[(i, p)] = c * x - s * y;
                        m[(i, q)] = s * x + c * y;
                    }
                }
            }
        }
        if !rotated {
            let norms: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|i, j| norms[*j].total_cmp(&norms[*i]));
            let sorted = DMatrix::from_fn(n, n, |i, k| v[(i, order[k])]);
            return Some((order.iter().map(|i| norms[*i]).collect(), sorted));
        }
    }
    None
}

/// The mode on the branch nearest to `near` in the upper half plane.
pub fn oscillatory_pole(
    samples: &[f64],
    period_s: f64,
    floor: f64,
    near: C64,
) -> Result<C64, Refusal> {
    let oscillatory: Vec<C64> =
        poles(samples, period_s, floor)?.into_iter().filter(|s| s.im > 0.0).collect();
    nearest_root(&oscillatory, near).ok_or(Refusal::NoOscillation)
}

/// Refuses fewer than `needed` samples, and what is no number.
pub(super) fn check(values: &[f64], needed: usize) -> Result<(), Refusal> {
    if values.len() < needed {
        return Err(Refusal::TooFew { found: values.len(), needed });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(Refusal::NotFinite { index, value: values[index] }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_modes_are_told_apart() {
        let (t, s1, s2, s3) = (0.05, C64::new(0.2, 6.0), C64::new(-3.0, 11.0), C64::new(-8.0, 0.0));
        let y: Vec<f64> = (0..200)
            .map(|n| {
                let time = f64::from(n) * t;
                ((s1 * time).exp() + (s2 * time).exp() * 0.7 + (s3 * time).exp() * 0.4).re
            })
            .collect();
        let got = oscillatory_pole(&y, t, 1e-9, C64::new(0.0, 6.0)).unwrap();
        // Record of e² dynamic range at rounding level 1e-16·e², poles separated by 0.2 in z:
        // conditioning below 1e4 leaves 1e-11.
        assert!((got - s1).norm() < 1e-9, "{got}");
    }

    /// Roots must not hang on the last bit of the record: modes of very different strength, as the
    /// redundant integrator has them, each copy with other rounding.
    #[test]
    fn rounding_of_the_record_does_not_move_a_root() {
        let t = 0.1;
        let z0 = C64::new(0.822_25, 0.547_03);
        let mut state = 1_u64;
        for _ in 0..40 {
            let y: Vec<f64> = (0..199)
                .map(|n| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    let rounding = 1.0 + ((state >> 40) as f64 / 2f64.powi(24) - 0.5) * 4e-16;
                    let fast = 0.725_f64.powi(n) + 0.2286_f64.powi(n) - 0.0597_f64.powi(n)
                        + (-0.0482_f64).powi(n);
                    (z0.powi(n).re + 1e-2 * fast) * 1e-3 * rounding
                })
                .collect();
            let exact = equivalent_root(z0, t);
            let got = oscillatory_pole(&y, t, 1e-9, exact).unwrap();
            // Rounding 1e-16 of a mode that is the strongest, times a condition below 1e4.
            assert!((got - exact).norm() < 1e-10, "{got} {exact}");
        }
    }

    #[test]
    fn records_that_say_nothing_are_refused() {
        assert!(matches!(poles(&[1.0; 5], 0.1, 1e-9), Err(Refusal::TooFew { .. })));
        let mut y = vec![1.0; 60];
        y[7] = f64::INFINITY;
        assert!(matches!(poles(&y, 0.1, 1e-9), Err(Refusal::NotFinite { index: 7, .. })));
        assert!(poles(&[0.0; 60], 0.1, 1e-9).is_err());
        assert!(oscillatory_pole(&[1.0; 60], 0.1, 1e-9, C64::new(0.0, 1.0)).is_err());
    }
}
