//! From a frozen point to the settings of the short-period patches.
//!
//! The same numbers feed the machine (by block name, [`Settings::values`]), the linearised
//! loops and the reference integration, so that all three are about one model. Yaw is the
//! same plane as pitch with the lateral speed counted positive to port.

use super::higher_modes::{self, HIGHER, HigherMode};
use super::point::FrozenPoint;

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

/// A line a coefficient: symbol and unit, name, the blocks that hold it, its value.
macro_rules! plane {
    ($point:ident, $disturbance:ident; $($(#[$doc:meta])* $field:ident [$($block:literal),*] $value:expr;)*) => {
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
            $($(#[$doc])* pub $field: f64,)*
            /// Second and third bending mode, where there are more than one.
            pub higher: Option<[HigherMode; HIGHER]>,
        }

        impl Plane {
            /// Coefficients of a point under a disturbance. Mass, inertia, speed and
            /// time constants of a frozen point are positive.
            pub fn new($point: &FrozenPoint, $disturbance: &Disturbance) -> Plane {
                Plane { $($field: $value,)* higher: None }
            }

            /// Every coefficient with the blocks that hold it.
            pub(super) fn each(&mut self) -> Vec<(&'static [&'static str], &mut f64)> {
                vec![$((&[$($block),*][..], &mut self.$field)),*]
            }

            fn values(&self) -> Vec<(&'static str, f64)> {
                vec![$($(($block, self.$field),)*)*]
            }
        }
    };
}

plane! { p, of;
    /// (T − A)/m, m/s² per rad.
    thrust_pull ["plane.thrust_pull"] (p.thrust_n - p.axial_force_n) / p.mass_kg;
    /// L_α/m, m/s² per rad.
    normal_pull ["plane.normal_pull"] p.normal_force_slope_nprad / p.mass_kg;
    /// 1/m, 1/kg.
    control_pull ["plane.control_pull"] 1.0 / p.mass_kg;
    /// 1/V, s/m.
    inverse_speed ["plane.drift_angle", "plane.drift_slope"] 1.0 / p.speed_mps;
    /// M_α/I, 1/s².
    aero_moment ["plane.aero_moment"] p.moment_slope_nmprad / p.inertia_kgm2;
    /// M_q/I, 1/s.
    damping ["plane.damping_moment"] p.pitch_damping_nms / p.inertia_kgm2;
    /// l_f/I, 1/(kg m).
    ftc_moment ["plane.fin_moment"] p.tip_arm_m / p.inertia_kgm2;
    /// l_t/I, 1/(kg m).
    tvc_moment ["plane.tvc_moment"] p.tvc_arm_m / p.inertia_kgm2;
    /// 2 ζ_b ω_b, 1/s.
    bending_drag ["plane.eta_drag"] 2.0 * p.bending_damping * p.bending_frequency_radps;
    /// ω_b², 1/s².
    bending_spring ["plane.eta_spring"] p.bending_frequency_radps * p.bending_frequency_radps;
    /// φ_c/M_g, 1/kg.
    bending_drive ["plane.eta_drive"] p.bending_displacement / p.bending_mass_kg;
    /// λ_g, 1/m.
    gyro_slope ["plane.gyro_pickup"] p.gyro_slope_pm;
    /// λ_i, 1/m.
    imu_slope ["plane.imu_pickup"] p.imu_slope_pm;
    /// Gyro ω², 1/s².
    gyro_spring ["plane.gyro_spring"] p.gyro_frequency_radps * p.gyro_frequency_radps;
    /// Gyro 2ζω, 1/s.
    gyro_drag ["plane.gyro_drag"] 2.0 * p.gyro_damping * p.gyro_frequency_radps;
    /// T_T, s.
    tvc_lead ["plane.tvc_lead"] p.tvc_lead_s;
    /// K_T, N/rad.
    tvc_gain ["plane.tvc_demand"] p.tvc_gain_nprad;
    /// 1/τ_T, 1/s.
    tvc_bandwidth ["plane.tvc_slope"] 1.0 / p.tvc_time_constant_s;
    /// F_max, N.
    tvc_limit ["plane.tvc_limit"] p.tvc_limit_n;
    /// e_dz with the tips idle in roll, rad.
    dead_zone ["dead_zone_width"] p.dead_zone_rad;
    /// What it loses for each rad of tip given to roll; the pitch tips give none.
    dead_zone_yield [] p.dead_zone_yield;
    /// T_F, s.
    ftc_lead ["plane.fin_lead"] p.ftc_lead_s;
    /// Pole of the bending filter, 1/s.
    filter_pole ["plane.filter_slope"] p.filter_pole_radps;
    /// K_F.
    ftc_gain ["plane.fin_demand"] p.ftc_gain;
    /// F_δ, N/rad; by another name in each patch.
    tip_force [] p.tip_force_slope_nprad;
    /// Tip travel limit, rad.
    tip_travel ["tip_travel"] p.tip_travel_rad;
    /// Tip rate limit, rad/s.
    tip_rate ["tip_rate"] p.tip_rate_radps;
    /// 1/τ_F, 1/s.
    tip_bandwidth ["tip_bandwidth"] 1.0 / p.ftc_time_constant_s;
    /// M_d/I, rad/s².
    misalignment ["plane.misalignment"] of.misalignment * p.misalignment_moment_nm / p.inertia_kgm2;
    /// Gust incidence in pitch, rad: of a horizontal gust, what is normal to the velocity.
    gust ["plane.gust"] of.gust * p.gust_mps * libm::sin(p.gamma_rad) / p.speed_mps;
}

/// What a run is set to: `pitch-loop.toml`, `pitch-loop-modes.toml` where there are higher modes, or
/// `yaw-roll-loop.toml` where there is roll.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The pitch or the yaw plane.
    pub plane: Plane,
    /// Commanded attitude in that plane, rad.
    pub command_rad: f64,
    /// Roll, and how it shares the tips.
    pub roll: Option<Roll>,
}

/// The roll loop of a yaw–roll run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roll {
    /// y_tip/I_xx, 1/(kg m).
    pub moment: f64,
    /// L_p/I_xx, 1/s.
    pub damping: f64,
    /// K_φ.
    pub gain: f64,
    /// T_φ, s.
    pub lead: f64,
    /// Fin-cant moment over I_xx, rad/s².
    pub cant: f64,
    /// Tips for roll only, thrust vector for yaw only.
    pub dedicated: bool,
    /// Initial offsets and rates.
    pub initial: Offsets,
}

