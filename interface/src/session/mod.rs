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
mod error;
mod partner;
mod place;
mod remains;

pub use base::base_directory;
pub use error::{BASE_VARIABLE, SessionError};
pub use partner::Partner;
pub(crate) use remains::SHARED_MEMORY;

use crate::Side;
use base::BaseLock;
use error::check_name;
use partner::is_held;
use place::Place;
pub use remains::SessionInfo;
use remains::{holder, infos, lock_path, make_prefix, prefix_of, remove_session, root_of, sweep};
use std::{fs, os::unix::fs::DirBuilderExt, path::Path, sync::Arc, time::SystemTime};

/// One side's place in a session; clones share it. The place is given up when
/// the last clone is dropped, and the last side to leave removes all traces.
#[derive(Clone, Debug)]
pub struct Session(Arc<Place>);

impl Session {
    /// Creates a session in the user's base directory; without a name it gets a fresh one.
    /// A live session of the same name is never disturbed.
    pub fn create(side: Side, name: Option<&str>) -> Result<Session, SessionError> {
        Session::create_in(&base_directory(), side, name)
    }

    /// Joins a session whose other side is alive.
    /// When the other side is gone, what it left is removed first.
    pub fn join(side: Side, name: &str) -> Result<Session, SessionError> {
        Session::join_in(&base_directory(), side, name)
    }

    /// [`Session::create`] in a given base directory.
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

    /// Every session that runs in a base directory, by name.
    pub fn list_in(base: &Path) -> Result<Vec<SessionInfo>, SessionError> {
        let Some(held) = BaseLock::existing(base)? else {
            return Ok(Vec::new());
        };
        Ok(infos(held.path()))
    }

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

    pub fn root(&self) -> &Path {
        &self.0.root
    }

    /// Prefix of the session's shared-memory files.
    pub fn prefix(&self) -> &str {
        &self.0.prefix
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
    pub fn child(&self, pid: u32) -> Result<Partner, SessionError> {
        Partner::open(pid, None)
            .map_err(|e| SessionError::io("watching the partner", self.root(), e.into()))
    }

    /// The partner, once it has joined.
    pub fn partner(&self) -> Result<Option<Partner>, SessionError> {
        // Under the base's lock: a held lock file is complete and its pid is its holder's.
        let Some(_held) = BaseLock::existing(&self.0.base)? else {
            return Ok(None);
        };
        let path = lock_path(self.root(), self.side().partner());
        let Some(pid) = holder(&path) else {
            return Ok(None);
        };
        let partner = Partner::open(pid, Some(path)).ok();
        // Still held after the pidfd was taken: so the pid was the holder's all along.
        Ok(partner.filter(|partner| !partner.left()))
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
