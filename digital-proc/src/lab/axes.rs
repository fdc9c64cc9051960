//! Translation in body, flight-path and H axes with the digital step of the paper.
//!
//! The attitude oscillates on the analog side; the digital side samples θ and q once a frame and
//! integrates the planar translation over a spherical earth by RK4, both held over the step:
//! ```text
//! body         u̇ = X − q w − g sin ϑ          ẇ = Z + q u + g cos ϑ         ϑ = θ + Γ
//! flight path  V̇ = X cos α + Z sin α − g sin γ   γ̇ = (X sin α − Z cos α)/V − (g/V − V/r) cos γ
//! H            d(r V_h)/dt = r (X cos ϑ + Z sin ϑ)   ḧ = X sin ϑ − Z cos ϑ + V_h²/r − g
//! ```
//! with `Z = −N α`, `α = ϑ − γ` (body: `atan2(w, u)`), `Γ̇ = V_h/r`, `ḣ = V_v`. The products q u and
//! q w are the *artificial accelerations* of body axes: the whole turn of the vehicle is
//! integrated as if it were a force, so that a rate held for a frame turns the velocity by the
//! attitude's own lag. Each frame is the same motion; with a fine step and the true attitude the
//! three agree (`reference`).
//!
//! θ is the inertial pitch angle from the horizontal of the launch point, rad. The earth does not
//! turn; mass, thrust and N are constant: the experiment is about axes, not about a flight.

use super::{
    plan::{LabError, RunPlan, require, tick},
    theory::hold::Hold,
};
use interface::{Tick, frame::Updates};
use serde::Serialize;

/// Earth radius, m (mean).
const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// Gravity at the surface, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;

/// Which axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// Body: u, w.
    Body,
    /// Flight path: V, γ.
    FlightPath,
    /// Howe's: r V_h, ḣ.
    H,
}

impl Axes {
    /// All, in the order of the tables.
    pub const ALL: [Axes; 3] = [Axes::Body, Axes::FlightPath, Axes::H];
}

/// Vehicle, attitude and digital step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxesSetting {
    /// Frame T, s.
    pub frame_s: f64,
    /// Amplitude of the attitude, rad.
    pub amplitude_rad: f64,
    /// Its frequency, rad/s.
    pub omega_rad_s: f64,
    /// Mean attitude at the start, rad, which is also γ at the start.
    pub mean_rad: f64,
    /// Steady rate of the mean attitude, rad/s.
    pub turn_rad_s: f64,
    /// Speed at the start, m/s.
    pub speed_m_s: f64,
    /// Altitude at the start, m.
    pub altitude_m: f64,
    /// Specific axial force X, m/s².
    pub axial_m_s2: f64,
    /// Specific normal force per angle of attack N, m/s² per rad.
    pub normal_m_s2_per_rad: f64,
    /// Offset of the analog or converted product that carries the rate of turn, as a fraction of
    /// its full scale: q u in body axes, the normal specific force in the others.
    pub offset_of_full_scale: f64,
    /// Duration, s.
    pub stop_s: f64,
}

/// State in one system of axes: two velocities, altitude m, range angle rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State([f64; 4]);

impl AxesSetting {
    /// 3° at 4 rad/s on a vehicle at 1074 m/s, so that the greatest q u is 225 m/s² and the greatest
    /// normal specific force 1.7 m/s².
    pub fn standard(frame_s: f64) -> AxesSetting {
        AxesSetting {
            frame_s,
            amplitude_rad: 3f64.to_radians(),
            omega_rad_s: 4.0,
            mean_rad: 40f64.to_radians(),
            turn_rad_s: -0.005,
            speed_m_s: 1074.0,
            altitude_m: 20_000.0,
            axial_m_s2: 25.0,
            normal_m_s2_per_rad: 32.0,
            offset_of_full_scale: 0.0,
            stop_s: 20.0,
        }
    }

