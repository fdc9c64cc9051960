//! Exact discretisation of a linear system behind a zero-order hold, with delay.
//!
//! `[Φ Γ; 0 I] = exp([A B; 0 0] T)`. With a delay `τ = (d + f) T`, 0 ≤ f < 1, the
//! update n takes effect at `t_n + τ`, so that
//! `x_{n+1} = Φ x_n + Γ_new u_{n−d} + Γ_old u_{n−d−1}`
//! with `Γ_old = Φ(T − fT) Γ(fT)` and `Γ_new = Γ(T − fT)`.

use super::{TheoryError, in_range};
use crate::matrix_exp::matrix_exp;
use nalgebra::DMatrix;

/// A discretised system; shapes n×n, n×m, n×m.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrete {
    /// Free motion over a frame.
    pub phi: DMatrix<f64>,
    /// Effect of `u_{n−d}`.
    pub gamma_new: DMatrix<f64>,
    /// Effect of `u_{n−d−1}`; zero where the delay is a whole number of frames.
    pub gamma_old: DMatrix<f64>,
    /// Whole frames d of delay.
    pub whole_frames: usize,
}

/// Φ and Γ over `period_s` without delay.
///
/// # Errors
/// When A is not square, B has other rows, or the period is negative.
pub fn hold_discretise(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    period_s: f64,
) -> Result<(DMatrix<f64>, DMatrix<f64>), TheoryError> {
    let (n, m) = (a.nrows(), b.ncols());
    if a.ncols() != n || b.nrows() != n {
        return Err(TheoryError::Shape {
            what: "[A B]",
            expected: format!("{n}x{n} and {n}x{m}"),
            found: format!("{:?} and {:?}", a.shape(), b.shape()),
        });
    }
    in_range("the period", period_s, period_s >= 0.0, "≥ 0 s")?;
    let mut block = DMatrix::zeros(n + m, n + m);
    block.view_mut((0, 0), (n, n)).copy_from(&(a * period_s));
    block.view_mut((0, n), (n, m)).copy_from(&(b * period_s));
    let e = matrix_exp(&block);
    Ok((e.view((0, 0), (n, n)).into_owned(), e.view((0, n), (n, m)).into_owned()))
}

/// Discretises with any delay `delay_s ≥ 0`, more than one frame included.
///
/// # Errors
/// As [`hold_discretise`], and for a period that is not positive or a negative delay.
pub fn zoh_discretise(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    period_s: f64,
    delay_s: f64,
) -> Result<Discrete, TheoryError> {
    in_range("the period", period_s, period_s > 0.0, "> 0 s")?;
    in_range("the delay", delay_s, delay_s >= 0.0, "≥ 0 s")?;
    let ratio = delay_s / period_s;
    // A delay given in decimal seconds may miss a whole number of frames by a few roundings.
    let nearest = ratio.round();
    let whole = if (ratio - nearest).abs() < 8.0 * f64::EPSILON * nearest.max(1.0) {
        nearest
    } else {
        ratio.floor()
    };
    let rest = (delay_s - whole * period_s).clamp(0.0, period_s);
    let (phi, gamma) = hold_discretise(a, b, period_s)?;
    let (gamma_new, gamma_old) = if rest == 0.0 || whole == nearest && nearest >= ratio {
        (gamma, DMatrix::zeros(b.nrows(), b.ncols()))
    } else {
        let (phi_late, gamma_late) = hold_discretise(a, b, period_s - rest)?;
        let (_, gamma_early) = hold_discretise(a, b, rest)?;
        (gamma_late, phi_late * gamma_early)
    };
    Ok(Discrete {
        phi,
        gamma_new,
        gamma_old,
        // A frame count beyond 2^32 is nonsense that later matrices would refuse by size.
        whole_frames: whole as usize,
    })
}

impl Discrete {
    /// Closed loop under `u_n = −K x_n`: state `[x_n; u_{n−1}; … ; u_{n−d−1}]`.
    ///
    /// With d = 0 and no fraction this is Φ − ΓK; one whole frame late it is
    /// `[[Φ, Γ], [−K, 0]]`.
    ///
    /// # Errors
    /// When K is not m×n.
    pub fn closed_loop(&self, k: &DMatrix<f64>) -> Result<DMatrix<f64>, TheoryError> {
        let (n, m) = self.gamma_new.shape();
        if k.shape() != (m, n) {
            return Err(TheoryError::Shape {
                what: "the gain matrix",
                expected: format!("{m}x{n}"),
                found: format!("{}x{}", k.nrows(), k.ncols()),
            });
        }
        let fractional = self.gamma_old.iter().any(|v| *v != 0.0);
        let stored = self.whole_frames + usize::from(fractional);
        let size = n + stored * m;
        let mut f = DMatrix::zeros(size, size);
        f.view_mut((0, 0), (n, n)).copy_from(&self.phi);
        // u_{n−i} is −K x_n for i = 0 and the stored block i − 1 otherwise.
        for (i, gamma) in
            [(self.whole_frames, &self.gamma_new), (self.whole_frames + 1, &self.gamma_old)]
        {
            if i == 0 {
                let mut x = f.view_mut((0, 0), (n, n));
                x -= gamma * k;
            } else if i <= stored {
                f.view_mut((0, n + (i - 1) * m), (n, m)).copy_from(gamma);
            }
        }
        if stored > 0 {
            f.view_mut((n, 0), (m, n)).copy_from(&(-k));
            for i in 1..stored {
                f.view_mut((n + i * m, n + (i - 1) * m), (m, m))
                    .copy_from(&DMatrix::identity(m, m));
            }
        }
        Ok(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Double integrator: Φ and Γ are polynomials, so that only rounding is left.
    #[test]
    fn double_integrator_with_fractional_delay() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let (t, f) = (0.1, 0.03);
        let d = zoh_discretise(&a, &b, t, 0.2 + f).unwrap();
        assert_eq!(d.whole_frames, 2);
        let r = t - f;
        // u_old acts for f seconds, then the plant drifts for r.
        let old = [f * f / 2.0 + f * r, f];
        let new = [r * r / 2.0, r];
        for i in 0..2 {
            assert!((d.gamma_old[i] - old[i]).abs() < 1e-16);
            assert!((d.gamma_new[i] - new[i]).abs() < 1e-16);
        }
        // 3 × 0.1 is not 0.3 in binary; it still is three whole frames.
        let d = zoh_discretise(&a, &b, t, 0.1 + 0.2).unwrap();
        assert_eq!(d.whole_frames, 3);
        assert!(d.gamma_old.iter().all(|v| *v == 0.0));
        assert!((d.gamma_new[0] - t * t / 2.0).abs() < 1e-16);
    }

    #[test]
    fn bad_shapes_and_numbers_are_refused() {
        let a = DMatrix::zeros(2, 2);
        assert!(zoh_discretise(&a, &DMatrix::zeros(3, 1), 0.1, 0.0).is_err());
        assert!(zoh_discretise(&a, &DMatrix::zeros(2, 1), 0.0, 0.0).is_err());
        assert!(zoh_discretise(&a, &DMatrix::zeros(2, 1), 0.1, -0.1).is_err());
        assert!(zoh_discretise(&a, &DMatrix::zeros(2, 1), 0.1, f64::NAN).is_err());
    }
}
