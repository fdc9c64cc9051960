//! The vehicle data set as it stands in the TOML file, one struct a section.
//!
//! Keys of the file keep their names; fields of the structs carry the unit.
//! Angles stay in the unit of the file here and are converted where they are
//! used. An unknown key is an error in every section but `[sources]` and
//! `[notes]`, which hold free text. Nothing is validated here beyond types:
//! that is `check`'s work.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleData {
    /// Short names of the sources cited in the comments.
    #[serde(default)]
    pub sources: BTreeMap<String, String>,
    /// Launch site and Earth.
    pub site: Site,
    /// Lengths and areas.
    pub geometry: Geometry,
    /// Masses and their layout.
    pub mass: Mass,
    /// Vacuum thrust.
    pub thrust: Thrust,
    /// Aerodynamic coefficients.
    pub aero: Aero,
    /// Fin-tip control.
    pub ftc: Ftc,
    /// Secondary-injection thrust vector control.
    pub tvc: Tvc,
    /// Rate gyro package.
    pub gyro: Gyro,
    /// Inertial measurement unit.
    pub imu: Imu,
    /// First bending mode.
    pub bending: Bending,
    /// Disturbances.
    pub disturbance: Disturbance,
    /// Structural limit.
    pub limits: Limits,
    /// Stored pitch programme.
    pub pitch_programme: PitchProgrammeData,
    /// Synthetic wind.
    pub wind: WindData,
    /// Designed gain schedule.
    pub gains: DesignedGains,
    /// Schedule with fewer switchings.
    pub gains_reduced: ScheduleData,
    /// Design case of the failure-mode study.
    pub long_period_case: LongPeriodCase,
    /// Statistics of the wind ensemble.
    pub windstat: WindStatistics,
    /// Values derived from the sections above, kept for checking.
    #[serde(default)]
    pub derived: Option<Derived>,
    /// Free remarks.
    #[serde(default)]
    pub notes: BTreeMap<String, String>,
}

/// `[site]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Site {
    /// Latitude, deg.
    pub lat_deg: f64,
    /// Launch azimuth, deg.
    pub azimuth_deg: f64,
    /// Radius of the spherical Earth, m.
    #[serde(rename = "earth_radius")]
    pub earth_radius_m: f64,
    /// Gravitational parameter, m³/s².
    #[serde(rename = "mu")]
    pub mu_m3ps2: f64,
    /// Altitude of the vehicle at lift-off, m.
    #[serde(rename = "alt0")]
    pub launch_altitude_m: f64,
}

/// `[geometry]`: stations in m forward of the nozzle exit plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Length, m.
    #[serde(rename = "length")]
    pub length_m: f64,
    /// Diameter, m.
    #[serde(rename = "diameter")]
    pub diameter_m: f64,
    /// Reference area, m².
    #[serde(rename = "S_ref")]
    pub reference_area_m2: f64,
    /// Reference length, m.
    #[serde(rename = "l_ref")]
    pub reference_length_m: f64,
    /// Effective thrust application point, m.
    #[serde(rename = "x_nozzle")]
    pub nozzle_x_m: f64,
    /// Injection plane, m.
    #[serde(rename = "x_sitvc")]
    pub injection_x_m: f64,
    /// Centre of pressure of the fixed fins, m.
    #[serde(rename = "x_fin")]
    pub fin_x_m: f64,
    /// Hinge and centre of pressure of the fin tips, m.
    #[serde(rename = "x_tip")]
    pub tip_x_m: f64,
    /// Radius of the tips' centre of pressure from the roll axis, m.
    #[serde(rename = "y_tip")]
    pub tip_y_m: f64,
    /// Radius of the fixed panels' centre of pressure, m.
    #[serde(rename = "y_fin")]
    pub fin_y_m: f64,
}

/// One rigid component of the layout: `[name, mass kg, x m, rod length m]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component(
    /// Name.
    pub String,
    /// Mass, kg.
    pub f64,
    /// Station of its centre, m.
    pub f64,
    /// Length of the equivalent uniform rod, m.
    pub f64,
);

