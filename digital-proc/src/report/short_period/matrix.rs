//! The matrix of conditions against trajectory points, one measure at a time.

use maud::Markup;

use crate::study::short_period::outcome::Outcome;
use desk::report::plot::{HeatCell, HeatMap, heat_map};

/// One measure over all conditions and points: `value` of (condition, point).
pub struct Measure<'a> {
    /// What it is, with unit and criterion.
    pub quantity: String,
    /// Above this a cell is marked.
    pub limit: f64,
    /// Values of the palest and deepest tint.
    pub scale: (f64, f64),
    /// The value of a cell, by condition and point; `None` where there was no such run.
    pub value: &'a dyn Fn(usize, usize) -> Option<f64>,
    /// Where a cell leads.
    pub href: &'a dyn Fn(usize, usize) -> Option<String>,
}

/// The matrix; conditions without any value are left out.
pub fn matrix(outcome: &Outcome, measure: &Measure<'_>) -> Markup {
    let plan = &outcome.plan;
    let mut rows = Vec::new();
    let mut cells = Vec::new();
    for (condition, entry) in plan.conditions.iter().enumerate() {
        let row: Vec<HeatCell> = (0..plan.points.len())
            .map(|point| match (measure.value)(condition, point) {
                Some(value) => HeatCell {
                    value,
                    // A measure that is no number is outside.
                    violated: value.is_nan() || value > measure.limit,
                    href: (measure.href)(condition, point),
                },
                None => HeatCell::new(f64::NAN),
            })
            .collect();
        if (0..plan.points.len()).any(|point| (measure.value)(condition, point).is_some()) {
            rows.push(if entry.title.is_empty() {
                entry.name.clone()
            } else {
                entry.title.clone()
            });
            cells.push(row);
        }
    }
    heat_map(&HeatMap {
        quantity: measure.quantity.clone(),
        corner: "Condition".to_owned(),
        rows,
        columns: plan
            .points
            .iter()
            .map(|p| format!("{} {:.1} s", p.name, p.slice.time_s))
            .collect(),
        cells,
        scale: Some(measure.scale),
        digits: 2,
    })
}
