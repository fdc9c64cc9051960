//! Semantic validation of a vehicle data set.
//!
//! The types are right when this runs; here the numbers are: finite, positive
//! where a physical quantity must be, tables of equal lengths with increasing
//! abscissae, and the sums that must close. Every fault is collected.

use std::cell::OnceCell;

use super::data::{ScheduleData, VehicleData};
use super::places::Places;
use crate::table::{TableError, first_abscissa_fault};
use desk::faults::{FileFault, Source};

/// What a number must be.
#[derive(Debug, Clone, Copy)]
enum Must {
    BeFinite,
    NotBeNegative,
    BePositive,
}

impl Must {
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::BeFinite => true,
                Self::NotBeNegative => value >= 0.0,
                Self::BePositive => value > 0.0,
            }
    }

    fn remedy(self) -> &'static str {
        match self {
            Self::BeFinite => "give a finite number",
            Self::NotBeNegative => "give a finite number that is zero or positive",
            Self::BePositive => "give a finite positive number",
        }
    }
}

/// Collects faults with their places.
struct Checker<'t> {
    file: &'t str,
    source: Option<Source<'t>>,
    /// Parsed only when there is something to report.
    places: OnceCell<Places<'t>>,
    faults: Vec<FileFault>,
}

impl Checker<'_> {
    fn fault(
        &mut self,
        section: &str,
        key: &str,
        index: Option<usize>,
        fault: String,
        remedy: &str,
    ) {
        let element = index.map_or_else(String::new, |i| format!("[{i}]"));
        self.faults.push(FileFault {
            file: self.file.to_owned(),
            place: self.source.and_then(|source| {
                let places = self.places.get_or_init(|| Places::of(source));
                places.find(section, key, index)
            }),
            fault: format!("{section}.{key}{element}: {fault}"),
            remedy: remedy.to_owned(),
        });
    }

    fn number(&mut self, section: &str, key: &str, value: f64, must: Must) {
        if !must.holds(value) {
            self.fault(section, key, None, format!("is {value}"), must.remedy());
        }
    }

    fn numbers(&mut self, section: &str, key: &str, values: &[f64], must: Must) {
        for (index, &value) in values.iter().enumerate() {
            if !must.holds(value) {
                self.fault(section, key, Some(index), format!("is {value}"), must.remedy());
            }
        }
    }

    /// Abscissae: at least `least` of them, finite and strictly increasing.
    fn abscissae(&mut self, section: &str, key: &str, values: &[f64], least: usize) {
        if values.len() < least {
            let fault = format!("has {} entries", values.len());
            self.fault(section, key, None, fault, &format!("give at least {least}"));
        }
        if let Some(error) = first_abscissa_fault(values) {
            let index = match error {
                TableError::AbscissaNotFinite { index, .. }
                | TableError::NotIncreasing { index, .. } => Some(index),
                _ => None,
            };
            self.fault(
                section,
                key,
                index,
                error.to_string(),
                "abscissae must be finite and strictly increasing",
            );
        }
    }

    /// Ordinates: as many as the abscissae, each as required.
    fn ordinates(&mut self, section: &str, key: &str, values: &[f64], wanted: usize, must: Must) {
        if values.len() != wanted {
            let fault = format!("has {} entries where {wanted} are needed", values.len());
            self.fault(section, key, None, fault, "give one entry for each abscissa");
        }
        self.numbers(section, key, values, must);
    }
}

/// All faults of `data`; `text` is the TOML it came from, if it came from one.
pub(crate) fn faults(file: &str, text: Option<&str>, data: &VehicleData) -> Vec<FileFault> {
    let mut check = Checker {
        file,
        source: text.map(|text| Source { file, text }),
        places: OnceCell::new(),
        faults: Vec::new(),
    };
    scalars(&mut check, data);
    tables(&mut check, data);
    schedules(&mut check, data);
    sums(&mut check, data);
    check.faults
}