/// `[mass]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// Launch mass, kg.
    #[serde(rename = "m0")]
    pub launch_mass_kg: f64,
    /// First-stage propellant, kg.
    #[serde(rename = "m_prop1")]
    pub propellant_kg: f64,
    /// Gross masses of the stages, kg.
    #[serde(rename = "stage_gross")]
    pub stage_gross_kg: Vec<f64>,
    /// Burning time, s.
    #[serde(rename = "burn_time")]
    pub burn_time_s: f64,
    /// Layout of everything but the propellant.
    pub components: Vec<Component>,
    /// Centroid of the grain, m.
    #[serde(rename = "prop_x")]
    pub propellant_x_m: f64,
    /// Length of the grain, m.
    #[serde(rename = "prop_len")]
    pub propellant_length_m: f64,
    /// Times of the roll inertia, s.
    #[serde(rename = "Ixx_t")]
    pub roll_inertia_time_s: Vec<f64>,
    /// Roll inertia, kg·m².
    #[serde(rename = "Ixx_v")]
    pub roll_inertia_kgm2: Vec<f64>,
    /// Distance of the nozzle exit from the centre of gravity used in jet damping, m.
    #[serde(rename = "r_exit")]
    pub exit_radius_m: f64,
}

/// `[thrust]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thrust {
    /// Times, s.
    #[serde(rename = "t")]
    pub time_s: Vec<f64>,
    /// Vacuum thrust before scaling to the total impulse, N.
    #[serde(rename = "F")]
    pub vacuum_thrust_n: Vec<f64>,
    /// Vacuum specific impulse, s.
    #[serde(rename = "isp_vac")]
    pub specific_impulse_s: f64,
    /// Nozzle exit area, m².
    #[serde(rename = "A_exit")]
    pub exit_area_m2: f64,
}

/// `[aero]`: coefficients on the reference area, per radian; shape `[mach]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Aero {
    /// Mach numbers.
    pub mach: Vec<f64>,
    /// Axial force.
    #[serde(rename = "C_A")]
    pub axial: Vec<f64>,
    /// Normal-force slope of the body.
    #[serde(rename = "CN_body")]
    pub body_slope: Vec<f64>,
    /// Centre of pressure of the body, m.
    #[serde(rename = "x_body")]
    pub body_x_m: Vec<f64>,
    /// Normal-force slope of the fixed fins (two panels).
    #[serde(rename = "CN_fin")]
    pub fin_slope: Vec<f64>,
    /// Normal-force slope of one tip on the tip area.
    #[serde(rename = "CN_tip")]
    pub tip_slope: Vec<f64>,
    /// Area of one tip, m².
    #[serde(rename = "S_tip")]
    pub tip_area_m2: f64,
    /// Effective cant of the fixed fins, deg.
    pub fin_cant_deg: f64,
}

/// `[ftc]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ftc {
    /// Actuator time constant, s.
    #[serde(rename = "tau")]
    pub time_constant_s: f64,
    /// Travel limit, deg.
    pub delta_max_deg: f64,
    /// Rate limit, deg/s.
    pub rate_max_dps: f64,
    /// Time at which the tips take over in pitch and yaw, s.
    #[serde(rename = "t_on")]
    pub on_time_s: f64,
}

/// `[tvc]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tvc {
    /// Actuator time constant, s.
    #[serde(rename = "tau")]
    pub time_constant_s: f64,
    /// Force limit per axis, N.
    #[serde(rename = "F_max")]
    pub force_max_n: f64,
    /// Side specific impulse, s.
    #[serde(rename = "Isp_side")]
    pub side_specific_impulse_s: f64,
    /// Injectant carried, kg.
    #[serde(rename = "fluid")]
    pub fluid_kg: f64,
}

/// `[gyro]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gyro {
    /// Natural frequency, rad/s.
    #[serde(rename = "wn")]
    pub natural_frequency_radps: f64,
    /// Damping ratio.
    #[serde(rename = "zeta")]
    pub damping_ratio: f64,
}

/// `[imu]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Imu {
    /// Sample period, s.
    #[serde(rename = "T_sample")]
    pub sample_period_s: f64,
}

