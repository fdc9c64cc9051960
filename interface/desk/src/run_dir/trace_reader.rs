//! The trace as it is read: all complete batches, and whether the stream was ended.
//!
//! What follows the last whole message is the torn tail of a killed run and is left out.
//! A trace may be longer than memory: for figures it is thinned while it is read.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_ipc::reader::StreamReader;
use arrow_schema::{DataType, Schema};

use super::RunDirError;
use super::thin::Rows;
use super::trace::{Column, TICK_COLUMN, UNIT_KEY, arrow};
use super::trace_messages::Messages;

/// Rows that a thinned trace has at most; every usual run has fewer.
const MOST_ROWS: usize = 1 << 16;

/// A trace in memory, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    path: PathBuf,
    columns: Vec<Column>,
    ticks: Vec<i64>,
    values: Vec<Vec<f64>>,
    /// Complete rows of the file, of which some may have been left out.
    recorded: usize,
    complete: bool,
}

impl Trace {
    /// Reads the trace at `path` up to its last complete batch.
    pub fn read(path: &Path) -> Result<Trace, RunDirError> {
        Trace::collect(open(path)?, path, usize::MAX)
    }

    /// As [`Trace::read`]; of a long trace only the rows that a picture shows, so that
    /// memory stays bounded: [`Trace::recorded`] tells how many there were.
    pub fn read_thinned(path: &Path) -> Result<Trace, RunDirError> {
        Trace::collect(open(path)?, path, MOST_ROWS)
    }

    /// The same from bytes in memory; `path` serves messages only.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Trace, RunDirError> {
        Trace::collect(bytes, path, usize::MAX)
    }

    fn collect(source: impl Read, path: &Path, most: usize) -> Result<Trace, RunDirError> {
        let arrow = |cause| arrow(path, cause);
        let mut messages = Messages::new(source);
        if !messages.begin().map_err(|f| f.told_of(path))? {
            return Err(RunDirError::Refused(format!(
                "trace `{}` ends before its column names are complete: nothing was recorded; repeat the run",
                path.display()
            )));
        }
        let mut reader = StreamReader::try_new(messages, None).map_err(arrow)?;
        let columns = columns_of(&reader.schema())
            .map_err(|reason| RunDirError::not_a_trace(path, &reason))?;
        let mut rows = Rows::new(columns.len(), most);
        loop {
            let batch = reader.next();
            if let Some(fault) = reader.get_mut().take_fault() {
                return Err(fault.told_of(path));
            }
            let Some(batch) = batch else { break };
            let batch = batch.map_err(arrow)?;
            let ticks = batch.column(0).as_primitive::<Int64Type>().values();
            let values = batch.columns()[1..].iter();
            let values: Vec<&[f64]> =
                values.map(|array| array.as_primitive::<Float64Type>().values().as_ref()).collect();
            rows.push(ticks, &values);
        }
        Ok(Trace {
            path: path.to_owned(),
            columns,
            complete: reader.get_ref().ended(),
            recorded: rows.seen(),
            ticks: rows.ticks,
            values: rows.values,
        })
    }

    /// Its columns, the tick column left out.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of complete rows in the file.
    pub fn recorded(&self) -> usize {
        self.recorded
    }

    /// Number of complete rows here; all of them, unless it was read thinned.
    pub fn rows(&self) -> usize {
        self.ticks.len()
    }

    /// Whether the run ended the trace itself; otherwise rows after the last complete batch
    /// are lost.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Problem time of each row, ns.
    pub fn ticks(&self) -> &[i64] {
        &self.ticks
    }

    /// Problem time of each row, s, rounded once.
    pub fn time_s(&self) -> Vec<f64> {
        self.ticks.iter().map(|&ns| interface::Tick(ns).secs()).collect()
    }

    /// The values of column `index`, one a row.
    pub fn values(&self, index: usize) -> Option<&[f64]> {
        self.values.get(index).map(Vec::as_slice)
    }

    /// The values of the column of that name.
    pub fn column(&self, name: &str) -> Result<&[f64], RunDirError> {
        self.columns
            .iter()
            .position(|column| column.name == name)
            .map(|index| self.values[index].as_slice())
            .ok_or_else(|| {
                let known: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
                let (path, known) = (self.path.display(), known.join(", "));
                RunDirError::Refused(format!(
                    "trace `{path}` has no column `{name}`; it has {known}"
                ))
            })
    }
}

/// Opens a file that can be read to its end: a pipe in its place would be waited for.
fn open(path: &Path) -> Result<impl Read, RunDirError> {
    let fail = RunDirError::read(path);
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() => Ok(BufReader::new(File::open(path).map_err(fail)?)),
        Ok(_) => Err(fail(io::Error::other("it is no file"))),
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => {
            Err(RunDirError::Refused(format!(
                "there is no `{}`: flights keep a trace and, on the wall clock, their transfers; not every command does",
                path.display()
            )))
        }
        Err(cause) => Err(fail(cause)),
    }
}

