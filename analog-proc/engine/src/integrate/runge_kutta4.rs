//! The classical Runge–Kutta method of order four, fixed steps.

use super::{Step, System};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct RungeKutta4 {
    k2: Vec<f64>,
    k3: Vec<f64>,
    k4: Vec<f64>,
}

impl RungeKutta4 {
    pub fn new(states: usize) -> RungeKutta4 {
        let zeros = || vec![0.0; states];
        RungeKutta4 { k2: zeros(), k3: zeros(), k4: zeros() }
    }

    pub fn attempt(&mut self, system: System, step: &mut Step, nets: &mut [f64]) -> f64 {
        let (n, h, t) = (step.y0.len(), step.h_s, step.t0_s);
        let (machine, frozen) = (system.machine, system.frozen);
        for i in 0..n {
            nets[i] = step.y0[i] + 0.5 * h * step.f0[i];
        }
        machine.derivatives(frozen, t + 0.5 * h, nets, &mut self.k2);
        for i in 0..n {
            nets[i] = step.y0[i] + 0.5 * h * self.k2[i];
        }
        machine.derivatives(frozen, t + 0.5 * h, nets, &mut self.k3);
        for i in 0..n {
            nets[i] = step.y0[i] + h * self.k3[i];
        }
        machine.derivatives(frozen, t + h, nets, &mut self.k4);
        for i in 0..n {
            let sum = step.f0[i] + 2.0 * (self.k2[i] + self.k3[i]) + self.k4[i];
            step.y1[i] = step.y0[i] + h / 6.0 * sum;
        }
        nets[..n].copy_from_slice(&step.y1);
        machine.derivatives(frozen, t + h, nets, &mut step.f1);
        step.evaluations += 4;
        0.0
    }
}
