//! The vehicle data set, one struct a section: each field with its key in the file and its rule.
//!
//! Keys of the file keep their names; fields of the structs carry the unit. Angles stay in the
//! unit of the file here and are converted where they are used. `[sources]` and `[notes]` hold
//! free text. What sections must fulfil together stands in [`relations`].

use crate::beam_shape::MODES;
use crate::structure::BodyLoads;
use desk::reader::Range::{Any, NotNegative, Positive};
use desk::reader::{Data, SheetFields, Value};
use desk::table;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

table! { "The whole file." VehicleData
    sources: BTreeMap<String, String> = texts("sources"), "Short names of the sources cited in the comments.";
    site: Site = table("site", Site::read), "Launch site and Earth.";
    geometry: Geometry = table("geometry", Geometry::read), "Lengths and areas.";
    mass: Mass = table("mass", Mass::read), "Masses and their layout.";
    thrust: Thrust = table("thrust", Thrust::read), "Vacuum thrust.";
    aero: Aero = table("aero", Aero::read), "Aerodynamic coefficients.";
    ftc: Ftc = table("ftc", Ftc::read), "Fin-tip control.";
    tvc: Tvc = table("tvc", Tvc::read), "Secondary-injection thrust vector control.";
    gyro: Gyro = table("gyro", Gyro::read), "Rate gyro package.";
    imu: Imu = table("imu", Imu::read), "Inertial measurement unit.";
    bending: Bending = table("bending", Bending::read), "Bending modes.";
    disturbance: Disturbance = table("disturbance", Disturbance::read), "Disturbances.";
    limits: Limits = table("limits", Limits::read), "Structural limit.";
    range_safety: RangeSafety = table("range_safety", RangeSafety::read), "Where the vehicle may come down.";
    pitch_programme: PitchProgrammeData = table("pitch_programme", PitchProgrammeData::read), "Stored pitch programme.";
    wind: WindData = table("wind", WindData::read), "Synthetic wind.";
    gains: DesignedGains = table("gains", DesignedGains::read), "Designed gain schedule.";
    gains_reduced: ScheduleData = table("gains_reduced", ScheduleData::read), "Schedule with fewer switchings.";
    long_period_case: LongPeriodCase = table("long_period_case", LongPeriodCase::read), "Design case of the failure-mode study.";
    windstat: WindStatistics = table("windstat", WindStatistics::read), "Statistics of the wind ensemble.";
    derived: Option<Derived> = table_or_none("derived", Derived::read), "Values derived from the sections above, kept for checking.";
    notes: BTreeMap<String, String> = texts("notes"), "Free remarks.";
}

table! { "`[site]`." Site
    lat_deg: f64 = number_in("lat_deg", Any), "Latitude, deg.";
    azimuth_deg: f64 = number_in("azimuth_deg", Any), "Launch azimuth, deg.";
    earth_radius_m: f64 = number_in("earth_radius", Positive), "Radius of the spherical Earth, m.";
    mu_m3ps2: f64 = number_in("mu", Positive), "Gravitational parameter, m³/s².";
    launch_altitude_m: f64 = number_in("alt0", Any), "Altitude of the vehicle at lift-off, m.";
}

table! { "`[geometry]`: stations in m forward of the nozzle exit plane." Geometry
    length_m: f64 = number_in("length", Positive), "Length, m.";
    diameter_m: f64 = number_in("diameter", Positive), "Diameter, m.";
    reference_area_m2: f64 = number_in("S_ref", Positive), "Reference area, m².";
    reference_length_m: f64 = number_in("l_ref", Positive), "Reference length, m.";
    nozzle_x_m: f64 = number_in("x_nozzle", Any), "Effective thrust application point, m.";
    injection_x_m: f64 = number_in("x_sitvc", Any), "Injection plane, m.";
    fin_x_m: f64 = number_in("x_fin", Any), "Centre of pressure of the fixed fins, m.";
    tip_x_m: f64 = number_in("x_tip", Any), "Hinge and centre of pressure of the fin tips, m.";
    tip_y_m: f64 = number_in("y_tip", Positive), "Radius of the tips' centre of pressure from the roll axis, m.";
    fin_y_m: f64 = number_in("y_fin", Positive), "Radius of the fixed panels' centre of pressure, m.";
}

