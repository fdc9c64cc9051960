//! Identification of what a run did: sinusoids, poles, growth.
//!
//! [`fit_sine`] is the single-frequency least-squares fit of frequency-response
//! testing; over whole periods mean, sine and cosine are orthogonal, so that
//! harmonics and drift of other frequencies drop out. [`poles`] is the matrix pencil:
//! it finds every mode of a sampled free response, so that the settled and the dying
//! modes are told apart rather than fitted together. Neither knows the theory.

use crate::sampling::theory::{C64, equivalent_root};
use nalgebra::{DMatrix, DVector, Matrix3, Schur, Vector3};
use serde::Serialize;

/// Why nothing could be identified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// Too few samples.
    #[error("{found} samples are too few, {needed} are needed")]
    TooFew {
        /// Samples given.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
    /// A sample is infinite or not a number.
    #[error("sample {index} is {value}: the run diverged or faulted")]
    NotFinite {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The frequency cannot be told from the mean at these instants.
    #[error("the samples do not determine a wave of {omega_rad_s} rad/s")]
    Singular {
        /// The frequency.
        omega_rad_s: f64,
    },
    /// No oscillatory mode in the record.
    #[error("the record has no oscillatory mode")]
    NoOscillation,
    /// A decomposition did not converge.
    #[error("the decomposition of the record did not converge")]
    NoConvergence,
}

/// `y = mean + amplitude · sin(ωt + phase)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SineFit {
    /// Mean.
    pub mean: f64,
    /// Amplitude ≥ 0.
    pub amplitude: f64,
    /// Phase, rad, (−π, π].
    pub phase_rad: f64,
    /// RMS of what the fit leaves.
    pub residual_rms: f64,
}

/// Least-squares sine of known frequency; `times_s` and `values` have one length.
///
/// # Errors
/// On fewer than four samples, non-finite ones, or instants that do not determine the wave.
pub fn fit_sine(
    times_s: &[f64],
    values: &[f64],
    omega_rad_s: f64,
) -> Result<SineFit, IdentifyError> {
    let n = times_s.len().min(values.len());
    check(&values[..n], 4)?;
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (t, y) in times_s.iter().zip(values) {
        let (s, c) = (omega_rad_s * t).sin_cos();
        let row = Vector3::new(1.0, s, c);
        normal += row * row.transpose();
        right += row * *y;
    }
    let solution = normal
        .cholesky()
        .ok_or(IdentifyError::Singular { omega_rad_s })?
        .solve(&right);
    let (mean, s, c) = (solution[0], solution[1], solution[2]);
    let square: f64 = times_s
        .iter()
        .zip(values)
        .map(|(t, y)| {
            let (sin, cos) = (omega_rad_s * t).sin_cos();
            (y - mean - s * sin - c * cos).powi(2)
        })
        .sum();
    Ok(SineFit {
        mean,
        amplitude: s.hypot(c),
        phase_rad: c.atan2(s),
        residual_rms: (square / n as f64).sqrt(),
    })
}

/// Phase of `sin` and `cos` correlations `∫y sin ωt dt`, `∫y cos ωt dt` over whole periods, rad.
#[must_use]
pub fn correlated_phase_rad(sine: f64, cosine: f64) -> f64 {
    cosine.atan2(sine)
}

/// Difference of two angles brought to (−π, π].
#[must_use]
pub fn angle_difference_rad(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(std::f64::consts::TAU);
    if d > std::f64::consts::PI {
        d - std::f64::consts::TAU
    } else {
        d
    }
}

/// Longest record that [`poles`] takes; further samples are left out.
const LONGEST: usize = 320;
/// Greatest number of modes sought.
const MODES: usize = 12;

