//! What a session leaves on disk and in shared memory, and its removal.
//!
//! Everything here runs under the base's lock. It touches nothing whose name is
//! not a session's: directories that end in `.session` and shared-memory files
//! that begin with a session's prefix.

use super::{SessionInfo, check_name, partner::is_held};
use crate::Side;
use sha2::{Digest, Sha256};
use std::{
    fs::{self, File},
    io::Read,
    os::unix::ffi::OsStrExt,
    path::{Path, PathBuf},
};

/// Marks our directories, so that a sweep touches nothing else.
const SUFFIX: &str = ".session";
/// Where POSIX shared memory lives on Linux.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";

pub(super) fn root_of(base: &Path, name: &str) -> PathBuf {
    base.join(format!("{name}{SUFFIX}"))
}

pub(super) fn lock_path(root: &Path, side: Side) -> PathBuf {
    root.join(format!("{}.lock", side.name()))
}

/// Fixed length and closed by `_`, so that no prefix is the beginning of another.
pub(super) fn prefix_of(base: &Path, name: &str) -> String {
    let mut sha = Sha256::new();
    sha.update(base.as_os_str().as_bytes());
    sha.update([0]);
    sha.update(name.as_bytes());
    let hex: String = sha
        .finalize()
        .iter()
        .take(8)
        .map(|b| format!("{b:02x}"))
        .collect();
    format!("hybrid{hex}_")
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
        let alive = [Side::Analog, Side::Digital]
            .into_iter()
            .any(|side| is_held(&lock_path(&root, side)));
        if !alive {
            remove_session(&root, &prefix_of(base, &name));
        }
    }
}

pub(super) fn remove_session(root: &Path, prefix: &str) {
    remove_shared_memory(prefix);
    let _ = fs::remove_dir_all(root);
}

pub(super) fn remove_shared_memory(prefix: &str) {
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    for entry in entries {
        if entry.file_name().as_bytes().starts_with(prefix.as_bytes()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
