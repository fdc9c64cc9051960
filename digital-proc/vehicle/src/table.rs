//! Linear interpolation in a one-dimensional table, with flagged edges.
//!
//! The trajectory computer looks up thrust, aerodynamic coefficients and wind
//! in tables. A look-up outside a table's abscissae is neither an error (the
//! vehicle does fly on after burn-out) nor silent: the end value is returned
//! **together with** the edge that was passed, and the caller records it.
//! This module refuses tables that are not strictly increasing or not finite;
//! it does not extrapolate.

/// Where an abscissa lies relative to a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Edge {
    /// Within the closed range of the table.
    Inside,
    /// Below the first abscissa: the first value was returned.
    Below,
    /// Above the last abscissa: the last value was returned.
    Above,
}

/// The answer of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lookup {
    /// Interpolated value; the end value beyond an edge; NaN for a NaN abscissa.
    pub value: f64,
    /// Slope of the segment used, zero beyond an edge (the value is held there).
    pub slope: f64,
    /// Which edge, if any, was passed.
    pub edge: Edge,
}

/// Why a table was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TableError {
    #[error("a table needs at least two points, this one has {points}")]
    TooShort { points: usize },
    #[error("{abscissae} abscissae but {ordinates} ordinates")]
    LengthMismatch { abscissae: usize, ordinates: usize },
    #[error("abscissa {index} is {value}, not a finite number")]
    AbscissaNotFinite { index: usize, value: f64 },
    #[error("ordinate {index} is {value}, not a finite number")]
    OrdinateNotFinite { index: usize, value: f64 },
    #[error("abscissa {index} ({value}) does not exceed the one before it ({previous})")]
    NotIncreasing { index: usize, value: f64, previous: f64 },
}

/// A piecewise-linear function y(x), shape `[n]`, n ≥ 2, abscissae strictly
/// increasing, everything finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    abscissae: Vec<f64>,
    ordinates: Vec<f64>,
}

impl Table {
    /// Builds a table; refuses the first fault found (abscissae before ordinates).
    pub fn new(abscissae: Vec<f64>, ordinates: Vec<f64>) -> Result<Self, TableError> {
        if abscissae.len() != ordinates.len() {
            return Err(TableError::LengthMismatch {
                abscissae: abscissae.len(),
                ordinates: ordinates.len(),
            });
        }
        if abscissae.len() < 2 {
            return Err(TableError::TooShort { points: abscissae.len() });
        }
        if let Some(fault) = first_abscissa_fault(&abscissae) {
            return Err(fault);
        }
        if let Some(index) = ordinates.iter().position(|y| !y.is_finite()) {
            return Err(TableError::OrdinateNotFinite { index, value: ordinates[index] });
        }
        Ok(Self { abscissae, ordinates })
    }

    /// y(x) by linear interpolation. Logarithmic in the number of points.
    pub fn lookup(&self, x: f64) -> Lookup {
        let last = self.abscissae.len() - 1;
        if x.is_nan() {
            return Lookup { value: f64::NAN, slope: f64::NAN, edge: Edge::Inside };
        }
        if x < self.abscissae[0] {
            return Lookup { value: self.ordinates[0], slope: 0.0, edge: Edge::Below };
        }
        if x > self.abscissae[last] {
            return Lookup { value: self.ordinates[last], slope: 0.0, edge: Edge::Above };
        }
        let right = self.abscissae.partition_point(|&a| a <= x).min(last);
        let (x0, x1) = (self.abscissae[right - 1], self.abscissae[right]);
        let (y0, y1) = (self.ordinates[right - 1], self.ordinates[right]);
        let slope = (y1 - y0) / (x1 - x0);
        // At x1 itself the form y0 + slope·(x − x0) may miss y1 by one rounding.
        let value = if x == x1 { y1 } else { y0 + slope * (x - x0) };
        Lookup { value, slope, edge: Edge::Inside }
    }

    pub fn abscissae(&self) -> &[f64] {
        &self.abscissae
    }

    pub fn ordinates(&self) -> &[f64] {
        &self.ordinates
    }

    /// The same table with every ordinate multiplied by `factor`; the caller
    /// gives a finite factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            abscissae: self.abscissae.clone(),
            ordinates: self.ordinates.iter().map(|y| y * factor).collect(),
        }
    }
}

/// The first abscissa that is not finite or does not exceed its predecessor.
pub(crate) fn first_abscissa_fault(abscissae: &[f64]) -> Option<TableError> {
    for (index, &value) in abscissae.iter().enumerate() {
        if !value.is_finite() {
            return Some(TableError::AbscissaNotFinite { index, value });
        }
        if index > 0 && value <= abscissae[index - 1] {
            return Some(TableError::NotIncreasing {
                index,
                value,
                previous: abscissae[index - 1],
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Table {
        Table::new(vec![0.0, 2.0, 6.0], vec![1.0, 5.0, -3.0]).unwrap()
    }

    #[test]
    fn breakpoints_are_returned_exactly_and_midpoints_are_means() {
        let table = triangle();
        // Exact: the numbers involved are small integers.
        for (x, y) in [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (4.0, 1.0), (6.0, -3.0)] {
            assert_eq!(table.lookup(x).value, y, "at {x}");
            assert_eq!(table.lookup(x).edge, Edge::Inside, "at {x}");
        }
        assert_eq!(table.lookup(1.0).slope, 2.0);
        assert_eq!(table.lookup(4.0).slope, -2.0);
    }

    #[test]
    fn beyond_an_edge_the_end_value_comes_with_a_flag() {
        let table = triangle();
        let below = table.lookup(-1e-12);
        assert_eq!((below.value, below.edge), (1.0, Edge::Below));
        let above = table.lookup(f64::INFINITY);
        assert_eq!((above.value, above.edge), (-3.0, Edge::Above));
        assert!(table.lookup(f64::NAN).value.is_nan());
    }

    #[test]
    fn faulty_tables_are_refused() {
        let whole = [0.0, 1.0];
        for (x, y, told) in [
            (&[0.0][..], &[0.0][..], "this one has 1"),
            (&whole, &[0.0], "2 abscissae but 1 ordinates"),
            (&[0.0, 0.0], &whole, "abscissa 1 (0) does not exceed"),
            (&[0.0, f64::NAN], &whole, "abscissa 1 is NaN"),
            (&whole, &[f64::INFINITY, 1.0], "ordinate 0 is inf"),
        ] {
            let error = Table::new(x.to_vec(), y.to_vec()).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
