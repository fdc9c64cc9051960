//! What fixed steps leave: an estimate of their error, by the rates that a run has anyway.
//!
//! A method of fixed steps has no error to end it by. But two steps of Runge and Kutta's are
//! compared with Simpson's rule over both, and a step of Euler's with the trapezoidal rule. Where
//! the steps resolve the rates, the differences tell the errors (Richardson's extrapolation);
//! where they do not (a pulse between two steps), the estimate is of the size of what was met. It
//! refuses to alter a step, and to tell of a pulse that no step has met.

use crate::integrate::{Scheme, Step};
use serde::{Deserialize, Serialize};

/// The estimate is told from this part of a state's greatest magnitude on: three digits.
const POOR: f64 = 1e-3;

/// Simpson's rule over two steps errs 15 times as much as over each, and each is in two pairs.
const PAIRED: f64 = 1.0 / 30.0;

/// Two steps of which one is so many times as long as the other are not compared.
const MOST_UNEQUAL: f64 = 8.0;

/// The estimate, and the step before.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FixedSteps {
    /// Sum of the errors of each state.
    errors: Vec<f64>,
    y0: Vec<f64>,
    f0: Vec<f64>,
    /// Its length, s; zero where something switched since.
    h_s: f64,
}

impl FixedSteps {
    pub fn new(states: usize) -> FixedSteps {
        let zeros = || vec![0.0; states];
        FixedSteps { errors: zeros(), y0: zeros(), f0: zeros(), h_s: 0.0 }
    }

    pub fn reset(&mut self) {
        self.errors.fill(0.0);
        self.part();
    }

    /// The next step does not follow the one before.
    pub fn part(&mut self) {
        self.h_s = 0.0;
    }

    /// Takes an accepted step. Out of line, so that it does not crowd the adaptive methods.
    #[inline(never)]
    pub fn take(&mut self, scheme: &Scheme, step: &Step) {
        match scheme {
            Scheme::Euler => {
                let rates = step.f0.iter().zip(&step.f1);
                for (error, (f0, f1)) in self.errors.iter_mut().zip(rates) {
                    *error += 0.5 * step.h_s * (f1 - f0).abs();
                }
            }
            Scheme::RungeKutta4(_) => self.compare(step),
            Scheme::DormandPrince(_) | Scheme::Sdirk4(_) => {}
        }
    }

    /// Simpson's rule for the rates at the ends of two steps, of any lengths.
    fn compare(&mut self, step: &Step) {
        let both_s = self.h_s + step.h_s;
        let ratio = step.h_s / self.h_s;
        if ratio * MOST_UNEQUAL >= 1.0 && ratio <= MOST_UNEQUAL {
            let weights = [2.0 - ratio, both_s * both_s / (self.h_s * step.h_s), 2.0 - 1.0 / ratio];
            for (i, error) in self.errors.iter_mut().enumerate() {
                let rates = [self.f0[i], step.f0[i], step.f1[i]];
                let sum: f64 = weights.iter().zip(rates).map(|(w, f)| w * f).sum();
                let rise = step.y1[i] - self.y0[i];
                *error += PAIRED * (rise - both_s / 6.0 * sum).abs();
            }
        }
        self.y0.copy_from_slice(&step.y0);
        self.f0.copy_from_slice(&step.f0);
        self.h_s = step.h_s;
    }

    /// The state of the poorest estimate beside its greatest magnitude, and that, where it is poor.
    pub fn poorest(&self, largest: &[f64]) -> Option<(usize, f64)> {
        let states = self.errors.iter().zip(largest).enumerate();
        let poor = states.filter(|(_, (error, largest))| **error > POOR * **largest);
        let parts = poor.map(|(i, (error, largest))| (i, *error, error / largest));
        let poorest = parts.max_by(|a, b| a.2.total_cmp(&b.2));
        poorest.map(|(i, error, _)| (i, error))
    }
}
