//! One sampled channel around a linear plant: circle test and root experiment.
//!
//! Plant `ẋ = A x + b y`, measured `m = c x`, sampled at `t_n = nT`. Digital law
//! `u_n = k [m_n + a (m_n − m_{n−1})]` with a lead of `a` frames; the transfer is at
//! `t_n + τ`, 0 ≤ τ ≤ T, through any [`Hold`]. Where a sample and a transfer fall
//! on one instant the sample comes first, which is the rule of the machine.

use super::{
    C64, Refusal,
    hold::Hold,
    period_map::PeriodMap,
    sampled_loop::{LinearLaw, Plant, period_map},
};
use nalgebra::{DMatrix, DVector, RowDVector};

/// A loop to be solved exactly; its constructors make the shapes that fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedbackLoop {
    /// A, n×n, 1/s.
    a: DMatrix<f64>,
    /// b, n.
    b: DVector<f64>,
    /// c, n.
    c: RowDVector<f64>,
    /// Gain k of the digital law, sign included.
    pub gain: f64,
    /// Lead a, frames.
    pub lead_frames: f64,
    pub hold: Hold,
    /// T, s.
    pub frame_s: f64,
    /// τ, s.
    pub latency_s: f64,
}

impl FeedbackLoop {
    /// Circle test: `ẋ = ω v`, `v̇ = −ω x`, the x that v sees having passed the digital side.
    pub fn circle(omega_rad_s: f64, hold: Hold, frame_s: f64, latency_s: f64) -> FeedbackLoop {
        FeedbackLoop {
            a: DMatrix::from_row_slice(2, 2, &[0.0, omega_rad_s, 0.0, 0.0]),
            b: DVector::from_vec(vec![0.0, -omega_rad_s]),
            c: RowDVector::from_vec(vec![1.0, 0.0]),
            gain: 1.0,
            lead_frames: 0.0,
            hold,
            frame_s,
            latency_s,
        }
    }

