//! Coordinate search: one parameter at a time, up and down by a factor.
//!
//! Parameters are positive, so steps are factors. A step that lowers the cost is
//! kept and tried again; after a round without a gain the factor is brought
//! nearer to 1. The search needs no slope, tolerates costs with corners (limits,
//! dead zones), is deterministic, and stops after a given number of evaluations.

/// How far and how finely is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Factor of the first steps.
    pub first_factor: f64,
    /// The search ends when the factor would fall below this.
    pub last_factor: f64,
    /// Most evaluations of the cost, the first included.
    pub evaluations: usize,
}

/// Bounds of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least value, positive.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found<const N: usize> {
    /// The best parameters.
    pub parameters: [f64; N],
    /// Their cost.
    pub cost: f64,
    /// The cost of the start.
    pub first_cost: f64,
    /// Evaluations used.
    pub evaluations: usize,
}

/// Searches from `start`; a cost that is no number counts as infinite.
///
/// # Errors
/// The cost's own error ends the search.
pub fn coordinate_search<const N: usize, E>(
    start: [f64; N],
    bounds: &[Bounds; N],
    effort: Effort,
    mut cost: impl FnMut(&[f64; N]) -> Result<f64, E>,
) -> Result<Found<N>, E> {
    let mut evaluate = |p: &[f64; N]| -> Result<f64, E> {
        cost(p).map(|c| if c.is_nan() { f64::INFINITY } else { c })
    };
    let within = |p: f64, b: &Bounds| p.clamp(b.low, b.high);
    let mut best: [f64; N] = std::array::from_fn(|i| within(start[i], &bounds[i]));
    let first_cost = evaluate(&best)?;
    let mut best_cost = first_cost;
    let mut used = 1;
    let mut factor = effort.first_factor;
    while factor >= effort.last_factor && used < effort.evaluations {
        let mut gained = false;
        for i in 0..N {
            for step in [factor, 1.0 / factor] {
                // Along a direction that pays, go on.
                while used < effort.evaluations {
                    let mut trial = best;
                    trial[i] = within(best[i] * step, &bounds[i]);
                    if trial == best {
                        break;
                    }
                    let trial_cost = evaluate(&trial)?;
                    used += 1;
                    if trial_cost < best_cost {
                        (best, best_cost, gained) = (trial, trial_cost, true);
                    } else {
                        break;
                    }
                }
            }
        }
        if !gained {
            factor = factor.sqrt();
        }
    }
    Ok(Found { parameters: best, cost: best_cost, first_cost, evaluations: used })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const BOUNDS: Bounds = Bounds { low: 0.1, high: 100.0 };
    const EFFORT: Effort = Effort { first_factor: 1.5, last_factor: 1.005, evaluations: 400 };

    #[test]
    fn the_minimum_of_a_bowl_is_found_to_the_last_factor() {
        let cost = |p: &[f64; 2]| -> Result<f64, Infallible> {
            Ok((p[0].ln() - 3f64.ln()).powi(2) + (p[1].ln() - 0.7f64.ln()).abs())
        };
        let found = coordinate_search([1.0, 1.0], &[BOUNDS; 2], EFFORT, cost).unwrap();
        // The bowl has no valleys askew to its axes: each coordinate ends within
        // one last step, a factor of at most 1.005², of the minimum.
        assert!((found.parameters[0] / 3.0 - 1.0).abs() < 0.011, "{found:?}");
        assert!((found.parameters[1] / 0.7 - 1.0).abs() < 0.011, "{found:?}");
        assert!(found.cost < found.first_cost);
    }

    #[test]
    fn bounds_and_the_number_of_evaluations_are_kept() {
        let mut seen = 0;
        let effort = Effort { evaluations: 7, ..EFFORT };
        let found = coordinate_search([50.0], &[BOUNDS], effort, |p| {
            seen += 1;
            assert!((BOUNDS.low..=BOUNDS.high).contains(&p[0]));
            // Beyond 90 there is no answer: the best that has one is 50 · 1.5.
            Ok::<f64, Infallible>(if p[0] > 90.0 { f64::NAN } else { -p[0] })
        })
        .unwrap();
        assert_eq!(seen, found.evaluations);
        assert!(seen <= 7);
        assert_eq!(found.parameters[0], 75.0, "{found:?}");
    }
}
