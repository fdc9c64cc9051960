//! The α loop of the rotational equations: conventional and redundant, exactly.
//!
//! Plant (d = +1 for α with pitch rate, −1 for β with yaw rate):
//! ```text
//! α̇ = d q − Z α*         q̇ = −d M α* − D q
//! ```
//! where `α*` is the angle at which the digital side looked up its force and moment
//! tables. Continuous (`α* = α`): `s² + (Z + D) s + M + ZD = 0`.
//!
//! # The reconstruction that is solved
//! The paper's figure 1 does not survive in the text; this reading reproduces every figure that is
//! known of it. T_s = N T_f is the slow and T_f the fast frame, τ ≤ T_f the latency, `f_k = d q_k − Z α*_k`.
//!
//! **Conventional.** One rate. The digital side samples q only and integrates the
//! translational equations itself, one slow frame ahead, by the second-order
//! Adams–Bashforth rule, looking its tables up at its own angle (`α* = α_d`):
//! ```text
//! α_d[k+1] = α_d[k] + T_s (3 f_k − f_{k−1}) / 2       f_k = d q_k − Z α_d[k]
//! moment   = −d M α_d[k],  transferred at t_k + τ, held
//! ```
//! **Redundant.** A spare analog integrator carries the angle continuously; q reaches it
//! without an interface, the tables are looked up at its fast samples:
//! ```text
//! analog:     α̇_a = d q − Z α* + c + b      α* = α_a sampled every T_f, τ late, held
//!             q̇   = −d M α* − D q            b: drift of the integrator
//! each T_s:   α_d[k+1] = α_d[k] + T_s (3 f_k − f_{k−1}) / 2     f_k = d q_k − Z α_a(t_k)
//!             e_k = α_d[k] − α_a(t_k)        both at the same instant (time-matched)
//! correction: c = K e / T_s for one slow frame (spread: time constant τ_c = T_s/K), or
//!             c = K e / T_f for one fast frame (pulse: a partial reset)
//! ```
//! `e` is `e_k` (prompt), `e_{k−1}` (one slow frame late, time-matched) or
//! `α_d[k−1] − α_a(t_k)` (one frame late and not time-matched).
//!
//! The digital angle thus comes from the digital side's own integration of the sampled rate,
//! with the forces that it looked up at the redundant angle; it needs no α sample of its own.
//! Two other readings were refused. With a digital angle taken as exact, the error decouples
//! (`e_{k+1} = (1 − K) e_k`) and no K < 2 can destabilise the loop, against the known price of
//! K = 0.5; with Euler or a rate held over the frame it lags by half a frame, and the shift at
//! K = 0.2 is three times too large.

use super::{C64, Refusal, frame_and_latency, period_map::PeriodMap, require};
use nalgebra::DMatrix;

/// The rotational equations of one plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// M, 1/s².
    pub moment_slope: f64,
    /// Z, 1/s.
    pub force_slope: f64,
    /// D, 1/s.
    pub rate_damping: f64,
    /// +1: α with pitch rate; −1: β with yaw rate.
    pub direction: f64,
}

impl Rotation {
    /// The plane of the laboratory: Z = 0.6, D = 0.4, M = ω².
    pub fn standard(omega_rad_s: f64) -> Rotation {
        Rotation {
            moment_slope: omega_rad_s * omega_rad_s,
            force_slope: 0.6,
            rate_damping: 0.4,
            direction: 1.0,
        }
    }

    /// Upper root of the continuous loop.
    pub fn continuous_root(&self) -> C64 {
        let half = (self.force_slope + self.rate_damping) / 2.0;
        let stiffness = self.moment_slope + self.force_slope * self.rate_damping;
        let discriminant = half * half - stiffness;
        if discriminant < 0.0 {
            C64::new(-half, (-discriminant).sqrt())
        } else {
            C64::new(-half + discriminant.sqrt(), 0.0)
        }
    }

    /// First-order shift where the moment is `moment_s` late and the force `force_s`:
    /// `Δs = s₀ (M τ_M + Z (s₀ + D) τ_Z) / (2 s₀ + Z + D)`.
    fn first_order_shift(&self, moment_s: f64, force_s: f64) -> C64 {
        let s0 = self.continuous_root();
        let (m, z, d) = (self.moment_slope, self.force_slope, self.rate_damping);
        s0 * (C64::new(m * moment_s, 0.0) + (s0 + d) * (z * force_s)) / (s0 * 2.0 + z + d)
    }
}

