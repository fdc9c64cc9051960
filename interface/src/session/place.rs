//! One side's place in a session: a lock file that is held as long as the side lives.

use super::{
    base::{BaseLock, is_same_file},
    error::SessionError,
    partner::is_held,
    remains::{lock_path, remove_session, root_of},
};
use crate::Side;
use rustix::{
    fs::{FlockOperation, flock},
    io::Errno,
};
use std::{
    fs::{File, OpenOptions},
    io::{Seek, Write},
    os::unix::fs::OpenOptionsExt,
    path::{Path, PathBuf},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

#[derive(Debug)]
pub(super) struct Place {
    pub(super) base: PathBuf,
    pub(super) name: String,
    pub(super) root: PathBuf,
    pub(super) prefix: String,
    pub(super) side: Side,
    /// Whether the other side made the session, and so was there first.
    pub(super) joined: bool,
    /// Held for as long as this side takes part.
    lock: Mutex<Option<File>>,
    /// Whether the traces are this side's to remove, though the partner holds its lock.
    heir: AtomicBool,
}

impl Place {
    /// Takes the place of `side` in the session `name` of a base that the caller has locked.
    pub(super) fn take(
        base: &BaseLock,
        name: String,
        prefix: String,
        side: Side,
        joined: bool,
    ) -> Result<Place, SessionError> {
        let root = root_of(base.path(), &name);
        let lock = take_lock(&root, &name, side)?;
        Ok(Place {
            base: base.path().to_owned(),
            name,
            root,
            prefix,
            side,
            joined,
            lock: Mutex::new(Some(lock)),
            heir: AtomicBool::new(false),
        })
    }

    pub(super) fn inherit(&self) {
        self.heir.store(true, Ordering::Relaxed);
    }

    /// Gives up the place, and removes the session if nobody is left in it.
    pub(super) fn leave(&self) {
        let mut lock = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(lock) = lock.take() else { return };
        let held = BaseLock::existing(&self.base);
        let [own, partner] = [self.side, self.side.partner()].map(|s| lock_path(&self.root, s));
        // Where the partner removed the session already, a namesake may have followed it …
        let ours = is_same_file(&lock, &own);
        drop(lock);
        // Without the base's lock nothing is removed: the next sweep will do it.
        if let Ok(Some(held)) = held {
            let last = self.heir.load(Ordering::Relaxed) || !is_held(&partner);
            // … or it was killed half-way: then nobody holds what is left.
            let half = !own.exists() && !is_held(&partner);
            if ours && last || half {
                remove_session(&self.root);
            }
            held.release();
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.leave();
    }
}

fn take_lock(root: &Path, name: &str, side: Side) -> Result<File, SessionError> {
    let path = lock_path(root, side);
    let fail = |e| SessionError::io("taking a place in the session", &path, e);
    let mut file = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .open(&path)
        .map_err(fail)?;
    // The partner's liveness check holds a shared lock for microseconds: try again.
    let taken = (0..20).any(|attempt| {
        if attempt > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        flock(&file, FlockOperation::NonBlockingLockExclusive) != Err(Errno::WOULDBLOCK)
    });
    if !taken {
        return Err(SessionError::Taken { name: name.to_owned(), side });
    }
    file.set_len(0)
        .and_then(|()| file.rewind())
        .and_then(|()| writeln!(file, "{}", std::process::id()))
        .map_err(fail)?;
    Ok(file)
}