/// The columns of a trace's schema.
fn columns_of(schema: &Schema) -> Result<Vec<Column>, String> {
    let (first, rest) = schema.fields().split_first().ok_or("it has no columns")?;
    if first.name() != TICK_COLUMN || *first.data_type() != DataType::Int64 {
        return Err(format!(
            "its first column is `{}`, not the integer column `{TICK_COLUMN}`",
            first.name()
        ));
    }
    rest.iter()
        .map(|field| {
            if *field.data_type() != DataType::Float64 {
                return Err(format!("its column `{}` is not of f64", field.name()));
            }
            let unit = field.metadata().get(UNIT_KEY).map(ToString::to_string).unwrap_or_default();
            Ok(Column::new(field.name(), unit))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use interface::Tick;
    use proptest::prelude::*;

    use super::super::TraceWriter;
    use super::*;

    const ROWS: usize = 40;
    const BATCH: usize = 8;

    fn value(row: usize, column: usize) -> f64 {
        (row as f64 + 0.1).sin() / (column as f64 + 3.0)
    }

    /// Bytes of a trace of three columns, and the length after each batch.
    fn written() -> (Vec<u8>, Vec<usize>) {
        let columns = ["a", "b", "c"].map(|name| Column::new(name, "m/s"));
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut lengths = Vec::new();
        let mut trace =
            TraceWriter::new(file.reopen().unwrap(), file.path(), &columns, BATCH).unwrap();
        for row in 0..ROWS {
            if row % BATCH == 0 {
                lengths.push(file.as_file().metadata().unwrap().len() as usize);
            }
            let tick = Tick(row as i64 * 100_000_000);
            trace.push(tick, &[value(row, 0), value(row, 1), value(row, 2)]).unwrap();
        }
        trace.finish().unwrap();
        (std::fs::read(file.path()).unwrap(), lengths)
    }

    #[test]
    fn round_trip_is_exact() {
        let (bytes, _) = written();
        let trace = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
        assert!(trace.is_complete());
        assert_eq!(trace.rows(), ROWS);
        assert_eq!(trace.columns()[2], Column::new("c", "m/s"));
        for row in 0..ROWS {
            assert_eq!(trace.ticks()[row], row as i64 * 100_000_000);
            let b = trace.column("b").unwrap();
            assert_eq!(b[row].to_bits(), value(row, 1).to_bits());
        }
        let error = trace.column("d").unwrap_err().to_string();
        assert!(error.contains("a, b, c"), "{error}");
    }

    #[test]
    fn every_truncation_reads_up_to_the_last_complete_batch() {
        let (bytes, lengths) = written();
        for cut in 0..bytes.len() {
            let complete = lengths.iter().filter(|&&length| length <= cut).count();
            match Trace::from_bytes(&bytes[..cut], Path::new("t")) {
                Ok(trace) => {
                    // lengths[0] is the schema's; the last batch has no entry of its own.
                    let rows = trace.rows();
                    assert!(!trace.is_complete());
                    assert!(
                        rows == (complete - 1) * BATCH || (rows == ROWS && complete == 5),
                        "cut {cut}: {rows} rows"
                    );
                }
                Err(error) => {
                    assert!(complete == 0 && error.to_string().contains("nothing was recorded"));
                }
            }
        }
    }

    #[test]
    fn a_thinned_trace_keeps_every_extreme() {
        let (bytes, _) = written();
        let whole = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
        let thin = Trace::collect(bytes.as_slice(), Path::new("t"), 24).unwrap();
        assert_eq!((thin.recorded(), whole.recorded()), (ROWS, ROWS));
        assert!(thin.rows() <= 24, "{}", thin.rows());
        let extreme = |trace: &Trace, of: fn(f64, f64) -> f64| {
            (0..3).map(|c| trace.values(c).unwrap().iter().copied().reduce(of)).collect::<Vec<_>>()
        };
        assert_eq!(extreme(&thin, f64::min), extreme(&whole, f64::min));
        assert_eq!(extreme(&thin, f64::max), extreme(&whole, f64::max));
        assert_eq!(thin.ticks()[0], 0);
        assert_eq!(thin.ticks().last(), whole.ticks().last());
        assert!(thin.ticks().is_sorted());
    }

    #[test]
    fn a_dropped_writer_loses_no_row() {
        let mut bytes = Vec::new();
        let mut trace =
            TraceWriter::new(&mut bytes, Path::new("t"), &[Column::new("x", "")], 100).unwrap();
        trace.push(Tick(5), &[f64::NAN]).unwrap();
        drop(trace);
        let trace = Trace::from_bytes(&bytes, Path::new("t")).unwrap();
        assert_eq!((trace.rows(), trace.is_complete()), (1, false));
        assert!(trace.values(0).unwrap()[0].is_nan());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        #[test]
        fn damaged_bytes_never_panic(at in 0_usize..4_000, byte: u8, more in 0_usize..4_000) {
            let (mut bytes, _) = written();
            let length = bytes.len();
            bytes[at % length] = byte;
            bytes[more % length] ^= byte;
            if let Ok(trace) = Trace::from_bytes(&bytes, Path::new("t")) {
                prop_assert!(trace.rows() <= length / 8);
            }
        }

        #[test]
        fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(Trace::from_bytes(&bytes, Path::new("t")).is_err());
        }
    }
}