/// When and against what the correction is formed; the doc comments are the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Delivery {
    /// At once
    Prompt,
    /// One slow frame late, both angles of one instant
    LateMatched,
    /// One slow frame late, against the present analog angle
    LateUnmatched,
}

/// How the correction enters the analog integrator; the doc comments are the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Correction {
    /// Over the whole slow period
    Spread,
    /// Over one fast frame
    Pulse,
}

/// How the loop is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scheme {
    /// The digital side integrates the angle, every frame.
    Conventional,
    /// Redundant integrator, sampled every frame and corrected every `slow_frames`.
    Redundant {
        /// N = T_s / T_f.
        slow_frames: u32,
        gain: f64,
        delivery: Delivery,
        correction: Correction,
    },
}

impl Scheme {
    /// N, 1 when conventional.
    pub fn slow_frames(self) -> u32 {
        match self {
            Scheme::Conventional => 1,
            Scheme::Redundant { slow_frames, .. } => slow_frames,
        }
    }
}

/// A sampled α loop. For [`Scheme::Conventional`] the frame is T_s, else T_f.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaLoop {
    pub rotation: Rotation,
    pub scheme: Scheme,
    /// Frame, s.
    pub frame_s: f64,
    /// Latency τ, s, at most one frame.
    pub latency_s: f64,
}

// State of the period map.
const A: usize = 0; // analog angle
const Q: usize = 1; // rate
const U: usize = 2; // angle of the held force and moment
const C: usize = 3; // correction rate
const U_NEXT: usize = 4; // buffers of the next transfer
const C_NEXT: usize = 5;
const AD: usize = 6; // digital angle
const F1: usize = 7; // f_{k−1}
const F2: usize = 8; // f_{k−2}
const E1: usize = 9; // e_{k−1}
const ORDER: usize = 10;

impl AlphaLoop {
    /// Monodromy over one slow frame.
    pub fn period_map(&self) -> Result<PeriodMap, Refusal> {
        let (frame, latency) = frame_and_latency(self.frame_s, self.latency_s)?;
        let slow = self.scheme.slow_frames();
        require("slow frames", f64::from(slow), slow >= 1, "≥ 1")?;

        let r = &self.rotation;
        let redundant = matches!(self.scheme, Scheme::Redundant { .. });
        let mut flow = DMatrix::zeros(ORDER, ORDER);
        flow[(Q, Q)] = -r.rate_damping;
        flow[(Q, U)] = -r.direction * r.moment_slope;
        if redundant {
            flow[(A, Q)] = r.direction;
            flow[(A, U)] = -r.force_slope;
            flow[(A, C)] = 1.0;
        }
        let mut transfer = DMatrix::identity(ORDER, ORDER);
        for (to, from) in [(U, U_NEXT), (C, C_NEXT)] {
            transfer[(to, to)] = 0.0;
            transfer[(to, from)] = 1.0;
        }
        let mut map = PeriodMap::new(ORDER);
        for j in 0..slow {
            map.jump(&self.sample_jump(frame, f64::from(slow) * frame, j));
            map.flow(&flow, latency);
            map.jump(&transfer);
            map.flow(&flow, frame - latency);
        }
        Ok(map)
    }

    /// What the digital side does with the samples of fast frame `j` of a slow frame.
    fn sample_jump(&self, fast_s: f64, slow_s: f64, j: u32) -> DMatrix<f64> {
        let r = &self.rotation;
        let unit = DMatrix::<f64>::identity(ORDER, ORDER);
        let row = |i: usize| unit.row(i).into_owned();
        let mut jump = unit.clone();
        let advanced = row(AD) + (row(F1) * 1.5 - row(F2) * 0.5) * slow_s;
        let step = |jump: &mut DMatrix<f64>, angle_for_force: &nalgebra::RowDVector<f64>| {
            jump.set_row(AD, &advanced);
            jump.set_row(F2, &row(F1));
            jump.set_row(F1, &(row(Q) * r.direction - angle_for_force * r.force_slope));
        };
        match self.scheme {
            Scheme::Conventional => {
                step(&mut jump, &advanced);
                jump.set_row(U_NEXT, &advanced);
                // There is no analog angle and no correction.
                jump.row_mut(A).fill(0.0);
                jump.row_mut(E1).fill(0.0);
                jump.row_mut(C_NEXT).fill(0.0);
            }
            Scheme::Redundant { gain, delivery, correction, .. } => {
                jump.set_row(U_NEXT, &row(A));
                if j == 0 {
                    step(&mut jump, &row(A));
                    let matched = &advanced - row(A);
                    let error = match delivery {
                        Delivery::Prompt => matched.clone(),
                        Delivery::LateMatched => row(E1),
                        Delivery::LateUnmatched => row(AD) - row(A),
                    };
                    jump.set_row(E1, &matched);
                    let over = match correction {
                        Correction::Spread => slow_s,
                        Correction::Pulse => fast_s,
                    };
                    jump.set_row(C_NEXT, &(error * (gain / over)));
                } else if correction == Correction::Pulse {
                    jump.row_mut(C_NEXT).fill(0.0);
                }
            }
        }
        jump
    }