    /// Attitude and pitch rate at `t_s`; the patch makes the same.
    ///
    /// The oscillation starts with no rate: a held rate that starts at its peak would add a constant
    /// of half a frame's turn to γ, which is an error of the start and not of the axes.
    pub fn attitude(&self, t_s: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.omega_rad_s * t_s);
        (
            self.mean_rad + self.turn_rad_s * t_s - self.amplitude_rad * c,
            self.turn_rad_s + self.amplitude_rad * self.omega_rad_s * s,
        )
    }

    fn start(&self, axes: Axes) -> State {
        let (theta, _) = self.attitude(0.0);
        let (v, gamma) = (self.speed_m_s, self.mean_rad);
        let alpha = theta - gamma;
        let pair = match axes {
            Axes::Body => [v * libm::cos(alpha), v * libm::sin(alpha)],
            Axes::FlightPath => [v, gamma],
            Axes::H => {
                [(EARTH_RADIUS_M + self.altitude_m) * v * libm::cos(gamma), v * libm::sin(gamma)]
            }
        };
        State([pair[0], pair[1], self.altitude_m, 0.0])
    }

    /// Full scale of the product that turns the velocity, m/s².
    fn full_scale(&self, axes: Axes) -> f64 {
        match axes {
            Axes::Body => self.amplitude_rad * self.omega_rad_s * self.speed_m_s,
            Axes::FlightPath | Axes::H => self.amplitude_rad * self.normal_m_s2_per_rad,
        }
    }

    fn derivative(&self, axes: Axes, s: State, theta: f64, q: f64) -> State {
        let [a, b, h, range] = s.0;
        let r = EARTH_RADIUS_M + h;
        let g = GRAVITY_M_S2 * (EARTH_RADIUS_M / r).powi(2);
        let pitch = theta + range;
        let offset = self.offset_of_full_scale * self.full_scale(axes);
        let x = self.axial_m_s2;
        let normal = |alpha: f64| -self.normal_m_s2_per_rad * alpha;
        match axes {
            Axes::Body => {
                let alpha = libm::atan2(b, a);
                let (v, gamma) = (libm::hypot(a, b), pitch - alpha);
                State([
                    x - q * b - g * libm::sin(pitch),
                    normal(alpha) + q * a + offset + g * libm::cos(pitch),
                    v * libm::sin(gamma),
                    v * libm::cos(gamma) / r,
                ])
            }
            Axes::FlightPath => {
                let alpha = pitch - b;
                let z = normal(alpha) + offset;
                State([
                    x * libm::cos(alpha) + z * libm::sin(alpha) - g * libm::sin(b),
                    (x * libm::sin(alpha) - z * libm::cos(alpha)) / a
                        - (g / a - a / r) * libm::cos(b),
                    a * libm::sin(b),
                    a * libm::cos(b) / r,
                ])
            }
            Axes::H => {
                let v_h = a / r;
                let alpha = pitch - libm::atan2(b, v_h);
                let z = normal(alpha) + offset;
                State([
                    r * (x * libm::cos(pitch) + z * libm::sin(pitch)),
                    x * libm::sin(pitch) - z * libm::cos(pitch) + v_h * v_h / r - g,
                    b,
                    v_h / r,
                ])
            }
        }
    }

    /// One RK4 step; `attitude` maps the fraction of the step to (θ, q).
    fn step(&self, axes: Axes, s: State, h: f64, attitude: impl Fn(f64) -> (f64, f64)) -> State {
        let at = |k: State, w: f64| State(std::array::from_fn(|i| s.0[i] + w * k.0[i]));
        let rate = |state: State, part: f64| {
            let (theta, q) = attitude(part);
            self.derivative(axes, state, theta, q)
        };
        let k1 = rate(s, 0.0);
        let k2 = rate(at(k1, h / 2.0), 0.5);
        let k3 = rate(at(k2, h / 2.0), 0.5);
        let k4 = rate(at(k3, h), 1.0);
        State(std::array::from_fn(|i| {
            s.0[i] + h / 6.0 * (k1.0[i] + 2.0 * k2.0[i] + 2.0 * k3.0[i] + k4.0[i])
        }))
    }

    fn gamma(axes: Axes, s: State, theta: f64) -> f64 {
        let [a, b, h, range] = s.0;
        match axes {
            Axes::Body => theta + range - libm::atan2(b, a),
            Axes::FlightPath => b,
            Axes::H => libm::atan2(b, a / (EARTH_RADIUS_M + h)),
        }
    }

    /// The run: `lab/axes.toml`.
    ///
    /// # Errors
    /// For numbers out of range.
    pub fn plan(&self) -> Result<RunPlan, LabError> {
        require("the speed", self.speed_m_s, self.speed_m_s > 0.0, "> 0 m/s")?;
        require("the frame", self.frame_s, self.frame_s > 0.0, "> 0 s")?;
        Ok(RunPlan {
            patch: "lab/axes.toml",
            params: vec![
                ("amplitude", self.amplitude_rad),
                ("frequency", self.omega_rad_s / std::f64::consts::TAU),
                ("rate_amplitude", self.amplitude_rad * self.omega_rad_s),
                ("mean", self.mean_rad),
                ("turn", self.turn_rad_s),
            ],
            frame: tick("the frame", self.frame_s)?,
            latency: Tick::ZERO,
            skew: Tick::ZERO,
            stop: tick("the stop time", self.stop_s)?,
            hold: Hold::ZeroOrder,
        })
    }

    /// The digital side.
    pub fn law(&self) -> AxesLaw {
        AxesLaw {
            setting: *self,
            states: Axes::ALL.map(|a| self.start(a)),
            gammas: Vec::new(),
            artificial: [0.0; 3],
        }
    }

    /// γ at the frames from a fully digital run with the true attitude, `substeps` RK4 steps a frame.
    pub fn reference(&self, axes: Axes, frames: usize, substeps: u32) -> Vec<f64> {
        let ideal = AxesSetting { offset_of_full_scale: 0.0, ..*self };
        let h = self.frame_s / f64::from(substeps.max(1));
        let mut s = ideal.start(axes);
        let mut gammas = Vec::with_capacity(frames);
        for n in 0..frames {
            let t0 = n as f64 * self.frame_s;
            gammas.push(Self::gamma(axes, s, self.attitude(t0).0));
            for i in 0..substeps.max(1) {
                let t = t0 + f64::from(i) * h;
                s = ideal.step(axes, s, h, |part| self.attitude(t + part * h));
            }
        }
        gammas
    }

    /// RMS error of γ in each system against the fine flight-path run.
    ///
    /// # Errors
    /// When the law has seen no frame.
    pub fn rows(&self, law: &AxesLaw) -> Result<Vec<AxesRow>, LabError> {
        let frames = law.gammas.len();
        require("the frames", frames as f64, frames > 0, "at least 1")?;
        // 1 ms steps at 4 rad/s: RK4's error is (0.004)⁴/120 of the motion, 2e-12.
        let substeps = (self.frame_s / 1e-3).ceil().max(1.0) as u32;
        let truth = self.reference(Axes::FlightPath, frames, substeps);
        let lag_rms = self.amplitude_rad * self.omega_rad_s * self.frame_s / 2.0 / 2f64.sqrt();
        Ok(Axes::ALL
            .iter()
            .enumerate()
            .map(|(k, axes)| {
                let square: f64 =
                    law.gammas.iter().zip(&truth).map(|(g, t)| (g[k] - t).powi(2)).sum();
                AxesRow {
                    axes: *axes,
                    frame_s: self.frame_s,
                    gamma_error_rms_deg: (square / frames as f64).sqrt().to_degrees(),
                    gamma_error_theory_deg: match axes {
                        Axes::Body => lag_rms.to_degrees(),
                        Axes::FlightPath | Axes::H => {
                            let lever = (self.axial_m_s2 + self.normal_m_s2_per_rad)
                                / (self.speed_m_s * self.omega_rad_s);
                            (lag_rms * lever).to_degrees()
                        }
                    },
                    turning_acceleration_max_m_s2: law.artificial[k],
                    full_scale_m_s2: self.full_scale(*axes),
                }
            })
            .collect())
    }
}

