//! The trace as it is read: all complete batches, and whether the stream was ended.
//!
//! The framing of the Arrow stream is walked first: every message must lie wholly within
//! the file and declare buffers that lie within its own body. What follows the last such
//! message is the torn tail of a killed run and is left out. Only then does the Arrow
//! library decode, so that no damaged length can make it allocate or index beyond the file.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_ipc::MessageHeader;
use arrow_ipc::reader::StreamReader;
use arrow_schema::{DataType, Schema};

use super::trace::{Column, TICK_COLUMN, UNIT_KEY};
use super::{RunDirError, TraceError};
use interface::user_file;

/// Longest trace that is read, bytes; it is held in memory twice. A day of flight at a frame of
/// 10 ms has less.
const LONGEST_TRACE: u64 = 4 << 30;

/// A trace in memory, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    path: PathBuf,
    columns: Vec<Column>,
    ticks: Vec<i64>,
    values: Vec<Vec<f64>>,
    complete: bool,
}

impl Trace {
    /// Reads the trace at `path` up to its last complete batch.
    ///
    /// # Errors
    /// The file cannot be read, ends before its column names, or is no trace.
    pub fn read(path: &Path) -> Result<Trace, TraceError> {
        let bytes = user_file::read(path, LONGEST_TRACE).map_err(|cause| TraceError::Io {
            path: path.to_owned(),
            cause,
        })?;
        Trace::from_bytes(&bytes, path)
    }

    /// The same from bytes in memory; `path` serves messages only.
    ///
    /// # Errors
    /// As [`Trace::read`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Trace, TraceError> {
        let not_a_trace = |reason: String| TraceError::NotATrace {
            path: path.to_owned(),
            reason,
        };
        let framing = walk(bytes).map_err(|reason| not_a_trace(reason.to_owned()))?;
        if framing.messages == 0 {
            return Err(TraceError::NothingRecorded {
                path: path.to_owned(),
            });
        }
        let arrow = |cause| TraceError::Arrow {
            path: path.to_owned(),
            cause,
        };
        let reader =
            StreamReader::try_new(Cursor::new(&bytes[..framing.end]), None).map_err(arrow)?;
        let columns = columns_of(&reader.schema()).map_err(not_a_trace)?;
        let mut trace = Trace {
            path: path.to_owned(),
            values: vec![Vec::new(); columns.len()],
            columns,
            ticks: Vec::new(),
            complete: framing.ended,
        };
        for batch in reader {
            let batch = batch.map_err(arrow)?;
            let ticks = batch.column(0).as_primitive::<Int64Type>();
            trace.ticks.extend_from_slice(ticks.values());
            for (column, array) in trace.values.iter_mut().zip(&batch.columns()[1..]) {
                column.extend_from_slice(array.as_primitive::<Float64Type>().values());
            }
        }
        Ok(trace)
    }

    /// Its columns, the tick column left out.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of complete rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.ticks.len()
    }

    /// Whether the run ended the trace itself; otherwise rows after the last complete batch
    /// are lost.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Problem time of each row, ns.
    #[must_use]
    pub fn ticks(&self) -> &[i64] {
        &self.ticks
    }

    /// Problem time of each row, s, rounded once.
    #[must_use]
    pub fn time_s(&self) -> Vec<f64> {
        self.ticks
            .iter()
            .map(|&ns| interface::Tick(ns).secs())
            .collect()
    }

    /// The values of column `index`, one a row.
    #[must_use]
    pub fn values(&self, index: usize) -> Option<&[f64]> {
        self.values.get(index).map(Vec::as_slice)
    }

    /// The values of the column of that name.
    ///
    /// # Errors
    /// There is none; the message lists those there are.
    pub fn column(&self, name: &str) -> Result<&[f64], TraceError> {
        self.columns
            .iter()
            .position(|column| column.name == name)
            .map(|index| self.values[index].as_slice())
            .ok_or_else(|| TraceError::NoSuchColumn {
                path: self.path.clone(),
                column: name.to_owned(),
                known: self.columns.iter().map(|c| c.name.clone()).collect(),
            })
    }

    /// Writes the trace as CSV to the file `path`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn export_csv(&self, path: &Path) -> Result<(), RunDirError> {
        let fail = |cause| RunDirError::Write {
            path: path.to_owned(),
            cause,
        };
        let file = std::fs::File::create(path).map_err(fail)?;
        super::write_csv(self, file).map_err(fail)
    }
}

