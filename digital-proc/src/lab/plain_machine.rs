//! A plain linear plant between the converters, for tests of the laws.
//!
//! It solves `ẋ = A x + B y` by the Taylor series of the exponential applied to the state, in
//! steps short against its norm: none of the block matrices of `theory` is used.

use super::{plan::RunPlan, theory::hold::Hold};
use interface::{Tick, frame::Updates};

pub(crate) struct PlainMachine {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    pub(crate) x: Vec<f64>,
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
    pub(crate) fn new(a: &[&[f64]], b: &[&[f64]], c: &[&[f64]], x: &[f64]) -> PlainMachine {
        let m = b.first().map_or(0, |r| r.len());
        PlainMachine {
            a: rows(a),
            b: rows(b),
            c: rows(c),
            x: x.to_vec(),
            level: vec![0.0; m],
            slope: vec![0.0; m],
            last: vec![0.0; m],
        }
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
                term_s = vec![0.0; term_s.len()];
                for (x, d) in self.x.iter_mut().zip(&next) {
                    *x += d;
                }
                for (y, d) in self.level.iter_mut().zip(&term_y) {
                    *y += d;
                }
                term_x = next;
            }
        }
    }

    /// Runs the plan: sample, law, transfer at `t_n + τ`; a sample comes before a transfer.
    pub(crate) fn run(&mut self, plan: &RunPlan, mut law: impl FnMut(u64, &[f64], &mut Updates)) {
        let (frame, latency) = (plan.frame.secs(), plan.latency.secs());
        let frames = plan.stop.0 / plan.frame.0;
        for n in 0..u64::try_from(frames).unwrap() {
            let adc: Vec<f64> = self.c.iter().map(|c| dot(c, &self.x)).collect();
            let mut updates = Updates::new(n, Tick::ZERO);
            law(n, &adc, &mut updates);
            self.flow(latency);
            for i in 0..self.level.len() {
                if updates.dac_mask >> i & 1 == 1 {
                    let new = updates.dac[i];
                    match plan.hold {
                        Hold::ZeroOrder => self.level[i] = new,
                        Hold::Extrapolating => {
                            self.level[i] = new;
                            self.slope[i] = (new - self.last[i]) / frame;
                        }
                        Hold::Interpolating => {
                            self.level[i] = self.last[i];
                            self.slope[i] = (new - self.last[i]) / frame;
                        }
                    }
                    self.last[i] = new;
                }
            }
            self.flow(frame - latency);
        }
    }
}
