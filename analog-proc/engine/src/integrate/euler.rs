//! Forward Euler, order one: for teaching what a step length does.

use super::{Step, System};

pub(super) fn attempt(system: System, step: &mut Step, nets: &mut [f64]) -> f64 {
    let n = step.y0.len();
    for i in 0..n {
        step.y1[i] = step.y0[i] + step.h_s * step.f0[i];
    }
    nets[..n].copy_from_slice(&step.y1);
    let end_s = step.t0_s + step.h_s;
    system.machine.derivatives(system.frozen, end_s, nets, &mut step.f1);
    step.evaluations += 1;
    0.0
}
