//! How a DAC's output runs between transfers.
//!
//! Between two events the output is one linear piece `a + b·(t − t0)`, which the
//! integrator can use exactly. With transfers v_k at t_k and T_k = t_k − t_{k−1}:
//!
//! | hold | piece from t_k on | lag of a ramp |
//! |---|---|---|
//! | zero order | v_k | T/2 on average |
//! | first order, extrapolating | v_k + (v_k − v_{k−1})/T_k · (t − t_k) | none |
//! | first order, interpolating | from the present output to v_k in T_k, then v_k | T |
//!
//! The first transfer has no forerunner and is held. Settling is a lag on top, which the
//! integrator solves. Time enters as an argument.

use crate::Tick;
use serde::{Deserialize, Serialize};

/// Kind of reconstruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HoldKind {
    /// The last value is held.
    #[default]
    ZeroOrder,
    /// The last slope is continued.
    Extrapolating,
    /// The output runs to the new value within one period.
    Interpolating,
}

/// A linear piece of output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Instant at which the piece begins.
    pub start: Tick,
    /// Value there, `a`.
    pub value: f64,
    /// Slope `b`, per second.
    pub slope: f64,
    /// Instant from which on the output holds, if it does.
    pub end: Option<Tick>,
}

impl Piece {
    /// Output at `t`, which is not before `start`.
    pub fn at(&self, t: Tick) -> f64 {
        let until = self.end.map_or(t, |end| end.min(t));
        self.value + self.slope * (until - self.start).secs()
    }
}

/// Reconstruction of one DAC channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    kind: HoldKind,
    last: Option<(Tick, f64)>,
    piece: Piece,
}

impl Hold {
    /// Holds `value` until the first transfer.
    pub fn new(kind: HoldKind, value: f64) -> Hold {
        Hold { kind, last: None, piece: Piece { start: Tick::ZERO, value, slope: 0.0, end: None } }
    }

    /// Transfers a value; gives the piece that holds from `at` on. A transfer that
    /// is not later than the last one replaces it and is held.
    pub fn transfer(&mut self, at: Tick, value: f64) -> Piece {
        let forerunner = self.last.filter(|(t, _)| *t < at);
        let held = Piece { start: at, value, slope: 0.0, end: None };
        self.piece = match (self.kind, forerunner) {
            (HoldKind::ZeroOrder, _) | (_, None) => held,
            (HoldKind::Extrapolating, Some((before, old))) => {
                Piece { slope: (value - old) / (at - before).secs(), ..held }
            }
            (HoldKind::Interpolating, Some((before, _))) => {
                let period = at - before;
                let present = self.piece.at(at);
                Piece {
                    value: present,
                    slope: (value - present) / period.secs(),
                    end: Some(at + period),
                    ..held
                }
            }
        };
        self.last = Some((at, value));
        self.piece
    }

    /// The piece that holds now.
    pub fn piece(&self) -> Piece {
        self.piece
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Tick = Tick(1_000_000);

    #[test]
    fn extrapolation_reproduces_a_ramp() {
        let mut hold = Hold::new(HoldKind::Extrapolating, 0.0);
        for k in 0..5 {
            let piece = hold.transfer(MS * k, 3.0 * k as f64);
            let halfway = MS * k + Tick(500_000);
            let expected = if k == 0 { 0.0 } else { 3.0 * (k as f64 + 0.5) };
            // Slope and product are each rounded once, relative 2⁻⁵³, on values below 20.
            assert!((piece.at(halfway) - expected).abs() < 20.0 * 2.0 * f64::EPSILON);
        }
    }

    #[test]
    fn interpolation_is_a_ramp_one_period_late_and_continuous() {
        let mut hold = Hold::new(HoldKind::Interpolating, 0.0);
        let mut before = 0.0;
        for k in 0..6 {
            let at = MS * k;
            let end_of_last = hold.piece().at(at);
            let piece = hold.transfer(at, 2.0 * k as f64);
            // Rounding of slope and product on values below 12.
            assert!((piece.at(at) - end_of_last).abs() < 12.0 * 2.0 * f64::EPSILON || k == 0);
            assert!((piece.at(at) - before).abs() < 12.0 * 2.0 * f64::EPSILON);
            before = 2.0 * k as f64;
        }
        // No further transfer: it stays at the last value after one period.
        assert!((hold.piece().at(MS * 100) - 10.0).abs() < 12.0 * 2.0 * f64::EPSILON);
    }

    #[test]
    fn a_repeated_instant_replaces() {
        for kind in [HoldKind::Extrapolating, HoldKind::Interpolating] {
            let mut hold = Hold::new(kind, 0.0);
            hold.transfer(MS, 1.0);
            let piece = hold.transfer(MS, 7.0);
            assert_eq!((piece.value, piece.slope), (7.0, 0.0));
        }
    }
}