table! { "`[mass]`." Mass
    launch_mass_kg: f64 = number_in("m0", Positive), "Launch mass, kg.";
    propellant_kg: f64 = number_in("m_prop1", Positive), "First-stage propellant, kg.";
    stage_gross_kg: Vec<f64> = numbers_in("stage_gross", Positive), "Gross masses of the stages, kg.";
    burn_time_s: f64 = number_in("burn_time", Positive), "Burning time, s.";
    components: Vec<Component> = each("components", COMPONENT, component), "Layout of everything but the propellant.";
    propellant_x_m: f64 = number_in("prop_x", Any), "Centroid of the grain, m.";
    propellant_length_m: f64 = number_in("prop_len", Positive), "Length of the grain, m.";
    roll_inertia_time_s: Vec<f64> = increasing("Ixx_t", 2), "Times of the roll inertia, s.";
    roll_inertia_kgm2: Vec<f64> = along("Ixx_v", &roll_inertia_time_s, Positive), "Roll inertia, kg·m².";
    exit_radius_m: f64 = number_in("r_exit", NotNegative), "Distance of the nozzle exit from the centre of gravity used in jet damping, m.";
}

table! { "`[thrust]`." Thrust
    time_s: Vec<f64> = increasing("t", 2), "Times, s.";
    vacuum_thrust_n: Vec<f64> = along("F", &time_s, NotNegative), "Vacuum thrust before scaling to the total impulse, N.";
    specific_impulse_s: f64 = number_in("isp_vac", Positive), "Vacuum specific impulse, s.";
    exit_area_m2: f64 = number_in("A_exit", NotNegative), "Nozzle exit area, m².";
}

table! { "`[aero]`: coefficients on the reference area, per radian; shape `[mach]`." Aero
    mach: Vec<f64> = increasing("mach", 2), "Mach numbers.";
    axial: Vec<f64> = along("C_A", &mach, NotNegative), "Axial force.";
    body_slope: Vec<f64> = along("CN_body", &mach, NotNegative), "Normal-force slope of the body.";
    body_x_m: Vec<f64> = along("x_body", &mach, Any), "Centre of pressure of the body, m.";
    fin_slope: Vec<f64> = along("CN_fin", &mach, NotNegative), "Normal-force slope of the fixed fins (two panels).";
    tip_slope: Vec<f64> = along("CN_tip", &mach, NotNegative), "Normal-force slope of one tip on the tip area.";
    tip_area_m2: f64 = number_in("S_tip", NotNegative), "Area of one tip, m².";
    fin_cant_deg: f64 = number_in("fin_cant_deg", Any), "Effective cant of the fixed fins, deg.";
    nose_slope: f64 = number_in("CN_nose", NotNegative), "Share of the body's slope that the nose carries.";
    nose_length_m: f64 = number_in("nose_len", Positive), "Length of the nose, m.";
}

table! { "`[ftc]`." Ftc
    time_constant_s: f64 = number_in("tau", Positive), "Actuator time constant, s.";
    delta_max_deg: f64 = number_in("delta_max_deg", Positive), "Travel limit, deg.";
    rate_max_dps: f64 = number_in("rate_max_dps", Positive), "Rate limit, deg/s.";
    on_time_s: f64 = number_in("t_on", NotNegative), "Time at which the tips take over in pitch and yaw, s.";
}

