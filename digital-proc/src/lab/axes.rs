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
//! Two [paths](Path): on the launch trajectory most of the error of flight-path axes is that of the
//! held pitch programme at low speed, where a small force turns the path far; at a constant high
//! speed only the axes are left. θ is the inertial pitch angle from the horizontal of the launch
//! point, rad; the earth does not turn. Long by the three systems of equations.

mod path;

use super::*;
use crate::flight::FlightFault;
use interface::frame::ModeCommand;
use path::Path;
use std::path::PathBuf;
use vehicle::{Vehicle, rk4};

/// The body axes' error is at least so many times that of flight-path axes.
const AXES_RATIO: f64 = 10.0;

/// Translation in body, flight-path and H axes: error of the flight-path angle
///
/// Translation computed in body, flight-path and H axes from the same samples of an oscillating
/// attitude, by RK4 with attitude and rate held over the digital step: on the launch trajectory
/// with its pitch programme, and at a constant 1074 m/s.
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
    /// Vehicle data set of your own for the launch trajectory [default: the shipped first stage]
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
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
struct Case<'v> {
    path: Path<'v>,
    frame_s: f64,
    amplitude_rad: f64,
    omega_rad_s: f64,
    /// Offset of the analog or converted product that carries the rate of turn, as a fraction of
    /// its full scale, which is its greatest value: q u in body axes, the normal specific force in
    /// the others.
    offset_of_full_scale: f64,
}

/// One system of axes.
#[derive(Clone, Copy, Debug)]
struct Row {
    path: &'static str,
    axes: Axes,
    frame_s: f64,
    /// RMS error of γ against the fine run, deg.
    error_deg: f64,
    /// First order of the oscillating part: in body axes the attitude's own lag `Aω(T/2)/√2`, in the
    /// others that times `(X + N)/(Vω)`, deg; none where that changes.
    theory_deg: Option<f64>,
    /// Greatest acceleration that turns the velocity: q u in body axes, N α in the others, m/s².
    turning_m_s2: f64,
    /// RMS of what the offset of the settings changes in γ, deg.
    by_offset_deg: f64,
}

/// State in one system of axes: two velocities, altitude m, range angle rad.
type State = [f64; 4];

/// What one run integrates.
struct Run {
    /// γ at the frames, in the order of [`Axes::ALL`], rad.
    gamma_rad: Vec<[f64; 3]>,
    turning_m_s2: [f64; 3],
}