    /// `ẍ + 2ζω₀ẋ + y = 0`, `y` being ω₀²x through the digital side.
    pub fn second_order(
        (omega0_rad_s, zeta): (f64, f64),
        lead_frames: f64,
        hold: Hold,
        frame_s: f64,
        latency_s: f64,
    ) -> FeedbackLoop {
        FeedbackLoop {
            a: DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, -2.0 * zeta * omega0_rad_s]),
            b: DVector::from_vec(vec![0.0, -1.0]),
            c: RowDVector::from_vec(vec![1.0, 0.0]),
            gain: omega0_rad_s * omega0_rad_s,
            lead_frames,
            hold,
            frame_s,
            latency_s,
        }
    }

    /// Root in the upper half plane of the loop closed without any interface.
    pub fn continuous_root(&self) -> Result<C64, Refusal> {
        let closed = &self.a + &self.b * &self.c * self.gain;
        super::period_map::eigenvalues(&closed)?
            .into_iter()
            .filter(|s| s.im > 0.0)
            .max_by(|p, q| p.re.total_cmp(&q.re))
            .ok_or(Refusal::NoRoot)
    }

    /// One frame from just before a sample to just before the next.
    ///
    /// # Errors
    /// A frame or latency out of range.
    pub fn period_map(&self) -> Result<PeriodMap, Refusal> {
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let (order, lead) = (self.a.nrows(), self.gain * self.lead_frames);
        let plant = Plant {
            a: self.a.clone(),
            b: DMatrix::from_column_slice(order, 1, self.b.as_slice()),
            c: DMatrix::from_row_slice(1, order, self.c.as_slice()),
            d: one(0.0),
        };
        // w_n = m_{n−1}.
        let law = LinearLaw { f: one(0.0), g: one(1.0), h: one(-lead), j: one(self.gain + lead) };
        period_map(&plant, &law, self.hold, self.frame_s, self.latency_s)
    }

    /// Exact equivalent root on the branch of the continuous one.
    pub fn exact_root(&self) -> Result<C64, Refusal> {
        self.period_map()?.root_near(self.continuous_root()?)
    }

    /// `τ_e = τ + (½ | 0 | 1) T − a T`: the delay that the loop feels to first order.
    pub fn effective_delay_s(&self) -> f64 {
        self.latency_s + (self.hold.delay_frames() - self.lead_frames) * self.frame_s
    }

    /// Howe's first-order shift of a characteristic root, `Δs = −τ_e s₀ / L′(s₀)`
    /// where `1 + L(s) = 0` closes the loop through the sampled path.
    ///
    /// `L = −k c (sI − A)⁻¹ b`, `L′ = k c (sI − A)⁻² b`.
    pub fn first_order_root(&self) -> Result<C64, Refusal> {
        let s0 = self.continuous_root()?;
        let n = self.a.nrows();
        let m = DMatrix::<C64>::identity(n, n) * s0 - self.a.map(|v| C64::new(v, 0.0));
        let lu = m.lu();
        let b = self.b.map(|v| C64::new(v, 0.0));
        let once = lu.solve(&b).ok_or(Refusal::NoRoot)?;
        let twice = lu.solve(&once).ok_or(Refusal::NoRoot)?;
        let slope: C64 = self.c.iter().zip(twice.iter()).map(|(c, v)| v * *c).sum();
        Ok(s0 - s0 * self.effective_delay_s() / (slope * self.gain))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{damping_ratio, growth_per_cycle, nearest_root};
    use super::*;

    /// The worked example: ω₀ = 3, ζ = 0.3, T = 0.1, one frame late: exact 0.0787, formula 0.0750.
    #[test]
    fn worked_example_of_the_root_shift() {
        let l = FeedbackLoop::second_order((3.0, 0.3), 0.0, Hold::ZeroOrder, 0.1, 0.1);
        let exact = damping_ratio(l.exact_root().unwrap());
        // Printed with four decimals: half a unit of the last.
        assert!((exact - 0.0787).abs() < 5e-5, "{exact}");
        let shift = l.first_order_root().unwrap() - l.continuous_root().unwrap();
        let (w, z, te) = (3.0_f64, 0.3_f64, 0.15);
        let formula = C64::new(1.0, z / (1.0 - z * z).sqrt()) * (w * w * te / 2.0);
        assert!((shift - formula).norm() < 1e-12);
        assert!((z - w * te / 2.0 - 0.0750).abs() < 1e-12);
    }

    /// The same loop by the textbook's matrices: with `[Φ Γ; 0 1] = exp([A b; 0 0] t)` over the
    /// parts of a frame before and after the transfer, `[[Φ, Γ_old], [−K, 0]]` and Γ_new (−K) on Φ.
    #[test]
    fn period_map_agrees_with_discretised_matrices() {
        for latency in [0.0, 0.03, 0.1] {
            let l = FeedbackLoop::second_order((3.0, 0.3), 0.0, Hold::ZeroOrder, 0.1, latency);
            let held = |t: f64| {
                let block =
                    DMatrix::from_row_slice(3, 3, &[0.0, t, 0.0, 0.0, -1.8 * t, -t, 0.0, 0.0, 0.0]);
                let e = crate::matrix_exp::matrix_exp(&block);
                (e.view((0, 0), (2, 2)).into_owned(), e.view((0, 2), (2, 1)).into_owned())
            };
            let (phi, _) = held(0.1);
            let (phi_late, new) = held(0.1 - latency);
            let (_, early) = held(latency);
            let k = DMatrix::from_row_slice(1, 2, &[9.0, 0.0]);
            let mut f = DMatrix::zeros(3, 3);
            f.view_mut((0, 0), (2, 2)).copy_from(&(phi + new * &k));
            f.view_mut((0, 2), (2, 1)).copy_from(&(phi_late * early));
            f.view_mut((2, 0), (1, 2)).copy_from(&k);
            let roots: Vec<C64> = super::super::period_map::eigenvalues(&f)
                .unwrap()
                .into_iter()
                .filter(|z| z.norm() > 1e-9)
                .map(|z| super::super::equivalent_root(z, 0.1))
                .collect();
            let other = nearest_root(&roots, l.continuous_root().unwrap()).unwrap();
            // Both are backward stable on matrices of norm about one: 1e-15 in z, 1e-14 in s.
            assert!((l.exact_root().unwrap() - other).norm() < 1e-12);
        }
    }

    /// First-order formula: its error must fall as T² for every hold.
    #[test]
    fn first_order_formula_is_first_order() {
        for hold in Hold::ALL {
            for lead in [0.0, 0.5] {
                let error = |t: f64| {
                    let l = FeedbackLoop::second_order((3.0, 0.3), lead, hold, t, 0.5 * t);
                    (l.exact_root().unwrap() - l.first_order_root().unwrap()).norm()
                };
                let order = (error(0.004) / error(0.002)).log2();
                assert!((order - 2.0).abs() < 0.2, "{hold:?} {lead}: {order}");
            }
        }
    }

    /// Circle test, no latency: |z|² = det F = 1 + (ωT)²/2 exactly, from F = Φ + ΓK by hand.
    #[test]
    fn circle_growth_in_closed_form() {
        let (t, w) = (0.01, 20.0);
        let x: f64 = w * t;
        // F = [[1 − x²/2, x], [−x, 1]]: trace 2 − x²/2, determinant 1 + x²/2.
        let (trace, det) = (2.0 - x * x / 2.0, 1.0 + x * x / 2.0);
        let z = C64::new(trace / 2.0, (det - trace * trace / 4.0).sqrt());
        let growth = growth_per_cycle(super::super::equivalent_root(z, t));
        let l = FeedbackLoop::circle(w, Hold::ZeroOrder, t, 0.0);
        let got = growth_per_cycle(l.exact_root().unwrap());
        assert!((got / growth - 1.0).abs() < 1e-12);
    }
}
