//! A period of a sampled loop as a product of flows and jumps, and its roots.
//!
//! The state lists everything the loop remembers: plant, DAC output, buffers,
//! digital memory. Between instants it *flows* by `exp(A Δt)`; at samples,
//! transfers and slow tasks it *jumps* by a matrix. The product over one whole
//! period is the monodromy matrix, whose eigenvalues decide the loop exactly,
//! for any latency and any number of rates.

use super::{C64, Refusal, equivalent_root, nearest_root};
use crate::matrix_exp::matrix_exp;
use nalgebra::{ComplexField, DMatrix, Schur, linalg::balancing::balance_parlett_reinsch};

/// Roots with |z| below this are memory cells that only shift; ln z means nothing there.
///
/// A chain of k cells has a k-fold root at 0, which rounding spreads to a circle of
/// radius ε^{1/k}: 6e-6 for three cells, 1e-4 for four. A real mode this small would lose
/// seven nepers a period and decide nothing.
pub const ORIGIN: f64 = 1e-3;

/// The product so far; shape n×n.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodMap {
    matrix: DMatrix<f64>,
    elapsed_s: f64,
}

impl PeriodMap {
    /// The identity on `order` states.
    pub fn new(order: usize) -> PeriodMap {
        PeriodMap { matrix: DMatrix::identity(order, order), elapsed_s: 0.0 }
    }

    /// Flows by `exp(generator · seconds)`; `generator` is n×n.
    pub fn flow(&mut self, generator: &DMatrix<f64>, seconds: f64) {
        if seconds > 0.0 {
            self.matrix = matrix_exp(&(generator * seconds)) * &self.matrix;
            self.elapsed_s += seconds;
        }
    }

    /// Applies a jump; `jump` is n×n.
    pub fn jump(&mut self, jump: &DMatrix<f64>) {
        self.matrix = jump * &self.matrix;
    }

    /// The same on states scaled to be alike, so that units cost no digits of the roots.
    pub fn balanced(mut self) -> PeriodMap {
        if self.matrix.iter().all(|v| v.abs() < 1e150) {
            balance_parlett_reinsch(&mut self.matrix);
        }
        self
    }

    /// Discrete roots z.
    pub fn discrete_roots(&self) -> Result<Vec<C64>, Refusal> {
        eigenvalues(&self.matrix)
    }

    /// Greatest |z|: the loop is stable when it is below 1.
    pub fn spectral_radius(&self) -> Result<f64, Refusal> {
        Ok(self.discrete_roots()?.iter().map(|z| z.modulus()).fold(0.0, f64::max))
    }

    /// Equivalent roots `ln z / T`, without those at the origin.
    pub fn roots(&self) -> Result<Vec<C64>, Refusal> {
        Ok(self
            .discrete_roots()?
            .into_iter()
            .filter(|z| z.modulus() > ORIGIN)
            .map(|z| equivalent_root(z, self.elapsed_s))
            .collect())
    }

    /// The equivalent root on the branch of `continuous`.
    pub fn root_near(&self, continuous: C64) -> Result<C64, Refusal> {
        nearest_root(&self.roots()?, continuous).ok_or(Refusal::NoRoot)
    }
}

/// Eigenvalues of a real square matrix.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<C64>, Refusal> {
    let n = matrix.nrows();
    if matrix.iter().any(|v| !v.is_finite()) {
        return Err(Refusal::NoConvergence { order: n });
    }
    // Francis steps need about two iterations a root; 100 a root is a bound, not an expectation.
    let iterate = |m: DMatrix<f64>| Schur::try_new(m, f64::EPSILON, 100 * n);
    if let Some(schur) = iterate(matrix.clone()) {
        return Ok(schur.complex_eigenvalues().iter().copied().collect());
    }
    // Deflation compares a subdiagonal with its neighbours on the diagonal, which are all zero in a
    // chain of memory cells; a shift of the whole spectrum by the norm makes them not so.
    let shift = matrix.norm().max(f64::MIN_POSITIVE);
    iterate(matrix + DMatrix::identity(n, n) * shift)
        .map(|s| s.complex_eigenvalues().iter().map(|z| z - shift).collect())
        .ok_or(Refusal::NoConvergence { order: n })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flow_of_an_oscillator_has_its_root() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -9.0, -0.6]);
        let mut map = PeriodMap::new(2);
        map.flow(&a, 0.04);
        map.flow(&a, 0.06);
        let s0 = C64::new(-0.3, (9.0_f64 - 0.09).sqrt());
        let s = map.root_near(s0).unwrap();
        // exp and Schur are backward stable: a few 1e-16 of |A|T in z, divided by T.
        assert!((s - s0).norm() < 1e-13);
    }

    #[test]
    fn a_shift_chain_has_only_origin_roots() {
        let mut j = DMatrix::zeros(3, 3);
        j[(1, 0)] = 1.0;
        j[(2, 1)] = 1.0;
        let mut map = PeriodMap::new(3);
        map.jump(&j);
        assert_eq!(map.root_near(C64::new(0.0, 1.0)), Err(Refusal::NoRoot));
    }

    #[test]
    fn non_finite_matrices_are_refused() {
        let m = DMatrix::from_element(2, 2, f64::NAN);
        assert!(eigenvalues(&m).is_err());
    }
}
