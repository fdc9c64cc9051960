//! What is frozen at one trajectory point: everything a condition may change.
//!
//! Physical quantities, before they are divided by inertias and turned into
//! coefficients, so that a condition says "rate-gyro slope" or "thrust-vector
//! time constant" and not "coefficient 18". SI units, radians, seconds.

use vehicle::Vehicle;
use vehicle::airframe::DAMPING_AIRSPEED_FLOOR_MPS;
use vehicle::gain_schedule::LoopGains;
use vehicle::slice::SlicePoint;

/// One trajectory point, frozen, with the loop gains in force there.
///
/// Symbols are those of the paper's eqs. (20)–(25); control moments and
/// aerodynamic moments are positive nose up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrozenPoint {
    /// Flight time, s.
    pub time_s: f64,
    /// Mach number.
    pub mach: f64,
    /// Dynamic pressure, Pa.
    pub q_pa: f64,
    /// Airspeed V, m/s; never below 30 m/s, so that incidence stays defined on the pad.
    pub speed_mps: f64,
    /// Flight-path angle γ, rad.
    pub gamma_rad: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Pitch (and yaw) moment of inertia, kg m².
    pub inertia_kgm2: f64,
    /// Roll moment of inertia, kg m².
    pub roll_inertia_kgm2: f64,
    /// Thrust T, N.
    pub thrust_n: f64,
    /// Axial aerodynamic force A, N.
    pub axial_force_n: f64,
    /// Normal-force slope `L_α`, N/rad.
    pub normal_force_slope_nprad: f64,
    /// Aerodynamic moment slope `M_α`, N m/rad.
    pub moment_slope_nmprad: f64,
    /// Pitch damping `M_q`, N m s (negative damps).
    pub pitch_damping_nms: f64,
    /// Force slope of a tip pair `F_δ`, N/rad.
    pub tip_force_slope_nprad: f64,
    /// Arm of the fin tips `l_f`, m.
    pub tip_arm_m: f64,
    /// Arm of the injection plane `l_t`, m.
    pub tvc_arm_m: f64,
    /// Arm of the fin tips about the roll axis, m.
    pub tip_roll_arm_m: f64,
    /// Roll damping `L_p`, N m s (negative damps).
    pub roll_damping_nms: f64,
    /// Rolling moment of the fin cant, N m.
    pub cant_moment_nm: f64,
    /// Thrust-misalignment moment at three sigma, N m.
    pub misalignment_moment_nm: f64,
    /// Step gust, m/s, horizontal.
    pub gust_mps: f64,
    /// Tip time constant `τ_F`, s.
    pub ftc_time_constant_s: f64,
    /// Tip travel limit, rad.
    pub tip_travel_rad: f64,
    /// Tip rate limit, rad/s.
    pub tip_rate_radps: f64,
    /// Thrust-vector time constant `τ_T`, s.
    pub tvc_time_constant_s: f64,
    /// Greatest thrust-vector force `F_max`, N.
    pub tvc_limit_n: f64,
    /// Fin-tip gain `K_F`, rad of tip per rad of error.
    pub ftc_gain: f64,
    /// Fin-tip rate gain `T_F`, s.
    pub ftc_lead_s: f64,
    /// Thrust-vector gain `K_T`, N/rad beyond the dead zone.
    pub tvc_gain_nprad: f64,
    /// Thrust-vector rate gain `T_T`, s.
    pub tvc_lead_s: f64,
    /// Half width of the thrust-vector dead zone, rad.
    pub dead_zone_rad: f64,
    /// Roll gain `K_φ`, rad of tip per rad of roll.
    pub roll_gain: f64,
    /// Roll rate gain `T_φ`, s.
    pub roll_lead_s: f64,
    /// Factor on `K_T` when thrust vector control alone does yaw.
    pub dedicated_gain_factor: f64,
    /// `T_T` when thrust vector control alone does yaw, s.
    pub dedicated_lead_s: f64,
    /// First bending frequency `ω_b`, rad/s.
    pub bending_frequency_radps: f64,
    /// First bending damping ratio `ζ_b`.
    pub bending_damping: f64,
    /// Generalised mass, kg.
    pub bending_mass_kg: f64,
    /// Mode displacement at the control forces.
    pub bending_displacement: f64,
    /// Mode slope at the rate gyro `λ_g`, 1/m.
    pub gyro_slope_pm: f64,
    /// Mode slope at the attitude reference `λ_i`, 1/m.
    pub imu_slope_pm: f64,
    /// Gyro natural frequency, rad/s.
    pub gyro_frequency_radps: f64,
    /// Gyro damping ratio.
    pub gyro_damping: f64,
    /// Pole of the bending filter, rad/s.
    pub filter_pole_radps: f64,
}

