//! The report of one flight: the ten variables that the paper monitors (section 4.2).

use maud::{Markup, html};

use super::{Partition, block_diagram};
use desk::report::plot::{Limit, Mark, Size};
use desk::report::{Curve, FigureSpec, trace_figure};
use desk::report::{Numbering, Section, Summary, page, provenance, side_by_side};
use desk::run_dir::{RunRecord, Trace, TraceError};

/// Columns that a flight's trace must have for this report, with their units (SI, radians).
pub const FLIGHT_COLUMNS: [(&str, &str); 11] = [
    ("velocity_m_s", "m/s"),
    ("flight_path_angle_rad", "rad"),
    ("altitude_m", "m"),
    ("range_angle_rad", "rad"),
    ("alpha_rad", "rad"),
    ("mach", ""),
    ("dynamic_pressure_pa", "Pa"),
    ("q_alpha_pa_rad", "Pa·rad"),
    ("theta_rad", "rad"),
    ("phi_rad", "rad"),
    ("tvc_pitch_force_n", "N"),
];

/// What the report says beside the trace.
#[derive(Clone, Debug, Default)]
pub struct FlightContext {
    /// Heading of the page (`First-stage flight, normal mode`).
    pub title: String,
    /// One or two sentences under it.
    pub lead: String,
    /// Limit of |Qα|, Pa·rad; drawn when present.
    pub q_alpha_limit_pa_rad: Option<f64>,
    /// Events of the flight, s.
    pub marks: Vec<Mark>,
    /// Further sections, set before the provenance.
    pub further: Vec<Section>,
}

/// The figures of the ten variables, in the paper's order.
pub fn ten_variables(context: &FlightContext) -> Vec<FigureSpec> {
    let degrees = 1f64.to_degrees();
    // Anchor, title, unit, and curves as (column, legend, factor).
    type Row<'a> = (&'a str, &'a str, &'a str, &'a [(&'a str, &'a str, f64)]);
    let rows: [Row<'_>; 10] = [
        ("velocity", "Inertial velocity", "m/s", &[("velocity_m_s", "", 1.0)]),
        (
            "flight-path",
            "Inertial flight-path angle",
            "°",
            &[("flight_path_angle_rad", "", degrees)],
        ),
        ("altitude", "Altitude", "km", &[("altitude_m", "", 1e-3)]),
        ("range-angle", "Range angle", "°", &[("range_angle_rad", "", degrees)]),
        ("alpha", "Pitch angle of attack", "°", &[("alpha_rad", "", degrees)]),
        ("mach", "Mach number", "", &[("mach", "", 1.0)]),
        ("dynamic-pressure", "Dynamic pressure Q", "kPa", &[("dynamic_pressure_pa", "", 1e-3)]),
        ("q-alpha", "Load indicator Qα", "kPa·°", &[("q_alpha_pa_rad", "", 1e-3 * degrees)]),
        (
            "attitude",
            "Attitude",
            "°",
            &[("theta_rad", "pitch θ", degrees), ("phi_rad", "roll φ", degrees)],
        ),
        ("tvc-force", "TVC force, pitch loop", "kN", &[("tvc_pitch_force_n", "", 1e-3)]),
    ];
    rows.into_iter()
        .map(|(id, title, unit, curves)| FigureSpec {
            id: id.to_owned(),
            title: String::new(),
            caption: format!("{title} against time."),
            label: title.to_owned(),
            unit: unit.to_owned(),
            curves: curves
                .iter()
                .map(|&(column, name, factor)| Curve {
                    column: column.to_owned(),
                    name: name.to_owned(),
                    factor,
                })
                .collect(),
            limits: match context.q_alpha_limit_pa_rad {
                Some(limit) if id == "q-alpha" => {
                    [(limit, "design limit"), (-limit, "design limit")]
                        .map(|(value, name)| Limit {
                            value: value * 1e-3 * degrees,
                            name: name.to_owned(),
                        })
                        .to_vec()
                }
                _ => Vec::new(),
            },
            marks: context.marks.clone(),
        })
        .collect()
}

