//! A plain linear plant between the converters, for tests of the laws.
//!
//! It solves `ẋ = A x + B y` by the Taylor series of the exponential applied to the state, in
//! steps short against its norm: none of the block matrices of `theory` is used.

use super::{
    plan::{LabError, Machine, RunPlan},
    theory::hold::Hold,
};
use interface::{
    Tick,
    frame::{RunState, Samples, Updates},
};

pub struct PlainMachine {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    x: Vec<f64>,
    level: Vec<f64>,
    slope: Vec<f64>,
    last: Vec<f64>,
}

fn rows(m: &[&[f64]]) -> Vec<Vec<f64>> {
    m.iter().map(|r| r.to_vec()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl PlainMachine {
    /// A n×n, B n×m by DAC channel, C p×n by ADC channel.
    pub fn new(a: &[&[f64]], b: &[&[f64]], c: &[&[f64]], x: &[f64]) -> PlainMachine {
        let zero = vec![0.0; b[0].len()];
        PlainMachine {
            a: rows(a),
            b: rows(b),
            c: rows(c),
            x: x.to_vec(),
            level: zero.clone(),
            slope: zero.clone(),
            last: zero,
        }
    }

    /// `lab/root.toml`: `ẍ + 2ζω₀ẋ + y = 0` from x = 1, y being DAC 0 and x ADC 0.
    pub fn second_order(omega0_rad_s: f64, zeta: f64) -> PlainMachine {
        PlainMachine::new(
            &[&[0.0, 1.0], &[0.0, -2.0 * zeta * omega0_rad_s]],
            &[&[0.0], &[-1.0]],
            &[&[1.0, 0.0]],
            &[1.0, 0.0],
        )
    }

    fn flow(&mut self, seconds: f64) {
        let size = self.a.iter().flatten().fold(1.0_f64, |m, v| m.max(v.abs()));
        let steps = (seconds * size * 4.0).ceil().max(1.0);
        let h = seconds / steps;
        for _ in 0..steps as usize {
            let mut term_x = self.x.clone();
            let mut term_y = self.level.clone();
            let mut term_s = self.slope.clone();
            for k in 1..=24 {
                let scale = h / f64::from(k);
                let next: Vec<f64> = (0..self.x.len())
                    .map(|i| (dot(&self.a[i], &term_x) + dot(&self.b[i], &term_y)) * scale)
                    .collect();
                term_y = term_s.iter().map(|s| s * scale).collect();
                term_s.fill(0.0);
                for (sum, term) in [(&mut self.x, &next), (&mut self.level, &term_y)] {
                    sum.iter_mut().zip(term).for_each(|(sum, term)| *sum += term);
                }
                term_x = next;
            }
        }
    }

    fn transfer(&mut self, i: usize, new: f64, hold: Hold, frame_s: f64) {
        (self.level[i], self.slope[i]) = match hold {
            Hold::ZeroOrder => (new, 0.0),
            Hold::Extrapolating => (new, (new - self.last[i]) / frame_s),
            Hold::Interpolating => (self.last[i], (new - self.last[i]) / frame_s),
        };
        self.last[i] = new;
    }
}

impl Machine for PlainMachine {
    /// Sample, law, transfer at `t_n + τ`; a sample comes before a transfer.
    fn run(
        &mut self,
        plan: &RunPlan,
        law: &mut dyn FnMut(&Samples, &mut Updates),
    ) -> Result<Vec<f64>, LabError> {
        let (frame, latency) = (plan.spec.frame.secs(), plan.spec.latency.secs());
        for n in 0..(plan.spec.stop.0 / plan.spec.frame.0).unsigned_abs() {
            let mut samples = Samples::new(n, Tick::ZERO, RunState::Operate);
            for (adc, c) in samples.adc.iter_mut().zip(&self.c) {
                *adc = dot(c, &self.x);
            }
            let mut updates = Updates::new(n, Tick::ZERO);
            law(&samples, &mut updates);
            self.flow(latency);
            for i in (0..self.level.len()).filter(|i| updates.dac_mask >> i & 1 == 1) {
                self.transfer(i, updates.dac[i], plan.hold, frame);
            }
            self.flow(frame - latency);
        }
        Ok(Vec::new())
    }
}

/// A machine whose ADCs read given functions of time and whose DACs do nothing.
pub struct Readings<F>(pub F);

impl<F: Fn(f64) -> [f64; 2]> Machine for Readings<F> {
    fn run(
        &mut self,
        plan: &RunPlan,
        law: &mut dyn FnMut(&Samples, &mut Updates),
    ) -> Result<Vec<f64>, LabError> {
        for n in 0..(plan.spec.stop.0 / plan.spec.frame.0).unsigned_abs() {
            let mut samples = Samples::new(n, Tick::ZERO, RunState::Operate);
            samples.adc[..2].copy_from_slice(&self.0(plan.spec.frame.secs() * n as f64));
            law(&samples, &mut Updates::new(n, Tick::ZERO));
        }
        Ok(Vec::new())
    }
}