table! { "`[tvc]`." Tvc
    time_constant_s: f64 = number_in("tau", Positive), "Actuator time constant, s.";
    force_max_n: f64 = number_in("F_max", Positive), "Force limit per axis, N.";
    side_specific_impulse_s: f64 = number_in("Isp_side", Positive), "Side specific impulse, s.";
    fluid_kg: f64 = number_in("fluid", NotNegative), "Injectant carried, kg.";
    dead_zone: DeadZone = word("dead_zone", Some(DeadZone::Remaining), &DeadZone::ALL.map(|d| (d.word(), d))), "Law of the dead zone.";
    reserve_fraction: f64 = number_in("reserve", NotNegative), "Reserve on the fluid asked for, fraction.";
}

interface::named! {
    /// How the half width of the TVC dead zone varies.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum DeadZone, word {
        /// With what the fin tips have left for the axis: (δ_max − ½|δ_2 − δ_4|)/K_F in yaw,
        /// δ_max/K_F in pitch, whose tips have no other task.
        Remaining "remaining"
        /// With time alone: `e_dz_deg` of the schedule.
        Scheduled "scheduled"
    }
}

table! { "`[gyro]`." Gyro
    natural_frequency_radps: f64 = number_in("wn", Positive), "Natural frequency, rad/s.";
    damping_ratio: f64 = number_in("zeta", NotNegative), "Damping ratio.";
}

table! { "`[imu]`." Imu
    sample_period_s: f64 = number_in("T_sample", Positive), "Sample period, s.";
}

table! { "`[bending]`." Bending
    time_s: Vec<f64> = increasing("t", 2), "Times, s.";
    freq_hz: Vec<f64> = along("freq_hz", &time_s, Positive), "Natural frequency, Hz.";
    generalised_mass_kg: Vec<f64> = along("M_gen", &time_s, Positive), "Generalised mass, kg.";
    displacement_at_control: f64 = number_in("phi_c", Any), "Mode displacement at the control-force station.";
    damping_ratio: f64 = number_in("zeta", NotNegative), "Damping ratio.";
    gyro_slope_pm: f64 = number_in("lam_gyro", Any), "Mode slope at the nominal gyro station, 1/m.";
    alternative_gyro_x_m: Vec<f64> = increasing("lam_gyro_alt_x", 2), "Candidate gyro stations, m.";
    alternative_gyro_slope_pm: Vec<f64> = along("lam_gyro_alt", &alternative_gyro_x_m, Any), "Mode slope there, 1/m.";
    filter_corner_radps: f64 = number_in("filter_w", Positive), "Corner of the FTC channel's bending filter, rad/s.";
    imu_slope_pm: f64 = number_in("lam_imu", Any), "Mode slope at the IMU, 1/m.";
    frequency_ratio: Vec<f64> = numbers_in("freq_ratio", Positive), "Frequencies of modes 2 and 3 over that of the first.";
    high_damping_ratio: Vec<f64> = along("zeta_high", &frequency_ratio, NotNegative), "Damping ratios of modes 2 and 3.";
    control_x_m: f64 = number_in("x_control", Any), "Station of the control forces for modes 2 and 3, m.";
    gyro_x_m: f64 = number_in("x_gyro", Any), "Station of the rate gyro for modes 2 and 3, m.";
    imu_x_m: f64 = number_in("x_imu", Any), "Station of the IMU for modes 2 and 3, m.";
}

table! { "`[disturbance]`." Disturbance
    thrust_misalign_deg: f64 = number_in("thrust_misalign_deg", Any), "3σ thrust misalignment, deg.";
    cg_offset_m: f64 = number_in("cg_offset", Any), "3σ lateral offset of the centre of gravity, m.";
    gust_step_mps: f64 = number_in("gust_step_mps", Any), "Step gust of the short-period runs, m/s.";
}

table! { "`[limits]`." Limits
    q_alpha_padeg: f64 = number_in("q_alpha_Pa_deg", Positive), "Structural limit on dynamic pressure × angle of attack, Pa·deg.";
}

