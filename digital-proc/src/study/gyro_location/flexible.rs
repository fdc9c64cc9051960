//! The linearised pitch plane with several bending modes.
//!
//! Mode i beside the first adds η̈ᵢ + 2ζᵢωᵢη̇ᵢ + ωᵢ²ηᵢ = (φᵢ/Mᵢ)(F_F + F_T), eq. (24), and reaches the
//! sensors as θ̇ + Σ λᵢη̇ᵢ and θ + Σ λᵢηᵢ, eq. (25). Drift, gyro, filter and actuators are those of
//! [`plane_matrix`], in its order of states; pairs (ηᵢ, η̇ᵢ) follow.

use crate::study::short_period::{
    coefficients::Plane,
    linear::{
        ChannelGains, Root, plane_matrix, roots_of,
        state::{ETA, FILTERED, GYRO, GYRO_SLOPE, THETA, TIP, TVC},
    },
};
use nalgebra::DMatrix;
use vehicle::{
    Vehicle,
    beam_shape::{FREE_FREE, shapes_at},
};

/// Modes of a flexible vehicle.
pub const MODES: usize = 3;
/// Order of the first mode's plane.
const RIGID_AND_FIRST: usize = 10;

/// A bending mode beyond the first, at the sensors and the control forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HigherMode {
    /// ω, rad/s.
    pub frequency_radps: f64,
    /// ζ.
    pub damping: f64,
    /// φ/M, 1/kg.
    pub drive: f64,
    /// λ at the rate gyro, 1/m.
    pub gyro_slope: f64,
    /// λ at the attitude reference, 1/m.
    pub imu_slope: f64,
}

/// Station of the attitude reference, m from the nozzle exit (equipment bay).
pub const IMU_STATION_M: f64 = 19.5;

/// Slope −dφ/dx of the free-free mode `mode` (0 is the first), φ(0) = 1, of a uniform beam of the
/// vehicle's length, 1/m.
pub fn free_free_slope(vehicle: &Vehicle, mode: usize, station_m: f64) -> f64 {
    -shapes_at(vehicle.data().geometry.length_m, station_m).slope[2 + mode]
}

/// Modes 2 and 3 beside the first, all estimates from the uniform free-free beam: ωᵢ = ω₁(kᵢ/k₁)²,
/// φ at the control forces and λ from its shapes; generalised mass and ζ of the first mode.
pub fn higher_modes(vehicle: &Vehicle, plane: &Plane, gyro_station_m: f64) -> [HigherMode; 2] {
    let data = vehicle.data();
    let geometry = &data.geometry;
    let between_actuators_m = (geometry.tip_x_m + geometry.injection_x_m) / 2.0;
    let phi = shapes_at(geometry.length_m, between_actuators_m).value;
    let first = plane.bending_spring.sqrt();
    let mass_kg = data.bending.displacement_at_control / plane.bending_drive;
    [1, 2].map(|mode| HigherMode {
        frequency_radps: first * (FREE_FREE[mode] / FREE_FREE[0]).powi(2),
        damping: data.bending.damping_ratio,
        drive: phi[2 + mode] / mass_kg,
        gyro_slope: free_free_slope(vehicle, mode, gyro_station_m),
        imu_slope: free_free_slope(vehicle, mode, IMU_STATION_M),
    })
}

/// A linear plane and the natural frequencies of its modes, rad/s.
#[derive(Clone, Debug)]
pub struct Flexible {
    pub plane: Plane,
    pub higher: Vec<HigherMode>,
    /// Of every mode, the first one first.
    pub frequency_radps: Vec<f64>,
}

/// The actuator at which the loop is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Actuator {
    Tips,
    Injection,
}

impl Actuator {
    pub const ALL: [Actuator; 2] = [Actuator::Tips, Actuator::Injection];

    pub fn words(self) -> &'static str {
        match self {
            Actuator::Tips => "fin tips",
            Actuator::Injection => "injection",
        }
    }
}