impl FrozenPoint {
    /// Freezes a point of the nominal flight with the given loop gains.
    pub fn new(vehicle: &Vehicle, slice: &SlicePoint, gains: &LoopGains) -> FrozenPoint {
        let data = vehicle.data();
        let frame = &slice.airframe;
        let bending = &slice.bending;
        FrozenPoint {
            time_s: slice.time_s,
            mach: frame.mach,
            q_pa: frame.dynamic_pressure_pa,
            speed_mps: frame.airspeed_mps.max(DAMPING_AIRSPEED_FLOOR_MPS),
            gamma_rad: slice.trajectory.path_angle_rad,
            mass_kg: frame.mass_kg,
            inertia_kgm2: frame.pitch_inertia_kgm2,
            roll_inertia_kgm2: frame.roll_inertia_kgm2,
            thrust_n: frame.thrust_n,
            axial_force_n: frame.axial_force_n,
            normal_force_slope_nprad: frame.normal_force_slope_nprad,
            moment_slope_nmprad: frame.moment_slope_nmprad,
            pitch_damping_nms: frame.rate_damping_nms,
            tip_force_slope_nprad: frame.tip_pair_force_slope_nprad,
            tip_arm_m: frame.tip_arm_m,
            tvc_arm_m: frame.tvc_arm_m,
            tip_roll_arm_m: data.geometry.tip_y_m,
            roll_damping_nms: frame.roll_damping_nms,
            cant_moment_nm: frame.fin_cant_moment_nm,
            misalignment_moment_nm: frame.misalignment_moment_nm,
            gust_mps: data.disturbance.gust_step_mps,
            ftc_time_constant_s: data.ftc.time_constant_s,
            tip_travel_rad: data.ftc.delta_max_deg.to_radians(),
            tip_rate_radps: data.ftc.rate_max_dps.to_radians(),
            tvc_time_constant_s: data.tvc.time_constant_s,
            tvc_limit_n: data.tvc.force_max_n,
            ftc_gain: gains.ftc_gain,
            ftc_lead_s: gains.ftc_lead_s,
            tvc_gain_nprad: gains.tvc_gain_nprad,
            tvc_lead_s: gains.tvc_lead_s,
            dead_zone_rad: gains.dead_zone_rad,
            roll_gain: slice.settings.roll_gain,
            roll_lead_s: slice.settings.roll_lead_s,
            dedicated_gain_factor: data.gains.decoupled_yaw_gain_factor,
            dedicated_lead_s: data.gains.decoupled_yaw_lead_s,
            bending_frequency_radps: bending.natural_frequency_radps,
            bending_damping: bending.damping_ratio,
            bending_mass_kg: bending.generalised_mass_kg,
            bending_displacement: bending.displacement_at_control,
            gyro_slope_pm: bending.gyro_slope_pm,
            imu_slope_pm: bending.imu_slope_pm,
            gyro_frequency_radps: data.gyro.natural_frequency_radps,
            gyro_damping: data.gyro.damping_ratio,
            filter_pole_radps: data.bending.filter_corner_radps,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::FrozenPoint;

    /// The stage near maximum dynamic pressure in round numbers.
    pub(crate) fn numbered() -> FrozenPoint {
        FrozenPoint {
            time_s: 32.5,
            mach: 2.2,
            q_pa: 95e3,
            speed_mps: 655.0,
            gamma_rad: 1.2,
            mass_kg: 11_284.0,
            inertia_kgm2: 388_900.0,
            roll_inertia_kgm2: 1_771.0,
            thrust_n: 433e3,
            axial_force_n: 38e3,
            normal_force_slope_nprad: 330e3,
            moment_slope_nmprad: 330e3,
            pitch_damping_nms: -35e3,
            tip_force_slope_nprad: 22e3,
            tip_arm_m: 10.75,
            tvc_arm_m: 10.65,
            tip_roll_arm_m: 1.05,
            roll_damping_nms: -150.0,
            cant_moment_nm: 130.0,
            misalignment_moment_nm: 25e3,
            gust_mps: 12.0,
            ftc_time_constant_s: 0.05,
            tip_travel_rad: 0.1745,
            tip_rate_radps: 1.745,
            tvc_time_constant_s: 0.1,
            tvc_limit_n: 15e3,
            ftc_gain: 7.4,
            ftc_lead_s: 0.74,
            tvc_gain_nprad: 6.3e3 * 57.3,
            tvc_lead_s: 0.15,
            dead_zone_rad: 0.0236,
            roll_gain: 5.0,
            roll_lead_s: 0.25,
            dedicated_gain_factor: 0.9,
            dedicated_lead_s: 0.55,
            bending_frequency_radps: 28.4,
            bending_damping: 0.01,
            bending_mass_kg: 2690.0,
            bending_displacement: 0.9,
            gyro_slope_pm: -0.03,
            imu_slope_pm: -0.1,
            gyro_frequency_radps: 100.0,
            gyro_damping: 0.7,
            filter_pole_radps: 30.0,
        }
    }
}
