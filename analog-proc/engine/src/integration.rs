//! How a patch is integrated: method, tolerances, steps, and what an overload does.
//!
//! Settings alone; what is out of range is refused where the machine is made.

/// Integration method of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Adaptive explicit 5(4) of Dormand and Prince, the default.
    DormandPrince,
    /// Classical fixed-step fourth-order Runge–Kutta.
    RungeKutta4,
    /// Fixed-step forward Euler.
    Euler,
    /// Adaptive L-stable singly diagonally implicit Runge–Kutta, order 4(3), for stiff patches.
    Sdirk4,
}

/// What an overload does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OverloadPolicy {
    /// It is latched and the run goes on.
    Continue,
    /// The run goes to HOLD.
    Hold,
    /// The run ends.
    Stop,
}

/// How the patch is to be integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integration {
    /// Method.
    pub method: Method,
    /// Relative tolerance of each integrator (adaptive methods).
    pub rtol: f64,
    /// Absolute tolerance, problem units (times `max`, where stated).
    pub atol: f64,
    /// Step of the fixed-step methods, s.
    pub step_s: f64,
    /// Greatest step of the adaptive methods, s.
    pub max_step_s: f64,
    /// Overload policy.
    pub overload: OverloadPolicy,
    /// Time scale: one second of problem time takes this many seconds of machine time (pacing only).
    pub time_scale: f64,
}

impl Default for Integration {
    /// Tolerances at which an oscillator keeps eight digits over tens of cycles.
    fn default() -> Self {
        Integration {
            method: Method::DormandPrince,
            rtol: 1e-10,
            atol: 1e-12,
            step_s: 1e-3,
            max_step_s: f64::INFINITY,
            overload: OverloadPolicy::Continue,
            time_scale: 1.0,
        }
    }
}
