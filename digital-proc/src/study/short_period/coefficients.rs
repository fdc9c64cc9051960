//! From a frozen point to the settings of the short-period patches.
//!
//! The same numbers feed the machine (by block name, [`PitchSettings::settings`]),
//! the linearised loops and the reference integration, so that all three are
//! about one model. Yaw is the same plane as pitch with the lateral speed
//! counted positive to port.

use super::point::FrozenPoint;

/// Coefficients of one plane: `sub/stage-plane.toml` and its tip actuators.
///
/// z̈ = −thrust_pull θ − normal_pull α + control_pull (F_F + F_T), eq. (20);
/// θ̈ = aero_moment α + damping θ̇ + ftc_moment F_F + tvc_moment F_T + misalignment, eq. (21);
/// α = θ + ż/V + gust, eq. (22).
///
/// Departs from the paper, eq. (21): the damping term `M_q/I θ̇` is kept, which
/// the printed equation lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// (T − A)/m, m/s² per rad.
    pub thrust_pull: f64,
    /// L_α/m, m/s² per rad.
    pub normal_pull: f64,
    /// 1/m, 1/kg.
    pub control_pull: f64,
    /// 1/V, s/m.
    pub inverse_speed: f64,
    /// M_α/I, 1/s².
    pub aero_moment: f64,
    /// M_q/I, 1/s.
    pub damping: f64,
    /// l_f/I, 1/(kg m).
    pub ftc_moment: f64,
    /// l_t/I, 1/(kg m).
    pub tvc_moment: f64,
    /// 2 ζ_b ω_b, 1/s.
    pub bending_drag: f64,
    /// ω_b², 1/s².
    pub bending_spring: f64,
    /// φ_c/M_g, 1/kg.
    pub bending_drive: f64,
    /// λ_g, 1/m.
    pub gyro_slope: f64,
    /// λ_i, 1/m.
    pub imu_slope: f64,
    /// Gyro ω², 1/s².
    pub gyro_spring: f64,
    /// Gyro 2ζω, 1/s.
    pub gyro_drag: f64,
    /// T_T, s.
    pub tvc_lead: f64,
    /// K_T, N/rad.
    pub tvc_gain: f64,
    /// 1/τ_T, 1/s.
    pub tvc_bandwidth: f64,
    /// F_max, N.
    pub tvc_limit: f64,
    /// e_dz, rad.
    pub dead_zone: f64,
    /// T_F, s.
    pub ftc_lead: f64,
    /// Pole of the bending filter, 1/s.
    pub filter_pole: f64,
    /// K_F.
    pub ftc_gain: f64,
    /// F_δ, N/rad.
    pub tip_force: f64,
    /// Tip travel limit, rad.
    pub tip_travel: f64,
    /// Tip rate limit, rad/s.
    pub tip_rate: f64,
    /// 1/τ_F, 1/s.
    pub tip_bandwidth: f64,
    /// M_d/I, rad/s².
    pub misalignment: f64,
    /// Gust incidence, rad.
    pub gust: f64,
}

/// What disturbs a run, as fractions of the point's own figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Fraction of the three-sigma thrust misalignment.
    pub misalignment: f64,
    /// Fraction of the step gust.
    pub gust: f64,
    /// Fraction of the fin-cant moment.
    pub cant: f64,
}

impl Disturbance {
    /// An undisturbed run.
    pub const NONE: Disturbance = Disturbance { misalignment: 0.0, gust: 0.0, cant: 0.0 };
}

/// Settings of `pitch-loop.toml`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchSettings {
    /// The pitch plane.
    pub plane: Plane,
    /// Commanded attitude, rad.
    pub command_rad: f64,
}

