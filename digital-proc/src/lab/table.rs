//! Look-up tables of the laboratory's digital laws: linear and bilinear.
//!
//! Beyond the ends the end values hold, as in the analog function generators, so that
//! both sides mean the same function.

use super::theory::Refusal;

/// `y(x)` by linear interpolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Table1 {
    x: Vec<f64>,
    y: Vec<f64>,
}

/// Cell and weight in which `at` lies: value = (1 − w) yᵢ + w yᵢ₊₁.
fn locate(x: &[f64], at: f64) -> (usize, f64) {
    let i = x.partition_point(|b| *b <= at).clamp(1, x.len() - 1) - 1;
    (i, ((at - x[i]) / (x[i + 1] - x[i])).clamp(0.0, 1.0))
}

fn check_breakpoints(x: &[f64]) -> Result<(), Refusal> {
    let fault = |value| Refusal::Setting {
        what: "a table's breakpoint",
        value,
        range: "finite and above the one before it, two at least",
    };
    if x.len() < 2 || !x[0].is_finite() {
        return Err(fault(x.first().copied().unwrap_or(f64::NAN)));
    }
    match x.windows(2).find(|w| !w[1].is_finite() || w[1] <= w[0]) {
        Some(w) => Err(fault(w[1])),
        None => Ok(()),
    }
}

impl Table1 {
    /// Breakpoints x, increasing, and as many values y.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Result<Table1, Refusal> {
        check_breakpoints(&x)?;
        if x.len() != y.len() || y.iter().any(|v| !v.is_finite()) {
            return Err(Refusal::Setting {
                what: "a table's count of values",
                value: y.len() as f64,
                range: "that of its breakpoints, all finite",
            });
        }
        Ok(Table1 { x, y })
    }

    /// A straight line through the origin over ±`limit`.
    pub fn line(slope: f64, limit: f64) -> Result<Table1, Refusal> {
        Table1::new(vec![-limit, 0.0, limit], vec![-slope * limit, 0.0, slope * limit])
    }

    /// Value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        let (i, w) = locate(&self.x, x);
        self.y[i] + w * (self.y[i + 1] - self.y[i])
    }

    /// Last breakpoint.
    pub fn end(&self) -> f64 {
        self.x[self.x.len() - 1]
    }
}

/// `z(x, y)` by bilinear interpolation, row-major `[x][y]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Table2 {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Table2 {
    /// Breakpoints of x and y, and `x.len() · y.len()` values.
    pub fn new(x: Vec<f64>, y: Vec<f64>, z: Vec<f64>) -> Result<Table2, Refusal> {
        check_breakpoints(&x)?;
        check_breakpoints(&y)?;
        if z.len() != x.len() * y.len() || z.iter().any(|v| !v.is_finite()) {
            return Err(Refusal::Setting {
                what: "a table's count of values",
                value: z.len() as f64,
                range: "the product of its breakpoint counts, all finite",
            });
        }
        Ok(Table2 { x, y, z })
    }

    /// Ordinate at breakpoint `i` of x, for `y`: the c_i(M) of hybrid function generation.
    pub fn ordinate(&self, i: usize, y: f64) -> f64 {
        let (j, w) = locate(&self.y, y);
        let row = &self.z[i * self.y.len()..(i + 1) * self.y.len()];
        row[j] + w * (row[j + 1] - row[j])
    }

    /// Value at (x, y).
    pub fn value(&self, x: f64, y: f64) -> f64 {
        let (i, w) = locate(&self.x, x);
        let (a, b) = (self.ordinate(i, y), self.ordinate(i + 1, y));
        a + w * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_is_exact_for_a_bilinear_function() {
        let f = |x: f64, y: f64| 1.0 + 2.0 * x - y + 0.5 * x * y;
        let (x, y) = (vec![-1.0, 0.5, 2.0], vec![0.0, 3.0]);
        let z = x.iter().flat_map(|a| y.iter().map(move |b| f(*a, *b))).collect();
        let t = Table2::new(x, y, z).unwrap();
        for (a, b) in [(-1.0, 0.0), (0.0, 1.0), (0.5, 3.0), (1.7, 2.2), (2.0, 3.0)] {
            // Rounding of a handful of operations on numbers below 10.
            assert!((t.value(a, b) - f(a, b)).abs() < 1e-14);
        }
        assert_eq!(t.value(9.0, 9.0), t.value(2.0, 3.0));
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(Table1::new(vec![0.0], vec![0.0]).is_err());
        assert!(Table1::new(vec![0.0, 0.0], vec![0.0, 1.0]).is_err());
        assert!(Table1::new(vec![0.0, 1.0], vec![0.0]).is_err());
        assert!(Table1::new(vec![0.0, f64::NAN], vec![0.0, 1.0]).is_err());
    }
}
