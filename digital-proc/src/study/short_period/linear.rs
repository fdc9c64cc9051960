//! The linearised loops: state matrices and their eigenvalues.
//!
//! A dead zone, a travel limit or a force limit is replaced by the gain it shows
//! to a small signal (1 inside its linear range, 0 where it is saturated or
//! closed). Eigenvalues therefore agree with a response only where the loop stays in
//! that range.

use crate::matrix_exp::matrix_exp;
use interface::control::LinearModel;
use nalgebra::{DMatrix, DVector, SMatrix};

use super::coefficients::Plane;
use super::higher_modes::{HIGHER, HigherMode};

/// Gains shown by the two channels, as fractions of the linear ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelGains {
    /// Fin-tip channel: 1 in its travel, 0 saturated.
    pub ftc: f64,
    /// Thrust-vector channel: 1 beyond the dead zone, 0 inside it.
    pub tvc: f64,
}

impl ChannelGains {
    /// Both channels, the dead zone ignored.
    pub const BOTH: ChannelGains = ChannelGains { ftc: 1.0, tvc: 1.0 };
    /// Fin tips alone, inside the dead zone.
    pub const FTC_ONLY: ChannelGains = ChannelGains { ftc: 1.0, tvc: 0.0 };
    /// Thrust vector alone: the tips saturated or absent, the dead zone ignored.
    pub const TVC_ONLY: ChannelGains = ChannelGains { ftc: 0.0, tvc: 1.0 };
}

/// One eigenvalue s as natural frequency |s| and damping ratio −Re s/|s|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Real part, 1/s.
    pub real: f64,
    /// Imaginary part, rad/s.
    pub imaginary: f64,
}

impl Root {
    /// Natural frequency |s|, rad/s.
    pub fn frequency_radps(&self) -> f64 {
        libm::hypot(self.real, self.imaginary)
    }

    /// Damping ratio −Re s/|s|; 0 for a root at the origin.
    pub fn damping(&self) -> f64 {
        let frequency = self.frequency_radps();
        if frequency == 0.0 { 0.0 } else { -self.real / frequency }
    }
}

/// States of a plane, as [`plane_matrix`] has them.
pub(crate) mod state {
    pub const DRIFT: usize = 0;
    pub const THETA: usize = 1;
    pub const RATE: usize = 2;
    pub const TIP: usize = 3;
    pub const TVC: usize = 4;
    pub const GYRO: usize = 5;
    pub const GYRO_SLOPE: usize = 6;
    pub const ETA: usize = 7;
    pub const ETA_RATE: usize = 8;
    pub const FILTERED: usize = 9;
    /// η of the second mode, of [`super::matrix_with`]; pairs η_i, η̇_i follow.
    pub const FIRST_HIGHER: usize = 10;
}
use state::{
    DRIFT, ETA, ETA_RATE, FILTERED, FIRST_HIGHER, GYRO, GYRO_SLOPE, RATE, THETA, TIP, TVC,
};