/// The report of a flight as a page.
///
/// # Errors
/// The trace lacks one of [`FLIGHT_COLUMNS`].
pub fn flight_report(
    context: &FlightContext,
    summary: &Summary,
    trace: &Trace,
    record: &RunRecord,
) -> Result<String, TraceError> {
    let mut numbering = Numbering::new();
    let figures = ten_variables(context)
        .iter()
        .map(|spec| {
            let drawing = trace_figure(spec, trace, Size::HALF)?;
            Ok(numbering.figure(&spec.id, &spec.caption, drawing))
        })
        .collect::<Result<Vec<Markup>, TraceError>>()?;
    let partition = numbering.figure(
        "partition",
        "Who computes what: control dynamics in the analog processor, trajectory dynamics in the digital one.",
        block_diagram(&Partition::long_period()),
    );
    let torn = html! {
        @if !trace.is_complete() {
            p { strong { "The run did not end its trace; what follows reaches to its last complete batch." } }
        }
    };
    let mut sections = vec![
        Section::new("Results", html! { (torn) (summary.table().markup()) }),
        Section::new("The ten monitored variables", side_by_side(&figures)),
        Section::new("Partition", partition),
    ];
    sections.extend(context.further.iter().cloned());
    sections.push(Section::new("Provenance", provenance(record)));
    Ok(page(&context.title, &context.lead, &sections))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use interface::Tick;

    use super::*;
    use desk::report::trace_report;
    use desk::run_dir::{Column, PatchIdentity, Seed, TraceWriter};

    /// A smooth stand-in for a flight: shapes and magnitudes only.
    fn sample_trace(rows: usize) -> Trace {
        let columns = FLIGHT_COLUMNS.map(|(name, unit)| Column::new(name, unit));
        let mut bytes = Vec::new();
        let mut writer = TraceWriter::new(&mut bytes, Path::new("sample"), &columns, 64).unwrap();
        for n in 0..rows {
            let t = 49.0 * n as f64 / (rows - 1) as f64;
            let q = 95_000.0 * (-((t - 32.0) / 11.0).powi(2)).exp();
            let alpha = 0.03 * (t * 0.9).sin() * (-t / 30.0).exp();
            let row = [
                21.5 * t,
                1.57 - 0.4 * (t / 49.0).powi(2),
                9.8 * t * t,
                2e-5 * t * t,
                alpha,
                0.07 * t,
                q,
                q * alpha,
                1.57 - 0.42 * (t / 49.0).powi(2) + 0.01 * (2.0 * t).sin(),
                0.002 * (0.7 * t).cos(),
                if t > 17.0 { 8_000.0 * (3.0 * t).sin() } else { 0.0 },
            ];
            writer.push(Tick((t * 1e9) as i64), &row).unwrap();
        }
        writer.finish().unwrap();
        Trace::from_bytes(&bytes, Path::new("sample")).unwrap()
    }

    fn sample_record() -> RunRecord {
        RunRecord {
            command: "fly normal".to_owned(),
            command_line: ["digital-proc", "fly", "--mode", "normal"].map(str::to_owned).to_vec(),
            started: "2026-03-01T12:34:56Z".to_owned(),
            profile: "ideal".to_owned(),
            link: "shm".to_owned(),
            versions: [("digital-proc".to_owned(), "0.1.0".to_owned())].into(),
            patch: Some(PatchIdentity {
                name: "stage.toml".to_owned(),
                sha256: "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
                    .to_owned(),
            }),
            seeds: [("gyro noise".to_owned(), Seed(7))].into(),
            parameters: toml::toml! { frame = "100ms" [wind] shear_per_s = 0.028 },
        }
    }

    fn sample_flight(rows: usize) -> String {
        let mut summary = Summary::new();
        summary.add(
            "max_q_kpa",
            "Maximum dynamic pressure",
            94.87,
            4,
            "kPa",
            "at 32.1 s, Mach 2.21",
        );
        summary.add("velocity_m_s", "Burn-out velocity", 1053.2, 5, "m/s", "");
        summary.add("altitude_km", "Burn-out altitude", 23.61, 4, "km", "");
        let context = FlightContext {
            title: "First-stage flight, normal mode".to_owned(),
            lead: "Two processes, 0.1 s frames, no wind.".to_owned(),
            q_alpha_limit_pa_rad: Some(2_000.0),
            marks: vec![Mark { x: 17.0, name: "FTC on".to_owned() }],
            further: Vec::new(),
        };
        flight_report(&context, &summary, &sample_trace(rows), &sample_record()).unwrap()
    }

    #[test]
    fn pages_are_self_contained_and_links_have_targets() {
        for html in [sample_flight(491), trace_report("t", &sample_trace(20), &sample_record())] {
            for outside in
                ["http:", "https:", "//", "src=", "import", "url(", "fetch", "<link", "NaN"]
            {
                assert!(!html.contains(outside), "{outside}");
            }
            for link in html.split("href=\"").skip(1) {
                let target = link.split('"').next().unwrap().strip_prefix('#').unwrap();
                assert!(html.contains(&format!("id=\"{target}\"")), "#{target} leads nowhere");
            }
        }
    }

    #[test]
    fn a_flights_report_is_small() {
        // Eleven curves of at most 800 points of at most 10 bytes, and 60 kB for the rest.
        let html = sample_flight(24_500);
        assert!(html.len() < 11 * 800 * 10 + 60_000, "{} bytes", html.len());
    }

    #[test]
    fn a_missing_column_is_named() {
        let columns = [Column::new("velocity_m_s", "m/s")];
        let mut bytes = Vec::new();
        TraceWriter::new(&mut bytes, Path::new("t"), &columns, 8).unwrap().finish().unwrap();
        let trace = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
        let error =
            flight_report(&FlightContext::default(), &Summary::new(), &trace, &sample_record());
        assert!(error.unwrap_err().to_string().contains("flight_path_angle_rad"));
    }
}
