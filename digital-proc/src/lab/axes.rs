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
//! turn; mass, thrust and N are constant: the experiment is about axes, not about a flight. Long by
//! the three systems of equations.

use super::*;

/// Earth radius, m (mean).
const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// Gravity at the surface, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;

/// The body axes' error is at least so many times that of flight-path axes.
const AXES_RATIO: f64 = 10.0;
/// Mean attitude at the start, rad (40°), which is also γ at the start.
const MEAN_RAD: f64 = 40_f64.to_radians();
/// Steady rate of the mean attitude, rad/s.
const TURN_RAD_S: f64 = -0.005;
const SPEED_M_S: f64 = 1074.0;
const ALTITUDE_M: f64 = 20_000.0;
/// Specific axial force X, m/s².
const AXIAL_M_S2: f64 = 25.0;
/// Specific normal force per angle of attack N, m/s² per rad.
const NORMAL_M_S2_PER_RAD: f64 = 32.0;
const STOP_S: f64 = 20.0;

/// Translation in body, flight-path and H axes: error of the flight-path angle
///
/// Translation computed in body, flight-path and H axes from the same samples of an oscillating
/// attitude, by RK4 with attitude and rate held over the digital step.
///
/// In body axes the whole turn of the vehicle is an artificial acceleration q u, which a held rate
/// makes wrong by the attitude's own lag; in flight-path and H axes only the true normal force is.
#[derive(clap::Args)]
pub struct AxesOfTranslation {
    /// Digital steps
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "25ms,50ms,100ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// Amplitude of the attitude, degrees
    #[arg(long, default_value_t = 3.0, value_name = "DEG")]
    amplitude: f64,
    /// Frequency of the attitude, rad/s
    #[arg(long, default_value_t = 4.0, value_name = "RAD/S")]
    omega: f64,
    /// Offset of the product that turns the velocity, percent of its full scale
    #[arg(long, default_value_t = 0.05, value_name = "PERCENT")]
    offset: f64,
}

interface::named! {
    /// In the order of the tables.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Axes, name {
        /// u, w.
        Body "body"
        /// V, γ.
        FlightPath "flight path"
        /// Howe's: r V_h, ḣ.
        H "H"
    }
}

/// One digital step of the attitude's motion.
#[derive(Clone, Copy, Debug)]
struct Case {
    frame_s: f64,
    amplitude_rad: f64,
    omega_rad_s: f64,
    /// Offset of the analog or converted product that carries the rate of turn, as a fraction of
    /// its full scale: q u in body axes, the normal specific force in the others.
    offset_of_full_scale: f64,
}

/// One system of axes.
#[derive(Clone, Copy, Debug)]
struct Row {
    axes: Axes,
    frame_s: f64,
    /// RMS error of γ against the fine run, deg.
    error_deg: f64,
    /// First order of the oscillating part: in body axes the attitude's own lag `Aω(T/2)/√2`, in the
    /// others that times `(X + N)/(Vω)`, deg.
    theory_deg: f64,
    /// Greatest acceleration that turns the velocity: q u in body axes, N α in the others, m/s².
    turning_m_s2: f64,
    /// Full scale that a product or converter needs for it, m/s².
    full_scale_m_s2: f64,
    /// `error_deg` with the offset of the settings.
    with_offset_deg: f64,
}

/// State in one system of axes: two velocities, altitude m, range angle rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State([f64; 4]);

