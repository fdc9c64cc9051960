//! The L-stable singly diagonally implicit method of order 4(3) of Hairer and
//! Wanner, for stiff patches.
//!
//! Five stages, γ = 1/4, stiffly accurate: Hairer and Wanner, Solving Ordinary
//! Differential Equations II, table 6.5 of section IV.6. The Jacobian is formed
//! by forward differences and kept while the simplified Newton iteration
//! converges fast; one LU factorisation serves all stages of a step length.
//! Factorising allocates; nothing else does.

use nalgebra::{DMatrix, DVector, Dyn, LU};
use serde::{Deserialize, Serialize};

use super::jacobian::jacobian;
use super::{Step, System};

const GAMMA: f64 = 0.25;
const STAGES: usize = 5;
const C: [f64; STAGES] = [1.0 / 4.0, 3.0 / 4.0, 11.0 / 20.0, 1.0 / 2.0, 1.0];
const A: [[f64; 4]; STAGES] = [
    [0.0, 0.0, 0.0, 0.0],
    [1.0 / 2.0, 0.0, 0.0, 0.0],
    [17.0 / 50.0, -1.0 / 25.0, 0.0, 0.0],
    [371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0, 0.0],
    [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];
const E: [f64; STAGES] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 1.0 / 4.0];

/// Newton iterations a stage; more means that the step is too long.
const ITERATIONS: usize = 10;
/// A stage is solved to this part of the tolerance, so that the iteration's
/// error is small beside the estimate of the method's.
const STAGE_TOLERANCE: f64 = 1e-2;
/// Convergence slower than this asks for a fresh Jacobian in the next step.
const SLOW: f64 = 0.1;
/// A Jacobian that tells so many times the change of a rate over a step is not that of the step …
const TOO_GREAT: f64 = 4.0;
/// … where its parts do not cancel: what is left of those may be its curvature.
const LEAST_SUM: f64 = 0.5;

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Kept", into = "Kept")]
pub(crate) struct Sdirk4 {
    k: [Vec<f64>; STAGES],
    base: Vec<f64>,
    residual: DVector<f64>,
    scratch: Vec<f64>,
    jacobian: DMatrix<f64>,
    fresh: bool,
    lu: Option<(f64, LU<f64, Dyn, Dyn>)>,
}

/// What outlives a step: the rest is room.
#[derive(Serialize, Deserialize)]
struct Kept {
    states: usize,
    jacobian: Vec<f64>,
    fresh: bool,
    /// The step whose matrix is factored, s.
    factored_s: Option<f64>,
}

impl From<Sdirk4> for Kept {
    fn from(method: Sdirk4) -> Kept {
        let Sdirk4 { jacobian, fresh, lu, .. } = method;
        let (states, factored_s) = (jacobian.nrows(), lu.map(|lu| lu.0));
        Kept { states, jacobian: jacobian.as_slice().to_vec(), fresh, factored_s }
    }
}

impl TryFrom<Kept> for Sdirk4 {
    type Error = &'static str;

    fn try_from(kept: Kept) -> Result<Sdirk4, &'static str> {
        let Kept { states, jacobian, fresh, factored_s } = kept;
        if states.checked_mul(states) != Some(jacobian.len()) {
            return Err("a Jacobian that is not square");
        }
        let mut method = Sdirk4::new(states);
        method.jacobian.copy_from_slice(&jacobian);
        method.fresh = fresh;
        if let Some(h) = factored_s {
            method.factor(h);
        }
        Ok(method)
    }
}

impl Sdirk4 {
    pub fn new(states: usize) -> Sdirk4 {
        let zeros = || vec![0.0; states];
        Sdirk4 {
            k: std::array::from_fn(|_| zeros()),
            base: zeros(),
            residual: DVector::zeros(states),
            scratch: zeros(),
            jacobian: DMatrix::zeros(states, states),
            fresh: false,
            lu: None,
        }
    }

    pub fn restart(&mut self) {
        self.fresh = false;
        self.lu = None;
    }

    pub fn attempt(&mut self, system: System, step: &mut Step, nets: &mut [f64]) -> f64 {
        let n = step.y0.len();
        if n == 0 {
            return super::euler::attempt(system, step, nets);
        }
        if !self.fresh {
            self.form_jacobian(system, step, nets);
        }
        let h = step.h_s;
        if self.lu.as_ref().is_none_or(|lu| lu.0 != h) {
            self.factor(h);
        }
        let mut slow = false;
        for stage in 0..STAGES {
            match self.solve_stage(stage, system, step, nets) {
                Some(rate) => slow |= rate > SLOW,
                None => {
                    self.restart();
                    return f64::INFINITY;
                }
            }
        }
        // Stiffly accurate: the last stage is the result, and `nets` hold it.
        step.y1.copy_from_slice(&nets[..n]);
        let doubtful = (0..n).any(|i| self.moved(i, &system, step).is_some());
        if doubtful {
            nets[..n].copy_from_slice(&step.y0);
            system.machine.derivatives(system.frozen, step.t0_s + h, nets, &mut self.scratch);
            step.evaluations += 1;
            nets[..n].copy_from_slice(&step.y1);
        }
        system.machine.derivatives(system.frozen, step.t0_s + h, nets, &mut step.f1);
        step.evaluations += 1;
        if doubtful && self.is_held(&system, step) {
            self.restart();
            return f64::INFINITY;
        }
        // The stage derivative is free of the amplification of the iteration error by stiffness.
        step.f1.copy_from_slice(&self.k[STAGES - 1]);
        for i in 0..n {
            let sum: f64 = (0..STAGES).map(|s| E[s] * self.k[s][i]).sum();
            self.residual[i] = h * sum;
        }
        // The estimate is unbounded for stiff components; one solution with the same
        // matrix makes it bounded (Hairer and Wanner II, IV.8).
        if let Some((_, lu)) = &self.lu
            && !lu.solve_mut(&mut self.residual)
        {
            return f64::INFINITY;
        }
        if slow {
            self.fresh = false;
        }
        let residual = &self.residual;
        step.norm(&system, |i| residual[i])
    }

