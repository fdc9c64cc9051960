//! Recorded rows on their way to a CSV or Arrow file.
//!
//! CSV: a header of `time` and net names, 17 significant digits, so that every
//! double reads back exactly. Arrow: IPC stream of Float64 columns, complete
//! batches readable even when the run is cut off. A record in a file can be gone on with where it
//! stood at a checkpoint.

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, DataType, Field, Schema};
use desk::{checkpoint::Seam, run_dir::RunDirError};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Rows in one Arrow batch.
const BATCH_ROWS: usize = 1024;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {reason}", path.display())]
pub struct RecordFault {
    path: PathBuf,
    reason: String,
    reader_left: bool,
}

impl RecordFault {
    /// Whether the program that read standard output has had enough, as `head` has.
    pub fn reader_left(&self) -> bool {
        self.reader_left
    }
}

/// Whether an error is that of a pipe without reader.
fn is_broken_pipe(error: &std::io::Error) -> bool {
    error.kind() == std::io::ErrorKind::BrokenPipe
}

enum Sink {
    Csv(Box<csv::Writer<Box<dyn Write>>>),
    Arrow(Box<ArrowFile>),
}

struct ArrowFile {
    file: File,
    /// Encodes into memory; each batch is then written whole.
    encoder: StreamWriter<Vec<u8>>,
    schema: Arc<Schema>,
    columns: Vec<Vec<f64>>,
}

/// Writes rows of time and net values.
pub struct Recorder {
    path: PathBuf,
    sink: Sink,
    /// The file once more from its first checkpoint on, which keeps others from going on in it.
    held: Option<File>,
}

/// Where a record stands at a checkpoint: its file, and the columns of the rows that are not in it
/// yet.
#[derive(Serialize, Deserialize)]
pub struct RecordState {
    seam: Seam,
    columns: Vec<Vec<f64>>,
}

impl Recorder {
    /// Opens `path`: `.arrow` for an Arrow IPC stream, `-` for CSV on standard output, else CSV.
    pub fn create<'n>(
        path: &Path,
        names: impl Iterator<Item = &'n str>,
    ) -> Result<Recorder, RecordFault> {
        let fault =
            |reason: String| RecordFault { path: path.to_owned(), reason, reader_left: false };
        let create = || File::create(path).map_err(|e| fault(e.to_string()));
        let header = std::iter::once("time").chain(names);
        let sink = if is_arrow(path) {
            let mut sink = ArrowFile::begun(create()?, header).map_err(|e| fault(e.to_string()))?;
            sink.hand_over().map_err(|e| fault(e.to_string()))?;
            Sink::Arrow(Box::new(sink))
        } else {
            let out: Box<dyn Write> = if path.as_os_str() == "-" {
                Box::new(std::io::stdout().lock())
            } else {
                Box::new(create()?)
            };
            let mut writer = csv::Writer::from_writer(out);
            writer.write_record(header).map_err(|e| fault(e.to_string()))?;
            Sink::Csv(Box::new(writer))
        };
        Ok(Recorder { path: path.to_owned(), sink, held: None })
    }

    /// Where the record, in a file, stands; all rows are then on the disk or in the state.
    pub fn state(&mut self) -> Result<RecordState, RunDirError> {
        let failed = |cause| RunDirError::Write { path: self.path.clone(), cause };
        let columns = match &mut self.sink {
            Sink::Csv(writer) => {
                writer.flush().map_err(failed)?;
                Vec::new()
            }
            Sink::Arrow(file) => file.columns.clone(),
        };
        let file = match self.held.take() {
            Some(file) => file,
            None => File::open(&self.path).map_err(failed)?,
        };
        let seam = Seam::at_end(self.held.insert(file), &self.path)?;
        Ok(RecordState { seam, columns })
    }

    /// Goes on with a record where it stood.
    pub fn resume<'n>(
        path: &Path,
        names: impl Iterator<Item = &'n str>,
        RecordState { seam, columns }: RecordState,
    ) -> Result<Recorder, RunDirError> {
        let failed = |cause| RunDirError::Write { path: path.to_owned(), cause };
        let file = seam.reopen(path)?;
        let held = Some(file.try_clone().map_err(failed)?);
        let sink = if is_arrow(path) {
            let header = std::iter::once("time").chain(names);
            let mut sink =
                ArrowFile::begun(file, header).map_err(|e| failed(std::io::Error::other(e)))?;
            // The file has its head already.
            sink.encoder.get_mut().clear();
            sink.columns = columns;
            Sink::Arrow(Box::new(sink))
        } else {
            Sink::Csv(Box::new(csv::Writer::from_writer(Box::new(file))))
        };
        Ok(Recorder { path: path.to_owned(), sink, held })
    }

    /// Adds one row: time in s, values in problem units.
    pub fn row(&mut self, time_s: f64, values: &[f64]) -> Result<(), RecordFault> {
        let row = std::iter::once(time_s).chain(values.iter().copied());
        let mut reader_left = false;
        let done = match &mut self.sink {
            Sink::Csv(writer) => {
                writer.write_record(row.map(|v| format!("{v:.16e}"))).map_err(|e| {
                    if let csv::ErrorKind::Io(error) = e.kind() {
                        reader_left = is_broken_pipe(error);
                    }
                    e.to_string()
                })
            }
            Sink::Arrow(file) => {
                for (column, value) in file.columns.iter_mut().zip(row) {
                    column.push(value);
                }
                if file.columns[0].len() < BATCH_ROWS {
                    return Ok(());
                }
                file.write_batch().map_err(|e| e.to_string())
            }
        };
        done.map_err(|reason| RecordFault { path: self.path.clone(), reason, reader_left })
    }

    /// Writes what is still buffered and ends the file.
    pub fn finish(self) -> Result<(), RecordFault> {
        let mut reader_left = false;
        let done = match self.sink {
            Sink::Csv(mut writer) => writer.flush().map_err(|e| {
                reader_left = is_broken_pipe(&e);
                e.to_string()
            }),
            Sink::Arrow(mut file) => {
                let encoded = file.write_batch().and_then(|()| file.encoder.finish());
                encoded.and_then(|()| Ok(file.hand_over()?)).map_err(|e| e.to_string())
            }
        };
        done.map_err(|reason| RecordFault { path: self.path, reason, reader_left })
    }
}

fn is_arrow(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "arrow")
}

impl ArrowFile {
    /// A file whose head is not handed over yet.
    fn begun<'n>(
        file: File,
        header: impl Iterator<Item = &'n str>,
    ) -> Result<ArrowFile, ArrowError> {
        let fields: Vec<Field> = header.map(|n| Field::new(n, DataType::Float64, false)).collect();
        let columns = vec![Vec::with_capacity(BATCH_ROWS); fields.len()];
        let schema = Arc::new(Schema::new(fields));
        let encoder = StreamWriter::try_new(Vec::new(), &schema)?;
        Ok(ArrowFile { file, encoder, schema, columns })
    }

    fn write_batch(&mut self) -> Result<(), ArrowError> {
        if self.columns[0].is_empty() {
            return Ok(());
        }
        let arrays = self
            .columns
            .iter_mut()
            .map(|c| Arc::new(Float64Array::from(std::mem::take(c))) as ArrayRef)
            .collect();
        let batch = RecordBatch::try_new(self.schema.clone(), arrays)?;
        self.encoder.write(&batch)?;
        Ok(self.hand_over()?)
    }

    fn hand_over(&mut self) -> std::io::Result<()> {
        let bytes = self.encoder.get_mut();
        let written = self.file.write_all(bytes);
        bytes.clear();
        written
    }
}
