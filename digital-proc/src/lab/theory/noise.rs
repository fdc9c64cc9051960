//! Closed forms for quantisation noise, multiplexer skew and held coefficients.
//!
//! Quantisation is taken as white and uniform over one step q, which holds when the
//! signal crosses many steps between samples; a signal that rests on one code is
//! outside these formulas.

/// Variance of the rounding error, `q²/12`.
pub fn quantisation_variance(step: f64) -> f64 {
    step * step / 12.0
}

/// Step of a converter of `bits` over ± full scale, `2 FS / 2^bits`.
pub fn quantum(bits: u32, full_scale: f64) -> f64 {
    2.0 * full_scale / 2f64.powi(i32::try_from(bits).unwrap_or(i32::MAX))
}

/// Variance of ∫e dt after `time_s`, with e held white noise of `step`: `(q²/12) T t`.
pub fn integrator_variance(step: f64, frame_s: f64, time_s: f64) -> f64 {
    quantisation_variance(step) * frame_s * time_s
}

/// Stationary variance, at the samples, of a lag `ẏ = a (e − y)`:
/// `(q²/12) (1 − e^{−aT}) / (1 + e^{−aT})`.
pub fn lag_variance(step: f64, frame_s: f64, corner_rad_s: f64) -> f64 {
    let decay = libm::exp(-corner_rad_s * frame_s);
    quantisation_variance(step) * (1.0 - decay) / (1.0 + decay)
}

/// Error of an angle read from a sine at `t` and a cosine at `t + δ`: `ωδ sin²θ`, rad, to first order.
pub fn resolver_skew_error_rad(omega_rad_s: f64, skew_s: f64, theta_rad: f64) -> f64 {
    omega_rad_s * skew_s * libm::sin(theta_rad).powi(2)
}

/// Mean error of a coefficient that moves at `rate` and is set every T, τ late: `rate (T/2 + τ)`.
pub fn staircase_mean(rate: f64, period_s: f64, latency_s: f64) -> f64 {
    rate * (period_s / 2.0 + latency_s)
}

/// Root-mean-square of the same: `|rate| √(T²/3 + Tτ + τ²)`, which is `|rate| T/√3` without latency.
pub fn staircase_rms(rate: f64, period_s: f64, latency_s: f64) -> f64 {
    rate.abs() * (period_s * period_s / 3.0 + period_s * latency_s + latency_s * latency_s).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn staircase_formulas_match_their_integrals() {
        // error = rate (τ + s), s uniform over a period; midpoint rule of n cells is exact for the
        // mean and low by (T/n)²/12 in the mean square.
        let (rate, t, tau) = (2.0, 0.1, 0.03);
        let n = 1000;
        let errors: Vec<f64> =
            (0..n).map(|i| rate * (tau + t * (f64::from(i) + 0.5) / f64::from(n))).collect();
        let mean = errors.iter().sum::<f64>() / f64::from(n);
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / f64::from(n)).sqrt();
        assert!((mean - staircase_mean(rate, t, tau)).abs() < 1e-14);
        let shortfall = rate * rate * (t / f64::from(n)).powi(2) / 12.0;
        assert!((rms.powi(2) + shortfall - staircase_rms(rate, t, tau).powi(2)).abs() < 1e-14);
        assert!((staircase_rms(rate, t, 0.0) - rate * t / 3f64.sqrt()).abs() < 1e-15);
    }
}
