//! Operating modes of the long-period study and the settings they give the
//! control loops.
//!
//! The paper (§4.2) names six: (i) normal, (ii) complete failure of roll
//! control, (iii) mechanical failures in pitch and yaw, (iv) failure of the FTC
//! electronics in pitch and yaw, (v) gain sequencer stuck after the first FTC
//! gains, (vi) a schedule with fewer switchings. A mode turns a flight time
//! into [`ControlSettings`]: numbers that the digital side sets by DCU. The
//! equations themselves do not know of modes.

use crate::gain_schedule::LoopGains;
use crate::vehicle::Vehicle;

/// Earliest state in which the sequencer of mode (v) sticks, s: just after the
/// FTC gains are first set at 17 s.
pub const SEQUENCER_STUCK_S: f64 = 17.5;

/// A mode of operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FlightMode {
    /// (i) Everything works.
    Normal,
    /// (ii) Roll gain zero.
    RollLost,
    /// (iii) Pitch tips at half effectiveness and tip 4 dead.
    TipsDead,
    /// (iii), only the pitch tips at half effectiveness.
    PitchTipsHalf,
    /// (iii), only tip 4 dead.
    TipFourDead,
    /// (iv) FTC gain zero in pitch and yaw; roll kept.
    FtcElectronics,
    /// (v) Sequencer stuck at its state of 17.5 s (or of the failure, if later).
    SequencerStuck,
    /// (vi) The schedule with fewer switchings.
    ReducedSchedule,
}

impl FlightMode {
    /// All modes, in the paper's order.
    pub const ALL: [Self; 8] = [
        Self::Normal,
        Self::RollLost,
        Self::TipsDead,
        Self::PitchTipsHalf,
        Self::TipFourDead,
        Self::FtcElectronics,
        Self::SequencerStuck,
        Self::ReducedSchedule,
    ];

    /// Name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::RollLost => "roll-lost",
            Self::TipsDead => "tips-dead",
            Self::PitchTipsHalf => "pitch-tips-half",
            Self::TipFourDead => "tip-four-dead",
            Self::FtcElectronics => "ftc-electronics",
            Self::SequencerStuck => "sequencer-stuck",
            Self::ReducedSchedule => "reduced-schedule",
        }
    }

    /// The mode of a name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }
}

/// What the control loops are set to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSettings {
    /// Gains of pitch and yaw.
    pub gains: LoopGains,
    /// K_φ, rad of tip per rad of roll.
    pub roll_gain: f64,
    /// T_φ, s.
    pub roll_lead_s: f64,
    /// Effectiveness of the pitch pair, 1 when sound.
    pub pitch_tips_effectiveness: f64,
    /// Effectiveness of tip 2.
    pub tip_2_effectiveness: f64,
    /// Effectiveness of tip 4.
    pub tip_4_effectiveness: f64,
}

/// Settings in a mode at a flight time; a failure acts from `failure_start_s`
/// on, and before it the vehicle is normal. The reduced schedule is a design,
/// not a failure: it holds throughout.
pub fn control_settings(
    vehicle: &Vehicle,
    mode: FlightMode,
    failure_start_s: f64,
    time_s: f64,
) -> ControlSettings {
    let data = &vehicle.data().gains;
    let mut settings = ControlSettings {
        gains: vehicle.designed_schedule().at(time_s),
        roll_gain: data.roll_gain,
        roll_lead_s: data.roll_lead_s,
        pitch_tips_effectiveness: 1.0,
        tip_2_effectiveness: 1.0,
        tip_4_effectiveness: 1.0,
    };
    if mode == FlightMode::ReducedSchedule {
        settings.gains = vehicle.reduced_schedule().at(time_s);
        return settings;
    }
    if time_s < failure_start_s {
        return settings;
    }
    match mode {
        FlightMode::Normal | FlightMode::ReducedSchedule => {}
        FlightMode::RollLost => settings.roll_gain = 0.0,
        FlightMode::TipsDead => {
            settings.pitch_tips_effectiveness = 0.5;
            settings.tip_4_effectiveness = 0.0;
        }
        FlightMode::PitchTipsHalf => settings.pitch_tips_effectiveness = 0.5,
        FlightMode::TipFourDead => settings.tip_4_effectiveness = 0.0,
        FlightMode::FtcElectronics => settings.gains.ftc_gain = 0.0,
        FlightMode::SequencerStuck => {
            let stuck_s = SEQUENCER_STUCK_S.max(failure_start_s);
            settings.gains = vehicle.designed_schedule().stuck_at(time_s, stuck_s);
        }
    }
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_modes_are_one_to_one() {
        for mode in FlightMode::ALL {
            assert_eq!(FlightMode::from_name(mode.name()), Some(mode));
        }
        assert_eq!(FlightMode::from_name("warp"), None);
    }

    #[test]
    fn a_failure_acts_from_its_start_and_touches_only_its_own_setting() {
        let vehicle = Vehicle::shipped().unwrap();
        let normal = control_settings(&vehicle, FlightMode::Normal, 0.0, 30.0);
        for mode in FlightMode::ALL {
            if mode != FlightMode::ReducedSchedule {
                assert_eq!(
                    control_settings(&vehicle, mode, 31.0, 30.0),
                    normal,
                    "{mode:?}"
                );
            }
        }
        let lost = control_settings(&vehicle, FlightMode::RollLost, 0.0, 30.0);
        assert_eq!(
            ControlSettings {
                roll_gain: normal.roll_gain,
                ..lost
            },
            normal
        );
        assert_eq!(lost.roll_gain, 0.0);
        let stuck = control_settings(&vehicle, FlightMode::SequencerStuck, 0.0, 45.0);
        assert_eq!(stuck.gains, vehicle.designed_schedule().at(17.0));
        let late = control_settings(&vehicle, FlightMode::SequencerStuck, 26.0, 45.0);
        assert_eq!(late.gains, vehicle.designed_schedule().at(25.0));
        let electronics = control_settings(&vehicle, FlightMode::FtcElectronics, 0.0, 30.0);
        assert_eq!(electronics.gains.ftc_gain, 0.0);
        assert_eq!(electronics.roll_gain, normal.roll_gain);
    }
}