/// State matrix of a plane, states: drift rate, θ, θ̇, δ, F_T, gyro rate, gyro
/// slope, η, η̇, filtered error; shape `[10][10]`.
pub fn plane_matrix(plane: &Plane, gains: ChannelGains) -> SMatrix<f64, 10, 10> {
    let mut a = SMatrix::<f64, 10, 10>::zeros();
    a[(DRIFT, DRIFT)] = -plane.normal_pull * plane.inverse_speed;
    a[(DRIFT, THETA)] = -plane.thrust_pull - plane.normal_pull;
    a[(DRIFT, TIP)] = plane.control_pull * plane.tip_force;
    a[(DRIFT, TVC)] = plane.control_pull;
    a[(THETA, RATE)] = 1.0;
    a[(RATE, DRIFT)] = plane.aero_moment * plane.inverse_speed;
    a[(RATE, THETA)] = plane.aero_moment;
    a[(RATE, RATE)] = plane.damping;
    a[(RATE, TIP)] = plane.ftc_moment * plane.tip_force;
    a[(RATE, TVC)] = plane.tvc_moment;
    a[(TIP, TIP)] = -plane.tip_bandwidth;
    a[(TIP, FILTERED)] = plane.tip_bandwidth * plane.ftc_gain * gains.ftc;
    let tvc = plane.tvc_bandwidth * plane.tvc_gain * gains.tvc;
    a[(TVC, TVC)] = -plane.tvc_bandwidth;
    a[(TVC, THETA)] = -tvc;
    a[(TVC, ETA)] = -tvc * plane.imu_slope;
    a[(TVC, GYRO)] = -tvc * plane.tvc_lead;
    a[(GYRO, GYRO_SLOPE)] = 1.0;
    a[(GYRO_SLOPE, RATE)] = plane.gyro_spring;
    a[(GYRO_SLOPE, ETA_RATE)] = plane.gyro_spring * plane.gyro_slope;
    a[(GYRO_SLOPE, GYRO)] = -plane.gyro_spring;
    a[(GYRO_SLOPE, GYRO_SLOPE)] = -plane.gyro_drag;
    a[(ETA, ETA_RATE)] = 1.0;
    a[(ETA_RATE, ETA)] = -plane.bending_spring;
    a[(ETA_RATE, ETA_RATE)] = -plane.bending_drag;
    a[(ETA_RATE, TIP)] = plane.bending_drive * plane.tip_force;
    a[(ETA_RATE, TVC)] = plane.bending_drive;
    a[(FILTERED, THETA)] = -plane.filter_pole;
    a[(FILTERED, ETA)] = -plane.filter_pole * plane.imu_slope;
    a[(FILTERED, GYRO)] = -plane.filter_pole * plane.ftc_lead;
    a[(FILTERED, FILTERED)] = -plane.filter_pole;
    a
}

/// The same with modes beyond the first behind, each as η_i, η̇_i; shape `[10 + 2n][10 + 2n]`.
pub fn matrix_with(plane: &Plane, higher: &[HigherMode], gains: ChannelGains) -> DMatrix<f64> {
    let order = FIRST_HIGHER + 2 * higher.len();
    let mut a = DMatrix::zeros(order, order);
    a.view_mut((0, 0), (FIRST_HIGHER, FIRST_HIGHER)).copy_from(&plane_matrix(plane, gains));
    for (i, mode) in higher.iter().enumerate() {
        let (eta, rate) = (FIRST_HIGHER + 2 * i, FIRST_HIGHER + 2 * i + 1);
        a[(eta, rate)] = 1.0;
        a[(rate, eta)] = -mode.spring();
        a[(rate, rate)] = -mode.drag();
        a[(rate, TIP)] = mode.drive * plane.tip_force;
        a[(rate, TVC)] = mode.drive;
        a[(GYRO_SLOPE, rate)] = plane.gyro_spring * mode.gyro_slope;
        a[(FILTERED, eta)] = -plane.filter_pole * mode.imu_slope;
        a[(TVC, eta)] = -plane.tvc_bandwidth * plane.tvc_gain * gains.tvc * mode.imu_slope;
    }
    a
}

/// The matrix with the modes that the plane has.
fn whole_matrix(plane: &Plane, gains: ChannelGains) -> DMatrix<f64> {
    matrix_with(plane, plane.higher.as_ref().map_or(&[], |higher| higher), gains)
}

/// Attitude and bending coordinate (rad, m) after a step command from rest, both channels
/// staying in the range that `gains` describes: x(t) = ∫₀ᵗ exp(A s) b ds by the
/// exponential of the matrix with its input appended, exact at every sample.
pub fn step_response(
    plane: &Plane,
    gains: ChannelGains,
    command_rad: f64,
    sample_s: f64,
    samples: usize,
) -> Vec<[f64; 2]> {
    driven_response(&driven_matrix(plane, gains), command_rad, sample_s, samples)
}

/// The state matrix with the command's column appended; shape `[n][n + 1]`.
pub fn driven_matrix(plane: &Plane, gains: ChannelGains) -> DMatrix<f64> {
    let matrix = whole_matrix(plane, gains);
    let n = matrix.nrows();
    let mut driven = matrix.insert_column(n, 0.0);
    driven[(TVC, n)] = plane.tvc_bandwidth * plane.tvc_gain * gains.tvc;
    driven[(FILTERED, n)] = plane.filter_pole;
    driven
}

