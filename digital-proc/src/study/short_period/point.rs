//! What is frozen at one trajectory point: everything a condition may change.
//!
//! Physical quantities, before they are divided by inertias and turned into
//! coefficients, so that a condition says "rate-gyro slope" or "thrust-vector
//! time constant" and not "coefficient 18". SI units, radians, seconds.

use desk::reader::Range;
use vehicle::Vehicle;
use vehicle::airframe::DAMPING_AIRSPEED_FLOOR_MPS;
use vehicle::gain_schedule::LoopGains;
use vehicle::slice::SlicePoint;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A line a field: its name, its value, and, if a study file may change it, the name and unit
/// there, the SI value of one such unit, and its range.
macro_rules! frozen {
    (
        $data:ident, $slice:ident, $gains:ident;
        $(
            $(#[$doc:meta])* $field:ident = $value:expr
            $(, $name:literal $unit:literal $scale:expr, $range:ident)?;
        )*
    ) => {
        /// One trajectory point, frozen, with the loop gains in force there.
        ///
        /// Symbols are those of the paper's eqs. (20)–(25); control moments and
        /// aerodynamic moments are positive nose up.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct FrozenPoint { $($(#[$doc])* pub $field: f64,)* }

        impl FrozenPoint {
            /// Freezes a point of the nominal flight with the given loop gains.
            pub fn new(vehicle: &Vehicle, $slice: &SlicePoint, $gains: &LoopGains) -> FrozenPoint {
                let $data = vehicle.data();
                FrozenPoint { $($field: $value,)* }
            }
        }

        /// Every quantity that a study file may change.
        pub const QUANTITIES: &[Quantity] = &[$($(
            Quantity {
                name: $name,
                unit: $unit,
                unit_in_si: $scale,
                range: Range::$range,
                field: |point| &mut point.$field,
            },
        )?)*];
    };
}

frozen! { data, slice, gains;
    /// Flight time, s.
    time_s = slice.time_s;
    /// Mach number.
    mach = slice.airframe.mach;
    /// Dynamic pressure, Pa.
    q_pa = slice.airframe.dynamic_pressure_pa;
    /// Airspeed V, m/s; never below 30 m/s, so that incidence stays defined on the pad.
    speed_mps = slice.airframe.airspeed_mps.max(DAMPING_AIRSPEED_FLOOR_MPS), "speed" "m/s" 1.0, Positive;
    /// Flight-path angle γ, rad.
    gamma_rad = slice.trajectory.path_angle_rad, "flight-path-angle" "deg" DEGREE, Any;
    /// Mass, kg.
    mass_kg = slice.airframe.mass_kg, "mass" "kg" 1.0, Positive;
    /// Pitch (and yaw) moment of inertia, kg m².
    inertia_kgm2 = slice.airframe.pitch_inertia_kgm2, "inertia" "kg m2" 1.0, Positive;
    /// Roll moment of inertia, kg m².
    roll_inertia_kgm2 = slice.airframe.roll_inertia_kgm2, "roll-inertia" "kg m2" 1.0, Positive;
    /// Thrust T, N.
    thrust_n = slice.airframe.thrust_n, "thrust" "N" 1.0, Any;
    /// Axial aerodynamic force A, N.
    axial_force_n = slice.airframe.axial_force_n, "axial-force" "N" 1.0, Any;
    /// Normal-force slope `L_α`, N/rad.
    normal_force_slope_nprad = slice.airframe.normal_force_slope_nprad, "normal-force-slope" "N/rad" 1.0, Any;
    /// Aerodynamic moment slope `M_α`, N m/rad.
    moment_slope_nmprad = slice.airframe.moment_slope_nmprad, "moment-slope" "N m/rad" 1.0, Any;
    /// Pitch damping `M_q`, N m s (negative damps).
    pitch_damping_nms = slice.airframe.rate_damping_nms, "pitch-damping" "N m s" 1.0, Any;
    /// Force slope of a tip pair `F_δ`, N/rad.
    tip_force_slope_nprad = slice.airframe.tip_pair_force_slope_nprad, "tip-force-slope" "N/rad" 1.0, Any;
    /// Arm of the fin tips `l_f`, m.
    tip_arm_m = slice.airframe.tip_arm_m, "tip-arm" "m" 1.0, Any;
    /// Arm of the injection plane `l_t`, m.
    tvc_arm_m = slice.airframe.tvc_arm_m, "tvc-arm" "m" 1.0, Any;
    /// Arm of the fin tips about the roll axis, m.
    tip_roll_arm_m = data.geometry.tip_y_m, "tip-roll-arm" "m" 1.0, Any;
    /// Roll damping `L_p`, N m s (negative damps).
    roll_damping_nms = slice.airframe.roll_damping_nms, "roll-damping" "N m s" 1.0, Any;
    /// Rolling moment of the fin cant, N m.
    cant_moment_nm = slice.airframe.fin_cant_moment_nm, "cant-moment" "N m" 1.0, Any;
    /// Thrust-misalignment moment at three sigma, N m.
    misalignment_moment_nm = slice.airframe.misalignment_moment_nm, "misalignment-moment" "N m" 1.0, Any;
    /// Step gust, m/s, horizontal.
    gust_mps = data.disturbance.gust_step_mps, "gust" "m/s" 1.0, Any;
    /// Tip time constant `τ_F`, s.
    ftc_time_constant_s = data.ftc.time_constant_s, "ftc-time-constant" "s" 1.0, Positive;
    /// Tip travel limit, rad.
    tip_travel_rad = data.ftc.delta_max_deg.to_radians(), "tip-travel" "deg" DEGREE, NotNegative;
    /// Tip rate limit, rad/s.
    tip_rate_radps = data.ftc.rate_max_dps.to_radians(), "tip-rate" "deg/s" DEGREE, NotNegative;
    /// Thrust-vector time constant `τ_T`, s.
    tvc_time_constant_s = data.tvc.time_constant_s, "tvc-time-constant" "s" 1.0, Positive;
    /// Greatest thrust-vector force `F_max`, N.
    tvc_limit_n = data.tvc.force_max_n, "tvc-limit" "N" 1.0, NotNegative;
    /// Fin-tip gain `K_F`, rad of tip per rad of error.
    ftc_gain = gains.ftc_gain, "ftc-gain" "deg/deg" 1.0, Any;
    /// Fin-tip rate gain `T_F`, s.
    ftc_lead_s = gains.ftc_lead_s, "ftc-lead" "s" 1.0, Any;
    /// Thrust-vector gain `K_T`, N/rad beyond the dead zone.
    tvc_gain_nprad = gains.tvc_gain_nprad, "tvc-gain" "N/deg" 1.0 / DEGREE, Any;
    /// Thrust-vector rate gain `T_T`, s.
    tvc_lead_s = gains.tvc_lead_s, "tvc-lead" "s" 1.0, Any;
    /// Half width of the thrust-vector dead zone while roll asks nothing of the tips, rad.
    dead_zone_rad = gains.dead_zone_rad, "dead-zone" "deg" DEGREE, NotNegative;
    /// By how much it shrinks in yaw for each rad of tip that roll has taken.
    dead_zone_yield = gains.dead_zone_yield, "dead-zone-yield" "deg/deg" 1.0, NotNegative;
    /// Roll gain `K_φ`, rad of tip per rad of roll.
    roll_gain = slice.settings.roll_gain, "roll-gain" "deg/deg" 1.0, Any;
    /// Roll rate gain `T_φ`, s.
    roll_lead_s = slice.settings.roll_lead_s, "roll-lead" "s" 1.0, Any;
    /// Factor on `K_T` when thrust vector control alone does yaw.
    dedicated_gain_factor = data.gains.decoupled_yaw_gain_factor, "dedicated-gain-factor" "1" 1.0, Any;
    /// `T_T` when thrust vector control alone does yaw, s.
    dedicated_lead_s = data.gains.decoupled_yaw_lead_s, "dedicated-lead" "s" 1.0, Any;
    /// First bending frequency `ω_b`, rad/s.
    bending_frequency_radps = slice.bending.natural_frequency_radps, "bending-frequency" "rad/s" 1.0, Positive;
    /// First bending damping ratio `ζ_b`.
    bending_damping = slice.bending.damping_ratio, "bending-damping" "1" 1.0, Any;
    /// Generalised mass, kg.
    bending_mass_kg = slice.bending.generalised_mass_kg, "bending-mass" "kg" 1.0, Positive;
    /// Mode displacement at the control forces.
    bending_displacement = slice.bending.displacement_at_control, "bending-displacement" "1" 1.0, Any;
    /// Mode slope at the rate gyro `λ_g`, 1/m.
    gyro_slope_pm = slice.bending.gyro_slope_pm, "gyro-slope" "1/m" 1.0, Any;
    /// Mode slope at the attitude reference `λ_i`, 1/m.
    imu_slope_pm = slice.bending.imu_slope_pm, "imu-slope" "1/m" 1.0, Any;
    /// Gyro natural frequency, rad/s.
    gyro_frequency_radps = data.gyro.natural_frequency_radps, "gyro-frequency" "rad/s" 1.0, Any;
    /// Gyro damping ratio.
    gyro_damping = data.gyro.damping_ratio, "gyro-damping" "1" 1.0, Any;
    /// Pole of the bending filter, rad/s.
    filter_pole_radps = data.bending.filter_corner_radps, "filter-pole" "rad/s" 1.0, Any;
}

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
pub(crate) mod tests {
    use super::{FrozenPoint, QUANTITIES};
    use vehicle::{Vehicle, slice};

    /// The shipped stage frozen at a time.
    pub(crate) fn frozen(time_s: f64) -> FrozenPoint {
        let vehicle = Vehicle::shipped().unwrap();
        let point = slice::points(&vehicle, &[("", time_s)]).unwrap().remove(0);
        FrozenPoint::new(&vehicle, &point, &point.settings.gains)
    }

    /// A macro line that names the wrong field would alias two quantities.
    #[test]
    fn every_quantity_is_a_field_of_its_own() {
        let mut point = frozen(32.5);
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            quantity.set(&mut point, 1000.0 + index as f64);
        }
        for (index, quantity) in QUANTITIES.iter().enumerate() {
            assert_eq!(quantity.get(&point), 1000.0 + index as f64, "{}", quantity.name);
        }
    }
}