/// `[bending]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bending {
    /// Times, s.
    #[serde(rename = "t")]
    pub time_s: Vec<f64>,
    /// Natural frequency, Hz.
    pub freq_hz: Vec<f64>,
    /// Generalised mass, kg.
    #[serde(rename = "M_gen")]
    pub generalised_mass_kg: Vec<f64>,
    /// Mode displacement at the control-force station.
    #[serde(rename = "phi_c")]
    pub displacement_at_control: f64,
    /// Damping ratio.
    #[serde(rename = "zeta")]
    pub damping_ratio: f64,
    /// Mode slope at the nominal gyro station, 1/m.
    #[serde(rename = "lam_gyro")]
    pub gyro_slope_pm: f64,
    /// Candidate gyro stations, m.
    #[serde(rename = "lam_gyro_alt_x")]
    pub alternative_gyro_x_m: Vec<f64>,
    /// Mode slope there, 1/m.
    #[serde(rename = "lam_gyro_alt")]
    pub alternative_gyro_slope_pm: Vec<f64>,
    /// Corner of the FTC channel's bending filter, rad/s.
    #[serde(rename = "filter_w")]
    pub filter_corner_radps: f64,
    /// Mode slope at the IMU, 1/m.
    #[serde(rename = "lam_imu")]
    pub imu_slope_pm: f64,
}

/// `[disturbance]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// 3σ thrust misalignment, deg.
    pub thrust_misalign_deg: f64,
    /// 3σ lateral offset of the centre of gravity, m.
    #[serde(rename = "cg_offset")]
    pub cg_offset_m: f64,
    /// Step gust of the short-period runs, m/s.
    pub gust_step_mps: f64,
}

/// `[limits]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Structural limit on dynamic pressure × angle of attack, Pa·deg.
    #[serde(rename = "q_alpha_Pa_deg")]
    pub q_alpha_padeg: f64,
}

/// `[pitch_programme]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PitchProgrammeData {
    /// Nodes, s; shape `[n + 1]`.
    #[serde(rename = "t_nodes")]
    pub node_time_s: Vec<f64>,
    /// Nose-down rate between the nodes, deg/s; shape `[n]`.
    pub rate_dps: Vec<f64>,
    /// Attitude before the first node, deg.
    pub theta0_deg: f64,
}

/// `[wind]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindData {
    /// Altitudes of the envelope, m.
    #[serde(rename = "env_h")]
    pub envelope_altitude_m: Vec<f64>,
    /// Speeds of the envelope, m/s.
    #[serde(rename = "env_w")]
    pub envelope_speed_mps: Vec<f64>,
    /// Reference altitude of shear and gust, m.
    #[serde(rename = "h_ref")]
    pub reference_altitude_m: f64,
    /// Coefficient of the 0.7-power shear law, m^0.3/s.
    pub shear_a: f64,
    /// Gust, m/s.
    pub gust_mps: f64,
    /// Factor on shear and gust when combined.
    #[serde(rename = "combine")]
    pub combination_factor: f64,
    /// Plateau of the gust, m.
    #[serde(rename = "gust_len")]
    pub gust_length_m: f64,
    /// Crosswind as a fraction of the profile.
    #[serde(rename = "cross_frac")]
    pub cross_fraction: f64,
}

/// `[gains]`: the designed schedule and what no schedule switches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignedGains {
    /// Switch times, s.
    #[serde(rename = "t_sw")]
    pub switch_time_s: Vec<f64>,
    /// FTC gain, deg fin per deg error.
    #[serde(rename = "K_F")]
    pub ftc_gain: Vec<f64>,
    /// FTC lead, s.
    #[serde(rename = "T_F")]
    pub ftc_lead_s: Vec<f64>,
    /// TVC gain, N per deg.
    #[serde(rename = "K_T")]
    pub tvc_gain_npdeg: Vec<f64>,
    /// TVC lead, s.
    #[serde(rename = "T_T")]
    pub tvc_lead_s: Vec<f64>,
    /// TVC dead zone, deg.
    #[serde(rename = "e_dz_deg")]
    pub dead_zone_deg: Vec<f64>,
    /// Roll gain, deg fin per deg roll.
    #[serde(rename = "K_phi")]
    pub roll_gain: f64,
    /// Roll lead, s.
    #[serde(rename = "T_phi")]
    pub roll_lead_s: f64,
    /// Factor on the TVC gain in yaw when the allocation is decoupled.
    #[serde(rename = "decoupled_yaw_KT")]
    pub decoupled_yaw_gain_factor: f64,
    /// TVC lead in yaw when the allocation is decoupled, s.
    #[serde(rename = "decoupled_yaw_TT")]
    pub decoupled_yaw_lead_s: f64,
}

