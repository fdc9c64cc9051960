//! Horizontal wind against altitude: calm, synthetic design profile, or a
//! tabulated one (a sounding, or a member of an ensemble).
//!
//! The synthetic profile is built from the envelope of wind speed, a shear and
//! a gust at a reference altitude h_ref:
//! * above h_ref the envelope W_e(h);
//! * below, W = W_e(h_ref) − c·a·(h_ref − h)^0.7 (0.7-power shear law, Fichtl),
//!   never below zero and never above the envelope;
//! * a quasi-square gust of c·gust: a (1 − cos) edge of 30 m that begins at
//!   h_ref, a plateau of `gust_len`, an edge of 30 m;
//! * c = `combine`, the customary 0.85 when shear and gust act together.
//!
//! Signs: positive along the flight direction (tailwind), so that a headwind is
//! negative; a crosswind is positive where it blows to starboard, the side to
//! which positive yaw turns the nose, so that it adds to α_y. The crosswind is
//! `cross_frac` times the profile. Unless told otherwise it has the sign of the
//! profile along: with the shipped fraction a headwind then blows to port. Which
//! side is free, so the tankage flies both.
//! Outside the envelope's altitudes its end value holds, flagged.

use crate::table::{Edge, Table, TableError};
use crate::{Vehicle, WindData};

/// Height over which the gust builds up and dies away, m.
pub const GUST_EDGE_M: f64 = 30.0;
/// Exponent of the shear law.
const SHEAR_EXPONENT: f64 = 0.7;

/// Wind at one altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindSample {
    /// Component along the flight direction, m/s; headwind negative.
    pub along_mps: f64,
    /// Component across it, m/s; positive to starboard.
    pub cross_mps: f64,
    pub edge: Edge,
}

/// Direction of the synthetic profile along the flight path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindDirection {
    Head,
    Tail,
}

/// A wind field.
#[derive(Debug, Clone, PartialEq)]
pub enum Wind {
    Calm,
    /// The synthetic design profile.
    Synthetic(SyntheticWind),
    /// Speed along the flight direction against altitude, and the fraction of
    /// it that blows across.
    Profile {
        /// Along-track speed (m/s) against altitude (m).
        along_mps: Table,
        cross_fraction: f64,
    },
}

impl Wind {
    /// The vehicle's synthetic profile as head- or tailwind.
    pub fn synthetic(vehicle: &Vehicle, direction: WindDirection) -> Result<Self, TableError> {
        let sign = if direction == WindDirection::Head { -1.0 } else { 1.0 };
        Self::signed(vehicle, sign, sign)
    }

    /// The synthetic profile, scaled by `along` in the flight plane (−1 headwind) and, times its
    /// share, by `cross` across it (+1 to starboard); calm where both are 0.
    pub fn signed(vehicle: &Vehicle, along: f64, cross: f64) -> Result<Self, TableError> {
        if along == 0.0 && cross == 0.0 {
            return Ok(Self::Calm);
        }
        SyntheticWind::new(&vehicle.data().wind, along, cross).map(Self::Synthetic)
    }

    /// The wind of the data set's design case: its sign scales the profile.
    pub fn design_case(vehicle: &Vehicle) -> Result<Self, TableError> {
        let sign = vehicle.data().long_period_case.wind_sign;
        Self::signed(vehicle, sign, sign)
    }

    pub fn at(&self, altitude_m: f64) -> WindSample {
        match self {
            Self::Calm => WindSample { along_mps: 0.0, cross_mps: 0.0, edge: Edge::Inside },
            Self::Synthetic(synthetic) => synthetic.at(altitude_m),
            Self::Profile { along_mps, cross_fraction } => {
                let found = along_mps.lookup(altitude_m);
                WindSample {
                    along_mps: found.value,
                    cross_mps: cross_fraction * found.value,
                    edge: found.edge,
                }
            }
        }
    }
}

/// The synthetic profile with its signs.
#[derive(Debug, Clone, PartialEq)]
pub struct SyntheticWind {
    envelope_mps: Table,
    reference_m: f64,
    reference_mps: f64,
    shear: f64,
    gust_mps: f64,
    gust_length_m: f64,
    /// Factors on the profile along and across.
    along: f64,
    cross: f64,
    cross_fraction: f64,
}