/// [`step_response`] of such a matrix.
pub fn driven_response(
    driven: &DMatrix<f64>,
    command_rad: f64,
    sample_s: f64,
    samples: usize,
) -> Vec<[f64; 2]> {
    let n = driven.nrows();
    let mut augmented = DMatrix::zeros(n + 1, n + 1);
    augmented.view_mut((0, 0), (n, n + 1)).copy_from(driven);
    let advance = matrix_exp(&(augmented * sample_s));
    let mut state = DVector::zeros(n + 1);
    state[n] = command_rad;
    let mut response = vec![[0.0; 2]];
    for _ in 0..samples {
        state = &advance * state;
        response.push([state[THETA], state[ETA]]);
    }
    response
}

/// Eigenvalues, by increasing natural frequency, the positive imaginary part of a pair
/// first. Empty if the matrix has a non-finite entry or the QR iteration gives up.
pub fn roots<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Vec<Root> {
    roots_of(DMatrix::from_column_slice(N, N, matrix.as_slice()))
}

/// [`roots`] of a matrix of any order.
pub fn roots_of(matrix: DMatrix<f64>) -> Vec<Root> {
    if matrix.iter().any(|v| !v.is_finite()) {
        return Vec::new();
    }
    // Bounded, so that no matrix can keep the iteration going for ever.
    const ITERATIONS: usize = 10_000;
    let Some(schur) = matrix.try_schur(f64::EPSILON, ITERATIONS) else {
        return Vec::new();
    };
    let mut roots: Vec<Root> =
        schur.complex_eigenvalues().iter().map(|s| Root { real: s.re, imaginary: s.im }).collect();
    roots.sort_by(|a, b| {
        a.frequency_radps()
            .total_cmp(&b.frequency_radps())
            .then(b.imaginary.total_cmp(&a.imaginary))
    });
    roots
}

/// State matrix of the machine's linear model of a patch.
pub fn model_matrix(model: &LinearModel) -> DMatrix<f64> {
    let order = model.states.len();
    DMatrix::from_row_slice(order, order, &model.a)
}

/// Its eigenvalues, as [`roots_of`] gives them.
pub fn model_roots(model: &LinearModel) -> Vec<Root> {
    roots_of(model_matrix(model))
}

/// Roots of a plane that matter for judging it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneRoots {
    /// The attitude oscillation: least damped pair below half the bending frequency.
    pub attitude: Option<Root>,
    /// The bending mode: the pair nearest to its natural frequency.
    pub bending: Option<Root>,
    /// The real root or pair farthest to the right of all.
    pub rightmost: Option<Root>,
    /// The second and third bending mode, where they are in the loop.
    pub higher: [Option<Root>; HIGHER],
}

/// Picks the attitude and bending roots.
pub fn plane_roots(plane: &Plane, gains: ChannelGains) -> PlaneRoots {
    matrix_roots(plane, whole_matrix(plane, gains))
}

