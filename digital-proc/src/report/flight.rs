//! The figures of one flight: the ten variables that the paper monitors (section 4.2), with the
//! yaw plane's share of the load, and the way across the launch plane.

use super::impact::{IMPACT_CAPTION, impact_chart};
use desk::{
    outcome::Figure,
    report::plot::{Axis, Limit, LineChart, Series, Size, line_chart},
    run_dir::{RunDirError, Trace},
};
use vehicle::VehicleData;

/// Anchor, quantity, unit, and curves as (column, legend, factor to the unit).
type Row = (&'static str, &'static str, &'static str, &'static [(&'static str, &'static str, f64)]);

const DEG: f64 = 180.0 / std::f64::consts::PI;

const VARIABLES: [Row; 12] = [
    ("velocity", "Inertial velocity", "m/s", &[("velocity_m_s", "", 1.0)]),
    ("flight-path", "Inertial flight-path angle", "°", &[("flight_path_angle_rad", "", DEG)]),
    ("altitude", "Altitude", "km", &[("altitude_m", "", 1e-3)]),
    ("range-angle", "Range angle", "°", &[("range_angle_rad", "", DEG)]),
    ("alpha", "Pitch angle of attack", "°", &[("alpha_rad", "", DEG)]),
    ("mach", "Mach number", "", &[("mach", "", 1.0)]),
    ("dynamic-pressure", "Dynamic pressure Q", "kPa", &[("dynamic_pressure_pa", "", 1e-3)]),
    (
        "q-alpha",
        "Load indicator Qα",
        "kPa·°",
        &[
            ("q_alpha_pa_rad", "pitch, Qα", 1e-3 * DEG),
            ("q_alpha_total_pa_rad", "total, Q√(α² + α_y²)", 1e-3 * DEG),
        ],
    ),
    ("attitude", "Attitude", "°", &[("theta_rad", "pitch θ", DEG), ("phi_rad", "roll φ", DEG)]),
    ("tvc-force", "TVC force, pitch loop", "kN", &[("tvc_pitch_force_n", "", 1e-3)]),
    ("azimuth", "Azimuth off that of the launch", "°", &[("azimuth_departure_rad", "", DEG)]),
    ("cross-range", "Distance from the launch plane", "m", &[("cross_range_m", "", 1.0)]),
];

/// The variables, the paper's first and in its order, and the track of the impact point.
pub fn variables(trace: &Trace, data: &VehicleData) -> Result<Vec<Figure>, RunDirError> {
    let time_s = trace.time_s();
    let figure = |(id, quantity, unit, curves): Row| {
        let series = |&(column, name, factor): &(&str, &str, f64)| {
            let values: Vec<f64> = trace.column(column)?.iter().map(|v| v * factor).collect();
            Ok(Series::line(name, &time_s, &values))
        };
        let series = curves.iter().map(series).collect::<Result<_, RunDirError>>()?;
        let mut chart =
            LineChart::new("", Axis::new("Time", "s"), Axis::new(quantity, unit), series);
        if id == "q-alpha" {
            let limit = |sign| Limit {
                value: sign * data.limits.q_alpha_padeg / 1e3,
                name: "design limit".to_owned(),
            };
            chart.limits = vec![limit(1.0), limit(-1.0)];
        }
        let caption = format!("{quantity} against time.");
        Ok(Figure::new(id, caption, line_chart(&chart.size(Size::HALF))))
    };
    let mut figures: Vec<Figure> = VARIABLES.into_iter().map(figure).collect::<Result<_, _>>()?;
    let impact = [trace.column("impact_downrange_m")?, trace.column("impact_cross_m")?];
    let chart = impact_chart(&[("", impact)], &data.range_safety).size(Size::HALF);
    figures.push(Figure::new("impact", IMPACT_CAPTION, line_chart(&chart)));
    Ok(figures)
}