impl SyntheticWind {
    /// Of the `[wind]` section; `along` and `cross` as in [`Wind::signed`].
    pub fn new(data: &WindData, along: f64, cross: f64) -> Result<Self, TableError> {
        let reference_m = data.reference_altitude_m;
        let envelope_mps =
            Table::new(data.envelope_altitude_m.clone(), data.envelope_speed_mps.clone())?;
        Ok(Self {
            reference_mps: envelope_mps.lookup(reference_m).value,
            envelope_mps,
            reference_m,
            shear: data.combination_factor * data.shear_a,
            gust_mps: data.combination_factor * data.gust_mps,
            gust_length_m: data.gust_length_m,
            along,
            cross,
            cross_fraction: data.cross_fraction,
        })
    }

    pub fn at(&self, altitude_m: f64) -> WindSample {
        let envelope = self.envelope_mps.lookup(altitude_m);
        let depth_m = self.reference_m - altitude_m;
        let steady_mps = if depth_m > 0.0 {
            let sheared = self.reference_mps - self.shear * libm::pow(depth_m, SHEAR_EXPONENT);
            // The model's definition, not a repair: calm below the shear layer.
            sheared.max(0.0).min(envelope.value)
        } else {
            envelope.value
        };
        let profile_mps = steady_mps + self.gust_mps * self.gust_shape(-depth_m);
        WindSample {
            along_mps: self.along * profile_mps,
            cross_mps: self.cross_fraction * (self.cross * profile_mps),
            edge: envelope.edge,
        }
    }

    /// 0…1, against height above the reference altitude, m.
    fn gust_shape(&self, above_m: f64) -> f64 {
        let length_m = 2.0 * GUST_EDGE_M + self.gust_length_m;
        if !(0.0..=length_m).contains(&above_m) {
            return 0.0;
        }
        let from_edge_m = above_m.min(length_m - above_m).min(GUST_EDGE_M);
        0.5 * (1.0 - libm::cos(std::f64::consts::PI * from_edge_m / GUST_EDGE_M))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head() -> Wind {
        Wind::synthetic(&Vehicle::shipped().unwrap(), WindDirection::Head).unwrap()
    }

    #[test]
    fn the_profile_has_its_shear_gust_and_envelope() {
        let wind = head();
        // W_e(9500) = 27 + 0.75·7 = 32.25 m/s; 1 km below: 0.85·0.135·1000^0.7
        // = 14.447 m/s less (three roundings of numbers below 40).
        let expected = -(32.25 - 0.85 * 0.135 * 1000f64.powf(0.7));
        assert!((wind.at(8_500.0).along_mps - expected).abs() < 1e-12);
        // Calm where the shear has used the reference speed up, at 6.35 km.
        assert_eq!(wind.at(6_300.0).along_mps, 0.0);
        // In the plateau: envelope at 9.6 km (32.6) and 0.85·9 m/s of gust.
        assert!((wind.at(9_600.0).along_mps + 32.6 + 7.65).abs() < 1e-12);
        // Halfway up the edge, half of the gust.
        assert!((wind.at(9_515.0).along_mps + 32.3025 + 0.5 * 7.65).abs() < 1e-12);
        // Above the gust the envelope alone; its peak is 54 m/s at 16 km.
        assert_eq!(wind.at(16_000.0).along_mps, -54.0);
        assert!((wind.at(16_000.0).cross_mps + 0.35 * 54.0).abs() < 1e-12);
        assert_eq!(wind.at(31_000.0).edge, Edge::Above);
    }

    #[test]
    fn the_wind_is_continuous_and_within_its_bounds() {
        let wind = head();
        let mut last = wind.at(0.0).along_mps;
        for metre in 1..30_000 {
            let now = wind.at(f64::from(metre)).along_mps;
            // Steepest parts: the gust's edge, 7.65·π/60 = 0.40 m/s per m, and
            // the shear law's first metre, 0.115 m/s.
            assert!((now - last).abs() < 0.52, "at {metre} m");
            assert!((-54.0 - 7.65..=0.0).contains(&now));
            last = now;
        }
    }

    #[test]
    fn a_tailwind_mirrors_the_headwind() {
        let vehicle = Vehicle::shipped().unwrap();
        let tail = Wind::synthetic(&vehicle, WindDirection::Tail).unwrap();
        assert_eq!(tail.at(9_000.0).along_mps, -head().at(9_000.0).along_mps);
    }
}