/// Settings and initial conditions of `yaw-roll-loop.toml`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YawRollSettings {
    /// The yaw plane.
    pub plane: Plane,
    /// y_tip/I_xx, 1/(kg m).
    pub roll_moment: f64,
    /// L_p/I_xx, 1/s.
    pub roll_damping: f64,
    /// K_φ.
    pub roll_gain: f64,
    /// T_φ, s.
    pub roll_lead: f64,
    /// Fin-cant moment over I_xx, rad/s².
    pub cant: f64,
    /// Tips for roll only, thrust vector for yaw only.
    pub dedicated: bool,
    /// Initial offsets and rates.
    pub initial: YawRollInitial,
}

/// Initial conditions of a yaw–roll run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YawRollInitial {
    /// Yaw offset ψ, rad.
    pub yaw_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: f64,
    /// Roll offset φ, rad.
    pub roll_rad: f64,
    /// Roll rate, rad/s.
    pub roll_rate_radps: f64,
}

impl Plane {
    /// Coefficients of a point under a disturbance. Mass, inertia, speed and
    /// time constants of a frozen point are positive.
    pub fn new(point: &FrozenPoint, disturbance: &Disturbance) -> Plane {
        let inertia = point.inertia_kgm2;
        let bending = point.bending_frequency_radps;
        let gyro = point.gyro_frequency_radps;
        Plane {
            thrust_pull: (point.thrust_n - point.axial_force_n) / point.mass_kg,
            normal_pull: point.normal_force_slope_nprad / point.mass_kg,
            control_pull: 1.0 / point.mass_kg,
            inverse_speed: 1.0 / point.speed_mps,
            aero_moment: point.moment_slope_nmprad / inertia,
            damping: point.pitch_damping_nms / inertia,
            ftc_moment: point.tip_arm_m / inertia,
            tvc_moment: point.tvc_arm_m / inertia,
            bending_drag: 2.0 * point.bending_damping * bending,
            bending_spring: bending * bending,
            bending_drive: point.bending_displacement / point.bending_mass_kg,
            gyro_slope: point.gyro_slope_pm,
            imu_slope: point.imu_slope_pm,
            gyro_spring: gyro * gyro,
            gyro_drag: 2.0 * point.gyro_damping * gyro,
            tvc_lead: point.tvc_lead_s,
            tvc_gain: point.tvc_gain_nprad,
            tvc_bandwidth: 1.0 / point.tvc_time_constant_s,
            tvc_limit: point.tvc_limit_n,
            dead_zone: point.dead_zone_rad,
            ftc_lead: point.ftc_lead_s,
            filter_pole: point.filter_pole_radps,
            ftc_gain: point.ftc_gain,
            tip_force: point.tip_force_slope_nprad,
            tip_travel: point.tip_travel_rad,
            tip_rate: point.tip_rate_radps,
            tip_bandwidth: 1.0 / point.ftc_time_constant_s,
            misalignment: disturbance.misalignment * point.misalignment_moment_nm / inertia,
            gust: disturbance.gust * point.gust_mps * libm::sin(point.gamma_rad) / point.speed_mps,
        }
    }

    /// The plane with thrust vector control alone in yaw: no dead zone, its own gains.
    pub fn dedicated(self, point: &FrozenPoint) -> Plane {
        Plane {
            dead_zone: 0.0,
            tvc_gain: self.tvc_gain * point.dedicated_gain_factor,
            tvc_lead: point.dedicated_lead_s,
            ..self
        }
    }

