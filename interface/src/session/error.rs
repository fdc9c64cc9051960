//! Why a session cannot be had.

use crate::Side;
use std::path::{Path, PathBuf};

/// Environment variable that overrides the base directory.
pub const BASE_VARIABLE: &str = "HYBRID_BASE";
/// Characters that the transport refuses in a path, besides control characters.
pub(super) const FORBIDDEN: &str = "< > \" | ? *";
/// Longest session name. With it a base may have 43 bytes, more than any default base has.
const NAME_LIMIT: usize = 48;

/// Why a session cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    #[error("the base directory {} is refused: {reason}; set {BASE_VARIABLE} to a directory of your own", path.display())]
    ForeignBase { path: PathBuf, reason: &'static str },
    #[error("the base directory {} cannot be used: {reason}; set {BASE_VARIABLE} to a directory whose path has at most {limit} bytes, all of them printable ASCII other than {}", path.display(), FORBIDDEN)]
    BasePath { path: PathBuf, reason: String, limit: usize },
    #[error("{} has {found_kib} KiB of free space, and a session needs {needed_kib} KiB; free some, or make the file system larger", path.display())]
    NoRoom { path: PathBuf, needed_kib: u64, found_kib: u64 },
    #[error("the base directory {} stayed locked by another process", path.display())]
    BaseBusy { path: PathBuf },
    #[error("`{name}` is no name for a session: use 1 to {NAME_LIMIT} letters, digits, `-` or `_`")]
    Name { name: String },
    #[error("a session named `{name}` is running already; choose another name")]
    InUse { name: String },
    #[error("no session named `{name}` is running{}", known_list(known))]
    Unknown { name: String, known: Vec<String> },
    #[error("{} of session `{name}` is gone", side.name())]
    Deserted { name: String, side: Side },
    #[error("session `{name}` already has its {}", side.name())]
    Taken { name: String, side: Side },
    #[error("{doing} failed at {}: {source}", path.display())]
    Io { doing: &'static str, path: PathBuf, source: std::io::Error },
}

fn known_list(known: &[String]) -> String {
    match known {
        [] => String::new(),
        names => format!(" (running: {})", names.join(", ")),
    }
}

impl SessionError {
    pub(super) fn io(doing: &'static str, path: &Path, source: std::io::Error) -> SessionError {
        SessionError::Io { doing, path: path.to_owned(), source }
    }
}

pub(super) fn check_name(name: &str) -> Result<(), SessionError> {
    let fits = (1..=NAME_LIMIT).contains(&name.len());
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if fits && name.chars().all(plain) {
        Ok(())
    } else {
        Err(SessionError::Name { name: name.to_owned() })
    }
}