/// [`plane_roots`] of a matrix of the plane, or of one beside it.
pub fn matrix_roots(plane: &Plane, matrix: DMatrix<f64>) -> PlaneRoots {
    let all = roots_of(matrix);
    let bending_frequency = plane.bending_spring.sqrt();
    let pairs = || all.iter().copied().filter(|r| r.imaginary > 0.0);
    let nearest = |frequency: f64| {
        pairs().min_by(|a, b| {
            let off = |r: &Root| (r.imaginary - frequency).abs();
            off(a).total_cmp(&off(b))
        })
    };
    // The drift root is slow; a pair below 0.5 rad/s is drift, not attitude.
    const DRIFT_RADPS: f64 = 0.5;
    PlaneRoots {
        attitude: pairs()
            .filter(|r| {
                r.frequency_radps() > DRIFT_RADPS && r.frequency_radps() < bending_frequency / 2.0
            })
            .min_by(|a, b| a.damping().total_cmp(&b.damping())),
        bending: nearest(bending_frequency),
        rightmost: all.iter().copied().max_by(|a, b| a.real.total_cmp(&b.real)),
        higher: plane
            .higher
            .map_or([None; HIGHER], |modes| modes.map(|mode| nearest(mode.frequency_radps))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::coefficients::{Disturbance, Settings};
    use crate::study::short_period::point::{FrozenPoint, tests::frozen};
    use crate::study::short_period::reference::{self, Grid};

    fn plane(point: &FrozenPoint) -> Plane {
        Plane::new(point, &Disturbance::NONE)
    }

    /// Figures of an independent prototype, each to half a unit of its last digit.
    #[test]
    fn thrust_vector_roots_are_those_of_the_independent_prototype() {
        let points = [2.0, 20.0, 32.5, 40.0].map(frozen);
        for (point, frequency, damping) in [(&points[1], 2.91, 0.084), (&points[2], 3.15, 0.085)] {
            let root = plane_roots(&plane(point), ChannelGains::TVC_ONLY).attitude.unwrap();
            assert!((root.frequency_radps() - frequency).abs() <= 0.005, "{root:?}");
            assert!((root.damping() - damping).abs() <= 0.0005, "{root:?}");
        }
        // The pole slowed to 1 rad/s.
        for (point, damping) in [(&points[0], -0.05), (&points[1], -0.27), (&points[2], -0.33)] {
            let slow = FrozenPoint { tvc_time_constant_s: 1.0, ..*point };
            let root = plane_roots(&plane(&slow), ChannelGains::TVC_ONLY).attitude.unwrap();
            assert!((root.damping() - damping).abs() <= 0.005, "{root:?}");
        }
        // The time constant shortened to 0.005 s lets the bending mode grow.
        for (point, damping) in [(&points[0], -0.025), (&points[3], -0.001)] {
            let fast = FrozenPoint { tvc_time_constant_s: 0.005, ..*point };
            let root = plane_roots(&plane(&fast), ChannelGains::TVC_ONLY).bending.unwrap();
            assert!((root.damping() - damping).abs() <= 0.0005, "{root:?}");
        }
        // Both channels at 20 s without TVC: the loop that sampling is measured on.
        let root = plane_roots(&plane(&points[1]), ChannelGains::FTC_ONLY).attitude.unwrap();
        assert!((root.damping() - 0.872).abs() <= 0.0005, "{root:?}");
    }

    /// In its linear range the reference must follow the matrix exponential, which
    /// shares no integration with it.
    #[test]
    fn reference_and_matrix_exponential_agree_in_the_linear_range() {
        let grid = Grid { samples: 300, sample_s: 0.02, steps: 20 };
        let points = [7.5, 20.0].map(frozen);
        let cases = [
            // Thrust vector alone, no dead zone: 4.5 kN/deg · 2° stays below 15 kN.
            (&points[0], ChannelGains::TVC_ONLY, 2.0_f64.to_radians()),
            // Tips alone: 0.1° stays inside the dead zone, 0.8° of tip inside its travel.
            (&points[1], ChannelGains::FTC_ONLY, 0.1_f64.to_radians()),
        ];
        for (point, gains, command) in cases {
            let settings = Settings::pitch(point, &Disturbance::NONE, command);
            let run = reference::run(&settings, &grid);
            let exact = step_response(&settings.plane, gains, command, 0.02, 300);
            for (i, row) in exact.iter().enumerate() {
                // RK4 at 1 ms: (100 rad/s · 1 ms)⁵/120 a step on the gyro's fast motion,
                // which dies out in 0.1 s: below 1e-7 · 100 steps of the step.
                let bound = 1e-5 * command;
                assert!((run.attitude_rad()[i] - row[0]).abs() < bound, "θ at sample {i}");
                assert!((run.eta_m()[i] - row[1]).abs() < bound, "η at sample {i}");
            }
        }
    }

    #[test]
    fn a_non_finite_matrix_has_no_roots() {
        let mut plane = plane(&frozen(20.0));
        plane.aero_moment = f64::NAN;
        assert!(roots(&plane_matrix(&plane, ChannelGains::BOTH)).is_empty());
        assert_eq!(plane_roots(&plane, ChannelGains::BOTH).attitude, None);
    }
}
