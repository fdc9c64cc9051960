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
    /// The base directory cannot be trusted.
    #[error("the base directory {} is refused: {reason}; set {BASE_VARIABLE} to a directory of your own", path.display())]
    ForeignBase {
        /// The directory.
        path: PathBuf,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The transport cannot work with the base's path.
    #[error("the base directory {} cannot be used: {reason}; set {BASE_VARIABLE} to a directory whose path has at most {limit} bytes, all of them printable ASCII other than {}", path.display(), FORBIDDEN)]
    BasePath {
        /// The directory, links resolved.
        path: PathBuf,
        /// What is wrong with its path.
        reason: String,
        /// Longest path for a session of this name.
        limit: usize,
    },
    /// Too little free space: a full file system would end the process by a signal.
    #[error("{} has {found_kib} KiB of free space, and a session needs {needed_kib} KiB; free some, or make the file system larger", path.display())]
    NoRoom {
        /// Where.
        path: PathBuf,
        /// KiB needed.
        needed_kib: u64,
        /// KiB found.
        found_kib: u64,
    },
    /// The base stayed locked.
    #[error("the base directory {} stayed locked by another process", path.display())]
    BaseBusy {
        /// The directory.
        path: PathBuf,
    },
    /// Not a name for a session.
    #[error("`{name}` is no name for a session: use 1 to {NAME_LIMIT} letters, digits, `-` or `_`")]
    Name {
        /// The name as given.
        name: String,
    },
    /// A live session has this name.
    #[error("a session named `{name}` is running already; choose another name")]
    InUse {
        /// The name.
        name: String,
    },
    /// No session has this name.
    #[error("no session named `{name}` is running{}", known_list(known))]
    Unknown {
        /// The name.
        name: String,
        /// Sessions that do run.
        known: Vec<String>,
    },
    /// The session's other side is gone.
    #[error("{} of session `{name}` is gone", side.name())]
    Deserted {
        /// The name.
        name: String,
        /// The side that is gone.
        side: Side,
    },
    /// Somebody else plays this part.
    #[error("session `{name}` already has its {}", side.name())]
    Taken {
        /// The name.
        name: String,
        /// The side that is taken.
        side: Side,
    },
    /// The operating system refused.
    #[error("{doing} failed at {}: {source}", path.display())]
    Io {
        /// What was being done.
        doing: &'static str,
        /// Where.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
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
