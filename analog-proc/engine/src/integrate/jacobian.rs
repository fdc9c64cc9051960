//! The Jacobian of the derivatives by forward differences, regions frozen.

use nalgebra::DMatrix;

use super::System;

/// Part of the largest state that one beside it is moved by at least, before half the digits.
const LEAST_PART: f64 = 1e-2;

/// Fills in ∂(dy_i/dt)/∂y_j, per second, at `t_s` and `y0`. `nets` are the nets there, and what
/// depends on the states is left moved; `origin` and `moved` are room for the derivatives.
pub(crate) fn jacobian(
    system: System,
    t_s: f64,
    y0: &[f64],
    nets: &mut [f64],
    [origin, moved]: [&mut [f64]; 2],
    jacobian: &mut DMatrix<f64>,
) {
    let n = y0.len();
    nets[..n].copy_from_slice(y0);
    let (machine, frozen) = (system.machine, system.frozen);
    machine.derivatives(frozen, t_s, nets, origin);
    let greatest = y0.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
    for j in 0..n {
        // Half the digits: balances rounding against curvature.
        let scale = y0[j]
            .abs()
            .max(system.atol[j] / system.rtol.max(f64::EPSILON))
            .max(LEAST_PART * greatest);
        // Where it goes to: behind it there may be a jump that it has just passed.
        let delta = f64::EPSILON.sqrt() * scale.max(f64::MIN_POSITIVE.sqrt());
        let delta = delta.copysign(origin[j]);
        nets[j] = y0[j] + delta;
        let step = nets[j] - y0[j];
        machine.derivatives(frozen, t_s, nets, moved);
        for i in 0..n {
            jacobian[(i, j)] = (moved[i] - origin[i]) / step;
        }
        nets[j] = y0[j];
    }
}
