//! A trace as comma-separated values, for programs that read nothing better.
//!
//! One header line, then a line a row: `tick_ns`, `time_s`, and the columns with their
//! units. 17 significant digits determine an `f64`, so reading back is exact.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use super::{RunDirError, Trace};

impl Trace {
    /// Writes the trace as CSV to the file `path`.
    pub fn export_csv(&self, path: &Path) -> Result<(), RunDirError> {
        let file = File::create(path).map_err(RunDirError::write(path))?;
        write_csv(self, file).map_err(RunDirError::write(path))
    }
}

/// Writes `trace` to `sink`. Values that are not numbers appear as `NaN`, `inf`, `-inf`.
pub fn write_csv<W: Write>(trace: &Trace, sink: W) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(sink);
    let headings = trace.columns().iter().map(|column| {
        if column.unit.is_empty() {
            column.name.clone()
        } else {
            format!("{} [{}]", column.name, column.unit)
        }
    });
    csv.write_record(["tick_ns".to_owned(), "time_s".to_owned()].into_iter().chain(headings))?;
    let columns: Vec<&[f64]> =
        (0..trace.columns().len()).filter_map(|index| trace.values(index)).collect();
    let mut field = String::new();
    for (row, &tick) in trace.ticks().iter().enumerate() {
        csv.write_field(tick.to_string())?;
        let time_s = interface::Tick(tick).secs();
        for value in std::iter::once(time_s).chain(columns.iter().map(|column| column[row])) {
            field.clear();
            // Writing to a String cannot fail.
            let _ = write!(field, "{value:.16e}");
            csv.write_field(&field)?;
        }
        csv.write_record(None::<&[u8]>)?;
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use interface::Tick;
    use proptest::prelude::*;

    use super::super::{Column, TraceWriter};
    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn seventeen_digits_read_back_exactly(values in proptest::collection::vec(any::<f64>(), 1..50)) {
            let mut bytes = Vec::new();
            let columns = [Column::new("x, y", "m"), Column::new("mach", "")];
            let mut writer = TraceWriter::new(&mut bytes, Path::new("t"), &columns, 16).unwrap();
            for (n, &value) in values.iter().enumerate() {
                writer.push(Tick(n as i64), &[value, -value]).unwrap();
            }
            writer.finish().unwrap();
            let trace = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
            let mut text = Vec::new();
            write_csv(&trace, &mut text).unwrap();
            let mut reader = csv::Reader::from_reader(text.as_slice());
            prop_assert_eq!(
                reader.headers().unwrap(),
                &csv::StringRecord::from(vec!["tick_ns", "time_s", "x, y [m]", "mach"])
            );
            for (record, &value) in reader.records().zip(&values) {
                let read: f64 = record.unwrap()[2].parse().unwrap();
                // A NaN's payload does not survive text; every other value keeps all its bits.
                prop_assert!(read.to_bits() == value.to_bits() || read.is_nan() && value.is_nan());
            }
        }
    }
}
