//! What can go wrong with a run directory or a trace; each names the path and the remedy.

use std::io;
use std::path::PathBuf;

/// A fault of a run directory or of the small files in it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunDirError {
    /// The directory that keeps the runs cannot be created, read or written.
    #[error("cannot keep runs in `{}`: {cause}; choose another directory with --out DIR", path.display())]
    Base {
        /// The base directory.
        path: PathBuf,
        /// The system's reason.
        #[source]
        cause: io::Error,
    },
    /// Every numbered variant of a name is taken.
    #[error("`{}` and all its numbered namesakes exist; remove old runs or choose another directory with --out DIR", path.display())]
    TooManyNamesakes {
        /// The name without a number.
        path: PathBuf,
    },
    /// Not a run directory.
    #[error("`{}` is not a run directory: it holds no run.toml; `digital-proc list` shows the runs", path.display())]
    NotARun {
        /// What was given.
        path: PathBuf,
    },
    /// No run has the given name or prefix.
    #[error("no run `{name}` in `{}`{}; `digital-proc list` shows the runs", base.display(), nearest.as_ref().map(|n| format!(", did you mean `{n}`?")).unwrap_or_default())]
    NoSuchRun {
        /// What was asked for.
        name: String,
        /// Where it was looked for.
        base: PathBuf,
        /// The name most like it.
        nearest: Option<String>,
    },
    /// Several runs begin with the given prefix.
    #[error("`{name}` may be any of {}; give more of the name", candidates.join(", "))]
    Ambiguous {
        /// What was asked for.
        name: String,
        /// The first few runs that match.
        candidates: Vec<String>,
    },
    /// A file of the run cannot be read.
    #[error("cannot read `{}`: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        #[source]
        cause: io::Error,
    },
    /// A file of the run cannot be written.
    #[error("cannot write `{}`: {cause}; check free space and permissions", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        #[source]
        cause: io::Error,
    },
    /// `run.toml` is damaged.
    #[error("`{}` is not a run record: {cause}", path.display())]
    BadRecord {
        /// The file.
        path: PathBuf,
        /// Line and reason.
        #[source]
        cause: toml::de::Error,
    },
    /// A record that TOML cannot express.
    #[error("the record for `{}` cannot be written as TOML: {cause}", path.display())]
    UnwritableRecord {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        cause: toml::ser::Error,
    },
    /// `summary.json` is damaged, or a summary cannot be JSON.
    #[error("`{}` is not JSON: {cause}", path.display())]
    BadSummary {
        /// The file.
        path: PathBuf,
        /// The reason.
        #[source]
        cause: serde_json::Error,
    },
}

/// A fault in writing or reading a trace.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The file cannot be read.
    #[error("trace `{}`: {cause}", path.display())]
    Io {
        /// The trace.
        path: PathBuf,
        /// The system's reason.
        #[source]
        cause: io::Error,
    },
    /// The trace cannot be written.
    #[error("cannot write trace `{}`: {cause}; check free space and permissions", path.display())]
    Write {
        /// The trace.
        path: PathBuf,
        /// The system's reason.
        #[source]
        cause: io::Error,
    },
    /// The Arrow library refused.
    #[error("trace `{}`: {cause}", path.display())]
    Arrow {
        /// The trace.
        path: PathBuf,
        /// Its reason.
        #[source]
        cause: arrow_schema::ArrowError,
    },
    /// Two columns of one name, or a column named like the tick column.
    #[error("trace `{}` would have two columns named `{column}`; rename one", path.display())]
    DuplicateColumn {
        /// The trace.
        path: PathBuf,
        /// The name.
        column: String,
    },
    /// A row that does not fit the columns.
    #[error("trace `{}` has {columns} columns, but a row of {values} values was given", path.display())]
    RowWidth {
        /// The trace.
        path: PathBuf,
        /// Declared columns.
        columns: usize,
        /// Given values.
        values: usize,
    },
    /// The run was cut off before its first complete batch, or wrote nothing.
    #[error("trace `{}` ends before its column names are complete: nothing was recorded; repeat the run", path.display())]
    NothingRecorded {
        /// The trace.
        path: PathBuf,
    },
    /// The bytes are not a trace of this machine.
    #[error("`{}` is not a trace: {reason}", path.display())]
    NotATrace {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// No such column.
    #[error("trace `{}` has no column `{column}`; it has {}", path.display(), known.join(", "))]
    NoSuchColumn {
        /// The trace.
        path: PathBuf,
        /// What was asked for.
        column: String,
        /// What there is.
        known: Vec<String>,
    },
}