    fn settings(&self) -> Vec<(&'static str, f64)> {
        vec![
            ("plane.thrust_pull", self.thrust_pull),
            ("plane.normal_pull", self.normal_pull),
            ("plane.control_pull", self.control_pull),
            ("plane.drift_angle", self.inverse_speed),
            ("plane.drift_slope", self.inverse_speed),
            ("plane.aero_moment", self.aero_moment),
            ("plane.damping_moment", self.damping),
            ("plane.fin_moment", self.ftc_moment),
            ("plane.tvc_moment", self.tvc_moment),
            ("plane.eta_drag", self.bending_drag),
            ("plane.eta_spring", self.bending_spring),
            ("plane.eta_drive", self.bending_drive),
            ("plane.gyro_pickup", self.gyro_slope),
            ("plane.imu_pickup", self.imu_slope),
            ("plane.gyro_spring", self.gyro_spring),
            ("plane.gyro_drag", self.gyro_drag),
            ("plane.tvc_lead", self.tvc_lead),
            ("plane.tvc_demand", self.tvc_gain),
            ("plane.tvc_slope", self.tvc_bandwidth),
            ("plane.tvc_limit", self.tvc_limit),
            ("plane.dead_zone_width", self.dead_zone),
            ("plane.fin_lead", self.ftc_lead),
            ("plane.filter_slope", self.filter_pole),
            ("plane.fin_demand", self.ftc_gain),
            ("plane.misalignment", self.misalignment),
            ("plane.gust", self.gust),
            ("tip_travel", self.tip_travel),
            ("tip_rate", self.tip_rate),
            ("tip_bandwidth", self.tip_bandwidth),
        ]
    }
}

impl PitchSettings {
    /// Settings of a pitch run at a point.
    pub fn new(point: &FrozenPoint, disturbance: &Disturbance, command_rad: f64) -> PitchSettings {
        PitchSettings { plane: Plane::new(point, disturbance), command_rad }
    }

    /// Value of every coefficient unit and converter of the patch, by block name.
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        let mut all = self.plane.settings();
        all.push(("fin_force", self.plane.tip_force));
        all.push(("theta_c", self.command_rad));
        all
    }
}

impl YawRollSettings {
    /// Settings of a yaw–roll run at a point, tips shared or dedicated to roll.
    pub fn new(
        point: &FrozenPoint,
        disturbance: &Disturbance,
        initial: YawRollInitial,
        dedicated: bool,
    ) -> YawRollSettings {
        let shared = Plane::new(point, disturbance);
        YawRollSettings {
            plane: if dedicated { shared.dedicated(point) } else { shared },
            roll_moment: point.tip_roll_arm_m / point.roll_inertia_kgm2,
            roll_damping: point.roll_damping_nms / point.roll_inertia_kgm2,
            roll_gain: point.roll_gain,
            roll_lead: point.roll_lead_s,
            cant: disturbance.cant * point.cant_moment_nm / point.roll_inertia_kgm2,
            dedicated,
            initial,
        }
    }

