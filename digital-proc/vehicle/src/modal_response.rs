//! A bending mode driven by a sampled force: η̈ + 2ζω η̇ + ω² η = f, eq. (24) of the paper.
//!
//! Between samples f is a cubic, for which the answer is exact, whatever the interval: what is
//! left of an error is that of the cubic, and none of integration.

/// A mode and its state.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct ModalResponse {
    /// η, m.
    pub displacement_m: f64,
    /// η̇, m/s.
    pub rate_mps: f64,
}

/// f₀ + f₁t + f₂t² + f₃t³, m/s² and so on, t from the beginning of an interval.
pub type Cubic = [f64; 4];

/// η of a cubic's own answer, as a cubic: each power of t balanced from the highest down.
fn own(w: f64, damping: f64, [f0, f1, f2, f3]: Cubic) -> Cubic {
    let (spring, drag) = (w * w, 2.0 * damping * w);
    let p3 = f3 / spring;
    let p2 = (f2 - 3.0 * drag * p3) / spring;
    let p1 = (f1 - 2.0 * drag * p2 - 6.0 * p3) / spring;
    let p0 = (f0 - drag * p1 - 2.0 * p2) / spring;
    [p0, p1, p2, p3]
}

/// A cubic at t.
pub fn at([f0, f1, f2, f3]: Cubic, t: f64) -> f64 {
    f0 + t * (f1 + t * (f2 + t * f3))
}

impl ModalResponse {
    /// Greatest |η̈| (m/s²) that the next `interval_s` can bring: that of the cubic's own answer,
    /// and that of what is left, which decays freely, its energy η̇² + ω²η² never growing, while
    /// |η̈| = |2ζωη̇ + ω²η| ≤ (1 + 2ζ)ω√(η̇² + ω²η²).
    pub fn acceleration_bound_mps2(
        &self,
        frequency_radps: f64,
        damping: f64,
        interval_s: f64,
        force: Cubic,
    ) -> f64 {
        let w = frequency_radps;
        let [p0, p1, p2, p3] = own(w, damping, force);
        let (x, v) = (self.displacement_m - p0, self.rate_mps - p1);
        let free = (1.0 + 2.0 * damping) * w * (v * v + w * w * x * x).sqrt();
        free + (2.0 * p2).abs() + (6.0 * p3).abs() * interval_s
    }

    /// The state `t_s` later under a force per mass from now on.
    pub fn after(&self, frequency_radps: f64, damping: f64, t_s: f64, force: Cubic) -> Self {
        let (w, t, spring) = (frequency_radps, t_s, frequency_radps * frequency_radps);
        let p @ [p0, p1, p2, p3] = own(w, damping, force);
        let (x, v) = (self.displacement_m - p0, self.rate_mps - p1);
        // What is left decays freely: e^{−ζωt} times cos and sin(ω_d t)/ω_d, hyperbolic beyond ζ = 1.
        let (drag, square) = (damping * w, spring * (1.0 - damping * damping));
        let own = square.abs().sqrt();
        let (cosine, sine) = if square > 0.0 {
            let decay = libm::exp(-drag * t);
            (decay * libm::cos(own * t), decay * libm::sin(own * t) / own)
        } else if square < 0.0 {
            // The exponents together: apart, a large damping would overflow.
            let (slow, fast) = (libm::exp((own - drag) * t), libm::exp(-(own + drag) * t));
            (0.5 * (slow + fast), 0.5 * (slow - fast) / own)
        } else {
            let decay = libm::exp(-drag * t);
            (decay, decay * t)
        };
        ModalResponse {
            displacement_m: (cosine + drag * sine) * x + sine * v + at(p, t),
            rate_mps: (cosine - drag * sine) * v - spring * sine * x
                + p1
                + t * (2.0 * p2 + 3.0 * t * p3),
        }
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

    /// A cubic from rest in one step and in many, and its equation by differences.
    #[test]
    fn a_cubic_is_answered_exactly_whatever_the_steps() {
        for damping in [0.0, 0.01, 0.7, 1.0, 1.5] {
            let (w, force) = (27.6, [2.0, 3.0, -4.0, 1.5]);
            let after = |t| ModalResponse::default().after(w, damping, t, force);
            let mut parts = ModalResponse::default();
            for n in 0..50 {
                let t = f64::from(n) / 50.0;
                // The same cubic from t on.
                let [_, f1, f2, f3] = force;
                let slope = f1 + t * (2.0 * f2 + 3.0 * t * f3);
                let onward = [at(force, t), slope, f2 + 3.0 * t * f3, f3];
                parts = parts.after(w, damping, 0.02, onward);
            }
            // Rounding of 50 steps.
            assert!((after(1.0).displacement_m - parts.displacement_m).abs() < 1e-14, "{damping}");
            assert!((after(1.0).rate_mps - parts.rate_mps).abs() < 1e-13, "{damping}");
            let (t, h) = (0.3, 1e-4);
            let [low, here, high] = [t - h, t, t + h].map(after);
            let rate = (high.displacement_m - low.displacement_m) / (2.0 * h);
            let acceleration = (high.rate_mps - low.rate_mps) / (2.0 * h);
            let expected = here.acceleration_mps2(w, damping, at(force, t));
            // Central differences: (ωh)²/6 of the rate and of the acceleration.
            assert!((rate - here.rate_mps).abs() < 2e-6 * 0.3, "{damping}");
            assert!((acceleration - expected).abs() < 2e-6 * 8.0, "{damping}");
            assert!(
                expected.abs()
                    <= ModalResponse::default().acceleration_bound_mps2(w, damping, 1.0, force)
            );
        }
    }

    /// A step from rest: η = f/ω² [1 − e^{−ζωt}(cos ω_d t + ζω/ω_d sin ω_d t)].
    #[test]
    fn a_step_is_answered_as_in_the_textbook() {
        let (w, z, t) = (27.6_f64, 0.01_f64, 0.37_f64);
        let mode = ModalResponse::default().after(w, z, t, [4.0, 0.0, 0.0, 0.0]);
        let wd = w * (1.0 - z * z).sqrt();
        let expected = 4.0 / (w * w)
            * (1.0 - (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin()));
        assert!((mode.displacement_m - expected).abs() < 1e-15);
        let acceleration =
            4.0 * (-z * w * t).exp() * ((wd * t).cos() - z * w / wd * (wd * t).sin());
        assert!((mode.acceleration_mps2(w, z, 4.0) - acceleration).abs() < 1e-13);
    }
}
