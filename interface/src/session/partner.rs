//! The partner process: a pid that cannot be mistaken for a later process.
//!
//! A pidfd names one process for ever, so a reused pid is never taken for the
//! partner. It is obtained either from a child that has not been reaped, or
//! from a session's lock file while the lock is held. It becomes readable the
//! moment the process ends.

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    fs::{FlockOperation, flock},
    io::Errno,
    process::{Pid, PidfdFlags, WaitId, WaitIdOptions, pidfd_open, waitid},
};
use std::{
    fs::File,
    os::fd::{AsFd, OwnedFd},
    path::{Path, PathBuf},
    time::Duration,
};

/// The process at the other end.
#[derive(Debug)]
pub struct Partner {
    pid: u32,
    pidfd: OwnedFd,
    /// Its lock file, once it has joined the session.
    lock: Option<PathBuf>,
}

impl Partner {
    /// Names process `pid`, which the caller knows to be the partner and not to be reaped.
    pub(super) fn open(pid: u32, lock: Option<PathBuf>) -> Result<Partner, Errno> {
        let raw = i32::try_from(pid).map_err(|_| Errno::INVAL)?;
        let named = Pid::from_raw(raw).ok_or(Errno::INVAL)?;
        let pidfd = pidfd_open(named, PidfdFlags::empty())?;
        Ok(Partner { pid, pidfd, lock })
    }

    pub fn ended(&self) -> bool {
        let mut polled = [PollFd::new(&self.pidfd, PollFlags::IN)];
        poll(&mut polled, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }

    /// Whether the process has given up its place in the session (it may live on).
    pub fn left(&self) -> bool {
        self.lock.as_deref().is_some_and(|lock| !is_held(lock))
    }

    /// What is known of its end, for a fault message.
    pub fn epitaph(&self) -> String {
        let pid = self.pid;
        // Leaves the child to be reaped by its owner; fails when it is not our child.
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        match waitid(WaitId::PidFd(self.pidfd.as_fd()), options) {
            Ok(Some(status)) => match (status.exit_status(), status.terminating_signal()) {
                (Some(code), _) => format!("process {pid} exited with code {code}"),
                (_, Some(signal)) => format!("process {pid} was ended by signal {signal}"),
                _ => format!("process {pid} ended"),
            },
            _ if self.ended() => format!("process {pid} ended"),
            _ => format!("process {pid} left the session"),
        }
    }

    /// Its line in /proc from the third field (its state) on: after its name, which may
    /// hold spaces.
    fn stat(&self) -> Option<String> {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.pid)).ok()?;
        Some(stat.rsplit_once(") ")?.1.to_owned())
    }

    /// Whether a signal has stopped the process; a debugger does not count.
    pub fn stopped(&self) -> bool {
        self.stat().is_some_and(|fields| fields.starts_with('T'))
    }

    /// CPU time that the process has used so far; `None` when it is gone.
    pub fn cpu_time(&self) -> Option<Duration> {
        // Fields 14 and 15: user and system time.
        let fields = self.stat()?;
        let ticks: u64 =
            fields.split(' ').skip(11).take(2).map(|field| field.parse::<u64>().unwrap_or(0)).sum();
        // Linux reports these in hundredths of a second on every architecture.
        Some(Duration::from_millis(ticks.saturating_mul(10)))
    }
}

/// Whether some process holds the lock on `path`.
pub(super) fn is_held(path: &Path) -> bool {
    File::open(path).is_ok_and(|file| {
        matches!(flock(&file, FlockOperation::NonBlockingLockShared), Err(Errno::WOULDBLOCK))
    })
}