/// Initial conditions of a yaw–roll run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offsets {
    /// Yaw offset ψ, rad.
    pub yaw_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_radps: f64,
    /// Roll offset φ, rad.
    pub roll_rad: f64,
    /// Roll rate, rad/s.
    pub roll_rate_radps: f64,
}

impl Settings {
    /// Settings of a pitch run at a point.
    pub fn pitch(point: &FrozenPoint, disturbance: &Disturbance, command_rad: f64) -> Settings {
        Settings { plane: Plane::new(point, disturbance), command_rad, roll: None }
    }

    /// Settings of a yaw–roll run at a point: tips shared, or dedicated to roll; then the thrust
    /// vector alone does yaw, without a dead zone and with its own gains.
    pub fn yaw_roll(
        point: &FrozenPoint,
        disturbance: &Disturbance,
        initial: Offsets,
        dedicated: bool,
    ) -> Settings {
        let mut plane = Plane::new(point, disturbance);
        // A lateral gust is normal to the velocity however steep the path: no factor sin γ.
        plane.gust = disturbance.gust * point.gust_mps / point.speed_mps;
        if dedicated {
            (plane.dead_zone, plane.dead_zone_yield) = (0.0, 0.0);
            plane.tvc_gain *= point.dedicated_gain_factor;
            plane.tvc_lead = point.dedicated_lead_s;
        }
        let roll = Roll {
            moment: point.tip_roll_arm_m / point.roll_inertia_kgm2,
            damping: point.roll_damping_nms / point.roll_inertia_kgm2,
            gain: point.roll_gain,
            lead: point.roll_lead_s,
            cant: disturbance.cant * point.cant_moment_nm / point.roll_inertia_kgm2,
            dedicated,
            initial,
        };
        Settings { plane, command_rad: 0.0, roll: Some(roll) }
    }

    /// Value of every coefficient unit, converter and control line of the patch, by block name.
    pub fn values(&self) -> Vec<(&'static str, f64)> {
        let plane = &self.plane;
        let mut all = plane.values();
        all.extend(plane.higher.iter().flat_map(higher_modes::values));
        match &self.roll {
            None => all.extend([("fin_force", plane.tip_force), ("theta_c", self.command_rad)]),
            Some(roll) => all.extend([
                ("psi_c", self.command_rad),
                ("dead_zone_yield", plane.dead_zone_yield),
                ("yaw_fin_force", plane.tip_force),
                ("roll_fin_force", plane.tip_force),
                ("roll_tip_moment", roll.moment),
                ("roll_damping", roll.damping),
                ("roll_demand", roll.gain),
                ("roll_lead", roll.lead),
                ("roll_gyro_spring", plane.gyro_spring),
                ("roll_gyro_drag", plane.gyro_drag),
                ("cant", roll.cant),
                ("dedicated", f64::from(u8::from(roll.dedicated))),
            ]),
        }
        all
    }

    /// Initial conditions by integrator name; the others stand as patched.
    pub fn initial_conditions(&self) -> Vec<(&'static str, f64)> {
        self.roll.map_or_else(Vec::new, |Roll { initial, .. }| {
            vec![
                ("plane.theta", initial.yaw_rad),
                ("plane.theta_rate", initial.yaw_rate_radps),
                ("roll_angle", initial.roll_rad),
                ("roll_rate", initial.roll_rate_radps),
            ]
        })
    }
}
