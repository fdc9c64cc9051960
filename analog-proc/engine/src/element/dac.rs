//! What a digital-to-analog channel puts out between two transfers.
//!
//! A straight line (slope zero for a zero-order hold), reached from the former
//! value through a first-order settling where the profile has one.

use crate::signal::Signal;
use serde::{Deserialize, Serialize};

/// One transfer to a channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DacPiece {
    /// Value at `from_s`.
    pub value: f64,
    /// Slope, per second.
    pub slope_per_s: f64,
    /// Problem time of the transfer, s.
    pub from_s: f64,
    /// Settling time constant, s; zero or less: at once.
    pub settling_s: f64,
}

impl DacPiece {
    /// A value held from `from_s` on, without settling.
    pub fn held(value: f64, from_s: f64) -> DacPiece {
        DacPiece { value, slope_per_s: 0.0, from_s, settling_s: 0.0 }
    }
}

/// A channel's output as a function of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    piece: DacPiece,
    /// What is left of the former value at `from_s`.
    residue: f64,
    constant: bool,
}

impl Hold {
    pub fn at(value: f64) -> Hold {
        Hold { piece: DacPiece::held(value, 0.0), residue: 0.0, constant: true }
    }

    pub fn transfer(&self, piece: DacPiece) -> Hold {
        let residue =
            if piece.settling_s > 0.0 { self.at_time(piece.from_s) - piece.value } else { 0.0 };
        if piece.slope_per_s == 0.0 && residue == 0.0 {
            return Hold::at(piece.value);
        }
        Hold { piece, residue, constant: false }
    }

    /// Whether the output stands still until the next transfer.
    pub fn constant(&self) -> bool {
        self.constant
    }

    #[inline(always)]
    pub fn at_time(&self, t_s: f64) -> f64 {
        if self.constant {
            return self.piece.value;
        }
        let since_s = t_s - self.piece.from_s;
        let mut value = self.piece.value + self.piece.slope_per_s * since_s;
        if self.residue != 0.0 {
            value += self.residue * libm::exp(-since_s / self.piece.settling_s);
        }
        value
    }

    /// The output with its rate.
    #[inline(always)]
    pub fn signal<N: Signal>(&self, t_s: f64) -> N {
        N::of_time(t_s, self.at_time(t_s), || {
            let piece = &self.piece;
            let mut rate = if self.constant { 0.0 } else { piece.slope_per_s };
            if self.residue != 0.0 {
                let fading = self.residue * libm::exp(-(t_s - piece.from_s) / piece.settling_s);
                rate -= fading / piece.settling_s;
            }
            rate
        })
    }
}
