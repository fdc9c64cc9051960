//! The trace as it is written: columns of `f64` against an integer tick, Arrow IPC stream.
//!
//! Rows collect in memory and leave the process a batch at a time, in one `write` each, so
//! a process that is killed leaves every complete batch readable. The bytes depend on the
//! data alone: no time of day, no host, no path. It does not wait for the disk (a power
//! failure may cost more than the last batch) and it never changes the columns of a trace.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, Field, Schema};
use interface::Tick;
use serde::{Deserialize, Serialize};

use super::RunDirError;
use crate::checkpoint::Seam;

/// Name of the column that holds problem time, integer nanoseconds.
pub(super) const TICK_COLUMN: &str = "tick";
/// Key of a column's unit among its metadata.
pub(super) const UNIT_KEY: &str = "unit";

/// A column of the trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name, unit included where that is the custom (`altitude_m`).
    pub name: String,
    /// Its unit for headings; empty when dimensionless.
    pub unit: String,
}

impl Column {
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Column {
        Column { name: name.into(), unit: unit.into() }
    }
}

/// Writes a trace row by row. Dropping it writes the rows still held, but not the end mark:
/// call [`TraceWriter::finish`] for that and to hear of a failure.
pub struct TraceWriter<W: Write> {
    sink: W,
    path: PathBuf,
    schema: Arc<Schema>,
    /// Encodes into memory; each batch is then handed to `sink` whole.
    encoder: StreamWriter<Vec<u8>>,
    ticks: Vec<i64>,
    columns: Vec<Vec<f64>>,
    rows_per_batch: usize,
    rows: u64,
    ended: bool,
}

/// Where a trace stands at a checkpoint: its file, and the rows that are not in it yet.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TraceState {
    seam: Seam,
    ticks: Vec<i64>,
    columns: Vec<Vec<f64>>,
    rows: u64,
}

impl TraceWriter<File> {
    /// Where it stands, from which [`TraceWriter::resume`] goes on.
    pub fn state(&self) -> Result<TraceState, RunDirError> {
        let seam = Seam::at_end(&self.sink, &self.path)?;
        let (ticks, columns) = (self.ticks.clone(), self.columns.clone());
        Ok(TraceState { seam, ticks, columns, rows: self.rows })
    }

    /// Goes on with the trace at `path` where it stood, in the same bytes as if it had never ended.
    pub fn resume(
        path: &Path,
        columns: &[Column],
        rows_per_batch: usize,
        state: TraceState,
    ) -> Result<TraceWriter<File>, RunDirError> {
        let mut writer =
            TraceWriter::begun(path, columns, rows_per_batch, |path| state.seam.reopen(path))?;
        // The file has its head already.
        writer.encoder.get_mut().clear();
        (writer.ticks, writer.columns, writer.rows) = (state.ticks, state.columns, state.rows);
        Ok(writer)
    }
}

impl<W: Write> TraceWriter<W> {
    /// Starts a trace on `sink`; `path` serves messages only. `rows_per_batch` (at least 1)
    /// is what a crash may cost: 64 is a good start for 10 to 1000 rows a second.
    pub fn new(
        sink: W,
        path: &Path,
        columns: &[Column],
        rows_per_batch: usize,
    ) -> Result<TraceWriter<W>, RunDirError> {
        let mut writer = TraceWriter::begun(path, columns, rows_per_batch, |_| Ok(sink))?;
        writer.hand_over()?;
        Ok(writer)
    }

