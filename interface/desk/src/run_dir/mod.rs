//! The directory that a run leaves behind, and everything read back from it.
//!
//! A run writes `run.toml` (what is needed to repeat it), `trace.arrow` (its columns
//! against problem time), `summary.json` and `report.html`. The directory is claimed by
//! one exclusive `mkdir`, so any number of runs may start in the same instant. Small
//! files are written beside their name and renamed, so that a killed run leaves each of
//! them whole or absent; the trace is a stream, readable up to its last complete batch.
//!
//! It reads no clock (the start time is an argument), interprets no column, and never
//! writes into a directory that another run has claimed.

mod compare;
mod curves;
mod error;
mod export;
mod list;
mod record;
pub mod thin;
mod trace;
mod trace_messages;
mod trace_reader;
mod utc;

pub use compare::first_difference;
pub use curves::Curves;
pub use error::RunDirError;
pub use export::write_csv;
pub use list::{RunEntry, RunState, list_runs, resolve};
pub use record::{PatchIdentity, RunRecord, Seed};
pub use trace::{Column, TraceState, TraceWriter};
pub use trace_reader::Trace;
pub use utc::UtcSecond;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::user_file;
use serde::Serialize;

/// Where runs are kept unless the user says otherwise.
pub const DEFAULT_BASE: &str = "runs";
/// What is needed to repeat the run.
pub const RECORD_FILE: &str = "run.toml";
/// The columnar trace.
pub const TRACE_FILE: &str = "trace.arrow";
/// When each update took effect, in a run on the wall clock.
pub const TRANSFERS_FILE: &str = "transfers.arrow";
/// The state of a flight on its way; gone once it has ended.
pub const CHECKPOINT_FILE: &str = "checkpoint";
/// The results in short; present only once the run has ended.
pub const SUMMARY_FILE: &str = "summary.json";
/// The self-contained report.
pub const REPORT_FILE: &str = "report.html";

/// More runs of one command in one second than this are refused.
const MOST_NAMESAKES: u32 = 100_000;

/// One run's directory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunDirectory {
    path: PathBuf,
}

impl RunDirectory {
    /// Claims a new directory `BASE/2026-03-01T12-34-56-COMMAND`, adding `-2`, `-3`, … when
    /// the name is taken. Characters of `command` outside `[A-Za-z0-9._]` become hyphens.
    pub fn create(
        base: &Path,
        command: &str,
        started: UtcSecond,
    ) -> Result<RunDirectory, RunDirError> {
        fs::create_dir_all(base).map_err(|cause| {
            if !base.exists() || base.is_dir() {
                return RunDirError::write(base)(cause);
            }
            let base = base.display();
            RunDirError::Refused(format!(
                "cannot keep runs in `{base}`, which is a file; choose a directory with --out DIR"
            ))
        })?;
        let stem = format!("{}-{}", started.file_name(), slug(command));
        for serial in 1..=MOST_NAMESAKES {
            let name = match serial {
                1 => stem.clone(),
                n => format!("{stem}-{n}"),
            };
            let path = base.join(name);
            match fs::create_dir(&path) {
                Ok(()) => return Ok(RunDirectory { path }),
                Err(cause) if cause.kind() == io::ErrorKind::AlreadyExists => {}
                Err(cause) => return Err(RunDirError::write(base)(cause)),
            }
        }
        Err(RunDirError::Refused(format!(
            "`{}` and all its numbered namesakes exist; remove old runs or choose another directory with --out DIR",
            base.join(stem).display()
        )))
    }