    /// Factors the matrix of the stages of a step of `h` seconds.
    fn factor(&mut self, h: f64) {
        let mut matrix = &self.jacobian * (-h * GAMMA);
        for i in 0..matrix.nrows() {
            matrix[(i, i)] += 1.0;
        }
        self.lu = Some((h, matrix.lu()));
    }

    /// What the Jacobian makes of the step in the rate of state `i`, and of what parts; `None` where
    /// that is less than the tolerance.
    fn moved(&self, i: usize, system: &System, step: &Step) -> Option<(f64, f64)> {
        let (y0, y1) = (&step.y0, &step.y1);
        let (mut sum, mut parts) = (0.0, 0.0);
        for j in 0..y0.len() {
            let part = self.jacobian[(i, j)] * (y1[j] - y0[j]);
            sum += part;
            parts += part.abs();
        }
        let scale = system.atol[i] + system.rtol * y0[i].abs().max(y1[i].abs());
        (step.h_s * GAMMA * sum.abs() > scale).then_some((sum, parts))
    }

    /// Whether the Jacobian, of before or of differences over a jump, is too great for the step: it
    /// then makes all corrections small, also of stages that are not solved. `scratch` holds the
    /// rates of the start's states at the end.
    fn is_held(&self, system: &System, step: &Step) -> bool {
        let changes = step.f1.iter().zip(&self.scratch).map(|(f1, f)| (f1 - f).abs());
        changes.enumerate().any(|(i, change)| {
            self.moved(i, system, step)
                .is_some_and(|(sum, parts)| sum.abs() > (TOO_GREAT * change).max(LEAST_SUM * parts))
        })
    }

    /// Solves one stage; the rate of convergence, `None` when it fails.
    fn solve_stage(
        &mut self,
        stage: usize,
        system: System,
        step: &mut Step,
        nets: &mut [f64],
    ) -> Option<f64> {
        let (n, h) = (step.y0.len(), step.h_s);
        let t = step.t0_s + C[stage] * h;
        for i in 0..n {
            let sum: f64 = (0..stage).map(|s| A[stage][s] * self.k[s][i]).sum();
            self.base[i] = step.y0[i] + h * sum;
            let guess = if stage == 0 { step.f0[i] } else { self.k[stage - 1][i] };
            nets[i] = self.base[i] + h * GAMMA * guess;
        }
        let (_, lu) = self.lu.as_ref()?;
        let (mut last, mut rate) = (f64::INFINITY, 0.0);
        for iteration in 0..ITERATIONS {
            system.machine.derivatives(system.frozen, t, nets, &mut self.scratch);
            step.evaluations += 1;
            for i in 0..n {
                self.residual[i] = self.base[i] + h * GAMMA * self.scratch[i] - nets[i];
            }
            if !lu.solve_mut(&mut self.residual) {
                return None;
            }
            let mut size = 0.0_f64;
            for i in 0..n {
                nets[i] += self.residual[i];
                let scale = system.atol[i] + system.rtol * nets[i].abs().max(step.y0[i].abs());
                let scaled = self.residual[i].abs() / scale;
                if !scaled.is_finite() {
                    return None;
                }
                size = size.max(scaled);
            }
            if iteration > 0 {
                rate = size / last;
                // Below rounding the ratio means nothing.
                if rate >= 1.0 && size > 1.0 {
                    return None;
                }
            }
            let bound = if rate > 0.0 && rate < 1.0 { rate / (1.0 - rate) } else { 1.0 };
            if size == 0.0
                || (bound * size).max(if rate >= 1.0 { size } else { 0.0 }) <= STAGE_TOLERANCE
            {
                for i in 0..n {
                    self.k[stage][i] = (nets[i] - self.base[i]) / (h * GAMMA);
                }
                return Some(if rate < 1.0 { rate } else { 0.0 });
            }
            last = size;
        }
        None
    }

    fn form_jacobian(&mut self, system: System, step: &mut Step, nets: &mut [f64]) {
        let room = [&mut self.scratch[..], &mut self.base[..]];
        let (t_s, y0) = (step.t0_s, &step.y0);
        jacobian(system, t_s, y0, nets, room, &mut self.jacobian);
        step.evaluations += y0.len() as u64 + 1;
        self.fresh = true;
        self.lu = None;
    }
}