/// Equivalent roots `ln z / T` of every mode above `floor` (relative to the largest singular
/// value; 1e-9 for a noise-free record, more for a quantised one), by the matrix pencil.
///
/// The Hankel matrix `Y[i][j] = y_{i+j}` of a sum of p exponentials has rank p and its row space
/// is spanned by Vandermonde rows, whose shift has the z as eigenvalues.
///
/// # Errors
/// On a short or non-finite record, or when a decomposition does not converge.
pub fn poles(samples: &[f64], period_s: f64, floor: f64) -> Result<Vec<C64>, IdentifyError> {
    check(samples, 3 * MODES)?;
    let y = &samples[..samples.len().min(LONGEST)];
    let columns = (y.len() / 3).clamp(MODES + 1, 3 * MODES) + 1;
    let rows = y.len() + 1 - columns;
    let hankel = DMatrix::from_fn(rows, columns, |i, j| y[i + j]);
    let svd = hankel
        .try_svd(false, true, f64::EPSILON, 10_000)
        .ok_or(IdentifyError::NoConvergence)?;
    let v_t = svd.v_t.ok_or(IdentifyError::NoConvergence)?;
    let largest = svd.singular_values.max();
    let keep: Vec<usize> = (0..svd.singular_values.len())
        .filter(|i| svd.singular_values[*i] > floor * largest)
        .take(MODES)
        .collect();
    if keep.is_empty() || largest == 0.0 {
        return Err(IdentifyError::NoOscillation);
    }
    // Columns of `first` and `second` are the kept right vectors without last and first entry.
    let first = DMatrix::from_fn(columns - 1, keep.len(), |i, k| v_t[(keep[k], i)]);
    let second = DMatrix::from_fn(columns - 1, keep.len(), |i, k| v_t[(keep[k], i + 1)]);
    let shift = first
        .svd(true, true)
        .solve(&second, 1e-13)
        .map_err(|_| IdentifyError::NoConvergence)?;
    let order = keep.len();
    let z = Schur::try_new(shift.clone(), f64::EPSILON, 500 * order)
        .ok_or(IdentifyError::NoConvergence)?
        .complex_eigenvalues();
    let shift = shift.map(|v| C64::new(v, 0.0));
    Ok(z.iter()
        .map(|z| polished(&shift, *z))
        .filter(|z| z.norm() > 1e-9)
        .map(|z| equivalent_root(z, period_s))
        .collect())
}

/// An eigenvalue made better by inverse iteration, each step at the last estimate.
///
/// The QR iteration gives up a subdiagonal entry once it is small against its neighbours; for
/// the far from normal matrices of the pencil that can leave 1e-4 of the root.
fn polished(matrix: &DMatrix<C64>, start: C64) -> C64 {
    let n = matrix.nrows();
    let mut z = start;
    let mut vector = DVector::from_element(n, C64::new(1.0, 0.0));
    for _ in 0..6 {
        let shifted = matrix - DMatrix::from_diagonal_element(n, n, z);
        // Singular to the last bit: z is an eigenvalue.
        let Some(next) = shifted.lu().solve(&vector) else {
            break;
        };
        let length = next.norm();
        if !length.is_finite() || length == 0.0 {
            break;
        }
        let next = next / C64::new(length, 0.0);
        let quotient = next.dotc(&(matrix * &next));
        vector = next;
        if !quotient.is_finite() || (quotient - start).norm() > 1e-2 * start.norm() {
            return start;
        }
        z = quotient;
    }
    z
}

/// The mode on the branch nearest to `near` in the upper half plane.
///
/// # Errors
/// As [`poles`], and when no mode oscillates.
pub fn oscillatory_pole(
    samples: &[f64],
    period_s: f64,
    floor: f64,
    near: C64,
) -> Result<C64, IdentifyError> {
    let oscillatory: Vec<C64> = poles(samples, period_s, floor)?
        .into_iter()
        .filter(|s| s.im > 0.0)
        .collect();
    crate::sampling::theory::nearest_root(&oscillatory, near).ok_or(IdentifyError::NoOscillation)
}

fn check(values: &[f64], needed: usize) -> Result<(), IdentifyError> {
    if values.len() < needed {
        return Err(IdentifyError::TooFew {
            found: values.len(),
            needed,
        });
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(IdentifyError::NotFinite {
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_with_harmonics_over_whole_periods() {
        let w = std::f64::consts::TAU / 2.0;
        let t: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.01).collect();
        let y: Vec<f64> = t
            .iter()
            .map(|t| 0.5 + 2.0 * (w * t + 0.3).sin() + 0.1 * (3.0 * w * t).cos())
            .collect();
        let f = fit_sine(&t, &y, w).unwrap();
        // Two whole periods: the harmonic is orthogonal, only rounding is left.
        assert!((f.amplitude - 2.0).abs() < 1e-13);
        assert!((f.phase_rad - 0.3).abs() < 1e-13);
        assert!((f.mean - 0.5).abs() < 1e-13);
        assert!((f.residual_rms - 0.1 / 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn three_modes_are_told_apart() {
        let (t, s1, s2, s3) = (
            0.05,
            C64::new(0.2, 6.0),
            C64::new(-3.0, 11.0),
            C64::new(-8.0, 0.0),
        );
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

    #[test]
    fn records_that_say_nothing_are_refused() {
        assert!(matches!(
            poles(&[1.0; 5], 0.1, 1e-9),
            Err(IdentifyError::TooFew { .. })
        ));
        let mut y = vec![1.0; 60];
        y[7] = f64::INFINITY;
        assert!(matches!(
            poles(&y, 0.1, 1e-9),
            Err(IdentifyError::NotFinite { index: 7, .. })
        ));
        assert!(poles(&[0.0; 60], 0.1, 1e-9).is_err());
        assert!(oscillatory_pole(&[1.0; 60], 0.1, 1e-9, C64::new(0.0, 1.0)).is_err());
        assert!(fit_sine(&[0.0; 9], &[1.0; 9], 3.0).is_err());
    }
}
