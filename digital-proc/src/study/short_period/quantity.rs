//! The quantities of a frozen point by name, as a study file writes them.

use super::point::FrozenPoint;

/// One quantity that a condition may multiply or replace.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Name in the study file.
    pub name: &'static str,
    /// Unit in which the study file states it.
    pub unit: &'static str,
    /// SI value of one such unit.
    pub unit_in_si: f64,
    /// Where it lies in the point.
    field: fn(&mut FrozenPoint) -> &mut f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

macro_rules! quantities {
    ($($name:literal $unit:literal $scale:expr => $field:ident;)*) => {
        /// Every quantity, grouped as in [`FrozenPoint`].
        pub const QUANTITIES: &[Quantity] = &[
            $(Quantity {
                name: $name,
                unit: $unit,
                unit_in_si: $scale,
                field: |point| &mut point.$field,
            },)*
        ];
    };
}

quantities! {
    "speed" "m/s" 1.0 => speed_mps;
    "flight-path-angle" "deg" DEGREE => gamma_rad;
    "mass" "kg" 1.0 => mass_kg;
    "inertia" "kg m2" 1.0 => inertia_kgm2;
    "roll-inertia" "kg m2" 1.0 => roll_inertia_kgm2;
    "thrust" "N" 1.0 => thrust_n;
    "axial-force" "N" 1.0 => axial_force_n;
    "normal-force-slope" "N/rad" 1.0 => normal_force_slope_nprad;
    "moment-slope" "N m/rad" 1.0 => moment_slope_nmprad;
    "pitch-damping" "N m s" 1.0 => pitch_damping_nms;
    "tip-force-slope" "N/rad" 1.0 => tip_force_slope_nprad;
    "tip-arm" "m" 1.0 => tip_arm_m;
    "tvc-arm" "m" 1.0 => tvc_arm_m;
    "tip-roll-arm" "m" 1.0 => tip_roll_arm_m;
    "roll-damping" "N m s" 1.0 => roll_damping_nms;
    "cant-moment" "N m" 1.0 => cant_moment_nm;
    "misalignment-moment" "N m" 1.0 => misalignment_moment_nm;
    "gust" "m/s" 1.0 => gust_mps;
    "ftc-time-constant" "s" 1.0 => ftc_time_constant_s;
    "tip-travel" "deg" DEGREE => tip_travel_rad;
    "tip-rate" "deg/s" DEGREE => tip_rate_radps;
    "tvc-time-constant" "s" 1.0 => tvc_time_constant_s;
    "tvc-limit" "N" 1.0 => tvc_limit_n;
    "ftc-gain" "deg/deg" 1.0 => ftc_gain;
    "ftc-lead" "s" 1.0 => ftc_lead_s;
    "tvc-gain" "N/deg" 1.0 / DEGREE => tvc_gain_nprad;
    "tvc-lead" "s" 1.0 => tvc_lead_s;
    "dead-zone" "deg" DEGREE => dead_zone_rad;
    "roll-gain" "deg/deg" 1.0 => roll_gain;
    "roll-lead" "s" 1.0 => roll_lead_s;
    "dedicated-gain-factor" "1" 1.0 => dedicated_gain_factor;
    "dedicated-lead" "s" 1.0 => dedicated_lead_s;
    "bending-frequency" "rad/s" 1.0 => bending_frequency_radps;
    "bending-damping" "1" 1.0 => bending_damping;
    "bending-mass" "kg" 1.0 => bending_mass_kg;
    "bending-displacement" "1" 1.0 => bending_displacement;
    "gyro-slope" "1/m" 1.0 => gyro_slope_pm;
    "imu-slope" "1/m" 1.0 => imu_slope_pm;
    "gyro-frequency" "rad/s" 1.0 => gyro_frequency_radps;
    "gyro-damping" "1" 1.0 => gyro_damping;
    "filter-pole" "rad/s" 1.0 => filter_pole_radps;
}

impl Quantity {
    /// Finds a quantity by its name in the study file.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Quantity> {
        QUANTITIES.iter().find(|q| q.name == name)
    }

    /// Its value at a point, SI.
    #[must_use]
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