fn scalars(check: &mut Checker<'_>, d: &VehicleData) {
    use Must::{BeFinite, BePositive, NotBeNegative};
    let rules = [
        ("site", "lat_deg", d.site.lat_deg, BeFinite),
        ("site", "azimuth_deg", d.site.azimuth_deg, BeFinite),
        ("site", "earth_radius", d.site.earth_radius_m, BePositive),
        ("site", "mu", d.site.mu_m3ps2, BePositive),
        ("site", "alt0", d.site.launch_altitude_m, BeFinite),
        ("geometry", "length", d.geometry.length_m, BePositive),
        ("geometry", "diameter", d.geometry.diameter_m, BePositive),
        ("geometry", "S_ref", d.geometry.reference_area_m2, BePositive),
        ("geometry", "l_ref", d.geometry.reference_length_m, BePositive),
        ("geometry", "x_nozzle", d.geometry.nozzle_x_m, BeFinite),
        ("geometry", "x_sitvc", d.geometry.injection_x_m, BeFinite),
        ("geometry", "x_fin", d.geometry.fin_x_m, BeFinite),
        ("geometry", "x_tip", d.geometry.tip_x_m, BeFinite),
        ("geometry", "y_tip", d.geometry.tip_y_m, BePositive),
        ("geometry", "y_fin", d.geometry.fin_y_m, BePositive),
        ("mass", "m0", d.mass.launch_mass_kg, BePositive),
        ("mass", "m_prop1", d.mass.propellant_kg, BePositive),
        ("mass", "burn_time", d.mass.burn_time_s, BePositive),
        ("mass", "prop_x", d.mass.propellant_x_m, BeFinite),
        ("mass", "prop_len", d.mass.propellant_length_m, BePositive),
        ("mass", "r_exit", d.mass.exit_radius_m, NotBeNegative),
        ("thrust", "isp_vac", d.thrust.specific_impulse_s, BePositive),
        ("thrust", "A_exit", d.thrust.exit_area_m2, NotBeNegative),
        ("aero", "S_tip", d.aero.tip_area_m2, NotBeNegative),
        ("aero", "fin_cant_deg", d.aero.fin_cant_deg, BeFinite),
        ("ftc", "tau", d.ftc.time_constant_s, BePositive),
        ("ftc", "delta_max_deg", d.ftc.delta_max_deg, BePositive),
        ("ftc", "rate_max_dps", d.ftc.rate_max_dps, BePositive),
        ("ftc", "t_on", d.ftc.on_time_s, NotBeNegative),
        ("tvc", "tau", d.tvc.time_constant_s, BePositive),
        ("tvc", "F_max", d.tvc.force_max_n, BePositive),
        ("tvc", "Isp_side", d.tvc.side_specific_impulse_s, BePositive),
        ("tvc", "fluid", d.tvc.fluid_kg, NotBeNegative),
        ("gyro", "wn", d.gyro.natural_frequency_radps, BePositive),
        ("gyro", "zeta", d.gyro.damping_ratio, NotBeNegative),
        ("imu", "T_sample", d.imu.sample_period_s, BePositive),
        ("bending", "phi_c", d.bending.displacement_at_control, BeFinite),
        ("bending", "zeta", d.bending.damping_ratio, NotBeNegative),
        ("bending", "lam_gyro", d.bending.gyro_slope_pm, BeFinite),
        ("bending", "filter_w", d.bending.filter_corner_radps, BePositive),
        ("bending", "lam_imu", d.bending.imu_slope_pm, BeFinite),
        ("disturbance", "thrust_misalign_deg", d.disturbance.thrust_misalign_deg, BeFinite),
        ("disturbance", "cg_offset", d.disturbance.cg_offset_m, BeFinite),
        ("disturbance", "gust_step_mps", d.disturbance.gust_step_mps, BeFinite),
        ("limits", "q_alpha_Pa_deg", d.limits.q_alpha_padeg, BePositive),
        ("pitch_programme", "theta0_deg", d.pitch_programme.theta0_deg, BeFinite),
        ("wind", "h_ref", d.wind.reference_altitude_m, BeFinite),
        ("wind", "shear_a", d.wind.shear_a, NotBeNegative),
        ("wind", "gust_mps", d.wind.gust_mps, NotBeNegative),
        ("wind", "combine", d.wind.combination_factor, NotBeNegative),
        ("wind", "gust_len", d.wind.gust_length_m, NotBeNegative),
        ("wind", "cross_frac", d.wind.cross_fraction, BeFinite),
        ("gains", "K_phi", d.gains.roll_gain, NotBeNegative),
        ("gains", "T_phi", d.gains.roll_lead_s, NotBeNegative),
        ("gains", "decoupled_yaw_KT", d.gains.decoupled_yaw_gain_factor, NotBeNegative),
        ("gains", "decoupled_yaw_TT", d.gains.decoupled_yaw_lead_s, NotBeNegative),
        ("long_period_case", "wind_sign", d.long_period_case.wind_sign, BeFinite),
        ("long_period_case", "misalign_pitch", d.long_period_case.misalign_pitch, BeFinite),
        ("long_period_case", "misalign_yaw", d.long_period_case.misalign_yaw, BeFinite),
        (
            "long_period_case",
            "accept_dV_frac",
            d.long_period_case.accept_speed_fraction,
            BePositive,
        ),
        ("long_period_case", "accept_dgam_deg", d.long_period_case.accept_dgam_deg, BePositive),
        (
            "long_period_case",
            "accept_dh_frac",
            d.long_period_case.accept_altitude_fraction,
            BePositive,
        ),
        ("long_period_case", "accept_drange_km", d.long_period_case.accept_drange_km, BePositive),
        ("windstat", "mean_frac", d.windstat.mean_fraction, BeFinite),
        ("windstat", "sigma_frac", d.windstat.sigma_fraction, NotBeNegative),
        ("windstat", "L_large", d.windstat.large_length_m, BePositive),
        ("windstat", "sigma_small", d.windstat.small_sigma_mps, NotBeNegative),
        ("windstat", "L_small", d.windstat.small_length_m, BePositive),
        ("windstat", "dryden_L", d.windstat.dryden_length_m, BePositive),
        ("windstat", "dryden_sigma", d.windstat.dryden_sigma_mps, NotBeNegative),
    ];
    for (section, key, value, must) in rules {
        check.number(section, key, value, must);
    }
}