    /// The directory of an existing run.
    pub fn open(path: &Path) -> Result<RunDirectory, RunDirError> {
        match holds_record(path) {
            Ok(true) => Ok(RunDirectory { path: path.to_owned() }),
            Ok(false) => Err(RunDirError::Refused(format!(
                "`{}` is not a run directory: it holds no run.toml; `digital-proc list` shows the runs",
                path.display()
            ))),
            Err(cause) => Err(RunDirError::read(&path.join(RECORD_FILE))(cause)),
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its last component, by which the user names the run.
    pub fn name(&self) -> String {
        self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    pub fn write_record(&self, record: &RunRecord) -> Result<(), RunDirError> {
        let text = record.to_toml().map_err(|e| {
            let path = self.file(RECORD_FILE);
            RunDirError::Refused(format!("`{}` cannot be written as TOML: {e}", path.display()))
        })?;
        self.write_file(RECORD_FILE, text.as_bytes())
    }

    pub fn read_record(&self) -> Result<RunRecord, RunDirError> {
        let path = self.file(RECORD_FILE);
        let text = user_file::read_text(&path).map_err(RunDirError::read(&path))?;
        toml::from_str(&text).map_err(|e| {
            RunDirError::Refused(format!("`{}` is not a run record: {e}", path.display()))
        })
    }

    /// Writes `summary.json`, indented. Its presence says that the run ended by itself.
    pub fn write_summary(&self, summary: &impl Serialize) -> Result<(), RunDirError> {
        let text = serde_json::to_string_pretty(summary).map_err(|e| {
            let path = self.file(SUMMARY_FILE);
            RunDirError::Refused(format!("`{}` cannot be JSON: {e}", path.display()))
        })?;
        self.write_file(SUMMARY_FILE, format!("{text}\n").as_bytes())
    }

    pub fn write_report(&self, html: &str) -> Result<PathBuf, RunDirError> {
        self.write_file(REPORT_FILE, html.as_bytes())?;
        Ok(self.file(REPORT_FILE))
    }

    /// Starts a trace of the given name.
    pub fn create_stream(
        &self,
        name: &str,
        columns: &[Column],
        rows_per_batch: usize,
    ) -> Result<TraceWriter<File>, RunDirError> {
        let path = self.file(name);
        let file = File::create(&path).map_err(RunDirError::write(&path))?;
        TraceWriter::new(file, &path, columns, rows_per_batch)
    }

    /// Reads `trace.arrow` up to its last complete batch.
    pub fn read_trace(&self) -> Result<Trace, RunDirError> {
        Trace::read(&self.file(TRACE_FILE))
    }

    /// The same for figures: of a long trace only what a picture shows.
    pub fn read_trace_thinned(&self) -> Result<Trace, RunDirError> {
        Trace::read_thinned(&self.file(TRACE_FILE))
    }

    /// Writes any further small file whole or not at all.
    pub fn write_file(&self, name: &str, bytes: &[u8]) -> Result<(), RunDirError> {
        let path = self.file(name);
        let partial = self.file(&format!(".{name}.partial"));
        let write = || {
            File::create(&partial)?.write_all(bytes)?;
            fs::rename(&partial, &path)
        };
        write().map_err(|cause| {
            // Half a file is of no use to anybody; if this fails too, the reason is the same.
            let _ = fs::remove_file(&partial);
            RunDirError::write(&path)(cause)
        })
    }
}

/// Whether there is a record in `directory`; the system's reason where it does not say.
fn holds_record(directory: &Path) -> io::Result<bool> {
    match fs::metadata(directory.join(RECORD_FILE)) {
        Ok(about) => Ok(about.is_file()),
        Err(cause) => match cause.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Ok(false),
            _ => Err(cause),
        },
    }
}

/// A command as part of a directory's name.
fn slug(command: &str) -> String {
    let mut slug = String::with_capacity(command.len());
    for c in command.chars().take(80) {
        if c.is_ascii_alphanumeric() || c == '.' || c == '_' {
            slug.push(c);
        } else if !slug.ends_with('-') {
            slug.push('-');
        }
    }
    let slug = slug.trim_matches(['-', '.']);
    if slug.is_empty() { "run".to_owned() } else { slug.to_owned() }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn fifty_runs_that_start_in_one_second_get_a_directory_each() {
        let base = tempfile::tempdir().unwrap();
        let start = std::sync::Barrier::new(50);
        let names: BTreeSet<PathBuf> = std::thread::scope(|scope| {
            let runs: Vec<_> = (0..50)
                .map(|_| {
                    scope.spawn(|| {
                        start.wait();
                        let base = base.path().join("deep").join("runs");
                        RunDirectory::create(&base, "fly normal", UtcSecond(1_772_368_496))
                            .unwrap()
                            .path()
                            .to_owned()
                    })
                })
                .collect();
            runs.into_iter().map(|run| run.join().unwrap()).collect()
        });
        assert_eq!(names.len(), 50);
        assert!(names.iter().all(|path| path.is_dir()));
    }

    #[test]
    fn a_commands_name_cannot_leave_the_base() {
        for (command, expected) in [
            ("fly --mode normal", "fly-mode-normal"),
            ("../../etc", "etc"),
            ("", "run"),
            ("é/∂", "run"),
        ] {
            assert_eq!(slug(command), expected, "{command}");
        }
    }

    #[test]
    fn an_unwritable_base_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = RunDirectory::create(file.path(), "fly", UtcSecond(0)).unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains(&file.path().display().to_string()) && text.contains("--out"),
            "{text}"
        );
    }
}
