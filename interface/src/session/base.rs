//! The per-user base directory of all sessions.
//!
//! Creating, joining, listing and removing sessions happen under an exclusive
//! lock of the base directory itself, so that nobody ever sees a session that
//! is half made, and the base can vanish with its last session. A lock dies
//! with its holder: a process killed in here blocks nobody.

use super::{
    error::{BASE_VARIABLE, FORBIDDEN, SessionError},
    remains::{PREFIX_LENGTH, SHARED_MEMORY},
};
use rustix::{
    fs::{Access, FlockOperation, Mode, OFlags, access, flock, fstat, lstat, statfs, statvfs},
    io::Errno,
};
use std::{
    fs,
    os::{
        fd::{AsFd, OwnedFd},
        unix::ffi::OsStrExt,
        unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt},
    },
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

/// The base is held for milliseconds at a time; even fifty processes in a row need less.
const LOCK_DEADLINE: Duration = Duration::from_secs(10);

/// Longest path that the transport works with.
const PATH_LIMIT: usize = 255;
/// What follows base, `/` and name in the longest path that the transport forms, that of a
/// connection (as if it lay in the session's directory): `.session/`, prefix, a hash of 40
/// digits, `_`, a port of up to 39 digits, `_`, another, `.connection`.
const BEHIND_NAME: usize = 9 + PREFIX_LENGTH + 40 + 1 + 39 + 1 + 39 + 11;
/// Free space that a session asks for, in KiB: twice what one takes at most (936 KiB of
/// shared memory while a patch of 3 MB is loaded; a flight takes 172).
pub(super) const ROOM_KIB: u64 = 2048;

/// The base directory: `$HYBRID_BASE`, else `$XDG_RUNTIME_DIR/hybrid-computer`, else
/// `/dev/shm/hybrid-computer-UID` if that is a tmpfs, else `/tmp/hybrid-computer-UID`.
///
/// The transport waits for the disk a dozen times a session, which a tmpfs does not have.
pub fn base_directory() -> PathBuf {
    if let Some(base) = std::env::var_os(BASE_VARIABLE).filter(|v| !v.is_empty()) {
        return PathBuf::from(base);
    }
    let user = rustix::process::getuid().as_raw();
    if let Some(runtime) = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from)
        && runtime.is_absolute()
        && fs::metadata(&runtime).is_ok_and(|m| m.is_dir() && m.uid() == user)
    {
        return runtime.join("hybrid-computer");
    }
    let parent = if is_writable_tmpfs(SHARED_MEMORY) { SHARED_MEMORY } else { "/tmp" };
    Path::new(parent).join(format!("hybrid-computer-{user}"))
}

fn is_writable_tmpfs(path: &str) -> bool {
    /// `TMPFS_MAGIC` of Linux.
    const TMPFS: u64 = 0x0102_1994;
    statfs(path).is_ok_and(|fs| u64::try_from(fs.f_type) == Ok(TMPFS))
        && access(path, Access::WRITE_OK | Access::EXEC_OK).is_ok()
}

/// Refuses a base with whose path the transport could not work, before anything is made.
pub(super) fn check_path(path: &Path, name_length: usize) -> Result<(), SessionError> {
    let path = resolved(path);
    let limit = PATH_LIMIT - BEHIND_NAME - 1 - name_length;
    let bytes = path.as_os_str().as_bytes();
    let fits =
        |b: &u8| (b' '..=b'~').contains(b) && !FORBIDDEN.replace(' ', "").as_bytes().contains(b);
    let reason = if bytes.len() > limit {
        format!("its path has {} bytes", bytes.len())
    } else if let Some(odd) = bytes.iter().position(|b| !fits(b)) {
        let odd = String::from_utf8_lossy(&bytes[odd..]).chars().next();
        format!("its path contains {:?}", odd.unwrap_or_default())
    } else {
        return Ok(());
    };
    Err(SessionError::BasePath { path, reason, limit })
}

/// The path as the transport will see it: absolute, and links resolved as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let real = absolute.ancestors().find_map(|ancestor| {
        let rest = absolute.strip_prefix(ancestor).ok()?;
        let real = fs::canonicalize(ancestor).ok()?;
        // Joining nothing would append a slash.
        Some(if rest.as_os_str().is_empty() { real } else { real.join(rest) })
    });
    real.unwrap_or(absolute)
}

/// Refuses a place with less free space than `needed_kib`.
///
/// The transport touches pages that it has not allocated, and where there is none left the
/// process is ended by a signal.
pub(super) fn check_room(path: &Path, needed_kib: u64) -> Result<(), SessionError> {
    // A base that is yet to be made lies where its nearest ancestor does.
    let Some(space) = path.ancestors().find_map(|p| statvfs(p).ok()) else {
        return Ok(());
    };
    let found_kib = space.f_bavail.saturating_mul(space.f_frsize) / 1024;
    // A tmpfs without a limit tells no blocks at all.
    if space.f_blocks == 0 || found_kib >= needed_kib {
        return Ok(());
    }
    Err(SessionError::NoRoom { path: path.to_owned(), needed_kib, found_kib })
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
        Err(SessionError::BaseBusy { path: path.to_owned() })
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
                    if is_same_file(&descriptor, &path) {
                        return Ok(Some(BaseLock { path, _descriptor: descriptor }));
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

/// Whether what is open is what has that name, and not a namesake that followed it.
pub(super) fn is_same_file(held: impl AsFd, path: &Path) -> bool {
    match (fstat(held), lstat(path)) {
        (Ok(held), Ok(named)) => held.st_ino == named.st_ino && held.st_dev == named.st_dev,
        _ => false,
    }
}

/// A base of another user, or one that others may write to, is refused: who can
/// write there can feed this process frames.
fn check_owner(path: &Path) -> Result<(), SessionError> {
    let Ok(meta) = fs::symlink_metadata(path) else {
        return Ok(());
    };
    let refuse = |reason| Err(SessionError::ForeignBase { path: path.to_owned(), reason });
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
