//! The digital executive: tasks at integer multiples of the fast frame.
//!
//! The frame that crosses the linkage is the fast frame; a slower task is due
//! in each `every`-th of them and holds its outputs in between. Times are
//! products of integers, so a task never drifts against another.

use interface::Tick;

/// The rate of one task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    every: u64,
}

impl Rate {
    /// Due in every fast frame.
    pub const FAST: Rate = Rate { every: 1 };

    /// Due in each `every`-th fast frame, the first included; `None` for 0.
    pub fn every(every: u64) -> Option<Rate> {
        (every > 0).then_some(Rate { every })
    }

    /// Whether the task is due in fast frame n.
    pub fn due(self, frame: u64) -> bool {
        frame.is_multiple_of(self.every)
    }

    /// Fast frames in one period of the task.
    pub fn fast_frames(self) -> u64 {
        self.every
    }

    /// The fast frame period for which this task has the period `slow`; `None`
    /// when it would not be a whole number of nanoseconds, one at least.
    pub fn fast_period(self, slow: Tick) -> Option<Tick> {
        let every = i64::try_from(self.every).ok()?;
        (slow.0 >= every && slow.0 % every == 0).then(|| Tick(slow.0 / every))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_task_is_due_in_each_fifth_frame() {
        let slow = Rate::every(5).unwrap();
        let due: Vec<u64> = (0..12).filter(|n| slow.due(*n)).collect();
        assert_eq!(due, [0, 5, 10]);
        assert_eq!(slow.fast_period(Tick(100_000_000)), Some(Tick(20_000_000)));
        assert_eq!(slow.fast_period(Tick(7)), None);
        assert_eq!(Rate::every(0), None);
    }
}
