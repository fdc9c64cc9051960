//! The per-user base directory of all sessions.
//!
//! Creating, joining, listing and removing sessions happen under an exclusive
//! lock of the base directory itself, so that nobody ever sees a session that
//! is half made, and the base can vanish with its last session. A lock dies
//! with its holder: a process killed in here blocks nobody.

use super::SessionError;
use rustix::{
    fs::{FlockOperation, Mode, OFlags, flock, fstat, stat},
    io::Errno,
};
use std::{
    fs,
    os::{
        fd::OwnedFd,
        unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt},
    },
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// Environment variable that overrides the base directory.
pub const BASE_VARIABLE: &str = "HYBRID_BASE";

/// The base is held for milliseconds at a time; even fifty processes in a row need less.
const LOCK_DEADLINE: Duration = Duration::from_secs(10);

/// The base directory: `$HYBRID_BASE`, else `$XDG_RUNTIME_DIR/hybrid-computer`,
/// else `/tmp/hybrid-computer-UID`.
#[must_use]
pub fn base_directory() -> PathBuf {
    if let Some(base) = std::env::var_os(BASE_VARIABLE).filter(|v| !v.is_empty()) {
        return PathBuf::from(base);
    }
    if let Some(runtime) = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from)
        && runtime.is_absolute()
        && fs::metadata(&runtime)
            .is_ok_and(|m| m.is_dir() && m.uid() == rustix::process::getuid().as_raw())
    {
        return runtime.join("hybrid-computer");
    }
    PathBuf::from(format!(
        "/tmp/hybrid-computer-{}",
        rustix::process::getuid().as_raw()
    ))
}

/// Exclusive hold of a base directory.
pub(super) struct BaseLock {
    path: PathBuf,
    _descriptor: OwnedFd,
}

impl BaseLock {
    /// Makes the base if it is missing and locks it.
    pub(super) fn create(path: &Path) -> Result<BaseLock, SessionError> {
        // Another session's end may remove the base between our two steps; again and
        // again only if something is badly wrong.
        for _ in 0..100 {
            if !path.exists() {
                fs::DirBuilder::new()
                    .recursive(true)
                    .mode(0o700)
                    .create(path)
                    .map_err(|e| SessionError::io("creating the base directory", path, e))?;
            }
            if let Some(lock) = BaseLock::existing(path)? {
                return Ok(lock);
            }
        }
        Err(SessionError::BaseBusy {
            path: path.to_owned(),
        })
    }

    /// Locks the base if there is one.
    pub(super) fn existing(path: &Path) -> Result<Option<BaseLock>, SessionError> {
        let path = match fs::canonicalize(path) {
            Ok(real) if fs::symlink_metadata(path).is_ok_and(|m| !m.is_symlink()) => real,
            Ok(_) => {
                return Err(SessionError::ForeignBase {
                    path: path.to_owned(),
                    reason: "it is a symbolic link",
                });
            }
            Err(_) => return Ok(None),
        };
        check_owner(&path)?;
        let started = Instant::now();
        loop {
            let flags = OFlags::DIRECTORY | OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
            let descriptor = match rustix::fs::open(&path, flags, Mode::empty()) {
                Ok(descriptor) => descriptor,
                Err(Errno::NOENT) => return Ok(None),
                Err(e) => return Err(SessionError::io("opening the base", &path, e.into())),
            };
            match flock(&descriptor, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => {
                    // The directory may have been removed (and made anew) before we got its lock.
                    let same = match (fstat(&descriptor), stat(&path)) {
                        (Ok(held), Ok(named)) => {
                            held.st_ino == named.st_ino && held.st_dev == named.st_dev
                        }
                        _ => false,
                    };
                    if same {
                        return Ok(Some(BaseLock {
                            path,
                            _descriptor: descriptor,
                        }));
                    }
                }
                Err(Errno::WOULDBLOCK | Errno::INTR) => {
                    if started.elapsed() > LOCK_DEADLINE {
                        return Err(SessionError::BaseBusy { path });
                    }
                    std::thread::sleep(Duration::from_micros(500));
                }
                Err(e) => return Err(SessionError::io("locking the base", &path, e.into())),
            }
        }
    }

    /// Canonical path of the base.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Releases the base, and removes it when no session is left in it.
    pub(super) fn release(self) {
        // Fails, as it should, while anything is in it.
        let _ = fs::remove_dir(&self.path);
    }
}

/// A base of another user, or one that others may write to, is refused: who can
/// write there can feed this process frames.
fn check_owner(path: &Path) -> Result<(), SessionError> {
    let Ok(meta) = fs::symlink_metadata(path) else {
        return Ok(());
    };
    let refuse = |reason| {
        Err(SessionError::ForeignBase {
            path: path.to_owned(),
            reason,
        })
    };
    if !meta.is_dir() {
        return refuse("it is not a directory");
    }
    if meta.uid() != rustix::process::getuid().as_raw() {
        return refuse("it belongs to another user");
    }
    if meta.permissions().mode() & 0o022 != 0 {
        return refuse("other users may write to it");
    }
    Ok(())
}
