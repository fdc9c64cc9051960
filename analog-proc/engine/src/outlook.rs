//! What the settings of a patch make of its run, judged at the initial condition.
//!
//! Nothing here is a fault: the engine follows what it is given or refuses it. But a
//! stiff patch crawls under an explicit method, and a fixed step that is too long for
//! the patch's own rates gives numbers that are the method's, not the patch's.

use nalgebra::DMatrix;

use crate::{integration::Method, linear::eigenvalues};

/// Ratio of the slowest to the fastest time constant from which on a patch counts as stiff.
const STIFF: f64 = 1e4;

/// A rate this small beside the fastest is zero, or what differences leave of zero.
const ZERO: f64 = 1e-7;

/// Something to be warned of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// An explicit method on a stiff patch.
    #[error(
        "stiff at the initial condition: its time constants reach from {fastest_s:e} s to {slowest_s:e} s, \
         and the explicit method takes steps of the fastest throughout; try method = \"sdirk4\""
    )]
    Stiff {
        /// Fastest time constant, s.
        fastest_s: f64,
        /// Slowest time constant, s.
        slowest_s: f64,
    },
    /// A fixed step too long for the rates of the patch.
    #[error(
        "the fixed step of {step_s:e} s is too long for a time constant of {fastest_s:e} s: the run grows \
         where the patch decays; the longest stable step is about {stable_s:e} s"
    )]
    Unstable {
        /// The step, s.
        step_s: f64,
        /// Fastest time constant, s.
        fastest_s: f64,
        /// Longest stable step, s.
        stable_s: f64,
    },
}

/// Warnings for a method of step `step_s` (of the fixed-step methods) on a patch with this
/// Jacobian, per second.
pub fn warnings(jacobian: &DMatrix<f64>, method: Method, step_s: f64) -> Vec<Warning> {
    let rates = eigenvalues(jacobian);
    let decaying = || rates.iter().filter(|z| z.re < 0.0);
    let size = |z: &nalgebra::Complex<f64>| libm::hypot(z.re, z.im);
    let fastest = decaying().map(size).fold(0.0, f64::max);
    let moving = rates.iter().map(size).filter(|rate| *rate > ZERO * fastest);
    let slowest = moving.fold(f64::INFINITY, f64::min);
    if fastest <= 0.0 {
        return Vec::new();
    }
    let fastest_s = 1.0 / fastest;
    // The extent of the region of stability along the negative real axis.
    let extent = match method {
        Method::Euler => 2.0,
        Method::RungeKutta4 => 2.785,
        Method::DormandPrince => {
            let stiff = fastest / slowest > STIFF;
            let slowest_s = 1.0 / slowest;
            let warning = Warning::Stiff { fastest_s, slowest_s };
            return if stiff { vec![warning] } else { Vec::new() };
        }
        Method::Sdirk4 => return Vec::new(),
    };
    let stable_s = extent * fastest_s;
    let warning = Warning::Unstable { step_s, fastest_s, stable_s };
    if step_s > stable_s { vec![warning] } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decays(rates: &[f64]) -> DMatrix<f64> {
        DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(rates))
    }

    #[test]
    fn a_stiff_patch_is_told_under_the_explicit_method_alone() {
        let stiff = decays(&[-1e5, -1.0, 0.0]);
        let found = warnings(&stiff, Method::DormandPrince, 1e-3);
        let [Warning::Stiff { fastest_s, slowest_s }] = found[..] else {
            panic!("{found:?}");
        };
        assert!((fastest_s * 1e5 - 1.0).abs() < 1e-9 && (slowest_s - 1.0).abs() < 1e-9);
        assert!(warnings(&stiff, Method::Sdirk4, 1e-3).is_empty());
        assert!(warnings(&decays(&[-10.0, -1.0]), Method::DormandPrince, 1e-3).is_empty());
    }

    #[test]
    fn a_fixed_step_is_held_against_the_region_of_stability() {
        // h λ = 2.5: outside Euler's region, inside that of Runge and Kutta.
        let fast = decays(&[-2500.0]);
        assert_eq!(warnings(&fast, Method::Euler, 1e-3).len(), 1);
        assert!(warnings(&fast, Method::RungeKutta4, 1e-3).is_empty());
        assert_eq!(warnings(&fast, Method::RungeKutta4, 2e-3).len(), 1);
    }
}
