//! Sessions: one pair of processes, one directory, one shared-memory prefix.
//!
//! A session is the directory `BASE/NAME.session`. In it each side holds an
//! exclusive lock on a file of its own (`analog-proc.lock`, `digital-proc.lock`),
//! which contains its pid. Whoever holds a lock is alive; a session in which
//! nobody holds one is stale and is swept by the next session that is made in
//! the base. The last side to leave removes the directory and every
//! shared-memory file with the session's prefix, so it does not matter which
//! side survives.
//!
//! The prefix is random and stands in the session's directory, which nobody else
//! may read: who could guess it could make the transport's files first.
//!
//! Before anything is made, the base's path and the free space are checked: the
//! transport ends the process by a panic or a signal where they do not suffice.

mod base;
mod partner;
mod place;
mod remains;

pub use base::{BASE_VARIABLE, base_directory};
pub use partner::Partner;
pub(crate) use remains::SHARED_MEMORY;

use crate::Side;
use base::BaseLock;
use partner::is_held;
use place::Place;
use remains::{holder, infos, lock_path, make_prefix, prefix_of, remove_session, root_of, sweep};
use std::{
    fs,
    os::unix::fs::DirBuilderExt,
    path::{Path, PathBuf},
    sync::Arc,
    time::SystemTime,
};

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
    #[error("the base directory {} cannot be used: {reason}; set {BASE_VARIABLE} to a directory whose path has at most {limit} bytes, all of them printable ASCII other than {}", path.display(), base::FORBIDDEN)]
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
    fn io(doing: &'static str, path: &Path, source: std::io::Error) -> SessionError {
        SessionError::Io { doing, path: path.to_owned(), source }
    }
}

/// A running session, as [`Session::list`] finds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionInfo {
    /// Its name.
    pub name: String,
    /// Pid of its analog side, if present.
    pub analog: Option<u32>,
    /// Pid of its digital side, if present.
    pub digital: Option<u32>,
}

/// One side's place in a session; clones share it. The place is given up when
/// the last clone is dropped, and the last side to leave removes all traces.
#[derive(Clone, Debug)]
pub struct Session(Arc<Place>);

impl Session {
    /// Creates a session in the user's base directory; without a name it gets a fresh one.
    ///
    /// # Errors
    /// [`SessionError`]; a live session of the same name is never disturbed.
    pub fn create(side: Side, name: Option<&str>) -> Result<Session, SessionError> {
        Session::create_in(&base_directory(), side, name)
    }

    /// Joins a session whose other side is alive.
    ///
    /// # Errors
    /// [`SessionError`]; when the other side is gone, what it left is removed first.
    pub fn join(side: Side, name: &str) -> Result<Session, SessionError> {
        Session::join_in(&base_directory(), side, name)
    }

    /// Every session that runs, by name.
    ///
    /// # Errors
    /// [`SessionError`] when the base cannot be read.
    pub fn list() -> Result<Vec<SessionInfo>, SessionError> {
        Session::list_in(&base_directory())
    }

    /// [`Session::create`] in a given base directory.
    ///
    /// # Errors
    /// As [`Session::create`].
    pub fn create_in(base: &Path, side: Side, name: Option<&str>) -> Result<Session, SessionError> {
        if let Some(name) = name {
            check_name(name)?;
        }
        base::check_path(base, name.map_or(FRESH_LENGTH, str::len))?;
        base::check_room(Path::new(remains::SHARED_MEMORY), base::ROOM_KIB)?;
        base::check_room(base, base::ROOM_KIB)?;
        let held = BaseLock::create(base)?;
        sweep(held.path());
        let name = name.map_or_else(|| fresh_name(held.path()), str::to_owned);
        let root = root_of(held.path(), &name);
        match fs::DirBuilder::new().mode(0o700).create(&root) {
            Ok(()) => {}
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => {
                return Err(SessionError::InUse { name });
            }
            Err(e) => {
                held.release();
                return Err(SessionError::io("creating the session", &root, e));
            }
        }
        let made = make_prefix(&root)
            .map_err(|e| SessionError::io("creating the session", &root, e))
            .and_then(|prefix| Place::take(&held, name, prefix, side, false));
        match made {
            Ok(place) => Ok(Session(Arc::new(place))),
            Err(error) => {
                remove_session(&root);
                held.release();
                Err(error)
            }
        }
    }

