//! One processor for both sides, where the machine has none to spare.
//!
//! Paced by the wall clock, a side stays awake while it waits, since waking up
//! takes longer than a fast frame's work. On a machine of two processors two such
//! sides leave none to anybody else: each passer-by then takes a processor from one
//! of them for some milliseconds, and on a virtual machine the host does too. They
//! are late less often when both share one, handing it to each other by yielding.

use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// With so many processors or fewer both sides share one.
const FEW: u32 = 2;

/// The processors on which this thread may run.
pub fn allowed() -> Vec<u32> {
    let set = sched_getaffinity(None).unwrap_or_else(|_| CpuSet::new());
    (0..CpuSet::MAX_CPU).filter(|i| set.is_set(*i)).map(|i| i as u32).collect()
}

/// The processor that both sides are to share: the one on which this thread runs;
/// `None` on a machine that has others to spare.
pub fn to_share() -> Option<u32> {
    let allowed = sched_getaffinity(None).ok()?;
    (allowed.count() <= FEW).then(|| sched_getcpu() as u32)
}

/// Keeps this thread, and the processes that it starts, on the processor that is due to the
/// worker of this number; `None` where it stays free.
pub fn share(worker: usize) -> Option<Kept> {
    let allowed = allowed();
    allowed.get(worker % allowed.len().max(1)).and_then(|processor| Kept::on(*processor))
}

/// Keeps this thread on one processor as long as it lives.
#[derive(Debug)]
pub struct Kept {
    before: CpuSet,
}

impl Kept {
    /// On `processor`; `None` where this thread may not run there, and so stays free.
    pub fn on(processor: u32) -> Option<Kept> {
        let index = usize::try_from(processor).ok()?;
        let before = sched_getaffinity(None).ok()?;
        if index >= CpuSet::MAX_CPU || !before.is_set(index) {
            return None;
        }
        let mut only = CpuSet::new();
        only.set(index);
        sched_setaffinity(None, &only).ok()?;
        Some(Kept { before })
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        // A processor that has gone since then: the thread stays where it is.
        let _ = sched_setaffinity(None, &self.before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_is_kept_and_released() {
        let before = sched_getaffinity(None).unwrap();
        let here = sched_getcpu() as u32;
        let kept = Kept::on(here).unwrap();
        let only = sched_getaffinity(None).unwrap();
        assert!(only.count() == 1 && only.is_set(here as usize));
        assert_eq!(to_share(), Some(here));
        drop(kept);
        assert_eq!(sched_getaffinity(None).unwrap(), before);
        assert!(Kept::on(u32::MAX).is_none());
    }
}