table! { "`[range_safety]`: corridor of the instantaneous impact point, and loss of control." RangeSafety
    half_width_m: f64 = number_in("half_width", Positive), "Half width of the corridor at the launch point, m.";
    opening_deg: f64 = number_in("opening_deg", NotNegative), "Angle by which each side opens down the track, deg.";
    behind_m: f64 = number_in("behind", Positive), "How far it reaches behind the launch point, m.";
    control_lost_deg: f64 = number_in("control_lost_deg", Positive), "Departure of the nose from its command at which control is lost, deg.";
}

table! { "`[pitch_programme]`." PitchProgrammeData
    node_time_s: Vec<f64> = increasing("t_nodes", 2), "Nodes, s; shape `[n + 1]`.";
    rate_dps: Vec<f64> = numbers_in("rate_dps", Any), "Nose-down rate between the nodes, deg/s; shape `[n]`.";
    theta0_deg: f64 = number_in("theta0_deg", Any), "Attitude before the first node, deg.";
}

table! { "`[wind]`." WindData
    envelope_altitude_m: Vec<f64> = increasing("env_h", 2), "Altitudes of the envelope, m.";
    envelope_speed_mps: Vec<f64> = along("env_w", &envelope_altitude_m, NotNegative), "Speeds of the envelope, m/s.";
    reference_altitude_m: f64 = number_in("h_ref", Any), "Reference altitude of shear and gust, m.";
    shear_a: f64 = number_in("shear_a", NotNegative), "Coefficient of the 0.7-power shear law, m^0.3/s.";
    gust_mps: f64 = number_in("gust_mps", NotNegative), "Gust, m/s.";
    combination_factor: f64 = number_in("combine", NotNegative), "Factor on shear and gust when combined.";
    gust_length_m: f64 = number_in("gust_len", NotNegative), "Plateau of the gust, m.";
    cross_fraction: f64 = number_in("cross_frac", Any), "Crosswind as a fraction of the profile.";
}

table! { "`[gains]`: the designed schedule and what no schedule switches." DesignedGains
    switch_time_s: Vec<f64> = increasing("t_sw", 1), "Switch times, s.";
    ftc_gain: Vec<f64> = along("K_F", &switch_time_s, NotNegative), "FTC gain, deg fin per deg error.";
    ftc_lead_s: Vec<f64> = along("T_F", &switch_time_s, NotNegative), "FTC lead, s.";
    tvc_gain_npdeg: Vec<f64> = along("K_T", &switch_time_s, NotNegative), "TVC gain, N per deg.";
    tvc_lead_s: Vec<f64> = along("T_T", &switch_time_s, NotNegative), "TVC lead, s.";
    dead_zone_deg: Vec<f64> = along("e_dz_deg", &switch_time_s, NotNegative), "TVC dead zone, deg.";
    roll_gain: f64 = number_in("K_phi", NotNegative), "Roll gain, deg fin per deg roll.";
    roll_lead_s: f64 = number_in("T_phi", NotNegative), "Roll lead, s.";
    decoupled_yaw_gain_factor: f64 = number_in("decoupled_yaw_KT", NotNegative), "Factor on the TVC gain in yaw when the allocation is decoupled.";
    decoupled_yaw_lead_s: f64 = number_in("decoupled_yaw_TT", NotNegative), "TVC lead in yaw when the allocation is decoupled, s.";
}

table! { "`[gains_reduced]`: piecewise-constant gains; shape `[switch]` throughout." ScheduleData
    switch_time_s: Vec<f64> = increasing("t_sw", 1), "Switch times, s.";
    ftc_gain: Vec<f64> = along("K_F", &switch_time_s, NotNegative), "FTC gain, deg fin per deg error.";
    ftc_lead_s: Vec<f64> = along("T_F", &switch_time_s, NotNegative), "FTC lead, s.";
    tvc_gain_npdeg: Vec<f64> = along("K_T", &switch_time_s, NotNegative), "TVC gain, N per deg.";
    tvc_lead_s: Vec<f64> = along("T_T", &switch_time_s, NotNegative), "TVC lead, s.";
    dead_zone_deg: Vec<f64> = along("e_dz_deg", &switch_time_s, NotNegative), "TVC dead zone, deg.";
}