impl Case {
    /// Attitude and pitch rate at `t_s`; the patch makes the same.
    ///
    /// The oscillation starts with no rate: a held rate that starts at its peak would add a constant
    /// of half a frame's turn to γ, which is an error of the start and not of the axes.
    fn attitude(&self, t_s: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.omega_rad_s * t_s);
        (
            MEAN_RAD + TURN_RAD_S * t_s - self.amplitude_rad * c,
            TURN_RAD_S + self.amplitude_rad * self.omega_rad_s * s,
        )
    }

    fn start(&self, axes: Axes) -> State {
        let (theta, _) = self.attitude(0.0);
        let (v, gamma) = (SPEED_M_S, MEAN_RAD);
        let alpha = theta - gamma;
        let pair = match axes {
            Axes::Body => [v * libm::cos(alpha), v * libm::sin(alpha)],
            Axes::FlightPath => [v, gamma],
            Axes::H => [(EARTH_RADIUS_M + ALTITUDE_M) * v * libm::cos(gamma), v * libm::sin(gamma)],
        };
        State([pair[0], pair[1], ALTITUDE_M, 0.0])
    }

    /// Full scale of the product that turns the velocity, m/s².
    fn full_scale(&self, axes: Axes) -> f64 {
        match axes {
            Axes::Body => self.amplitude_rad * self.omega_rad_s * SPEED_M_S,
            Axes::FlightPath | Axes::H => self.amplitude_rad * NORMAL_M_S2_PER_RAD,
        }
    }

    fn derivative(&self, axes: Axes, s: State, theta: f64, q: f64) -> State {
        let [a, b, h, range] = s.0;
        let r = EARTH_RADIUS_M + h;
        let g = GRAVITY_M_S2 * (EARTH_RADIUS_M / r).powi(2);
        let pitch = theta + range;
        let offset = self.offset_of_full_scale * self.full_scale(axes);
        let x = AXIAL_M_S2;
        let normal = |alpha: f64| -NORMAL_M_S2_PER_RAD * alpha;
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

    /// γ at the frames from a fully digital run with the true attitude, `substeps` RK4 steps a frame.
    fn reference(&self, axes: Axes, frames: usize, substeps: u32) -> Vec<f64> {
        let ideal = Case { offset_of_full_scale: 0.0, ..*self };
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

    /// All three systems side by side from the same samples, ADC 0 θ and ADC 1 q, against the fine
    /// flight-path run.
    fn run(&self, machine: &mut impl Machine) -> Result<[Row; 3], LabError> {
        require("the frame", self.frame_s, self.frame_s > 0.0, "> 0 s")?;
        let plan = RunPlan {
            params: vec![
                ("amplitude", self.amplitude_rad),
                ("frequency", self.omega_rad_s / TAU),
                ("rate_amplitude", self.amplitude_rad * self.omega_rad_s),
                ("mean", MEAN_RAD),
                ("turn", TURN_RAD_S),
            ],
            ..RunPlan::new("lab/axes.toml", self.frame_s, 0.0, STOP_S)?
        };
        let mut states = Axes::ALL.map(|axes| self.start(axes));
        let mut turning = [0.0_f64; 3];
        let mut gammas: Vec<[f64; 3]> = Vec::new();
        machine.run(&plan, &mut |samples, _| {
            let (theta, q) = (samples.adc[0], samples.adc[1]);
            gammas.push(std::array::from_fn(|k| {
                let (axes, s) = (Axes::ALL[k], states[k]);
                let gamma = Case::gamma(axes, s, theta);
                let product = match axes {
                    Axes::Body => q * s.0[0],
                    _ => NORMAL_M_S2_PER_RAD * (theta + s.0[3] - gamma),
                };
                turning[k] = turning[k].max(product.abs());
                states[k] = self.step(axes, s, self.frame_s, |_| (theta, q));
                gamma
            }));
        })?;
        let frames = gammas.len();
        require("the frames", frames as f64, frames > 0, "at least 1")?;
        // 1 ms steps at 4 rad/s: RK4's error is (0.004)⁴/120 of the motion, 2e-12.
        let substeps = (self.frame_s / 1e-3).ceil().max(1.0) as u32;
        let truth = self.reference(Axes::FlightPath, frames, substeps);
        let lag_rms = self.amplitude_rad * self.omega_rad_s * self.frame_s / 2.0 / 2f64.sqrt();
        let lever = (AXIAL_M_S2 + NORMAL_M_S2_PER_RAD) / (SPEED_M_S * self.omega_rad_s);
        Ok(std::array::from_fn(|k| {
            let axes = Axes::ALL[k];
            let square: f64 = gammas.iter().zip(&truth).map(|(g, t)| (g[k] - t).powi(2)).sum();
            let theory = if axes == Axes::Body { lag_rms } else { lag_rms * lever };
            let error_deg = (square / frames as f64).sqrt().to_degrees();
            Row {
                axes,
                frame_s: self.frame_s,
                error_deg,
                theory_deg: theory.to_degrees(),
                turning_m_s2: turning[k],
                full_scale_m_s2: self.full_scale(axes),
                with_offset_deg: error_deg,
            }
        }))
    }
}

impl AxesOfTranslation {
    fn case(&self, frame_s: f64, offset_of_full_scale: f64) -> Case {
        let amplitude_rad = self.amplitude.to_radians();
        Case { frame_s, amplitude_rad, omega_rad_s: self.omega, offset_of_full_scale }
    }

    fn run(&self, machine: &mut impl Machine, frame_s: f64) -> Result<[Row; 3], LabError> {
        let mut rows = self.case(frame_s, 0.0).run(machine)?;
        let off = self.case(frame_s, self.offset / 100.0).run(machine)?;
        for (row, off) in rows.iter_mut().zip(off) {
            row.with_offset_deg = off.error_deg;
        }
        Ok(rows)
    }
}

impl Experiment for AxesOfTranslation {
    const NAME: &'static str = "axes";
    const TITLE: &'static str = "Axes of the translational equations";
    const LEAD: &'static str = "The same flight integrated in three systems of axes from the same \
        samples of an oscillating attitude. The products q u of body axes are artificial \
        accelerations, whose error is the attitude's own lag.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("amplitude-deg", self.amplitude);
        outcome.set("omega-rad-s", self.omega);
        outcome.set("offset-percent", self.offset);
        let runs = bench.each(&self.frame, |bench, frame| self.run(bench, frame.secs()))?;
        let mut rows = runs.concat();
        let columns = [
            Column::new("axes", "", |r: &Row| r.axes.name().into()),
            Column::new("step", "s", |r| r.frame_s.into()),
            Column::new("rms error of gamma", "deg", |r| r.error_deg.into()),
            Column::new("first order", "deg", |r| r.theory_deg.into()),
            Column::new("with offset", "deg", |r| r.with_offset_deg.into()),
            Column::new("greatest turning acceleration", "m/s2", |r| r.turning_m_s2.into()),
            Column::new("full scale", "m/s2", |r| r.full_scale_m_s2.into()),
        ];
        let caption = format!(
            "Error of the flight-path angle over 20 s; `with offset`: the product that turns the velocity is off by {} % of its full scale.",
            self.offset
        );
        outcome.section("Numbers").table("axes", caption, Table::of(&columns, &rows));
        rows.sort_by(|a, b| a.frame_s.total_cmp(&b.frame_s));
        let ratios =
            rows.chunks_exact(3).map(|of| (of[0].frame_s * 1e3, of[0].error_deg / of[1].error_deg));
        if let Some((_, ratio)) = ratios.clone().find(|(ms, _)| (ms - 100.0).abs() < 1e-9) {
            outcome.check(
                "ratio",
                format!("at 100 ms the error in body axes is more than {AXES_RATIO} times that in flight-path axes: {ratio:.1} times"),
                ratio > AXES_RATIO,
            );
        }
        let compared = Axes::ALL.map(|axes| {
            let of = rows.iter().filter(|r| r.axes == axes);
            Compared::of(axes.name(), of.map(|r| (r.frame_s * 1e3, r.theory_deg, r.error_deg)))
        });
        let errors = measured_vs_theory(
            "Error of the flight-path angle",
            Axis::new("digital step", "ms").log(),
            Axis::new("rms error of γ", "°").log(),
            &compared,
        );
        let worth = LineChart::new(
            "Body axes against flight-path axes",
            Axis::new("digital step", "ms"),
            Axis::new("ratio of rms errors of γ", ""),
            vec![Series::of("", ratios).draw(Draw::Markers)],
        );
        let caption = "Lines: first order of the oscillating part. Markers: runs on the machine.";
        let figures = outcome.section("Figures").chart("gamma-error", caption, &errors);
        figures.chart("ratio", "What the choice of axes is worth.", &worth);
        Ok(())
    }
}
