//! Shapes that the axis of the vehicle takes: two rigid ones and the free-free bending modes of a
//! uniform beam, each with its slope and its first and second integrals in closed form.
//!
//! Mode i of a uniform free-free beam of length L, κ = k_i x/L:
//! φᵘ = ½[cosh κ + cos κ − σ(sinh κ + sin κ)], σ = (cosh k − cos k)/(sinh k − sin k),
//! so that φᵘ(0) = 1. Its fourth derivative is (k/L)⁴ φᵘ, whence the integrals.

/// Number of bending modes that are known.
pub const MODES: usize = 3;
/// Number of shapes: displacement, rotation, modes.
pub const SHAPES: usize = 2 + MODES;
/// Roots k of cosh k cos k = 1: the free-free modes of a uniform beam.
pub const FREE_FREE: [f64; MODES] = [4.730_041, 7.853_205, 10.995_608];

/// Every shape at one station, in the order 1, x, φᵘ₁, φᵘ₂, φᵘ₃.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapesAt {
    pub value: [f64; SHAPES],
    /// Derivative along the axis, 1/m for a shape without a unit.
    pub slope: [f64; SHAPES],
    /// An integral along the axis; only differences mean anything.
    pub integral: [f64; SHAPES],
    /// An integral of `integral`.
    pub double_integral: [f64; SHAPES],
}

/// All shapes of a beam of `length_m` at `x_m` from its aft end.
pub fn shapes_at(length_m: f64, x_m: f64) -> ShapesAt {
    let x = x_m;
    let mut at = ShapesAt {
        value: [1.0, x, 0.0, 0.0, 0.0],
        slope: [0.0, 1.0, 0.0, 0.0, 0.0],
        integral: [x, x * x / 2.0, 0.0, 0.0, 0.0],
        double_integral: [x * x / 2.0, x * x * x / 6.0, 0.0, 0.0, 0.0],
    };
    for (mode, k) in FREE_FREE.into_iter().enumerate() {
        let sigma = (libm::cosh(k) - libm::cos(k)) / (libm::sinh(k) - libm::sin(k));
        let per_m = k / length_m;
        let kappa = per_m * x;
        let (ch, sh) = (libm::cosh(kappa), libm::sinh(kappa));
        let (s, c) = libm::sincos(kappa);
        let i = 2 + mode;
        at.value[i] = 0.5 * (ch + c - sigma * (sh + s));
        at.slope[i] = 0.5 * per_m * (sh - s - sigma * (ch + c));
        at.double_integral[i] = 0.5 / (per_m * per_m) * (ch - c - sigma * (sh - s));
        at.integral[i] = 0.5 / per_m * (sh + s - sigma * (ch - c));
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_and_integrals_are_those_of_the_shapes() {
        let (length, h) = (22.7, 1e-3);
        for x in [0.55, 5.0, 11.7, 19.5] {
            let [low, at, high] = [x - h, x, x + h].map(|x| shapes_at(length, x));
            for i in 0..SHAPES {
                // Central differences: third derivative (at most (11/22.7)³·x) h²/6, and the
                // rounding of values up to 2 000 m³ over h.
                let near = |low: f64, high: f64, derivative: f64| {
                    ((high - low) / (2.0 * h) - derivative).abs() < 1e-6
                };
                assert!(near(low.value[i], high.value[i], at.slope[i]), "{i} at {x}");
                assert!(near(low.integral[i], high.integral[i], at.value[i]), "{i} at {x}");
                let double = [low, high].map(|s| s.double_integral[i]);
                assert!(near(double[0], double[1], at.integral[i]), "{i} at {x}");
            }
        }
    }

    /// The published figures of a uniform beam: nodes of the first mode at 0.2242 L, ends ±1.
    #[test]
    fn modes_are_those_of_a_uniform_beam() {
        let at = |x| shapes_at(1.0, x).value;
        assert!(at(0.2241)[2] > 0.0 && at(0.2243)[2] < 0.0);
        assert!((at(0.5)[2] + 0.6078).abs() < 1e-4, "{}", at(0.5)[2]);
        for (i, end) in [(2, 1.0), (3, -1.0), (4, 1.0)] {
            assert_eq!(at(0.0)[i], 1.0);
            // The roots have six decimals, of which cosh(11)·1e-6 is left.
            assert!((at(1.0)[i] - end).abs() < 0.02, "{i}: {}", at(1.0)[i]);
        }
    }
}