/// Integrates all three systems side by side from the same samples: ADC 0 θ, ADC 1 q.
#[derive(Clone, Debug)]
pub struct AxesLaw {
    setting: AxesSetting,
    states: [State; 3],
    gammas: Vec<[f64; 3]>,
    artificial: [f64; 3],
}

impl AxesLaw {
    /// Frame n.
    pub fn step(&mut self, _frame: u64, adc: &[f64], _updates: &mut Updates) {
        let at = |i: usize| adc.get(i).copied().unwrap_or(f64::NAN);
        let (theta, q) = (at(0), at(1));
        let mut gammas = [0.0; 3];
        for (k, axes) in Axes::ALL.into_iter().enumerate() {
            let s = self.states[k];
            gammas[k] = AxesSetting::gamma(axes, s, theta);
            let turning = match axes {
                Axes::Body => (q * s.0[0]).abs(),
                _ => (self.setting.normal_m_s2_per_rad * (theta + s.0[3] - gammas[k])).abs(),
            };
            self.artificial[k] = self.artificial[k].max(turning);
            self.states[k] = self.setting.step(axes, s, self.setting.frame_s, |_| (theta, q));
        }
        self.gammas.push(gammas);
    }

    /// γ at each frame in body, flight-path and H axes, rad.
    pub fn gammas(&self) -> &[[f64; 3]] {
        &self.gammas
    }
}

