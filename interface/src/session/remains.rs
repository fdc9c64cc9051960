//! What a session leaves on disk and in shared memory, and its removal.
//!
//! Everything here runs under the base's lock. It touches nothing whose name is
//! not a session's: directories that end in `.session` and shared-memory files
//! that begin with a session's prefix. The prefix is written in the directory
//! before there is any such file, and the directory goes after the last of them,
//! so that whatever a killed process left can be found from the directory.

use super::{error::check_name, partner::is_held};
use crate::Side;
use std::{
    collections::hash_map::RandomState,
    fs::{self, File, OpenOptions},
    hash::BuildHasher,
    io::{Read, Write},
    os::unix::{ffi::OsStrExt, fs::OpenOptionsExt},
    path::{Path, PathBuf},
};

/// A running session, as [`super::Session::list_in`] finds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionInfo {
    pub name: String,
    /// Pid of its analog side, if present.
    pub analog: Option<u32>,
    /// Pid of its digital side, if present.
    pub digital: Option<u32>,
}

/// Marks our directories, so that a sweep touches nothing else.
const SUFFIX: &str = ".session";
/// Where POSIX shared memory lives on Linux.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

pub(super) fn root_of(base: &Path, name: &str) -> PathBuf {
    base.join(format!("{name}{SUFFIX}"))
}

pub(super) fn lock_path(root: &Path, side: Side) -> PathBuf {
    root.join(format!("{}.lock", side.name()))
}

/// Bytes of a prefix: `hybrid`, 16 hexadecimal digits, `_`. Of fixed length and closed by
/// `_`, so that no prefix is the beginning of another.
pub(super) const PREFIX_LENGTH: usize = 23;

fn prefix_path(root: &Path) -> PathBuf {
    root.join("prefix")
}

/// Gives a fresh session its prefix: one that nobody can know beforehand, since
/// everybody may make files where shared memory lives.
pub(super) fn make_prefix(root: &Path) -> std::io::Result<String> {
    // Keyed by the operating system's random numbers.
    let random = RandomState::new().hash_one(std::process::id());
    let prefix = format!("hybrid{random:016x}_");
    OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(0o600)
        .open(prefix_path(root))?
        .write_all(prefix.as_bytes())?;
    Ok(prefix)
}

/// The prefix of a session; `None` where its maker was killed before it had one.
pub(super) fn prefix_of(root: &Path) -> Option<String> {
    let prefix = fs::read_to_string(prefix_path(root)).ok()?;
    let digits = prefix.strip_prefix("hybrid")?.strip_suffix('_')?;
    let ours = prefix.len() == PREFIX_LENGTH && digits.bytes().all(|b| b.is_ascii_hexdigit());
    ours.then_some(prefix)
}

/// Pid of the process that holds the lock file; `None` when nobody does.
pub(super) fn holder(path: &Path) -> Option<u32> {
    if !is_held(path) {
        return None;
    }
    let mut text = String::new();
    File::open(path).ok()?.read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

/// Names of all our session directories in a base.
fn names(base: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(base)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_type().is_ok_and(|t| t.is_dir()))
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter_map(|file| file.strip_suffix(SUFFIX).map(str::to_owned))
        .filter(|name| check_name(name).is_ok())
        .collect();
    names.sort();
    names
}

pub(super) fn infos(base: &Path) -> Vec<SessionInfo> {
    names(base)
        .into_iter()
        .map(|name| {
            let root = root_of(base, &name);
            SessionInfo {
                analog: holder(&lock_path(&root, Side::Analog)),
                digital: holder(&lock_path(&root, Side::Digital)),
                name,
            }
        })
        .filter(|info| info.analog.is_some() || info.digital.is_some())
        .collect()
}

/// Removes every session in which nobody holds a lock. The base must be locked.
pub(super) fn sweep(base: &Path) {
    for name in names(base) {
        let root = root_of(base, &name);
        let alive =
            [Side::Analog, Side::Digital].into_iter().any(|side| is_held(&lock_path(&root, side)));
        if !alive {
            remove_session(&root);
        }
    }
}

/// Removes a session's shared memory, then its directory.
pub(super) fn remove_session(root: &Path) {
    if let Some(prefix) = prefix_of(root) {
        let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
        for entry in entries {
            if entry.file_name().as_bytes().starts_with(prefix.as_bytes()) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
    // Unfindable without its prefix, the shared memory must be gone first.
    let _ = fs::remove_dir_all(root);
}