    /// Value of every coefficient unit, converter and control line of the patch, by block name.
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        let mut all = self.plane.settings();
        all.extend([
            ("psi_c", 0.0),
            ("yaw_fin_force", self.plane.tip_force),
            ("roll_fin_force", self.plane.tip_force),
            ("roll_tip_moment", self.roll_moment),
            ("roll_damping", self.roll_damping),
            ("roll_demand", self.roll_gain),
            ("roll_lead", self.roll_lead),
            ("roll_gyro_spring", self.plane.gyro_spring),
            ("roll_gyro_drag", self.plane.gyro_drag),
            ("cant", self.cant),
            ("dedicated", f64::from(u8::from(self.dedicated))),
        ]);
        all
    }

    /// Initial conditions by integrator name.
    pub fn initial_conditions(&self) -> [(&'static str, f64); 4] {
        [
            ("plane.theta", self.initial.yaw_rad),
            ("plane.theta_rate", self.initial.yaw_rate_radps),
            ("roll_angle", self.initial.roll_rad),
            ("roll_rate", self.initial.roll_rate_radps),
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::study::short_period::point::tests::numbered;
    use crate::study::short_period::response::{PITCH_CHANNELS, YAW_ROLL_CHANNELS};

    const PITCH: &str = include_str!("../../../../patch-files/pitch-loop.toml");
    const YAW_ROLL: &str = include_str!("../../../../patch-files/yaw-roll-loop.toml");
    const PLANE: &str = include_str!("../../../../patch-files/sub/stage-plane.toml");

    const INITIAL: YawRollInitial = YawRollInitial {
        yaw_rad: 0.04,
        yaw_rate_radps: 0.01,
        roll_rad: 0.35,
        roll_rate_radps: 0.02,
    };

    /// Kind and channel (or line) of every block, the plane's under its prefix.
    fn blocks(text: &str) -> BTreeMap<String, (String, Option<i64>)> {
        let mut all = BTreeMap::new();
        for (text, prefix) in [(text, ""), (PLANE, "plane.")] {
            let table: toml::Table = toml::from_str(text).unwrap();
            for (name, block) in table["blocks"].as_table().unwrap() {
                let number = block.get("channel").or(block.get("line"));
                all.insert(
                    format!("{prefix}{name}"),
                    (
                        block["kind"].as_str().unwrap().to_owned(),
                        number.and_then(toml::Value::as_integer),
                    ),
                );
            }
        }
        all
    }

    fn assert_settings_match(patch: &str, settings: &[(&'static str, f64)]) {
        let blocks = blocks(patch);
        let wanted: BTreeSet<&str> = blocks
            .iter()
            .filter(|(_, (kind, _))| matches!(kind.as_str(), "dcu" | "dac" | "control"))
            .map(|(name, _)| name.as_str())
            .collect();
        let set: BTreeSet<&str> = settings.iter().map(|(name, _)| *name).collect();
        assert_eq!(wanted, set);
        assert_eq!(set.len(), settings.len(), "a block is set twice");
        for kind in ["dcu", "dac", "adc"] {
            let mut channels: Vec<_> = blocks
                .values()
                .filter(|(k, _)| k == kind)
                .map(|(_, number)| number.unwrap())
                .collect();
            channels.sort_unstable();
            let expected: Vec<_> = (0..channels.len() as i64).collect();
            assert_eq!(channels, expected, "{kind} channels");
        }
    }

    fn assert_channels_match(patch: &str, channels: &[&str]) {
        let blocks = blocks(patch);
        for (number, name) in channels.iter().enumerate() {
            let expected = ("adc".to_owned(), Some(number as i64));
            assert_eq!(blocks.get(*name), Some(&expected), "{name}");
        }
    }

    #[test]
    fn every_coefficient_of_the_patches_is_set_once() {
        let point = numbered();
        let pitch = PitchSettings::new(&point, &Disturbance::NONE, 0.035);
        assert_settings_match(PITCH, &pitch.settings());
        assert_channels_match(PITCH, &PITCH_CHANNELS.map(|c| c.adc));
        let yaw_roll = YawRollSettings::new(&point, &Disturbance::NONE, INITIAL, true);
        assert_settings_match(YAW_ROLL, &yaw_roll.settings());
        assert_channels_match(YAW_ROLL, &YAW_ROLL_CHANNELS.map(|c| c.adc));
        let blocks = blocks(YAW_ROLL);
        for (name, _) in yaw_roll.initial_conditions() {
            assert_eq!(blocks[name].0, "integrator", "{name}");
        }
    }

    #[test]
    fn dedicated_allocation_opens_the_dead_zone_and_changes_the_lead() {
        let point = numbered();
        let plane =
            |dedicated| YawRollSettings::new(&point, &Disturbance::NONE, INITIAL, dedicated).plane;
        let (shared, alone) = (plane(false), plane(true));
        assert_eq!(alone.dead_zone, 0.0);
        assert_eq!(alone.tvc_gain, 0.9 * shared.tvc_gain);
        assert_eq!(alone.tvc_lead, 0.55);
        assert_eq!(alone.aero_moment, shared.aero_moment);
    }

    #[test]
    fn the_gust_is_seen_normal_to_the_path() {
        let point = numbered();
        let gust = Disturbance { misalignment: 0.0, gust: 0.5, cant: 0.0 };
        let plane = Plane::new(&point, &gust);
        assert_eq!(plane.gust, 0.5 * 12.0 * 1.2_f64.sin() / 655.0);
        assert_eq!(plane.misalignment, 0.0);
    }
}
