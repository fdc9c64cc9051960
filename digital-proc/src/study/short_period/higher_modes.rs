//! Bending modes beyond the first: eq. (24) of the paper with n = 3.
//!
//! η̈_i + 2ζ_iω_i η̇_i + ω_i² η_i = φ_ci/M_g (F_F + F_T), felt by the rate gyro as λ_gi η̇_i and by
//! the attitude reference as λ_ii η_i, eq. (25). Estimates: the shapes are those of a uniform
//! free-free beam, λ = −dφ/dx, the frequencies keep the vehicle's ratio to the first mode's, whose
//! generalised mass they share.

use super::point::FrozenPoint;
use vehicle::{
    Vehicle,
    beam_shape::{MODES, shapes_at},
};

/// Modes beyond the first.
pub const HIGHER: usize = MODES - 1;

/// One of them, at the sensors and the control forces.
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

impl HigherMode {
    /// ω², 1/s².
    pub fn spring(&self) -> f64 {
        self.frequency_radps * self.frequency_radps
    }

    /// 2 ζ ω, 1/s.
    pub fn drag(&self) -> f64 {
        2.0 * self.damping * self.frequency_radps
    }

    /// The same where nothing drives or feels it.
    fn left_out(self) -> HigherMode {
        HigherMode { drive: 0.0, gyro_slope: 0.0, imu_slope: 0.0, ..self }
    }
}

/// Slope −dφ/dx of the free-free mode `mode` (0 is the first), φ(0) = 1, of a uniform beam of the
/// vehicle's length, 1/m.
pub fn free_free_slope(vehicle: &Vehicle, mode: usize, station_m: f64) -> f64 {
    // Shapes: displacement, rotation, first mode, …
    -shapes_at(vehicle.data().geometry.length_m, station_m).slope[2 + mode]
}

/// Modes 2 and 3 beside the first of a point, with the rate gyro at a station.
pub fn higher_modes(vehicle: &Vehicle, point: &FrozenPoint, gyro_x_m: f64) -> [HigherMode; HIGHER] {
    let (data, bending) = (vehicle.data(), &vehicle.data().bending);
    let control = shapes_at(data.geometry.length_m, bending.control_x_m).value;
    std::array::from_fn(|i| HigherMode {
        frequency_radps: bending.frequency_ratio[i] * point.bending_frequency_radps,
        damping: bending.high_damping_ratio[i],
        drive: control[3 + i] / point.bending_mass_kg,
        gyro_slope: free_free_slope(vehicle, 1 + i, gyro_x_m),
        imu_slope: free_free_slope(vehicle, 1 + i, bending.imu_x_m),
    })
}

/// The same for a loop of so many modes in all: none where the first is alone, and what is beyond
/// their number left out.
pub fn of_a_loop(
    vehicle: &Vehicle,
    point: &FrozenPoint,
    gyro_x_m: f64,
    modes: usize,
) -> Option<[HigherMode; HIGHER]> {
    let [second, third] = higher_modes(vehicle, point, gyro_x_m);
    match modes {
        0 | 1 => None,
        2 => Some([second, third.left_out()]),
        _ => Some([second, third]),
    }
}

/// Blocks of drag, spring, drive and slopes in `pitch-loop-modes.toml`.
const BLOCKS: [[&str; 5]; HIGHER] = [
    [
        "mode2.eta_drag",
        "mode2.eta_spring",
        "mode2.eta_drive",
        "mode2.gyro_pickup",
        "mode2.imu_pickup",
    ],
    [
        "mode3.eta_drag",
        "mode3.eta_spring",
        "mode3.eta_drive",
        "mode3.gyro_pickup",
        "mode3.imu_pickup",
    ],
];

/// Values by block.
pub fn values(modes: &[HigherMode; HIGHER]) -> impl Iterator<Item = (&'static str, f64)> {
    BLOCKS.iter().zip(modes).flat_map(|(blocks, mode)| {
        let values = [mode.drag(), mode.spring(), mode.drive, mode.gyro_slope, mode.imu_slope];
        blocks.iter().copied().zip(values)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::point::tests::frozen;

    /// φ at the control forces is a figure of an independent formulation, to half a unit of its
    /// last digit; the slopes are held against it in `gyro_location`.
    #[test]
    fn a_loop_of_two_modes_leaves_the_third_out() {
        let (vehicle, point) = (Vehicle::shipped().unwrap(), frozen(32.5));
        let of = |modes| of_a_loop(&vehicle, &point, 11.7, modes);
        assert_eq!(of(1), None);
        let ([two, out], [same, three]) = (of(2).unwrap(), of(3).unwrap());
        assert_eq!(two, same);
        for (mode, displacement) in [(two, 0.8096), (three, 0.7338)] {
            assert!((mode.drive * point.bending_mass_kg - displacement).abs() <= 5e-5, "{mode:?}");
        }
        assert_eq!((out.drive, out.gyro_slope, out.imu_slope), (0.0, 0.0, 0.0));
        assert_eq!((out.spring(), out.drag()), (three.spring(), three.drag()));
    }
}
