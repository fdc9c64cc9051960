//! Attention while integrating: somebody is asked whether to go on.
//!
//! The engine does no I/O and reads no clock or signal. It asks whoever had it started,
//! between two steps, once at least [`PASSES`] derivative passes are done since it was
//! asked last; rejected attempts and the probes for crossings count. An answer ends a
//! run or leaves it as it is, to the last bit.

use crate::simulation::Statistics;
use std::ops::ControlFlow;

/// Passes between two questions: some 30 µs for a small patch, a few ms for a huge one.
const PASSES: u64 = 1000;

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
    due: u64,
}

impl<'a> Heed<'a> {
    /// Asks first when [`PASSES`] more are done than `passes`.
    pub fn new(passes: u64, attendant: &'a mut Attendant<'a>) -> Heed<'a> {
        Heed {
            attendant,
            due: passes.saturating_add(PASSES),
        }
    }

    pub fn is_due(&self, passes: u64) -> bool {
        passes >= self.due
    }

    /// Whether to go on.
    pub fn ask(&mut self, pulse: &Pulse) -> ControlFlow<()> {
        self.due = pulse.statistics.evaluations.saturating_add(PASSES);
        (self.attendant)(pulse)
    }
}
