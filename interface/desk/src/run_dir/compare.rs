//! Whether two traces are one, to the last bit.

use super::Trace;
use interface::Tick;
use std::fmt;

/// Where two traces first differ.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// Their columns have other names, units or order.
    Columns,
    /// One has a row more.
    Rows(usize, usize),
    /// A row at another instant.
    Instant {
        /// The row, counted from 0.
        row: usize,
        /// Instants in the first and in the second trace.
        ticks: [Tick; 2],
    },
    /// A value.
    Value {
        /// The row, counted from 0.
        row: usize,
        /// Its instant.
        tick: Tick,
        /// The column.
        column: String,
        /// Values in the first and in the second trace.
        values: [f64; 2],
    },
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Difference::Columns => write!(f, "the columns are not the same"),
            Difference::Rows(a, b) => write!(f, "{a} rows against {b}"),
            Difference::Instant { row, ticks } => {
                write!(f, "row {row}: at {} against {}", ticks[0], ticks[1])
            }
            Difference::Value { row, tick, column, values: [a, b] } => write!(
                f,
                "row {row} at {tick}: `{column}` is {a:e} against {b:e} (bits {:016x} and {:016x})",
                a.to_bits(),
                b.to_bits()
            ),
        }
    }
}

/// The first difference within the first `rows` rows, row by row; a value differs when
/// any of its bits does, so that a NaN equals itself and the zeros differ by sign.
pub fn first_difference(a: &Trace, b: &Trace, rows: usize) -> Option<Difference> {
    if a.columns() != b.columns() {
        return Some(Difference::Columns);
    }
    let (in_a, in_b) = (a.rows().min(rows), b.rows().min(rows));
    for row in 0..in_a.min(in_b) {
        let ticks = [a, b].map(|t| Tick(t.ticks()[row]));
        if ticks[0] != ticks[1] {
            return Some(Difference::Instant { row, ticks });
        }
        for (index, column) in a.columns().iter().enumerate() {
            let (Some(x), Some(y)) = (a.values(index), b.values(index)) else {
                continue;
            };
            if x[row].to_bits() != y[row].to_bits() {
                return Some(Difference::Value {
                    row,
                    tick: ticks[0],
                    column: column.name.clone(),
                    values: [x[row], y[row]],
                });
            }
        }
    }
    (in_a != in_b).then_some(Difference::Rows(in_a, in_b))
}

#[cfg(test)]
mod tests {
    use super::super::{Column, TraceWriter};
    use super::*;
    use std::path::Path;

    fn trace(rows: &[(i64, f64)]) -> Trace {
        let mut bytes = Vec::new();
        let columns = [Column::new("x", "m")];
        let mut writer = TraceWriter::new(&mut bytes, Path::new("t"), &columns, 4).unwrap();
        for &(tick, x) in rows {
            writer.push(Tick(tick), &[x]).unwrap();
        }
        writer.finish().unwrap();
        Trace::from_bytes(&bytes, Path::new("t")).unwrap()
    }

    #[test]
    fn one_bit_is_a_difference_and_a_nan_is_none() {
        let rows = [(0, 1.0), (5, f64::NAN), (9, 0.0)];
        let sound = trace(&rows);
        assert_eq!(first_difference(&sound, &trace(&rows), usize::MAX), None);
        let bit = trace(&[(0, 1.0), (5, f64::NAN), (9, -0.0)]);
        let found = first_difference(&sound, &bit, usize::MAX).unwrap();
        assert!(
            matches!(&found, Difference::Value { row: 2, tick: Tick(9), column, .. } if column == "x")
        );
        assert!(found.to_string().contains("8000000000000000"), "{found}");
        assert_eq!(first_difference(&sound, &bit, 2), None);
        assert_eq!(
            first_difference(&sound, &trace(&rows[..2]), usize::MAX),
            Some(Difference::Rows(3, 2))
        );
        assert!(matches!(
            first_difference(&sound, &trace(&[(1, 1.0)]), usize::MAX),
            Some(Difference::Instant { row: 0, .. })
        ));
    }
}
