//! What ends a run: numbers that are not finite, steps below the resolution of
//! time, events that repeat without progress. Each fault names the block.

use super::Engine;
use super::instants::{LEAST_TIME_S, resolution_s};
use crate::fault::RunFault;
use serde::{Deserialize, Serialize};

/// This many events within [`CHATTER_SPAN`] are chatter: a bouncing ball that loses a
/// fifth of its speed each time comes from one second to rounding in 160 bounces.
const CHATTER_EVENTS: u32 = 1000;

/// Relative progress of time under which events count as repeated.
const CHATTER_SPAN: f64 = 1e-9;

/// Switchings accumulate where so many on end follow each other more quickly by a tenth …
const ZENO_EVENTS: u32 = 5;

const ZENO_RATIO: f64 = 0.9;

/// … down to this part of the first of their intervals: soon there are too many to count.
const ZENO_SPAN: f64 = 1e-6;

/// So do those that begin with as many on end, each within so many resolutions of time of the
/// one before.
const ZENO_START: f64 = 64.0;

/// When an element was last left from its first region, and how its switchings follow one another.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Switched {
    at_s: f64,
    interval_s: f64,
    /// The interval from which on each is shorter than the one before, and how many are.
    first_s: f64,
    shorter: u32,
    /// How many intervals on end time hardly resolves.
    unresolved: u32,
}

impl Switched {
    /// Whether a switching at `t_s` is one of a sequence that accumulates.
    fn accumulates(&mut self, t_s: f64) -> bool {
        let interval_s = t_s - self.at_s;
        if interval_s <= ZENO_RATIO * self.interval_s {
            self.shorter += 1;
        } else {
            (self.first_s, self.shorter) = (interval_s, 0);
        }
        let resolved = interval_s > ZENO_START * resolution_s(t_s);
        self.unresolved = if resolved { 0 } else { self.unresolved + 1 };
        (self.at_s, self.interval_s) = (t_s, interval_s);
        self.unresolved >= ZENO_EVENTS
            || self.shorter >= ZENO_EVENTS && interval_s <= ZENO_SPAN * self.first_s
    }
}

/// Whether all are finite: zero times a finite number is zero. Eight sums side by side,
/// so that no addition waits for the one before.
fn finite(values: &[f64]) -> bool {
    let (chunks, tail) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += x * 0.0;
        }
    }
    let sum: f64 = sums.iter().chain(tail).map(|x| x * 0.0).sum();
    sum == 0.0
}

impl Engine {
    pub(super) fn check_finite(&self) -> Result<(), RunFault> {
        if finite(&self.nets) && finite(&self.step.f0) {
            return Ok(());
        }
        Err(self.not_finite(&self.nets, &self.step.f0))
    }

    fn not_finite(&self, nets: &[f64], rates: &[f64]) -> RunFault {
        let machine = &self.machine;
        let state = nets[..rates.len()].iter().position(|x| !x.is_finite());
        let later = nets.iter().position(|x| !x.is_finite());
        let rate = rates.iter().position(|x| !x.is_finite());
        let (what, slot) = match (state, later, rate) {
            (Some(slot), _, _) | (None, Some(slot), _) => ("output", slot),
            (None, None, Some(slot)) => ("derivative", slot),
            (None, None, None) => ("error estimate", self.step.worst),
        };
        let block =
            machine.block_of_slot.get(slot).map_or_else(String::new, |b| machine.block_name(*b));
        let net = machine.slot_name(slot as u32);
        RunFault::NonFinite { t_s: self.t_s, block, net, what }
    }

    pub(super) fn underflow(&self, error: f64, step_s: f64) -> RunFault {
        if error.is_finite() {
            let state = self.step.worst;
            let block = self.machine.block_of_state.get(state);
            let block = block.map_or_else(String::new, |b| self.machine.block_name(*b));
            RunFault::StepUnderflow { t_s: self.t_s, step_s, block }
        } else {
            self.not_finite(&self.nets, &self.step.f1)
        }
    }

    /// A function turns faster than time is resolved.
    pub(super) fn too_quick(&self) -> RunFault {
        let block = self.machine.paces.get(self.paces.bounded_by);
        RunFault::TooQuick {
            t_s: self.t_s,
            block: block.map_or_else(String::new, |b| self.machine.block_name(b.1)),
        }
    }

    /// An element is about to be left.
    pub(super) fn count_chatter(&mut self, element: u32) -> Result<(), RunFault> {
        let span_s = CHATTER_SPAN * self.t_s.abs().max(LEAST_TIME_S);
        if self.t_s - self.chatter_from_s > span_s {
            self.chatter_from_s = self.t_s;
            self.chatter = 0;
        }
        self.chatter += 1;
        if self.chatter < CHATTER_EVENTS { Ok(()) } else { Err(self.chatters(element)) }
    }

    /// After settling: none of what switched does so ever more quickly.
    pub(super) fn count_switchings(&mut self) -> Result<(), RunFault> {
        while let Some(element) = self.happenings.switched.pop() {
            let switched = &mut self.switched[element as usize];
            // Once an instant: what repeats within one is a logic race.
            if self.t_s > switched.at_s && switched.accumulates(self.t_s) {
                return Err(self.chatters(element));
            }
        }
        Ok(())
    }

    fn chatters(&self, element: u32) -> RunFault {
        let (block, _) = self.machine.elements[element as usize];
        RunFault::Chatter {
            t_s: self.t_s,
            block: self.machine.block_name(block),
            events: self.chatter.max(self.switched[element as usize].shorter + 1),
        }
    }
}
