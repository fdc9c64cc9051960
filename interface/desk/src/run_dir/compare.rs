//! Whether two traces are one, to the last bit.

use super::Trace;
use interface::Tick;

/// The first difference within the first `rows` rows, row by row, in words; a value differs when
/// any of its bits does, so that a NaN equals itself and the zeros differ by sign.
pub fn first_difference(a: &Trace, b: &Trace, rows: usize) -> Option<String> {
    if a.columns() != b.columns() {
        return Some("the columns are not the same".to_owned());
    }
    let (in_a, in_b) = (a.rows().min(rows), b.rows().min(rows));
    for row in 0..in_a.min(in_b) {
        let [tick, other] = [a, b].map(|t| Tick(t.ticks()[row]));
        if tick != other {
            return Some(format!("row {row}: at {tick} against {other}"));
        }
        for (index, column) in a.columns().iter().enumerate() {
            let (Some(x), Some(y)) = (a.values(index), b.values(index)) else { continue };
            let (x, y) = (x[row], y[row]);
            if x.to_bits() != y.to_bits() {
                let bits = format!("bits {:016x} and {:016x}", x.to_bits(), y.to_bits());
                let name = &column.name;
                return Some(format!(
                    "row {row} at {tick}: `{name}` is {x:e} against {y:e} ({bits})"
                ));
            }
        }
    }
    (in_a != in_b).then(|| format!("{in_a} rows against {in_b}"))
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
        let differs = |other: &Trace, rows| first_difference(&sound, other, rows);
        assert_eq!(differs(&trace(&rows), usize::MAX), None);
        let bit = trace(&[(0, 1.0), (5, f64::NAN), (9, -0.0)]);
        let found = differs(&bit, usize::MAX).unwrap();
        assert!(found.starts_with("row 2 at 9ns: `x`"), "{found}");
        assert!(found.contains("8000000000000000"), "{found}");
        assert_eq!(differs(&bit, 2), None);
        assert_eq!(differs(&trace(&rows[..2]), usize::MAX).unwrap(), "3 rows against 2");
        assert!(differs(&trace(&[(1, 1.0)]), usize::MAX).unwrap().starts_with("row 0: at"));
    }
}