fn tables(check: &mut Checker<'_>, d: &VehicleData) {
    use Must::{BeFinite, BePositive, NotBeNegative};
    check.abscissae("mass", "Ixx_t", &d.mass.roll_inertia_time_s, 2);
    let n = d.mass.roll_inertia_time_s.len();
    check.ordinates("mass", "Ixx_v", &d.mass.roll_inertia_kgm2, n, BePositive);
    check.numbers("mass", "stage_gross", &d.mass.stage_gross_kg, BePositive);

    check.abscissae("thrust", "t", &d.thrust.time_s, 2);
    check.ordinates("thrust", "F", &d.thrust.vacuum_thrust_n, d.thrust.time_s.len(), NotBeNegative);
    if d.thrust.vacuum_thrust_n.iter().sum::<f64>() <= 0.0 {
        check.fault(
            "thrust",
            "F",
            None,
            "is zero throughout".to_owned(),
            "give a motor with an impulse",
        );
    }
    if let (Some(&first), Some(&last)) = (d.thrust.time_s.first(), d.thrust.time_s.last())
        && (first > 0.0 || last < d.mass.burn_time_s)
    {
        let fault = format!("covers {first} s to {last} s only");
        check.fault("thrust", "t", None, fault, "cover lift-off (0 s) to mass.burn_time");
    }

    check.abscissae("aero", "mach", &d.aero.mach, 2);
    let n = d.aero.mach.len();
    check.ordinates("aero", "C_A", &d.aero.axial, n, NotBeNegative);
    check.ordinates("aero", "CN_body", &d.aero.body_slope, n, NotBeNegative);
    check.ordinates("aero", "x_body", &d.aero.body_x_m, n, BeFinite);
    check.ordinates("aero", "CN_fin", &d.aero.fin_slope, n, NotBeNegative);
    check.ordinates("aero", "CN_tip", &d.aero.tip_slope, n, NotBeNegative);

    check.abscissae("bending", "t", &d.bending.time_s, 2);
    let n = d.bending.time_s.len();
    check.ordinates("bending", "freq_hz", &d.bending.freq_hz, n, BePositive);
    check.ordinates("bending", "M_gen", &d.bending.generalised_mass_kg, n, BePositive);
    check.abscissae("bending", "lam_gyro_alt_x", &d.bending.alternative_gyro_x_m, 2);
    let n = d.bending.alternative_gyro_x_m.len();
    check.ordinates("bending", "lam_gyro_alt", &d.bending.alternative_gyro_slope_pm, n, BeFinite);

    check.abscissae("pitch_programme", "t_nodes", &d.pitch_programme.node_time_s, 2);
    let segments = d.pitch_programme.node_time_s.len().saturating_sub(1);
    if d.pitch_programme.rate_dps.len() != segments {
        let fault =
            format!("has {} entries where {segments} are needed", d.pitch_programme.rate_dps.len());
        check.fault(
            "pitch_programme",
            "rate_dps",
            None,
            fault,
            "give one rate for each interval between nodes",
        );
    }
    check.numbers("pitch_programme", "rate_dps", &d.pitch_programme.rate_dps, BeFinite);

    check.abscissae("wind", "env_h", &d.wind.envelope_altitude_m, 2);
    let n = d.wind.envelope_altitude_m.len();
    check.ordinates("wind", "env_w", &d.wind.envelope_speed_mps, n, NotBeNegative);

    if let Some(derived) = &d.derived {
        check.abscissae("derived", "t", &derived.time_s, 2);
        let n = derived.time_s.len();
        check.ordinates("derived", "mass", &derived.mass_kg, n, BePositive);
        check.ordinates("derived", "xcg", &derived.cg_x_m, n, BeFinite);
        check.ordinates("derived", "Iyy", &derived.pitch_inertia_kgm2, n, BePositive);
        check.ordinates("derived", "Ixx", &derived.roll_inertia_kgm2, n, BePositive);
        check.ordinates("derived", "F_vac", &derived.vacuum_thrust_n, n, NotBeNegative);
        check.ordinates("derived", "mdot", &derived.mass_flow_kgps, n, NotBeNegative);
    }
}

