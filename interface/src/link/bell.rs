//! The bell: how a side sleeps until the other has sent it something.
//!
//! A few words that both sides can reach, mapped from a file of the session or,
//! inside one process, shared by two threads. Who waits says so, looks once more
//! and sleeps on a futex; who sends rings only where somebody sleeps, which costs
//! a fence and a load where nobody does.
//!
//! No ring is lost. The waiter says that it sleeps *before* its last look, and the
//! sender has sent *before* it asks who sleeps; both orders are sequentially
//! consistent, so at least one of the two sees the other. A ring that falls between
//! the last look and the sleep has changed the word slept on, and the sleep ends at
//! once. The bell holds no lock, so a side that dies anywhere in here blocks nobody;
//! and every sleep has a limit, after which the waiter looks at its partner.
//!
//! It also remembers whether the processors are crowded: see [`Bell::crowded`].

use crate::Side;
use rustix::{
    fs::{FallocateFlags, Mode, OFlags, fallocate, ftruncate},
    io::Errno,
    mm::{MapFlags, ProtFlags, mmap, munmap},
    thread::futex,
};
use std::{
    cell::Cell,
    path::Path,
    ptr::NonNull,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering, fence},
    },
    time::Duration,
};

/// A yield that takes longer than this gave the processor to a stranger: the
/// partner's own work between two frames is shorter, and so is a bare yield (0.3 µs).
const SLOW_YIELD: Duration = Duration::from_micros(50);
/// Waits that go straight to sleep after a slow yield. A yield beside a busy program
/// costs a slice of some milliseconds; once in so many waits that is microseconds each.
const CROWDED_WAITS: u32 = 1000;
/// The same after a slow yield that no other came shortly before: on idle processors,
/// where sleeping is dear, one comes now and then by chance.
const CROWDED_AT_FIRST: u32 = 125;

/// One side's door, on a cache line (and its prefetched neighbour) of its own.
#[derive(Debug, Default)]
#[repr(C, align(128))]
struct Door {
    /// Counts the rings; slept on.
    rung: AtomicU32,
    /// Whether the side sleeps, or is about to.
    asleep: AtomicU32,
    /// Whether the side has closed its end for good.
    closed: AtomicU32,
}

/// Both doors. All zeros are two sides awake.
#[derive(Debug, Default)]
#[repr(C)]
struct Doors([Door; 2]);

#[derive(Debug)]
enum Memory {
    Own(Arc<Doors>),
    Mapped(NonNull<Doors>),
}

// SAFETY: the mapping belongs to this value alone, stays until it is dropped, and
// everything in it is atomic, as in the `Arc` of the other variant.
unsafe impl Send for Memory {}

impl Memory {
    fn doors(&self) -> &Doors {
        match self {
            Memory::Own(doors) => doors,
            // SAFETY: mapped for as long as `self` lives, of the length and alignment of
            // `Doors`, backed by allocated pages; any bits are valid atomics.
            Memory::Mapped(doors) => unsafe { doors.as_ref() },
        }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if let Memory::Mapped(doors) = self {
            // SAFETY: mapped by `Bell::mapped` with this length; no reference outlives `self`.
            let _ = unsafe { munmap(doors.as_ptr().cast(), size_of::<Doors>()) };
        }
    }
}

/// One side's view of the bell. Dropping it closes the side's door for good.
#[derive(Debug)]
pub struct Bell {
    memory: Memory,
    side: Side,
    /// Waits that are still to go straight to sleep.
    crowded: Cell<u32>,
    /// Waits since then that did not.
    calm: Cell<u32>,
    /// How many are to sleep after the next slow yield.
    next: Cell<u32>,
}

impl Bell {
    /// The views of the analog and of the digital side, inside one process.
    pub(super) fn pair() -> (Bell, Bell) {
        let doors = Arc::new(Doors::default());
        let view = |side| Bell::new(Memory::Own(doors.clone()), side);
        (view(Side::Analog), view(Side::Digital))
    }

    /// The view of `side` by way of a file, which is made where it is missing.
    pub(super) fn mapped(path: &Path, side: Side) -> Result<Bell, Errno> {
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let file = rustix::fs::open(path, flags, Mode::RUSR | Mode::WUSR)?;
        let length = size_of::<Doors>();
        // Either side may be the first: both only ever lengthen the file. Its pages are
        // allocated here, where a full file system is an error and not a signal.
        match fallocate(&file, FallocateFlags::empty(), 0, length as u64) {
            Err(Errno::OPNOTSUPP) => ftruncate(&file, length as u64)?,
            done => done?,
        }
        // SAFETY: a fresh shared mapping, which aliases nothing of this process.
        let address = unsafe {
            mmap(
                std::ptr::null_mut(),
                length,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED,
                &file,
                0,
            )
        }?;
        let doors = NonNull::new(address.cast()).ok_or(Errno::NOMEM)?;
        Ok(Bell::new(Memory::Mapped(doors), side))
    }

    fn new(memory: Memory, side: Side) -> Bell {
        Bell {
            memory,
            side,
            crowded: Cell::new(0),
            calm: Cell::new(0),
            next: Cell::new(CROWDED_AT_FIRST),
        }
    }

    fn door(&self, side: Side) -> &Door {
        let [analog, digital] = &self.memory.doors().0;
        match side {
            Side::Analog => analog,
            Side::Digital => digital,
        }
    }

    /// Wakes the partner if it sleeps. To be called after each message, or part of one.
    pub(super) fn ring(&self) {
        let door = self.door(self.side.partner());
        fence(Ordering::SeqCst);
        if door.asleep.load(Ordering::SeqCst) != 0 {
            door.rung.fetch_add(1, Ordering::SeqCst);
            // Nobody is woken where the sleeper has died or was just woken.
            let _ = futex::wake(&door.rung, futex::Flags::empty(), 1);
        }
    }