impl Case<'_> {
    /// Attitude and pitch rate at `t_s`; the patch makes the oscillation.
    ///
    /// The oscillation starts with no rate: a held rate that starts at its peak would add a constant
    /// of half a frame's turn to γ, which is an error of the start and not of the axes.
    fn attitude(&self, t_s: f64) -> (f64, f64) {
        let (mean, turn) = self.path.attitude(t_s);
        let (s, c) = libm::sincos(self.omega_rad_s * t_s);
        (mean - self.amplitude_rad * c, turn + self.amplitude_rad * self.omega_rad_s * s)
    }

    fn start(&self, axes: Axes) -> State {
        let (theta, _) = self.attitude(0.0);
        let [v, gamma, h] = self.path.start();
        let alpha = theta - gamma;
        let [a, b] = match axes {
            Axes::Body => [v * libm::cos(alpha), v * libm::sin(alpha)],
            Axes::FlightPath => [v, gamma],
            Axes::H => [self.path.gravity(h).0 * v * libm::cos(gamma), v * libm::sin(gamma)],
        };
        [a, b, h, 0.0]
    }

    /// V, γ and α of a state at an attitude.
    fn flow(&self, axes: Axes, [a, b, h, range]: State, theta: f64) -> [f64; 3] {
        let pitch = theta + range;
        let (v, gamma) = match axes {
            Axes::Body => (libm::hypot(a, b), pitch - libm::atan2(b, a)),
            Axes::FlightPath => (a, b),
            Axes::H => {
                let level = a / self.path.gravity(h).0;
                (libm::hypot(level, b), libm::atan2(b, level))
            }
        };
        [v, gamma, pitch - gamma]
    }

    fn derivative(
        &self,
        axes: Axes,
        t_s: f64,
        state: State,
        (theta, q): (f64, f64),
        offset_m_s2: f64,
    ) -> Result<State, FlightFault> {
        let [a, b, h, range] = state;
        let (r, g) = self.path.gravity(h);
        let pitch = theta + range;
        let [v, gamma, alpha] = self.flow(axes, state, theta);
        let forces = self.path.forces(t_s, h, v)?;
        let x = forces.axial;
        let z = offset_m_s2 - forces.normal_slope * alpha;
        let [sine, cosine] = [libm::sin(gamma), libm::cos(gamma)];
        Ok(match axes {
            Axes::Body => [
                x - q * b - g * libm::sin(pitch),
                z + q * a + g * libm::cos(pitch),
                v * sine,
                v * cosine / r,
            ],
            Axes::FlightPath => [
                x * libm::cos(alpha) + z * libm::sin(alpha) - g * sine,
                (x * libm::sin(alpha) - z * libm::cos(alpha)) / v - (g / v - v / r) * cosine,
                v * sine,
                v * cosine / r,
            ],
            Axes::H => {
                let level = a / r;
                [
                    r * (x * libm::cos(pitch) + z * libm::sin(pitch)),
                    x * libm::sin(pitch) - z * libm::cos(pitch) + level * level / r - g,
                    b,
                    level / r,
                ]
            }
        })
    }

    /// γ at the frames from a fully digital run with the true attitude, `substeps` RK4 steps a frame.
    fn reference(&self, frames: usize, substeps: u32) -> Result<Vec<f64>, FlightFault> {
        let axes = Axes::FlightPath;
        let h = self.frame_s / f64::from(substeps);
        let mut state = self.start(axes);
        let mut gammas = Vec::with_capacity(frames);
        for n in 0..frames {
            let t0 = n as f64 * self.frame_s;
            gammas.push(self.flow(axes, state, self.attitude(t0).0)[1]);
            for i in 0..substeps {
                let t = t0 + f64::from(i) * h;
                state = rk4::step(t, &state, h, |at, s| {
                    self.derivative(axes, at, *s, self.attitude(at), 0.0)
                })?;
            }
        }
        Ok(gammas)
    }

    /// All three systems side by side from the same samples, ADC 0 the swing of θ and ADC 1 that of
    /// q; the offsets are added to their products.
    fn run(&self, machine: &mut impl Machine, offset_m_s2: [f64; 3]) -> Result<Run, LabError> {
        let plan = RunPlan {
            params: vec![
                ("amplitude", self.amplitude_rad),
                ("frequency", self.omega_rad_s / TAU),
                ("rate_amplitude", self.amplitude_rad * self.omega_rad_s),
            ],
            ..RunPlan::new("lab/axes.toml", self.frame_s, 0.0, self.path.stop_s())?
        };
        let mut states = Axes::ALL.map(|axes| self.start(axes));
        let mut run = Run { gamma_rad: Vec::new(), turning_m_s2: [0.0; 3] };
        let mut fault = None;
        machine.run(&plan, &mut |samples, updates| {
            let t = samples.frame as f64 * self.frame_s;
            let (mean, turn) = self.path.attitude(t);
            let attitude = (mean + samples.adc[0], turn + samples.adc[1]);
            match self.frame(t, attitude, &mut states, offset_m_s2, &mut run.turning_m_s2) {
                Ok(gammas) => run.gamma_rad.push(gammas),
                Err(found) => {
                    fault.get_or_insert(found);
                    updates.mode = ModeCommand::End as u32;
                    updates.effective = samples.tick;
                }
            }
        })?;
        fault.map_or(Ok(run), |fault| Err(fault.into()))
    }

    /// Advances every system by a frame with θ and q held; gives γ at its start.
    fn frame(
        &self,
        t_s: f64,
        attitude: (f64, f64),
        states: &mut [State; 3],
        offset_m_s2: [f64; 3],
        turning_m_s2: &mut [f64; 3],
    ) -> Result<[f64; 3], FlightFault> {
        let mut gammas = [0.0; 3];
        for (k, axes) in Axes::ALL.into_iter().enumerate() {
            let state = states[k];
            let [v, gamma, alpha] = self.flow(axes, state, attitude.0);
            let product = match axes {
                Axes::Body => attitude.1 * state[0],
                _ => self.path.forces(t_s, state[2], v)?.normal_slope * alpha,
            };
            turning_m_s2[k] = turning_m_s2[k].max(product.abs());
            states[k] = rk4::step(t_s, &state, self.frame_s, |at, s| {
                self.derivative(axes, at, *s, attitude, offset_m_s2[k])
            })?;
            gammas[k] = gamma;
        }
        Ok(gammas)
    }

    /// Error, and what an offset adds to it.
    fn rows(&self, machine: &mut impl Machine) -> Result<[Row; 3], LabError> {
        require("the frame", self.frame_s, self.frame_s > 0.0, "> 0 s")?;
        let run = self.run(machine, [0.0; 3])?;
        let frames = run.gamma_rad.len();
        require("the frames", frames as f64, frames > 0, "at least 1")?;
        let offset = run.turning_m_s2.map(|greatest| self.offset_of_full_scale * greatest);
        let off = self.run(machine, offset)?;
        // 1 ms steps at 4 rad/s: RK4's error is (0.004)⁴/120 of the motion, 2e-12.
        let substeps = (self.frame_s / 1e-3).ceil().max(1.0) as u32;
        let truth = self.reference(frames, substeps)?;
        let lag_rms = self.amplitude_rad * self.omega_rad_s * self.frame_s / 2.0 / 2f64.sqrt();
        let rms_deg = |squares: f64| (squares / frames as f64).sqrt().to_degrees();
        Ok(std::array::from_fn(|k| {
            let axes = Axes::ALL[k];
            let gammas = run.gamma_rad.iter().map(|g| g[k]);
            let error: f64 = gammas.clone().zip(&truth).map(|(g, t)| (g - t).powi(2)).sum();
            let moved: f64 = gammas.zip(&off.gamma_rad).map(|(g, o)| (o[k] - g).powi(2)).sum();
            let share = match axes {
                Axes::Body => Some(1.0),
                _ => self.path.lever().map(|lever| lever / self.omega_rad_s),
            };
            Row {
                path: self.path.name(),
                axes,
                frame_s: self.frame_s,
                error_deg: rms_deg(error),
                theory_deg: share.map(|share| (lag_rms * share).to_degrees()),
                turning_m_s2: run.turning_m_s2[k],
                by_offset_deg: rms_deg(moved),
            }
        }))
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
        let own = self.vehicle.as_deref().map(Vehicle::load);
        let vehicle = own.unwrap_or_else(Vehicle::shipped)?;
        let paths = [Path::launch(&vehicle)?, Path::Fast];
        let cases = paths.into_iter().flat_map(|path| self.frame.iter().map(move |f| (path, f)));
        let runs = bench.each(cases, |bench, (path, frame)| {
            let case = Case {
                path,
                frame_s: frame.secs(),
                amplitude_rad: self.amplitude.to_radians(),
                omega_rad_s: self.omega,
                offset_of_full_scale: self.offset / 100.0,
            };
            case.rows(bench)
        })?;
        let rows = runs.concat();
        let columns = [
            Column::new("trajectory", "", |r: &Row| r.path.into()),
            Column::new("axes", "", |r| r.axes.name().into()),
            Column::new("step", "s", |r| r.frame_s.into()),
            Column::new("rms error of gamma", "deg", |r| r.error_deg.into()),
            Column::new("first order", "deg", |r| r.theory_deg.into()),
            Column::new("rms by the offset", "deg", |r| r.by_offset_deg.into()),
            Column::new("greatest turning acceleration", "m/s2", |r| r.turning_m_s2.into()),
        ];
        let caption = format!(
            "Error of the flight-path angle on the launch trajectory, from its greatest pitch rate to burn-out, and at a constant 1074 m/s, 20 s; `by the offset`: what changes where the product that turns the velocity is off by {} % of its greatest value.",
            self.offset
        );
        outcome.section("Numbers").table("axes", caption, Table::of(&columns, &rows));
        for path in paths.map(Path::name) {
            let mut of_path: Vec<Row> = rows.iter().filter(|r| r.path == path).copied().collect();
            of_path.sort_by(|a, b| a.frame_s.total_cmp(&b.frame_s));
            let ratios: Vec<(f64, f64)> = of_path
                .chunks_exact(3)
                .map(|of| (of[0].frame_s * 1e3, of[0].error_deg / of[1].error_deg))
                .collect();
            if let Some((_, ratio)) = ratios.iter().find(|(ms, _)| (ms - 100.0).abs() < 1e-9) {
                outcome.check(
                    if path == Path::Fast.name() { "ratio" } else { "launch-ratio" },
                    format!("{path}: at 100 ms the error in body axes is more than {AXES_RATIO} times that in flight-path axes: {ratio:.1} times"),
                    *ratio > AXES_RATIO,
                );
            }
            let compared = Axes::ALL.map(|axes| {
                let of = of_path.iter().filter(|r| r.axes == axes);
                let theory = |r: &Row| r.theory_deg.unwrap_or(f64::NAN);
                Compared::of(axes.name(), of.map(|r| (r.frame_s * 1e3, theory(r), r.error_deg)))
            });
            let errors = measured_vs_theory(
                &format!("Error of the flight-path angle, {path}"),
                Axis::new("digital step", "ms").log(),
                Axis::new("rms error of γ", "°").log(),
                &compared,
            );
            let worth = LineChart::new(
                format!("Body axes against flight-path axes, {path}"),
                Axis::new("digital step", "ms"),
                Axis::new("ratio of rms errors of γ", ""),
                vec![Series::of("", ratios).draw(Draw::Markers)],
            );
            let caption =
                "Lines: first order of the oscillating part. Markers: runs on the machine.";
            let id = |of: &str| format!("{of}-{}", path.replace([' ', '/'], "-"));
            let figures = outcome.section("Figures").chart(id("gamma-error"), caption, &errors);
            figures.chart(id("ratio"), "What the choice of axes is worth.", &worth);
        }
        Ok(())
    }
}