/// A loop opened: ẋ = A x + b u, y = c x, and 1 + L = 0 with L = −c (s − A)⁻¹ b is the closed one.
#[derive(Clone, Debug)]
pub struct OpenLoop {
    pub a: DMatrix<f64>,
    pub b: DMatrix<f64>,
    pub c: DMatrix<f64>,
}

impl Flexible {
    pub fn new(plane: Plane, higher: &[HigherMode]) -> Flexible {
        let first = plane.bending_spring.sqrt();
        let frequencies = higher.iter().map(|m| m.frequency_radps);
        Flexible {
            plane,
            higher: higher.to_vec(),
            frequency_radps: std::iter::once(first).chain(frequencies).collect(),
        }
    }

    /// State matrix, both channels showing `gains`.
    pub fn matrix(&self, gains: ChannelGains) -> DMatrix<f64> {
        let plane = &self.plane;
        let order = RIGID_AND_FIRST + 2 * self.higher.len();
        let mut a = DMatrix::zeros(order, order);
        a.view_mut((0, 0), (RIGID_AND_FIRST, RIGID_AND_FIRST))
            .copy_from(&plane_matrix(plane, gains));
        for (i, mode) in self.higher.iter().enumerate() {
            let (eta, rate) = (RIGID_AND_FIRST + 2 * i, RIGID_AND_FIRST + 2 * i + 1);
            a[(eta, rate)] = 1.0;
            a[(rate, eta)] = -mode.frequency_radps * mode.frequency_radps;
            a[(rate, rate)] = -2.0 * mode.damping * mode.frequency_radps;
            a[(rate, TIP)] = mode.drive * plane.tip_force;
            a[(rate, TVC)] = mode.drive;
            a[(GYRO_SLOPE, rate)] = plane.gyro_spring * mode.gyro_slope;
            a[(FILTERED, eta)] = -plane.filter_pole * mode.imu_slope;
            a[(TVC, eta)] = -plane.tvc_bandwidth * plane.tvc_gain * gains.tvc * mode.imu_slope;
        }
        a
    }

    /// The root of each mode: the pair nearest to jω of its natural frequency.
    pub fn mode_roots(&self, gains: ChannelGains) -> Vec<Option<Root>> {
        let roots = roots_of(self.matrix(gains));
        self.frequency_radps
            .iter()
            .map(|frequency| {
                let off = |r: &Root| libm::hypot(r.real, r.imaginary - frequency);
                roots
                    .iter()
                    .filter(|r| r.imaginary > 0.0)
                    .min_by(|a, b| off(a).total_cmp(&off(b)))
                    .copied()
            })
            .collect()
    }

