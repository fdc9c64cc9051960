//! The linearised pitch plane with several bending modes.
//!
//! Mode i beside the first adds η̈ᵢ + 2ζᵢωᵢη̇ᵢ + ωᵢ²ηᵢ = (φᵢ/Mᵢ)(F_F + F_T), eq. (24), and reaches the
//! sensors as θ̇ + Σ λᵢη̇ᵢ and θ + Σ λᵢηᵢ, eq. (25). Drift, gyro, filter and actuators are those of
//! [`matrix_with`], in its order of states; pairs (ηᵢ, η̇ᵢ) follow.

use crate::study::short_period::{
    coefficients::Plane,
    higher_modes::HigherMode,
    linear::{
        ChannelGains, Root, matrix_with, roots_of,
        state::{ETA, FILTERED, FIRST_HIGHER, GYRO, THETA, TIP, TVC},
    },
};
use nalgebra::DMatrix;

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
        matrix_with(&self.plane, &self.higher, gains)
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
                    c[FIRST_HIGHER + 2 * i] = -plane.tvc_gain * mode.imu_slope;
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
        coefficients::Disturbance, higher_modes::higher_modes, linear::plane_roots,
        point::FrozenPoint,
    };
    use vehicle::{Vehicle, beam_shape::shapes_at, slice};

    fn at(vehicle: &Vehicle, time_s: f64, gyro_station_m: f64) -> Flexible {
        let point = slice::points(vehicle, &[("", time_s)]).unwrap().remove(0);
        let frozen = FrozenPoint::new(vehicle, &point, &point.settings.gains);
        let plane = Plane::new(&frozen, &Disturbance::NONE);
        Flexible::new(plane, &higher_modes(vehicle, &frozen, gyro_station_m))
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
