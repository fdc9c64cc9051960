//! A bending mode driven by a sampled force: η̈ + 2ζω η̇ + ω² η = f, eq. (24) of the paper.
//!
//! Between samples f is taken as a straight line, for which the answer is exact, whatever the
//! interval: the error is that of the straight line, f″h²/8, and none of integration.

/// A mode and its state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ModalResponse {
    /// η, m.
    pub displacement_m: f64,
    /// η̇, m/s.
    pub rate_mps: f64,
}

impl ModalResponse {
    /// Goes on by `interval_s`, in which the force per mass goes from `before` to `now`, m/s².
    pub fn advance(
        &mut self,
        frequency_radps: f64,
        damping: f64,
        interval_s: f64,
        [before, now]: [f64; 2],
    ) {
        let (w, h) = (frequency_radps, interval_s);
        let spring = w * w;
        let ramp = (now - before) / h;
        // The straight line's own answer: η_p = f/ω² − 2ζ ḟ/ω³.
        let lag = 2.0 * damping * ramp / (w * spring);
        let (x, v) = (self.displacement_m - before / spring + lag, self.rate_mps - ramp / spring);
        // What is left decays freely: e^{−ζωt} times cos and sin(ω_d t)/ω_d, hyperbolic beyond ζ = 1.
        let (drag, square) = (damping * w, spring * (1.0 - damping * damping));
        let own = square.abs().sqrt();
        let (cosine, sine) = if square > 0.0 {
            let decay = libm::exp(-drag * h);
            (decay * libm::cos(own * h), decay * libm::sin(own * h) / own)
        } else if square < 0.0 {
            // The exponents together: apart, a large damping would overflow.
            let (slow, fast) = (libm::exp((own - drag) * h), libm::exp(-(own + drag) * h));
            (0.5 * (slow + fast), 0.5 * (slow - fast) / own)
        } else {
            let decay = libm::exp(-drag * h);
            (decay, decay * h)
        };
        self.displacement_m = (cosine + drag * sine) * x + sine * v + now / spring - lag;
        self.rate_mps = (cosine - drag * sine) * v - spring * sine * x + ramp / spring;
    }

    /// η̈ under a force per mass, m/s².
    pub fn acceleration_mps2(&self, frequency_radps: f64, damping: f64, force: f64) -> f64 {
        force
            - 2.0 * damping * frequency_radps * self.rate_mps
            - frequency_radps * frequency_radps * self.displacement_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ramp from rest, in steps of any length: the closed form of the whole.
    #[test]
    fn a_ramp_is_answered_exactly_whatever_the_steps() {
        for damping in [0.0, 0.01, 0.7, 1.0, 1.5] {
            let w = 27.6;
            let mut whole = ModalResponse::default();
            whole.advance(w, damping, 1.0, [2.0, 5.0]);
            let mut parts = ModalResponse::default();
            for n in 0..50 {
                let f = |n: i32| 2.0 + 3.0 * f64::from(n) / 50.0;
                parts.advance(w, damping, 0.02, [f(n), f(n + 1)]);
            }
            // Rounding of 50 steps.
            assert!((whole.displacement_m - parts.displacement_m).abs() < 1e-14, "{damping}");
            assert!((whole.rate_mps - parts.rate_mps).abs() < 1e-13, "{damping}");
        }
    }

    /// A step from rest: η = f/ω² [1 − e^{−ζωt}(cos ω_d t + ζω/ω_d sin ω_d t)].
    #[test]
    fn a_step_is_answered_as_in_the_textbook() {
        let (w, z, t) = (27.6_f64, 0.01_f64, 0.37_f64);
        let mut mode = ModalResponse::default();
        mode.advance(w, z, t, [4.0, 4.0]);
        let wd = w * (1.0 - z * z).sqrt();
        let expected = 4.0 / (w * w)
            * (1.0 - (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin()));
        assert!((mode.displacement_m - expected).abs() < 1e-15);
        let acceleration =
            4.0 * (-z * w * t).exp() * ((wd * t).cos() - z * w / wd * (wd * t).sin());
        assert!((mode.acceleration_mps2(w, z, 4.0) - acceleration).abs() < 1e-13);
    }
}
