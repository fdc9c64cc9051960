//! The classical fourth-order Runge–Kutta step (Kutta 1901).
//!
//! The paper solves its trajectory equations with it at 0.1 s. One pure
//! function: the state is a plain array, time enters as an argument, and the
//! derivative may refuse (an altitude outside the atmosphere), in which case
//! the step is abandoned and the refusal handed on. No error control: the step
//! is the frame.

/// Nodes of the scheme, as fractions of the step.
const NODES: [f64; 4] = [0.0, 1.0 / 2.0, 1.0 / 2.0, 1.0];
/// Weights of the scheme.
const WEIGHTS: [f64; 4] = [1.0 / 6.0, 2.0 / 6.0, 2.0 / 6.0, 1.0 / 6.0];

/// One step of ẏ = f(t, y) from (`time_s`, `state`) over `step_s` seconds.
///
/// `derivative` is called four times: at t, twice at t + h/2, at t + h. Local
/// error O(h⁵), global O(h⁴) for smooth f. The first error it returns ends the
/// step.
pub fn step<const N: usize, E>(
    time_s: f64,
    state: &[f64; N],
    step_s: f64,
    mut derivative: impl FnMut(f64, &[f64; N]) -> Result<[f64; N], E>,
) -> Result<[f64; N], E> {
    let mut next = *state;
    let mut slope = [0.0; N];
    for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
        let mut stage = *state;
        for (s, k) in stage.iter_mut().zip(&slope) {
            *s += node * step_s * k;
        }
        slope = derivative(time_s + node * step_s, &stage)?;
        for (n, k) in next.iter_mut().zip(&slope) {
            *n += weight * step_s * k;
        }
    }
    Ok(next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn oscillator_error(steps: u32) -> f64 {
        let end = 2.0;
        let h = end / f64::from(steps);
        let mut y = [1.0, 0.0];
        for n in 0..steps {
            y = step(f64::from(n) * h, &y, h, |_, y| Ok::<_, Infallible>([y[1], -y[0]])).unwrap();
        }
        ((y[0] - end.cos()).powi(2) + (y[1] + end.sin()).powi(2)).sqrt()
    }

    #[test]
    fn cubic_right_hand_sides_are_integrated_exactly() {
        // Simpson's rule is exact for cubics; what is left is rounding of a
        // handful of operations on numbers near 1.
        let y = step(0.0, &[0.0], 1.0, |t, _| Ok::<_, Infallible>([4.0 * t * t * t - t])).unwrap();
        assert!((y[0] - 0.5).abs() < 8.0 * f64::EPSILON, "{}", y[0]);
    }

    #[test]
    fn the_order_is_four() {
        // The slope of log error over one halving tends to 4; at h = 0.1 the
        // next term of the error series changes it by O(h), hence ±0.2.
        let order = (oscillator_error(20) / oscillator_error(40)).log2();
        assert!((order - 4.0).abs() < 0.2, "{order}");
    }

    #[test]
    fn a_refusal_ends_the_step() {
        let outcome = step(0.0, &[0.0], 1.0, |t, _| if t > 0.7 { Err(t) } else { Ok([1.0]) });
        assert_eq!(outcome, Err(1.0));
    }
}
