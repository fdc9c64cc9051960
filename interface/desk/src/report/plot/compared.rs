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

    /// Points (x, theory, measured).
    pub fn of(
        name: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Compared {
        let mut all = Compared::new(name);
        for (x, theory, measured) in points {
            for (to, y) in [(&mut all.theory, theory), (&mut all.measured, measured)] {
                to.0.push(x);
                to.1.push(y);
            }
        }
        all
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
