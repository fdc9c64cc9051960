//! Attention while integrating: somebody is asked whether to go on.
//!
//! The engine does no I/O and reads no clock or signal. It asks whoever had it started,
//! between two attempts at a step, once some thousand derivative passes are done since it was asked
//! last ([`WORK`]); rejected attempts and the probes for crossings count. An answer ends
//! a run or leaves it as it is, to the last bit.

use crate::statistics::Statistics;
use std::ops::ControlFlow;

/// Passes times states between two questions: some 50 µs, for a patch of any size. A
/// question costs a tenth of a microsecond.
const WORK: usize = 1 << 14;
/// A patch of fewer states counts as one of so many: its pass has a fixed cost too.
const LEAST_STATES: usize = 4;
/// Passes of one attempt of the implicit method, about: it is not to be asked more often.
const LEAST_PASSES: usize = 64;

/// How far an integration has come when somebody is asked whether it is to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Problem time, s.
    pub t_s: f64,
    /// Counts since the last reset.
    pub statistics: Statistics,
    /// Length of the last step times the fastest rate met in it, where the method can tell:
    /// near 3.3 stability and not accuracy keeps the steps of the explicit method short.
    pub step_rate: Option<f64>,
}

/// Somebody who is asked whether an integration is to go on.
pub type Attendant<'a> = dyn FnMut(&Pulse) -> ControlFlow<()> + 'a;

/// The attendant, and when to ask next.
pub(crate) struct Heed<'a> {
    attendant: &'a mut Attendant<'a>,
    every: u64,
    due: u64,
}

impl<'a> Heed<'a> {
    /// For a patch of so many states, of which so many passes are done already.
    pub fn new(states: usize, passes: u64, attendant: &'a mut Attendant<'a>) -> Heed<'a> {
        let every = (WORK / states.max(LEAST_STATES)).max(LEAST_PASSES) as u64;
        Heed { attendant, every, due: passes.saturating_add(every) }
    }

    pub fn is_due(&self, passes: u64) -> bool {
        passes >= self.due
    }

    /// Whether to go on.
    pub fn ask(&mut self, pulse: &Pulse) -> ControlFlow<()> {
        self.due = pulse.statistics.evaluations.saturating_add(self.every);
        (self.attendant)(pulse)
    }
}
