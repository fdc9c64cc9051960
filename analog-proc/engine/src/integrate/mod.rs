//! Integration methods over one step with frozen regions.
//!
//! Each method is given a [`Step`] that holds y and f at its start, and fills in
//! y and f at its end, so that the last evaluation of a step is the first of the
//! next. Between the ends every method has the same dense output: the cubic of
//! Hermite, plus a quartic term where the method supplies one (Dormand–Prince).
//! Deciding about step lengths, events and stops belongs to the simulation.

#![allow(clippy::needless_range_loop, reason = "the formulas index several arrays by one state")]

mod dormand_prince;
mod euler;
pub(crate) mod jacobian;
mod runge_kutta4;
mod sdirk4;

use crate::integration::Method;
use crate::machine::{Frozen, Machine};
use crate::signal::Signal;
use serde::{Deserialize, Serialize};

/// Right-hand side with everything frozen that changes only at events.
#[derive(Clone, Copy)]
pub(crate) struct System<'a> {
    pub machine: &'a Machine,
    pub frozen: &'a Frozen,
    /// Absolute tolerance of each state.
    pub atol: &'a [f64],
    pub rtol: f64,
}

/// One step: its ends, and the polynomial between them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Step {
    pub t0_s: f64,
    pub h_s: f64,
    pub y0: Vec<f64>,
    pub y1: Vec<f64>,
    pub f0: Vec<f64>,
    pub f1: Vec<f64>,
    /// Coefficient of the quartic term of the dense output.
    pub quartic: Vec<f64>,
    /// State of the greatest scaled error.
    pub worst: usize,
    pub evaluations: u64,
}

impl Step {
    pub fn new(states: usize) -> Step {
        let zeros = || vec![0.0; states];
        Step {
            t0_s: 0.0,
            h_s: 0.0,
            y0: zeros(),
            y1: zeros(),
            f0: zeros(),
            f1: zeros(),
            quartic: zeros(),
            worst: 0,
            evaluations: 0,
        }
    }

    /// Makes the end of this step the start of the next.
    pub fn advance(&mut self) {
        std::mem::swap(&mut self.y0, &mut self.y1);
        std::mem::swap(&mut self.f0, &mut self.f1);
    }

    /// y at `t0 + theta·h`, written to `out`; with its rate where `theta` has one.
    pub fn dense<N: Signal>(&self, theta: N, out: &mut [N]) {
        let n = self.y0.len();
        let (y0, y1, f0, f1) = (&self.y0[..n], &self.y1[..n], &self.f0[..n], &self.f1[..n]);
        let (quartic, out) = (&self.quartic[..n], &mut out[..n]);
        let rest = N::constant(1.0) - theta;
        for i in 0..n {
            let rise = y1[i] - y0[i];
            let start = self.h_s * f0[i] - rise;
            let end = rise - self.h_s * f1[i] - start;
            let inner = N::constant(start) + theta * (N::constant(end) + rest * quartic[i]);
            out[i] = N::constant(y0[i]) + theta * (N::constant(rise) + rest * inner);
        }
    }

    /// Largest scaled error of `error(i)`, each integrator on its own scale.
    fn norm(&mut self, system: &System, error: impl Fn(usize) -> f64) -> f64 {
        let mut norm = 0.0;
        for i in 0..self.y0.len() {
            let size = self.y0[i].abs().max(self.y1[i].abs());
            let scaled = error(i).abs() / (system.atol[i] + system.rtol * size);
            // An undefined error stays undefined: it must not pass as a small one.
            if scaled > norm || scaled.is_nan() {
                norm = scaled;
                self.worst = i;
            }
        }
        norm
    }
}

/// A method with its working storage.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Scheme {
    DormandPrince(dormand_prince::DormandPrince),
    RungeKutta4(runge_kutta4::RungeKutta4),
    Euler,
    Sdirk4(Box<sdirk4::Sdirk4>),
}

impl Scheme {
    pub fn new(method: Method, states: usize) -> Scheme {
        match method {
            Method::DormandPrince => {
                Scheme::DormandPrince(dormand_prince::DormandPrince::new(states))
            }
            Method::RungeKutta4 => Scheme::RungeKutta4(runge_kutta4::RungeKutta4::new(states)),
            Method::Euler => Scheme::Euler,
            Method::Sdirk4 => Scheme::Sdirk4(Box::new(sdirk4::Sdirk4::new(states))),
        }
    }

    pub fn adaptive(&self) -> bool {
        matches!(self, Scheme::DormandPrince(_) | Scheme::Sdirk4(_))
    }

    /// Order of the error estimate plus one.
    pub fn exponent(&self) -> f64 {
        match self {
            Scheme::DormandPrince(_) => 5.0,
            _ => 4.0,
        }
    }

    /// Steps from `step.t0_s` by `h_s`; `nets` then hold the values at the end.
    /// Returns the scaled error, acceptable up to one; infinite where the method failed.
    pub fn attempt(&mut self, system: System, step: &mut Step, h_s: f64, nets: &mut [f64]) -> f64 {
        step.h_s = h_s;
        match self {
            Scheme::DormandPrince(method) => method.attempt(system, step, nets),
            Scheme::RungeKutta4(method) => method.attempt(system, step, nets),
            Scheme::Euler => euler::attempt(system, step, nets),
            Scheme::Sdirk4(method) => method.attempt(system, step, nets),
        }
    }

    /// Length of the last step, which [`Step::advance`] has made the past, times the fastest
    /// rate met in it.
    pub fn step_rate(&self, step: &Step, atol: &[f64], rtol: f64) -> Option<f64> {
        match self {
            Scheme::DormandPrince(method) => method.step_rate(step, atol, rtol),
            _ => None,
        }
    }

    /// The right-hand side has changed: forget what was learnt about it.
    pub fn restart(&mut self) {
        if let Scheme::Sdirk4(method) = self {
            method.restart();
        }
    }
}
