//! Figures and a plain report straight from a trace's columns.

use maud::{Markup, html};

use super::plot::{Axis, Limit, LineChart, Mark, Series, Size, line_chart};
use super::{Numbering, Section, page, provenance, side_by_side};
use crate::run_dir::{RunRecord, Trace, TraceError};

/// One curve of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Column of the trace.
    pub column: String,
    /// Name in the legend; empty when the figure has one curve.
    pub name: String,
    /// What the column is multiplied by to reach the figure's unit.
    pub factor: f64,
}

/// A figure of columns against time.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureSpec {
    /// Anchor.
    pub id: String,
    /// Heading inside the figure.
    pub title: String,
    /// Caption under it.
    pub caption: String,
    /// The ordinate's quantity.
    pub label: String,
    /// The ordinate's unit.
    pub unit: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Limit lines, in the figure's unit.
    pub limits: Vec<Limit>,
    /// Event marks, s.
    pub marks: Vec<Mark>,
}

/// The figure drawn from `trace`.
///
/// # Errors
/// The trace lacks a column; the message lists those it has.
pub fn trace_figure(spec: &FigureSpec, trace: &Trace, size: Size) -> Result<Markup, TraceError> {
    let time_s = trace.time_s();
    let mut series = Vec::with_capacity(spec.curves.len());
    for curve in &spec.curves {
        let values: Vec<f64> =
            trace.column(&curve.column)?.iter().map(|value| value * curve.factor).collect();
        series.push(Series::line(curve.name.clone(), &time_s, &values));
    }
    Ok(line_chart(&LineChart {
        limits: spec.limits.clone(),
        marks: spec.marks.clone(),
        size,
        ..LineChart::new(
            spec.title.clone(),
            Axis::new("Time", "s"),
            Axis::new(spec.label.clone(), spec.unit.clone()),
            series,
        )
    }))
}

/// A report of any run: every column against time, and the provenance.
pub fn trace_report(title: &str, trace: &Trace, record: &RunRecord) -> String {
    let time_s = trace.time_s();
    let mut numbering = Numbering::new();
    let figures: Vec<Markup> = trace
        .columns()
        .iter()
        .enumerate()
        .filter_map(|(index, column)| Some((column, trace.values(index)?)))
        .map(|(column, values)| {
            let chart = LineChart::new(
                "",
                Axis::new("Time", "s"),
                Axis::new(column.name.clone(), column.unit.clone()),
                vec![Series::line("", &time_s, values)],
            );
            let id = super::anchor(&column.name);
            let caption = format!("{} against time.", column.name);
            numbering.figure(&id, &caption, line_chart(&chart.size(Size::HALF)))
        })
        .collect();
    let extent = format!("{} rows of {} columns.", trace.recorded(), trace.columns().len());
    let torn = "The run did not end its trace: rows after the last complete batch are lost.";
    let body = html! {
        p { (extent) }
        @if !trace.is_complete() { p { strong { (torn) } } }
        (side_by_side(&figures))
    };
    page(
        title,
        "",
        &[Section::new("Time histories", body), Section::new("Provenance", provenance(record))],
    )
}