fn schedules(check: &mut Checker<'_>, d: &VehicleData) {
    for (section, schedule) in [("gains", &d.gains.schedule()), ("gains_reduced", &d.gains_reduced)]
    {
        schedule_faults(check, section, schedule);
    }
}

fn schedule_faults(check: &mut Checker<'_>, section: &str, s: &ScheduleData) {
    check.abscissae(section, "t_sw", &s.switch_time_s, 1);
    if s.switch_time_s.first().is_some_and(|&t| t != 0.0) {
        let fault = format!("starts at {} s", s.switch_time_s[0]);
        check.fault(section, "t_sw", Some(0), fault, "the first switch time must be 0");
    }
    let n = s.switch_time_s.len();
    for (key, values) in [
        ("K_F", &s.ftc_gain),
        ("T_F", &s.ftc_lead_s),
        ("K_T", &s.tvc_gain_npdeg),
        ("T_T", &s.tvc_lead_s),
        ("e_dz_deg", &s.dead_zone_deg),
    ] {
        check.ordinates(section, key, values, n, Must::NotBeNegative);
    }
}

/// Components and propellant must make the launch mass to the kilogram.
fn sums(check: &mut Checker<'_>, d: &VehicleData) {
    let mut dry_kg = 0.0;
    for (index, component) in d.mass.components.iter().enumerate() {
        dry_kg += component.1;
        let bad = !(Must::BePositive.holds(component.1)
            && component.2.is_finite()
            && Must::NotBeNegative.holds(component.3));
        if bad {
            let fault = format!(
                "\"{}\" has mass {}, x {}, length {}",
                component.0, component.1, component.2, component.3
            );
            check.fault(
                "mass",
                "components",
                Some(index),
                fault,
                "give a positive mass, a finite station and a length that is not negative",
            );
        }
    }
    let total_kg = dry_kg + d.mass.propellant_kg;
    if total_kg.is_finite() && (total_kg - d.mass.launch_mass_kg).abs() > 1.0 {
        let fault = format!(
            "components and propellant add up to {total_kg} kg, m0 is {} kg",
            d.mass.launch_mass_kg
        );
        check.fault("mass", "components", None, fault, "make them agree to 1 kg");
    }
}
