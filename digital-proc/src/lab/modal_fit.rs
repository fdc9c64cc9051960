//! How well a sum of modes `Σ c_k z_k^n` describes a record, and how much each of them has in it.
//!
//! [`identify`](super::identify) finds modes in any record, also in one that is no sum of modes;
//! only what they leave of the record says whether they are true.

use super::theory::C64;
use nalgebra::{ComplexField, DMatrix};

/// Modes below this factor a frame are over after as many frames as there are of them (delays of a
/// law that fill, an instant at which the input changes): those frames are left out, not fitted.
const OVER_AT_ONCE: f64 = 1e-3;
/// Most samples fitted; a longer record is thinned out evenly. A sum of modes holds at any
/// samples, and some thousand determine two dozen numbers as well as a million would.
const MOST: usize = 8192;

/// A least-squares fit of given modes to a record.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalFit {
    /// RMS of what the fit leaves over the RMS of the record about its mean.
    pub residual: f64,
    /// Σ of |c_k z_k^n|² of each mode, in the order given; zero of those left out.
    pub energy: Vec<f64>,
    /// Σ of squares of the record about its mean, over the same samples as the energies.
    pub record_energy: f64,
    /// How many samples those are.
    pub samples: usize,
}

impl ModalFit {
    /// Fits `z` to all of `samples`; none where they do not determine the weights, or where the
    /// record is constant.
    pub fn new(samples: &[f64], z: &[C64]) -> Option<ModalFit> {
        let slow: Vec<usize> = (0..z.len()).filter(|k| z[*k].modulus() >= OVER_AT_ONCE).collect();
        let first = z.len() - slow.len();
        let stride = samples.len().div_ceil(MOST).max(1);
        let at: Vec<usize> = (first..samples.len()).step_by(stride).collect();
        if slow.is_empty() || at.len() < slow.len() {
            return None;
        }
        // A growing mode is counted from its end, so that no column leaves the range of numbers.
        let from = |z: &C64| {
            if z.modulus() > 1.0 { *at.last().unwrap_or(&0) } else { first }
        };
        let columns = DMatrix::from_fn(at.len(), slow.len(), |i, k| {
            let z = z[slow[k]];
            ComplexField::exp(ComplexField::ln(z) * (at[i] as f64 - from(&z) as f64))
        });
        let right = DMatrix::from_fn(at.len(), 1, |i, _| C64::new(samples[at[i]], 0.0));
        let qr = columns.clone().qr();
        let weights = qr.r().solve_upper_triangular(&(qr.q().adjoint() * &right))?;
        let left = (&columns * &weights - &right).norm_squared();
        let mean = right.iter().map(|v| v.re).sum::<f64>() / at.len() as f64;
        let record_energy: f64 = right.iter().map(|v| (v.re - mean).powi(2)).sum();
        let mut energy = vec![0.0; z.len()];
        for (k, of) in slow.iter().enumerate() {
            energy[*of] = weights[(k, 0)].norm_sqr() * columns.column(k).norm_squared();
        }
        let residual = (left / record_energy).sqrt();
        residual.is_finite().then_some(ModalFit {
            residual,
            energy,
            record_energy,
            samples: at.len(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights, energies and what is left of a growing, a decaying and a vanishing mode.
    #[test]
    fn modes_are_weighed_and_the_rest_is_left() {
        let (grows, decays) = (C64::new(0.4, 0.95), C64::new(0.9, 0.0));
        let pair = [grows, grows.conj(), decays, C64::new(0.0, 0.0)];
        let record: Vec<f64> = (0..900)
            .map(|n| {
                // The mode at zero is the first sample alone.
                let first = if n == 0 { 7.0 } else { 0.0 };
                grows.powi(n).re * 1e-12 + decays.powi(n).re + first
            })
            .collect();
        let fit = ModalFit::new(&record, &pair).unwrap();
        // |z|^900 = 7e11, times 1e-12, and 1: both modes count, rounding is 1e-16 of the greater.
        assert!(fit.residual < 1e-12, "{fit:?}");
        // Sum of 0.81^n from n = 1 on: 0.81/0.19.
        assert!((fit.energy[2] - 0.81 / 0.19).abs() < 1e-6, "{fit:?}");
        assert_eq!(fit.energy[3], 0.0);
        // The growing pair has about half of the energy, 4 of 8.
        let without = ModalFit::new(&record, &pair[2..]).unwrap();
        assert!((0.6..0.8).contains(&without.residual), "{without:?}");
        assert_eq!(ModalFit::new(&[2.0; 50], &[C64::new(1.0, 0.0)]), None);
    }
}