    /// The loop opened at an actuator's command; the other channel shows its gain of `gains`.
    pub fn opened(&self, at: Actuator, gains: ChannelGains) -> OpenLoop {
        let plane = &self.plane;
        let rest = match at {
            Actuator::Tips => ChannelGains { ftc: 0.0, ..gains },
            Actuator::Injection => ChannelGains { tvc: 0.0, ..gains },
        };
        let a = self.matrix(rest);
        let order = a.nrows();
        let (mut b, mut c) = (DMatrix::zeros(order, 1), DMatrix::zeros(1, order));
        match at {
            Actuator::Tips => {
                b[TIP] = plane.tip_bandwidth;
                c[FILTERED] = plane.ftc_gain;
            }
            Actuator::Injection => {
                b[TVC] = plane.tvc_bandwidth;
                c[THETA] = -plane.tvc_gain;
                c[GYRO] = -plane.tvc_gain * plane.tvc_lead;
                c[ETA] = -plane.tvc_gain * plane.imu_slope;
                for (i, mode) in self.higher.iter().enumerate() {
                    c[RIGID_AND_FIRST + 2 * i] = -plane.tvc_gain * mode.imu_slope;
                }
            }
        }
        OpenLoop { a, b, c }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::{
        coefficients::Disturbance, linear::plane_roots, point::FrozenPoint,
    };
    use vehicle::slice;

    fn at(vehicle: &Vehicle, time_s: f64, gyro_station_m: f64) -> Flexible {
        let point = slice::points(vehicle, &[("", time_s)]).unwrap().remove(0);
        let frozen = FrozenPoint::new(vehicle, &point, &point.settings.gains);
        let plane = Plane::new(&frozen, &Disturbance::NONE);
        Flexible::new(plane, &higher_modes(vehicle, &plane, gyro_station_m))
    }

    /// Figures of an independent formulation, to their last digit.
    #[test]
    fn the_higher_modes_are_those_of_the_independent_formulation() {
        let vehicle = Vehicle::shipped().unwrap();
        let found = at(&vehicle, 32.5, 11.7);
        let phi = shapes_at(22.7, 0.55).value;
        for (i, [phi_c, gyro, imu]) in
            [[0.8096, -0.2361, 0.2895], [0.7338, 0.0575, -0.2986]].into_iter().enumerate()
        {
            let mode = &found.higher[i];
            assert!((phi[3 + i] - phi_c).abs() <= 5e-5, "{}", phi[3 + i]);
            assert!((mode.gyro_slope - gyro).abs() <= 5e-5, "{mode:?}");
            assert!((mode.imu_slope - imu).abs() <= 5e-5, "{mode:?}");
            let ratio = mode.frequency_radps / found.frequency_radps[0];
            assert!((ratio - [2.757, 5.404][i]).abs() <= 5e-4, "{ratio}");
        }
        // Stable at all points: mode 2 with ζ = 0.011 to 0.020, mode 3 with 0.0096 to 0.0100.
        let (mut second, mut third) = (Vec::new(), Vec::new());
        for time_s in [2.0, 4.0, 7.5, 10.0, 17.0, 18.3, 20.0, 25.0, 32.5, 34.0, 40.0, 45.0, 47.0] {
            let flexible = at(&vehicle, time_s, 11.7);
            let gains = if flexible.plane.ftc_gain == 0.0 {
                ChannelGains::TVC_ONLY
            } else {
                ChannelGains::BOTH
            };
            let roots = flexible.mode_roots(gains);
            second.push(roots[1].unwrap().damping());
            third.push(roots[2].unwrap().damping());
        }
        println!("{second:?} {third:?}");
        let within =
            |all: &[f64], low: f64, high: f64| all.iter().all(|z| (low..=high).contains(z));
        assert!(within(&second, 0.0105, 0.0205), "{second:?}");
        assert!(within(&third, 0.00955, 0.01005), "{third:?}");
    }

    /// One mode is the plane of the short-period study.
    #[test]
    fn with_one_mode_it_is_the_plane() {
        let vehicle = Vehicle::shipped().unwrap();
        let plane = at(&vehicle, 20.0, 11.7).plane;
        let one = Flexible::new(plane, &[]);
        for gains in [ChannelGains::BOTH, ChannelGains::FTC_ONLY, ChannelGains::TVC_ONLY] {
            assert_eq!(one.mode_roots(gains)[0], plane_roots(&plane, gains).bending);
        }
    }

    /// Closing an opened loop gives back the closed one.
    #[test]
    fn a_loop_that_is_opened_closes_again() {
        let vehicle = Vehicle::shipped().unwrap();
        let flexible = at(&vehicle, 20.0, 11.7);
        for at in Actuator::ALL {
            let open = flexible.opened(at, ChannelGains::BOTH);
            let closed = &open.a + &open.b * &open.c;
            let truth = flexible.matrix(ChannelGains::BOTH);
            // Products in another order: some roundings.
            assert!((closed - &truth).norm() <= 1e-14 * truth.norm(), "{at:?}");
        }
    }
}