    /// [`Session::join`] in a given base directory.
    ///
    /// # Errors
    /// As [`Session::join`].
    pub fn join_in(base: &Path, side: Side, name: &str) -> Result<Session, SessionError> {
        check_name(name)?;
        let unknown = |known| SessionError::Unknown { name: name.to_owned(), known };
        base::check_path(base, name.len())?;
        let Some(held) = BaseLock::existing(base)? else {
            return Err(unknown(Vec::new()));
        };
        let root = root_of(held.path(), name);
        if !root.is_dir() {
            let known = infos(held.path()).into_iter().map(|i| i.name).collect();
            return Err(unknown(known));
        }
        let deserted = SessionError::Deserted { name: name.to_owned(), side: side.partner() };
        if !is_held(&lock_path(&root, side.partner())) {
            if !is_held(&lock_path(&root, side)) {
                remove_session(&root);
                held.release();
            }
            return Err(deserted);
        }
        // Whoever holds its lock has written the prefix before.
        let prefix = prefix_of(&root).ok_or(deserted)?;
        // Whoever made the session has found room for both, and taken its part.
        let rest_kib = base::ROOM_KIB / 2;
        base::check_room(Path::new(remains::SHARED_MEMORY), rest_kib)?;
        base::check_room(held.path(), rest_kib)?;
        let place = Place::take(&held, name.to_owned(), prefix, side, true)?;
        Ok(Session(Arc::new(place)))
    }

    /// [`Session::list`] in a given base directory.
    ///
    /// # Errors
    /// As [`Session::list`].
    pub fn list_in(base: &Path) -> Result<Vec<SessionInfo>, SessionError> {
        let Some(held) = BaseLock::existing(base)? else {
            return Ok(Vec::new());
        };
        Ok(infos(held.path()))
    }

    /// Removes what dead processes left in a base directory.
    ///
    /// # Errors
    /// [`SessionError`] when the base cannot be read.
    pub fn sweep_in(base: &Path) -> Result<(), SessionError> {
        if let Some(held) = BaseLock::existing(base)? {
            sweep(held.path());
            held.release();
        }
        Ok(())
    }

    /// Name of the session, which the partner joins.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The side that this process plays.
    pub fn side(&self) -> Side {
        self.0.side
    }

    /// Whether this process joined a session that the other side had made.
    pub fn joined(&self) -> bool {
        self.0.joined
    }

    /// Directory of the session.
    pub fn root(&self) -> &Path {
        &self.0.root
    }

    /// Prefix of the session's shared-memory files.
    pub fn prefix(&self) -> &str {
        &self.0.prefix
    }

    /// The base directory in which the session lives.
    pub fn base(&self) -> &Path {
        &self.0.base
    }

    /// Gives up this side's place now, even where clones of it live on.
    pub fn leave(&self) {
        self.0.leave();
    }

    /// Says that the partner has nothing of the session open any more, though it may
    /// still hold its place: then this side, leaving first, removes all traces.
    pub(crate) fn inherit(&self) {
        self.0.inherit();
    }

    /// A child just started to be the partner, which has not joined yet. The
    /// caller must not have reaped it.
    ///
    /// # Errors
    /// [`SessionError::Io`] when no such process exists.
    pub fn child(&self, pid: u32) -> Result<Partner, SessionError> {
        Partner::open(self.side().partner(), pid, None)
            .map_err(|e| SessionError::io("watching the partner", self.root(), e.into()))
    }

    /// The partner, once it has joined.
    ///
    /// # Errors
    /// [`SessionError`] when the base cannot be locked.
    pub fn partner(&self) -> Result<Option<Partner>, SessionError> {
        // Under the base's lock: a held lock file is complete and its pid is its holder's.
        let Some(_held) = BaseLock::existing(&self.0.base)? else {
            return Ok(None);
        };
        let side = self.side().partner();
        let path = lock_path(self.root(), side);
        let Some(pid) = holder(&path) else {
            return Ok(None);
        };
        let partner = Partner::open(side, pid, Some(path)).ok();
        // Still held after the pidfd was taken: so the pid was the holder's all along.
        Ok(partner.filter(|partner| !partner.left()))
    }
}

fn check_name(name: &str) -> Result<(), SessionError> {
    let fits = (1..=NAME_LIMIT).contains(&name.len());
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if fits && name.chars().all(plain) {
        Ok(())
    } else {
        Err(SessionError::Name { name: name.to_owned() })
    }
}

/// Longest [`fresh_name`]: a pid of up to seven digits, `-`, six hexadecimal digits.
const FRESH_LENGTH: usize = 14;

/// A name that no session in the base has; the base is locked, so it stays free.
fn fresh_name(base: &Path) -> String {
    let nanos =
        SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |d| d.subsec_nanos());
    (0_u32..)
        .map(|n| format!("{}-{:06x}", std::process::id(), nanos.wrapping_add(n) >> 8))
        .find(|name| !root_of(base, name).exists())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests;