/// The extent of the readable part.
struct Framing {
    /// Bytes up to the end of the last whole message.
    end: usize,
    /// Whole messages, the schema included.
    messages: usize,
    /// Whether the end mark follows.
    ended: bool,
}

/// Walks the messages of a stream: marker, metadata length, metadata, body.
fn walk(bytes: &[u8]) -> Result<Framing, &'static str> {
    const MARKER: [u8; 4] = [0xff; 4];
    let mut framing = Framing {
        end: 0,
        messages: 0,
        ended: false,
    };
    let mut columns = 0;
    while let Some((prefix, rest)) = bytes[framing.end..].split_first_chunk::<8>() {
        if prefix[..4] != MARKER {
            return Err("it does not begin as an Arrow stream, or a message of it is overwritten");
        }
        let length = i32::from_le_bytes([prefix[4], prefix[5], prefix[6], prefix[7]]);
        let length = usize::try_from(length).map_err(|_| "a message has a negative length")?;
        if length == 0 {
            framing.ended = true;
            break;
        }
        let Some(metadata) = rest.get(..length) else {
            break;
        };
        let message =
            arrow_ipc::root_as_message(metadata).map_err(|_| "a message's metadata is damaged")?;
        let body =
            usize::try_from(message.bodyLength()).map_err(|_| "a body has a negative length")?;
        if rest.len() - length < body {
            break;
        }
        match (framing.messages, message.header_type()) {
            (0, MessageHeader::Schema) => {
                let schema = message.header_as_schema().ok_or("it has no schema")?;
                columns = schema.fields().map_or(0, |fields| fields.len());
            }
            (1.., MessageHeader::RecordBatch) => {
                let batch = message
                    .header_as_record_batch()
                    .ok_or("a batch is damaged")?;
                check_batch(batch, columns, body)?;
            }
            _ => return Err("it holds messages that a trace never holds"),
        }
        framing.end += 8 + length + body;
        framing.messages += 1;
    }
    Ok(framing)
}

/// Each column of a batch is one node and two buffers (validity, then 8 bytes a row), all
/// within the body and uncompressed.
fn check_batch(
    batch: arrow_ipc::RecordBatch<'_>,
    columns: usize,
    body: usize,
) -> Result<(), &'static str> {
    const DAMAGED: &str = "a batch's buffers do not fit its rows";
    let (nodes, buffers) = (
        batch.nodes().ok_or(DAMAGED)?,
        batch.buffers().ok_or(DAMAGED)?,
    );
    let rows = batch.length();
    let whole = nodes.len() == columns
        && buffers.len() == 2 * columns
        && batch.compression().is_none()
        && (0..=(body / 8) as i64).contains(&rows)
        && nodes
            .iter()
            .all(|node| node.length() == rows && node.null_count() == 0)
        && buffers.iter().enumerate().all(|(i, buffer)| {
            let (offset, length) = (buffer.offset(), buffer.length());
            let enough = i % 2 == 0 || length == rows * 8;
            offset >= 0
                && length >= 0
                && enough
                && offset
                    .checked_add(length)
                    .is_some_and(|end| end <= body as i64)
        });
    if whole { Ok(()) } else { Err(DAMAGED) }
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
            let unit = field
                .metadata()
                .get(UNIT_KEY)
                .map(ToString::to_string)
                .unwrap_or_default();
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
            trace
                .push(tick, &[value(row, 0), value(row, 1), value(row, 2)])
                .unwrap();
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
                Err(TraceError::NothingRecorded { .. }) => assert_eq!(complete, 0, "cut {cut}"),
                Err(error) => panic!("cut {cut}: {error}"),
            }
        }
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
