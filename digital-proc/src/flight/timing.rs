//! When updates take effect in a flight, and the record by which a free-running
//! one is repeated.
//!
//! Free-running, each update takes effect when it arrives, and the analog side
//! tells that instant. Those instants are all that the wall clock contributes to
//! a run: with them a replay in lock-step is the same to the last bit.

use interface::{
    Tick,
    control::Clock,
    frame::{Samples, Transfer},
    processor,
};

/// Who says when updates take effect.
#[derive(Clone, Copy, Debug)]
pub enum Timing<'a> {
    /// The frame: at `t_n + τ`.
    LockStep,
    /// The wall clock: when they arrive.
    Wall,
    /// The record of an earlier flight.
    Replay(&'a TransferLog),
}

impl Timing<'_> {
    /// As the analog side is told; on the wall clock both sides may have to share a processor.
    pub fn clock(self) -> Clock {
        match self {
            Timing::LockStep => Clock::LockStep,
            Timing::Wall => Clock::Wall { processor: processor::to_share() },
            Timing::Replay(_) => Clock::Replay,
        }
    }

    /// The instant that updates of `frame` must carry; `None` leaves it to the analog side.
    pub fn effective(self, frame: u64) -> Option<Tick> {
        match self {
            Timing::LockStep | Timing::Wall => None,
            // What never took effect, because the run ended before, never does.
            Timing::Replay(log) => Some(log.at(frame).unwrap_or(Tick(i64::MAX))),
        }
    }
}

/// Every transfer of a run, in order of frame and of time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TransferLog {
    transfers: Vec<Transfer>,
}

/// Why transfers are not those of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("transfer {row} (frame {frame}, {at}) does not follow the one before it")]
pub struct OutOfOrder {
    /// Its row, counted from 0.
    pub row: usize,
    /// Its frame.
    pub frame: u64,
    /// Its instant.
    pub at: Tick,
}

impl TransferLog {
    /// The log of these transfers.
    pub fn new(transfers: Vec<Transfer>) -> Result<TransferLog, OutOfOrder> {
        let follows =
            |pair: &[Transfer]| pair[0].frame < pair[1].frame && pair[0].tick <= pair[1].tick;
        match transfers.windows(2).position(|pair| !follows(pair)) {
            None => Ok(TransferLog { transfers }),
            Some(before) => {
                let row = before + 1;
                Err(OutOfOrder { row, frame: transfers[row].frame, at: transfers[row].tick })
            }
        }
    }

    /// Takes over what a frame tells.
    pub fn observe(&mut self, samples: &Samples) {
        self.transfers.extend_from_slice(samples.transfers());
    }

    /// When updates of `frame` took effect, if they did.
    pub fn at(&self, frame: u64) -> Option<Tick> {
        self.transfers
            .binary_search_by_key(&frame, |t| t.frame)
            .ok()
            .map(|found| self.transfers[found].tick)
    }

    /// All of them.
    pub fn transfers(&self) -> &[Transfer] {
        &self.transfers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replay_carries_the_recorded_instants() {
        let of = |frame, tick| Transfer { frame, tick: Tick(tick) };
        let log = TransferLog::new(vec![of(0, 5), of(2, 5), of(3, 40)]).unwrap();
        let timing = Timing::Replay(&log);
        assert_eq!(timing.effective(2), Some(Tick(5)));
        assert_eq!(timing.effective(1), Some(Tick(i64::MAX)));
        assert_eq!(Timing::Wall.effective(2), None);
        for wrong in [vec![of(1, 5), of(1, 6)], vec![of(0, 6), of(1, 5)]] {
            assert_eq!(TransferLog::new(wrong).unwrap_err().row, 1);
        }
    }
}