table! { "`[long_period_case]`." LongPeriodCase
    wind_sign: f64 = number_in("wind_sign", Any), "Sign of the wind along the flight direction: −1 headwind, +1 tailwind, 0 calm.";
    misalign_pitch: f64 = number_in("misalign_pitch", Any), "Pitch misalignment, fraction of 3σ.";
    misalign_yaw: f64 = number_in("misalign_yaw", Any), "Yaw misalignment, fraction of 3σ.";
    accept_speed_fraction: f64 = number_in("accept_dV_frac", Positive), "Accepted velocity dispersion, fraction.";
    accept_dgam_deg: f64 = number_in("accept_dgam_deg", Positive), "Accepted flight-path-angle dispersion, deg.";
    accept_altitude_fraction: f64 = number_in("accept_dh_frac", Positive), "Accepted altitude dispersion, fraction.";
    accept_drange_km: f64 = number_in("accept_drange_km", Positive), "Accepted range dispersion, km.";
}

table! { "`[windstat]`." WindStatistics
    mean_fraction: f64 = number_in("mean_frac", Any), "Mean wind over the envelope.";
    sigma_fraction: f64 = number_in("sigma_frac", NotNegative), "Large-scale standard deviation over the envelope.";
    large_length_m: f64 = number_in("L_large", Positive), "Correlation length of the large scale, m.";
    small_sigma_mps: f64 = number_in("sigma_small", NotNegative), "Small-scale standard deviation, m/s.";
    small_length_m: f64 = number_in("L_small", Positive), "Correlation length of the small scale, m.";
    dryden_length_m: f64 = number_in("dryden_L", Positive), "Dryden scale length, m.";
    dryden_sigma_mps: f64 = number_in("dryden_sigma", NotNegative), "Dryden standard deviation, m/s.";
}

table! { "`[derived]`: a published table of what follows from the rest; shape `[t]`." Derived
    time_s: Vec<f64> = increasing("t", 2), "Times, s.";
    mass_kg: Vec<f64> = along("mass", &time_s, Positive), "Mass, kg.";
    cg_x_m: Vec<f64> = along("xcg", &time_s, Any), "Centre of gravity, m.";
    pitch_inertia_kgm2: Vec<f64> = along("Iyy", &time_s, Positive), "Pitch and yaw inertia, kg·m².";
    roll_inertia_kgm2: Vec<f64> = along("Ixx", &time_s, Positive), "Roll inertia, kg·m².";
    vacuum_thrust_n: Vec<f64> = along("F_vac", &time_s, NotNegative), "Scaled vacuum thrust, N.";
    mass_flow_kgps: Vec<f64> = along("mdot", &time_s, NotNegative), "Mass flow, kg/s.";
}

/// One rigid component of the layout: `[name, mass kg, x m, rod length m]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Component(
    pub String,
    /// Mass, kg.
    pub f64,
    /// Station of its centre, m.
    pub f64,
    /// Length of the equivalent uniform rod, m.
    pub f64,
);

const COMPONENT: &str = "[[\"motor case\", 2140.0, 4.2, 9.5]]";