    /// Says that this side is about to sleep; it has to look once more before it does.
    pub(super) fn listen(&self) -> u32 {
        let door = self.door(self.side);
        door.asleep.store(1, Ordering::SeqCst);
        fence(Ordering::SeqCst);
        door.rung.load(Ordering::SeqCst)
    }

    /// Says that the last look found something: no sleep.
    pub(super) fn stay_awake(&self) {
        self.door(self.side).asleep.store(0, Ordering::Relaxed);
    }

    /// Sleeps until rung since [`Bell::listen`] gave `heard`, at most `limit`. A signal
    /// ends it early.
    pub(super) fn sleep(&self, heard: u32, limit: Duration) {
        let door = self.door(self.side);
        let limit = futex::Timespec {
            tv_sec: i64::try_from(limit.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(limit.subsec_nanos()),
        };
        let _ = futex::wait(&door.rung, futex::Flags::empty(), heard, Some(&limit));
        self.stay_awake();
    }

    /// Says that this side has closed its end for good.
    pub(super) fn close(&self) {
        self.door(self.side).closed.store(1, Ordering::Release);
        self.ring();
    }

    /// Whether the partner has closed its end.
    pub(super) fn partner_closed(&self) -> bool {
        self.door(self.side.partner()).closed.load(Ordering::Acquire) != 0
    }

    /// Asked once a wait: whether it is to sleep at once instead of yielding.
    ///
    /// A yield beside a busy program gives away a whole slice, thousands of times
    /// what a frame takes; a side that sleeps is scheduled as soon as it is rung. On
    /// idle processors it is the other way round, since one that has gone to sleep
    /// wakes up slowly. So a slow yield decides, for the next waits; the sooner slow
    /// yields follow each other, the more of them ([`CROWDED_WAITS`] at most).
    pub(super) fn crowded(&self) -> bool {
        let left = self.crowded.get();
        self.crowded.set(left.saturating_sub(1));
        if left == 0 {
            self.calm.set(self.calm.get().saturating_add(1));
        }
        left > 0
    }

    /// Takes note of a yield; true when it was so slow that the wait had better sleep.
    pub(super) fn yielded_for(&self, took: Duration) -> bool {
        let slow = took > SLOW_YIELD;
        if slow {
            if self.calm.replace(0) > CROWDED_WAITS {
                self.next.set(CROWDED_AT_FIRST);
            }
            let waits = self.next.get();
            self.next.set((2 * waits).min(CROWDED_WAITS));
            self.crowded.set(waits);
        }
        slow
    }
}

impl Drop for Bell {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{sync::atomic::AtomicU64, time::Instant};

    /// Many rounds of ping-pong in which both sides sleep at every turn. The sleep's limit
    /// is a minute: one lost ring would show.
    fn ping_pong(analog: Bell, digital: Bell) {
        const ROUNDS: u64 = 20_000;
        let balls = [const { AtomicU64::new(0) }; 2];
        let started = Instant::now();
        let play = |bell: &Bell, own: usize, first: u64| {
            for n in 1..=ROUNDS {
                if first == 1 {
                    balls[1 - own].store(n, Ordering::Release);
                    bell.ring();
                }
                loop {
                    let heard = bell.listen();
                    if balls[own].load(Ordering::Acquire) >= n {
                        bell.stay_awake();
                        break;
                    }
                    bell.sleep(heard, Duration::from_secs(60));
                }
                if first == 0 {
                    balls[1 - own].store(n, Ordering::Release);
                    bell.ring();
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(move || {
                play(&analog, 0, 1);
                // Closed only when both are done.
                analog
            });
            play(&digital, 1, 0);
        });
        assert!(started.elapsed() < Duration::from_secs(60));
    }

    #[test]
    fn no_ring_is_lost_between_threads() {
        let (analog, digital) = Bell::pair();
        ping_pong(analog, digital);
    }

    #[test]
    fn no_ring_is_lost_through_a_file() {
        let dir = tempfile::tempdir().unwrap();
        let view = |side| Bell::mapped(&dir.path().join("bell"), side).unwrap();
        ping_pong(view(Side::Analog), view(Side::Digital));
    }

    #[test]
    fn a_closed_end_is_seen_and_wakes_the_other() {
        let (analog, digital) = Bell::pair();
        assert!(!digital.partner_closed());
        let heard = digital.listen();
        drop(analog);
        let started = Instant::now();
        digital.sleep(heard, Duration::from_secs(60));
        assert!(started.elapsed() < Duration::from_secs(30));
        assert!(digital.partner_closed());
    }

    #[test]
    fn a_slow_yield_decides_for_the_next_waits() {
        let (bell, _partner) = Bell::pair();
        assert!(!bell.crowded());
        assert!(!bell.yielded_for(SLOW_YIELD));
        let crowded = |waits: u32| (0..waits).filter(|_| bell.crowded()).count();
        // Again and again while they come soon after each other, then from the start.
        for sleeps in [125, 250, 500, 1000, 1000] {
            assert!(bell.yielded_for(2 * SLOW_YIELD));
            assert_eq!(crowded(CROWDED_WAITS + 10), sleeps);
        }
        assert_eq!(crowded(CROWDED_WAITS), 0);
        assert!(bell.yielded_for(2 * SLOW_YIELD));
        assert_eq!(crowded(CROWDED_WAITS), CROWDED_AT_FIRST as usize);
    }
}