/// `[gains_reduced]`: piecewise-constant gains; shape `[switch]` throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduleData {
    /// Switch times, s.
    #[serde(rename = "t_sw")]
    pub switch_time_s: Vec<f64>,
    /// FTC gain, deg fin per deg error.
    #[serde(rename = "K_F")]
    pub ftc_gain: Vec<f64>,
    /// FTC lead, s.
    #[serde(rename = "T_F")]
    pub ftc_lead_s: Vec<f64>,
    /// TVC gain, N per deg.
    #[serde(rename = "K_T")]
    pub tvc_gain_npdeg: Vec<f64>,
    /// TVC lead, s.
    #[serde(rename = "T_T")]
    pub tvc_lead_s: Vec<f64>,
    /// TVC dead zone, deg.
    #[serde(rename = "e_dz_deg")]
    pub dead_zone_deg: Vec<f64>,
}

impl DesignedGains {
    /// The switched part, in the shape that both schedules share.
    pub fn schedule(&self) -> ScheduleData {
        ScheduleData {
            switch_time_s: self.switch_time_s.clone(),
            ftc_gain: self.ftc_gain.clone(),
            ftc_lead_s: self.ftc_lead_s.clone(),
            tvc_gain_npdeg: self.tvc_gain_npdeg.clone(),
            tvc_lead_s: self.tvc_lead_s.clone(),
            dead_zone_deg: self.dead_zone_deg.clone(),
        }
    }
}

/// `[long_period_case]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LongPeriodCase {
    /// Sign of the wind along the flight direction: −1 headwind, +1 tailwind, 0 calm.
    pub wind_sign: f64,
    /// Pitch misalignment, fraction of 3σ.
    pub misalign_pitch: f64,
    /// Yaw misalignment, fraction of 3σ.
    pub misalign_yaw: f64,
    /// Accepted velocity dispersion, fraction.
    #[serde(rename = "accept_dV_frac")]
    pub accept_speed_fraction: f64,
    /// Accepted flight-path-angle dispersion, deg.
    pub accept_dgam_deg: f64,
    /// Accepted altitude dispersion, fraction.
    #[serde(rename = "accept_dh_frac")]
    pub accept_altitude_fraction: f64,
    /// Accepted range dispersion, km.
    pub accept_drange_km: f64,
}

/// `[windstat]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindStatistics {
    /// Mean wind over the envelope.
    #[serde(rename = "mean_frac")]
    pub mean_fraction: f64,
    /// Large-scale standard deviation over the envelope.
    #[serde(rename = "sigma_frac")]
    pub sigma_fraction: f64,
    /// Correlation length of the large scale, m.
    #[serde(rename = "L_large")]
    pub large_length_m: f64,
    /// Small-scale standard deviation, m/s.
    #[serde(rename = "sigma_small")]
    pub small_sigma_mps: f64,
    /// Correlation length of the small scale, m.
    #[serde(rename = "L_small")]
    pub small_length_m: f64,
    /// Dryden scale length, m.
    #[serde(rename = "dryden_L")]
    pub dryden_length_m: f64,
    /// Dryden standard deviation, m/s.
    #[serde(rename = "dryden_sigma")]
    pub dryden_sigma_mps: f64,
}

/// `[derived]`: a published table of what follows from the rest; shape `[t]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Derived {
    /// Times, s.
    #[serde(rename = "t")]
    pub time_s: Vec<f64>,
    /// Mass, kg.
    #[serde(rename = "mass")]
    pub mass_kg: Vec<f64>,
    /// Centre of gravity, m.
    #[serde(rename = "xcg")]
    pub cg_x_m: Vec<f64>,
    /// Pitch and yaw inertia, kg·m².
    #[serde(rename = "Iyy")]
    pub pitch_inertia_kgm2: Vec<f64>,
    /// Roll inertia, kg·m².
    #[serde(rename = "Ixx")]
    pub roll_inertia_kgm2: Vec<f64>,
    /// Scaled vacuum thrust, N.
    #[serde(rename = "F_vac")]
    pub vacuum_thrust_n: Vec<f64>,
    /// Mass flow, kg/s.
    #[serde(rename = "mdot")]
    pub mass_flow_kgps: Vec<f64>,
}