fn component(f: &mut SheetFields<'_, '_>, key: &str, value: &Value) -> Option<Component> {
    if let Data::List(items) = &value.data
        && let [name, mass, x, length] = &items[..]
        && let Some(name) = name.text()
    {
        let mass = f.number_at(key, mass, Positive);
        let (x, length) = (f.number_at(key, x, Any), f.number_at(key, length, NotNegative));
        return Some(Component(name.to_owned(), mass?, x?, length?));
    }
    let remedy =
        "write name, mass (kg), station (m) and length (m): [\"motor case\", 2140.0, 4.2, 9.5]";
    f.fault(value.span, "this is no component", remedy);
    None
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

/// Longest vehicle offered, m.
const LONGEST_M: f64 = 1e3;

/// What fields must fulfil together.
pub(crate) fn relations(f: &mut SheetFields<'_, '_>, d: &VehicleData) {
    let push = d.thrust.vacuum_thrust_n.iter().any(|&thrust| thrust > 0.0);
    f.require(push, "thrust.F", "the thrust is zero throughout", "give a motor with an impulse");

    let (times, burn_s) = (&d.thrust.time_s, d.mass.burn_time_s);
    let (first, last) = (times[0], times[times.len() - 1]);
    let fault = format!("`thrust.t` covers {first} s to {last} s only");
    let remedy = format!("cover lift-off (0 s) to mass.burn_time ({burn_s} s)");
    f.require(first <= 0.0 && last >= burn_s, "thrust.t", fault, remedy);

    let (nodes, rates) = (d.pitch_programme.node_time_s.len(), d.pitch_programme.rate_dps.len());
    let fault = format!("`pitch_programme` has {nodes} nodes and {rates} rates");
    let remedy = "give one rate for each interval between nodes";
    f.require(nodes == rates + 1, "pitch_programme.rate_dps", fault, remedy);

    for (key, first) in [
        ("gains.t_sw", d.gains.switch_time_s[0]),
        ("gains_reduced.t_sw", d.gains_reduced.switch_time_s[0]),
    ] {
        let fault = format!("`{key}` starts at {first} s");
        f.require(first == 0.0, key, fault, "the first switch time must be 0");
    }

    let launch_kg = d.mass.launch_mass_kg;
    let total_kg = d.mass.propellant_kg + d.mass.components.iter().map(|c| c.1).sum::<f64>();
    let fault =
        format!("components and propellant add up to {total_kg} kg, `m0` is {launch_kg} kg");
    let agree = (total_kg - launch_kg).abs() <= 1.0;
    f.require(agree, "mass.components", fault, "make them agree to 1 kg");

    let fault = format!("`freq_ratio` has {} numbers", d.bending.frequency_ratio.len());
    let two = d.bending.frequency_ratio.len() == MODES - 1;
    f.require(two, "bending.freq_ratio", fault, "give two: modes 2 and 3 over the first");

    let (aero, length_m) = (&d.aero, d.geometry.length_m);
    // The beam has stations from end to end of all that has mass.
    let fault = format!("a vehicle of {length_m} m");
    let short = length_m <= LONGEST_M;
    f.require(short, "geometry.length", fault, "give at most 1000 m");
    let grain = (d.mass.propellant_x_m, d.mass.propellant_length_m);
    let mut rods = d.mass.components.iter().map(|c| (c.2, c.3)).chain([grain]);
    let beyond = rods.find(|(x, rod)| x - 0.5 * rod < -length_m || x + 0.5 * rod > 2.0 * length_m);
    if let Some((x, rod)) = beyond {
        let fault = format!("{rod} m of mass about {x} m on a vehicle of {length_m} m");
        f.require(false, "mass.components", fault, "keep within a length of the vehicle's ends");
    }
    let fault = format!("a nose of {} m on a vehicle of {length_m} m", aero.nose_length_m);
    f.require(aero.nose_length_m <= length_m, "aero.nose_len", fault, "shorten the nose");
    for (i, mach) in aero.mach.iter().enumerate() {
        let (slope, x_m) = (aero.body_slope[i], aero.body_x_m[i]);
        let loads = BodyLoads::new(d, slope, x_m);
        let fault = format!(
            "at Mach {mach} no uniform load gives the body its slope and centre of pressure beside the nose"
        );
        let remedy = "bring the rest of CN_body, behind CN_nose, to a centre in the aft half of the vehicle, and x_body off x_fin";
        if !f.require(loads.is_some(), "aero.CN_nose", fault, remedy) {
            break;
        }
    }
}