    /// A trace whose head is not handed over yet.
    fn begun(
        path: &Path,
        columns: &[Column],
        rows_per_batch: usize,
        sink: impl FnOnce(&Path) -> Result<W, RunDirError>,
    ) -> Result<TraceWriter<W>, RunDirError> {
        let mut seen = BTreeSet::from([TICK_COLUMN]);
        if let Some(twice) = columns.iter().find(|c| !seen.insert(&c.name)) {
            return Err(RunDirError::Refused(format!(
                "trace `{}` would have two columns named `{}`; rename one",
                path.display(),
                twice.name
            )));
        }
        let field = |name: &str, unit: &str, kind| {
            Field::new(name, kind, false)
                .with_metadata(HashMap::from([(UNIT_KEY.to_owned(), unit.to_owned())]))
        };
        let fields: Vec<Field> = std::iter::once(field(TICK_COLUMN, "ns", DataType::Int64))
            .chain(columns.iter().map(|c| field(&c.name, &c.unit, DataType::Float64)))
            .collect();
        let schema = Arc::new(Schema::new(fields));
        let encoder =
            StreamWriter::try_new(Vec::new(), &schema).map_err(|cause| arrow(path, cause))?;
        let rows_per_batch = rows_per_batch.max(1);
        Ok(TraceWriter {
            sink: sink(path)?,
            path: path.to_owned(),
            schema,
            encoder,
            ticks: Vec::with_capacity(rows_per_batch),
            columns: vec![Vec::with_capacity(rows_per_batch); columns.len()],
            rows_per_batch,
            rows: 0,
            ended: false,
        })
    }

    /// Adds a row: `values[i]` belongs to column `i`. NaN marks a value that does not exist.
    pub fn push(&mut self, tick: Tick, values: &[f64]) -> Result<(), RunDirError> {
        if values.len() != self.columns.len() {
            return Err(RunDirError::Refused(format!(
                "trace `{}` has {} columns, but a row of {} values was given",
                self.path.display(),
                self.columns.len(),
                values.len()
            )));
        }
        self.ticks.push(tick.0);
        for (column, &value) in self.columns.iter_mut().zip(values) {
            column.push(value);
        }
        self.rows += 1;
        if self.ticks.len() >= self.rows_per_batch {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the rows held back as a batch of their own.
    pub fn flush(&mut self) -> Result<(), RunDirError> {
        if self.ticks.is_empty() {
            return Ok(());
        }
        let capacity = self.rows_per_batch;
        let ticks = std::mem::replace(&mut self.ticks, Vec::with_capacity(capacity));
        let mut arrays: Vec<ArrayRef> = Vec::with_capacity(self.columns.len() + 1);
        arrays.push(Arc::new(Int64Array::from(ticks)));
        for column in &mut self.columns {
            let values = std::mem::replace(column, Vec::with_capacity(capacity));
            arrays.push(Arc::new(Float64Array::from(values)));
        }
        RecordBatch::try_new(Arc::clone(&self.schema), arrays)
            .and_then(|batch| self.encoder.write(&batch))
            .map_err(|cause| arrow(&self.path, cause))?;
        self.hand_over()
    }

    /// Writes the remaining rows and the end mark, and returns the sink.
    pub fn finish(mut self) -> Result<u64, RunDirError> {
        self.flush()?;
        self.encoder.finish().map_err(|cause| arrow(&self.path, cause))?;
        self.hand_over()?;
        self.ended = true;
        Ok(self.rows)
    }

    /// Passes what the encoder holds to the sink in one write.
    fn hand_over(&mut self) -> Result<(), RunDirError> {
        let bytes = self.encoder.get_mut();
        let written = self
            .sink
            .write_all(bytes)
            .and_then(|()| self.sink.flush())
            .map_err(RunDirError::write(&self.path));
        bytes.clear();
        written
    }
}

impl<W: Write> Drop for TraceWriter<W> {
    fn drop(&mut self) {
        if !self.ended {
            // A failure here was either reported by an earlier call or can no longer be.
            let _ = self.flush();
        }
    }
}

pub(super) fn arrow(path: &Path, cause: ArrowError) -> RunDirError {
    RunDirError::Refused(format!("trace `{}`: {cause}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_that_do_not_fit_are_refused() {
        let refusal = |names: [&str; 2], row: &[f64]| {
            let columns = names.map(|name| Column::new(name, "m"));
            TraceWriter::new(Vec::new(), Path::new("t"), &columns, 8)
                .and_then(|mut trace| trace.push(Tick(0), row))
                .unwrap_err()
                .to_string()
        };
        assert!(refusal(["x", "y"], &[1.0]).contains("2 columns"));
        assert!(refusal(["x", "x"], &[1.0, 2.0]).contains("two columns named `x`"));
        assert!(refusal(["x", "tick"], &[1.0, 2.0]).contains("two columns named `tick`"));
    }
}