    /// The continuous root and its first-order shift by a delay of half a frame and the latency,
    /// without the penalty of the correction. A digital side that integrates the angle itself has
    /// the force at once: there the moment alone is late.
    pub fn first_order_root(&self) -> C64 {
        let late_s = self.latency_s + self.frame_s / 2.0;
        let force_s = match self.scheme {
            Scheme::Conventional => 0.0,
            Scheme::Redundant { .. } => late_s,
        };
        self.rotation.continuous_root() + self.rotation.first_order_shift(late_s, force_s)
    }

    /// Exact equivalent root on the branch of the continuous one.
    pub fn exact_root(&self) -> Result<C64, Refusal> {
        self.period_map()?.root_near(self.rotation.continuous_root())
    }

    /// Stable when every |z| of the slow period is below 1.
    pub fn spectral_radius(&self) -> Result<f64, Refusal> {
        self.period_map()?.spectral_radius()
    }
}

/// Largest error that a drift b leaves, `b T_s / K`, against `b t` uncorrected.
pub fn drift_error(drift_rad_s: f64, slow_s: f64, gain: f64) -> f64 {
    drift_rad_s * slow_s / gain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn redundant(omega: f64, fast: f64, gain: f64, slow: (Delivery, Correction)) -> AlphaLoop {
        let (delivery, correction) = slow;
        AlphaLoop {
            rotation: Rotation::standard(omega),
            scheme: Scheme::Redundant { slow_frames: 10, gain, delivery, correction },
            frame_s: fast,
            latency_s: fast,
        }
    }

    fn conventional(omega: f64, slow: f64) -> AlphaLoop {
        AlphaLoop {
            rotation: Rotation::standard(omega),
            scheme: Scheme::Conventional,
            frame_s: slow,
            latency_s: slow,
        }
    }

    /// Ratio of the root shifts at T_s = 0.05, T_f = 0.005, K = 0.2 against
    /// 0.093, 0.128, 0.146 of an independent prototype whose slow rule is not on record.
    #[test]
    fn shift_ratio_is_that_of_the_frames_plus_a_penalty() {
        for (omega, known) in [(2.0, 0.093), (4.0, 0.128), (6.0, 0.146)] {
            let s0 = Rotation::standard(omega).continuous_root();
            let r = redundant(omega, 0.005, 0.2, (Delivery::Prompt, Correction::Pulse));
            let shift = (r.exact_root().unwrap() - s0).norm();
            let slow = (conventional(omega, 0.05).exact_root().unwrap() - s0).norm();
            // An instant reset, a pulse and a spread correction differ among themselves by up to 0.003.
            assert!((shift / slow - known).abs() < 0.003, "{omega}: {}", shift / slow);
        }
    }

    /// Against the exact root, with the moment alone late (conventional) and with both (K = 0 and
    /// N = 1: an analog angle sampled once a frame), the first-order shift holds to T².
    #[test]
    fn shift_formula_is_first_order() {
        let both = Scheme::Redundant {
            slow_frames: 1,
            gain: 0.0,
            delivery: Delivery::Prompt,
            correction: Correction::Spread,
        };
        for scheme in [Scheme::Conventional, both] {
            let error = |t: f64| {
                let rotation = Rotation::standard(4.0);
                let l = AlphaLoop { rotation, scheme, frame_s: t, latency_s: t };
                (l.exact_root().unwrap() - l.first_order_root()).norm()
            };
            let order = (error(0.002) / error(0.001)).log2();
            assert!((order - 2.0).abs() < 0.2, "{scheme:?}: {order}");
        }
    }
}
