//! The report of one flight: the ten variables that the paper monitors (section 4.2).

use maud::{Markup, html};

use super::plot::{Limit, Mark, Size};
use super::trace_figures::{Curve, FigureSpec, trace_figure};
use super::{
    Numbering, Partition, Section, Summary, block_diagram, page, provenance, side_by_side,
};
use crate::run_dir::{RunRecord, Trace, TraceError};

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
    let partition = numbering.figure(
        "partition",
        "Who computes what: control dynamics in the analog processor, trajectory dynamics in the digital one.",
        block_diagram(&Partition::long_period()),
    );
    let figures = ten_variables(context)
        .iter()
        .map(|spec| {
            let drawing = trace_figure(spec, trace, Size::HALF)?;
            Ok(numbering.figure(&spec.id, &spec.caption, drawing))
        })
        .collect::<Result<Vec<Markup>, TraceError>>()?;
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
