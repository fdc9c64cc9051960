//! Measurement beside the theory that it is held against, in one style each.

use super::{Axis, LineChart, Series};

/// A theory and the measurement that it is held against, each as (abscissae, ordinates).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compared {
    /// What varies from one to the next; may be empty.
    pub name: String,
    /// Drawn as a line.
    pub theory: (Vec<f64>, Vec<f64>),
    /// Drawn as markers.
    pub measured: (Vec<f64>, Vec<f64>),
}

impl Compared {
    /// Without points.
    pub fn new(name: impl Into<String>) -> Compared {
        Compared { name: name.into(), ..Compared::default() }
    }

    /// Adds an abscissa at which there are both.
    pub fn push(&mut self, x: f64, theory: f64, measured: f64) {
        for (points, y) in [(&mut self.theory, theory), (&mut self.measured, measured)] {
            points.0.push(x);
            points.1.push(y);
        }
    }

    fn named(&self, what: &str) -> String {
        if self.name.is_empty() { what.to_owned() } else { format!("{}, {what}", self.name) }
    }
}

/// Theory as lines and measurement as markers, each two in one style.
pub fn measured_vs_theory(title: &str, x: Axis, y: Axis, compared: &[Compared]) -> LineChart {
    let series = compared
        .iter()
        .enumerate()
        .flat_map(|(i, each)| {
            let ((x, y), (at, found)) = (&each.theory, &each.measured);
            [
                Series::line(each.named("theory"), x, y).style(i),
                Series::markers(each.named("measured"), at, found).style(i),
            ]
        })
        .collect();
    LineChart::new(title, x, y, series)
}