/// One system of axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxesRow {
    /// Axes.
    pub axes: Axes,
    /// Frame, s.
    pub frame_s: f64,
    /// RMS error of γ against the fine run, deg.
    pub gamma_error_rms_deg: f64,
    /// First order of the oscillating part: in body axes the attitude's own lag `Aω(T/2)/√2`, in the
    /// others that times `(X + N)/(Vω)`, deg.
    pub gamma_error_theory_deg: f64,
    /// Greatest acceleration that turns the velocity: q u in body axes, N α in the others, m/s².
    pub turning_acceleration_max_m_s2: f64,
    /// Full scale that a product or converter needs for it, m/s².
    pub full_scale_m_s2: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(setting: &AxesSetting) -> Vec<AxesRow> {
        let plan = setting.plan().unwrap();
        let mut law = setting.law();
        for n in 0..plan.stop.0 / plan.frame.0 {
            let (theta, q) = setting.attitude(plan.frame.secs() * n as f64);
            law.step(n.unsigned_abs(), &[theta, q], &mut Updates::new(0, Tick::ZERO));
        }
        setting.rows(&law).unwrap()
    }

    #[test]
    fn the_three_systems_are_one_motion() {
        let setting = AxesSetting::standard(0.1);
        let runs = Axes::ALL.map(|a| setting.reference(a, 200, 100));
        for n in 0..200 {
            for r in &runs[1..] {
                // RK4 at 1 ms: below 1e-11 a step of relative motion, 2e4 steps.
                assert!((r[n] - runs[0][n]).abs() < 1e-8, "frame {n}");
            }
        }
    }

    #[test]
    fn body_axes_pay_for_their_artificial_accelerations() {
        let rows = run(&AxesSetting::standard(0.1));
        let [body, path, h] = [&rows[0], &rows[1], &rows[2]];
        assert!(body.turning_acceleration_max_m_s2 > 200.0);
        assert!(path.turning_acceleration_max_m_s2 < 3.0);
        assert!(body.gamma_error_rms_deg / path.gamma_error_rms_deg > 10.0, "{rows:?}");
        // Flight-path and H axes hold the same quantities: they differ at second order only.
        let ratio = h.gamma_error_rms_deg / path.gamma_error_rms_deg;
        assert!((ratio - 1.0).abs() < 0.1, "{rows:?}");
        // The lag of 0.424° rms; the rate seen in the body sum is Aω sin, so ω²T²/24 ≈ 1 %,
        // and lift turns the path back by (X + N)/(Vω) ≈ 1.5 % of it; the steady turn adds 0.014°.
        let ratio = body.gamma_error_rms_deg / body.gamma_error_theory_deg;
        assert!((ratio - 1.0).abs() < 0.1, "{rows:?}");
    }

    #[test]
    fn errors_vanish_at_first_order() {
        let (coarse, fine) =
            (run(&AxesSetting::standard(0.05)), run(&AxesSetting::standard(0.025)));
        for (c, f) in coarse.iter().zip(&fine) {
            let order = (c.gamma_error_rms_deg / f.gamma_error_rms_deg).log2();
            assert!((order - 1.0).abs() < 0.2, "{c:?} {f:?}");
        }
    }

    #[test]
    fn an_offset_of_full_scale_costs_body_axes_most() {
        // Small frames leave the offset alone.
        let rows = run(&AxesSetting { offset_of_full_scale: 5e-4, ..AxesSetting::standard(1e-3) });
        assert!(rows[0].gamma_error_rms_deg > 4.0 * rows[1].gamma_error_rms_deg, "{rows:?}");
    }
}
