//! Why a case of a loop study has no damping, and what else happened in it.

use super::swing::Swing;
use std::fmt;

/// What of a record its modes may leave (rms over rms of the record about its mean) for a damping
/// to be told, where no converter is in the way.
///
/// Decays of linear loops leave 1e-12 to 1e-7 (tolerance of the integration). Where the loop is
/// not linear all through, modes bend to it: a limiter that acts for the first swing left 0.005
/// and moved ζ by 0.02, one that left 2e-4 moved it by less than 1e-4. A step of the reference
/// within the record or a relay leaves 0.02 to 1.
pub(super) const WORST_FIT: f64 = 1e-3;
/// A ring-down is judged while it is at least this many converter steps high: below, the loop
/// hunts about one step and has no damping to speak of.
pub(super) const STEPS_HIGH: f64 = 10.0;

/// A remark on one case.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// Converters or coefficients reached the end of their range.
    Saturated {
        /// By name, as `DAC u`.
        channels: Vec<String>,
        /// Instant of the last frame in which one did, s.
        until_s: f64,
    },
    /// Too few frames are left to find modes in.
    TooShort { frames: usize },
    /// The record stands too few converter steps high.
    TooCoarse,
    /// No mode at all: a constant.
    NoModes,
    /// Modes, none of which oscillates.
    NoOscillation { fit: f64 },
    /// No sum of modes: not the decay of one linear loop.
    NotOneDecay { fit: f64 },
    /// It swings on to the end.
    Swings(Swing),
    /// There are no exact poles, for this reason.
    NoPoles(String),
}

impl Remark {
    /// What the modes sought leave of the record.
    pub(super) fn fit(&self) -> Option<f64> {
        match self {
            Remark::NoOscillation { fit } | Remark::NotOneDecay { fit } => Some(*fit),
            _ => None,
        }
    }

    /// What it means and what to do, the same for every case; none where the remark says all.
    pub fn explanation(&self) -> Option<String> {
        match self {
            Remark::Saturated { .. } => Some(
                "saturated: the loop is not linear until then; it is judged from there on.".into(),
            ),
            Remark::NotOneDecay { .. } => Some(format!(
                "not one decay: no sum of modes describes the record to {WORST_FIT} of it and what its converters round, so that no damping is told. Judge a free decay, or a step response after the last change of the reference: state `from` (and `until`) in the study. With a relay, a limiter that acts, a dead zone, noise or few bits there is none to tell."
            )),
            Remark::TooCoarse => Some(format!(
                "too coarse: what stands {STEPS_HIGH} converter steps high is too short to tell a damping; use more of the converters' range, or more bits."
            )),
            Remark::TooShort { .. } => Some(
                "too short: saturation leaves too little of the record; state a later `stop` or an `until` before it, or excite the loop less.".into(),
            ),
            Remark::Swings(_) => Some(
                "swings on: a limit cycle, an undamped loop, or an input of that period.".into(),
            ),
            Remark::NoModes | Remark::NoOscillation { .. } | Remark::NoPoles(_) => None,
        }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Remark::Saturated { channels, until_s } => {
                write!(f, "saturated until {until_s:.4} s: {}", channels.join(", "))
            }
            Remark::TooShort { frames } => write!(f, "too short: {frames} frames left"),
            Remark::TooCoarse => f.write_str("too coarse"),
            Remark::NoModes => f.write_str("constant"),
            Remark::NoOscillation { .. } => f.write_str("does not oscillate"),
            Remark::NotOneDecay { .. } => f.write_str("not one decay"),
            Remark::NoPoles(reason) => write!(f, "no exact poles: {reason}"),
            Remark::Swings(swing) => write!(
                f,
                "swings on: amplitude {:.3e}, period {:.4} s",
                swing.amplitude, swing.period_s
            ),
        }
    }
}
