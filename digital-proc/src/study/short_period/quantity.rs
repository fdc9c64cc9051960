//! The quantities of a frozen point by name, as a study file writes them.

use super::point::FrozenPoint;
use desk::reader::Range;

/// One quantity that a condition may multiply or replace.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Name in the study file.
    pub name: &'static str,
    /// Unit in which the study file states it.
    pub unit: &'static str,
    /// SI value of one such unit.
    pub unit_in_si: f64,
    /// Which values make sense.
    pub range: Range,
    /// Where it lies in the point.
    field: fn(&mut FrozenPoint) -> &mut f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

macro_rules! quantities {
    ($($name:literal $unit:literal $scale:expr => $field:ident $range:ident;)*) => {
        /// Every quantity, grouped as in [`FrozenPoint`].
        pub const QUANTITIES: &[Quantity] = &[
            $(Quantity {
                name: $name,
                unit: $unit,
                unit_in_si: $scale,
                range: Range::$range,
                field: |point| &mut point.$field,
            },)*
        ];
    };
}

quantities! {
    "speed" "m/s" 1.0 => speed_mps Positive;
    "flight-path-angle" "deg" DEGREE => gamma_rad Any;
    "mass" "kg" 1.0 => mass_kg Positive;
    "inertia" "kg m2" 1.0 => inertia_kgm2 Positive;
    "roll-inertia" "kg m2" 1.0 => roll_inertia_kgm2 Positive;
    "thrust" "N" 1.0 => thrust_n Any;
    "axial-force" "N" 1.0 => axial_force_n Any;
    "normal-force-slope" "N/rad" 1.0 => normal_force_slope_nprad Any;
    "moment-slope" "N m/rad" 1.0 => moment_slope_nmprad Any;
    "pitch-damping" "N m s" 1.0 => pitch_damping_nms Any;
    "tip-force-slope" "N/rad" 1.0 => tip_force_slope_nprad Any;
    "tip-arm" "m" 1.0 => tip_arm_m Any;
    "tvc-arm" "m" 1.0 => tvc_arm_m Any;
    "tip-roll-arm" "m" 1.0 => tip_roll_arm_m Any;
    "roll-damping" "N m s" 1.0 => roll_damping_nms Any;
    "cant-moment" "N m" 1.0 => cant_moment_nm Any;
    "misalignment-moment" "N m" 1.0 => misalignment_moment_nm Any;
    "gust" "m/s" 1.0 => gust_mps Any;
    "ftc-time-constant" "s" 1.0 => ftc_time_constant_s Positive;
    "tip-travel" "deg" DEGREE => tip_travel_rad NotNegative;
    "tip-rate" "deg/s" DEGREE => tip_rate_radps NotNegative;
    "tvc-time-constant" "s" 1.0 => tvc_time_constant_s Positive;
    "tvc-limit" "N" 1.0 => tvc_limit_n NotNegative;
    "ftc-gain" "deg/deg" 1.0 => ftc_gain Any;
    "ftc-lead" "s" 1.0 => ftc_lead_s Any;
    "tvc-gain" "N/deg" 1.0 / DEGREE => tvc_gain_nprad Any;
    "tvc-lead" "s" 1.0 => tvc_lead_s Any;
    "dead-zone" "deg" DEGREE => dead_zone_rad NotNegative;
    "roll-gain" "deg/deg" 1.0 => roll_gain Any;
    "roll-lead" "s" 1.0 => roll_lead_s Any;
    "dedicated-gain-factor" "1" 1.0 => dedicated_gain_factor Any;
    "dedicated-lead" "s" 1.0 => dedicated_lead_s Any;
    "bending-frequency" "rad/s" 1.0 => bending_frequency_radps Positive;
    "bending-damping" "1" 1.0 => bending_damping Any;
    "bending-mass" "kg" 1.0 => bending_mass_kg Positive;
    "bending-displacement" "1" 1.0 => bending_displacement Any;
    "gyro-slope" "1/m" 1.0 => gyro_slope_pm Any;
    "imu-slope" "1/m" 1.0 => imu_slope_pm Any;
    "gyro-frequency" "rad/s" 1.0 => gyro_frequency_radps Any;
    "gyro-damping" "1" 1.0 => gyro_damping Any;
    "filter-pole" "rad/s" 1.0 => filter_pole_radps Any;
}

impl Quantity {
    /// All of them, as words of a file.
    pub fn by_name() -> Vec<(&'static str, &'static Quantity)> {
        QUANTITIES.iter().map(|q| (q.name, q)).collect()
    }

    /// Its value at a point, SI.
    pub fn get(&self, point: &FrozenPoint) -> f64 {
        let mut copy = *point;
        *(self.field)(&mut copy)
    }

    /// Sets it, SI.
    pub fn set(&self, point: &mut FrozenPoint, value_si: f64) {
        *(self.field)(point) = value_si;
    }
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A macro line that names the wrong field would alias two quantities.
    #[test]
    fn every_quantity_is_a_field_of_its_own() {
        let mut point = super::super::point::tests::numbered();
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            quantity.set(&mut point, 1000.0 + index as f64);
        }
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            assert_eq!(quantity.get(&point), 1000.0 + index as f64, "{}", quantity.name);
        }
    }
}
