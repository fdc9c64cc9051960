//! What can go wrong with a run directory or a trace; each names the path and the remedy.

use std::io;
use std::path::{Path, PathBuf};

/// A fault of a run directory, of its traces or of the small files in it.
#[derive(Debug, thiserror::Error)]
pub enum RunDirError {
    #[error("cannot read `{}`: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("cannot write `{}`: {cause}; check free space and permissions", path.display())]
    Write { path: PathBuf, cause: io::Error },
    #[error("{0}")]
    Refused(String),
}

impl RunDirError {
    pub(super) fn read(path: &Path) -> impl Fn(io::Error) -> RunDirError {
        move |cause| RunDirError::Read { path: path.to_owned(), cause }
    }

    pub(super) fn write(path: &Path) -> impl Fn(io::Error) -> RunDirError {
        move |cause| RunDirError::Write { path: path.to_owned(), cause }
    }

    pub(super) fn not_a_trace(path: &Path, reason: &str) -> RunDirError {
        RunDirError::Refused(format!("`{}` is not a trace: {reason}", path.display()))
    }
}
