//! Operating modes as scripts, and the settings they give the control loops.
//!
//! The paper (§4.2) names six: (i) normal, (ii) complete failure of roll
//! control, (iii) mechanical failures in pitch and yaw, (iv) failure of the FTC
//! electronics in pitch and yaw, (v) gain sequencer stuck after the first FTC
//! gains, (vi) a schedule with fewer switchings. A mode is a [`FlightScript`]:
//! actions, each with its time of occurrence. It turns a flight time into
//! [`ControlSettings`]: numbers that the digital side sets by DCU. The equations
//! themselves do not know of modes. Scripts come from a failure file
//! ([`crate::failure_file`]); [`FlightMode`] names the shipped ones.

use crate::Vehicle;
use crate::gain_schedule::LoopGains;

interface::named! {
    /// A mode of the shipped failure file, in the paper's order, by its name on the command line,
    /// in the failure file and in reports.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum FlightMode, name {
        /// (i) Everything works.
        Normal "normal"
        /// (ii) Roll gain zero.
        RollLost "roll-lost"
        /// (iii) Pitch tips at half effectiveness and tip 4 dead.
        TipsDead "tips-dead"
        /// (iii), only the pitch tips at half effectiveness.
        PitchTipsHalf "pitch-tips-half"
        /// (iii), only tip 4 dead.
        TipFourDead "tip-four-dead"
        /// (iv) FTC gain zero in pitch and yaw; roll kept.
        FtcElectronics "ftc-electronics"
        /// (v) Sequencer stuck at its state of 17.5 s.
        SequencerStuck "sequencer-stuck"
        /// (vi) The schedule with fewer switchings.
        ReducedSchedule "reduced-schedule"
    }
}

/// A mode as a script.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct FlightScript {
    pub name: String,
    /// The paper's words for it, or the author's.
    pub text: String,
    /// The schedule that the sequencer runs through.
    pub schedule: Schedule,
    pub actions: Vec<Action>,
}

/// Which gain schedule is loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// The one designed from the short-period models.
    Designed,
    /// The one with fewer switchings.
    Reduced,
}

/// One scripted event.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Action {
    /// Flight time from which it acts, s.
    pub at_s: f64,
    pub effect: Effect,
}

/// What an action does.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// Sets the factor on a quantity: 0 dead, 1 sound.
    Factor(Part, f64),
    /// The sequencer keeps the state it has at that instant.
    FreezeSequencer,
    /// The sequencer takes up its schedule again.
    RunSequencer,
}

interface::named! {
    /// A part of the control system that an action may weaken.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Part, words {
        RollGain "roll gain"
        FtcPitch "FTC gain in pitch"
        FtcYaw "FTC gain in yaw"
        TvcPitch "TVC gain in pitch"
        TvcYaw "TVC gain in yaw"
        PitchTips "pitch tips"
        Tip2 "tip 2"
        Tip4 "tip 4"
    }
}

impl FlightScript {
    /// A flight on which nothing fails.
    pub fn sound() -> Self {
        Self {
            name: FlightMode::Normal.name().to_owned(),
            text: String::new(),
            schedule: Schedule::Designed,
            actions: Vec::new(),
        }
    }

    /// The same failure with its first action at `at_s`; the others keep their distance from it.
    pub fn occurring_at(&self, at_s: f64) -> Self {
        let first_s = self.actions.iter().map(|a| a.at_s).fold(f64::INFINITY, f64::min);
        let later = |action: &Action| Action { at_s: at_s + (action.at_s - first_s), ..*action };
        Self { actions: self.actions.iter().map(later).collect(), ..self.clone() }
    }
}

/// What the control loops are set to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSettings {
    /// Gains of pitch and yaw as the sequencer gives them.
    pub gains: LoopGains,
    /// Factors on K_F in pitch and yaw, 1 when sound.
    pub ftc_factor: [f64; 2],
    /// Factors on K_T in pitch and yaw, 1 when sound.
    pub tvc_factor: [f64; 2],
    /// K_φ, rad of tip per rad of roll.
    pub roll_gain: f64,
    /// T_φ, s.
    pub roll_lead_s: f64,
    /// Effectiveness of the pitch pair, 1 when sound.
    pub pitch_tips_effectiveness: f64,
    pub tip_2_effectiveness: f64,
    pub tip_4_effectiveness: f64,
}

impl ControlSettings {
    /// Settings of a sound vehicle on the designed schedule.
    pub fn sound(vehicle: &Vehicle, time_s: f64) -> Self {
        let data = &vehicle.data().gains;
        Self {
            gains: vehicle.designed_schedule().at(time_s),
            ftc_factor: [1.0; 2],
            tvc_factor: [1.0; 2],
            roll_gain: data.roll_gain,
            roll_lead_s: data.roll_lead_s,
            pitch_tips_effectiveness: 1.0,
            tip_2_effectiveness: 1.0,
            tip_4_effectiveness: 1.0,
        }
    }

    /// K_F in force in pitch and yaw, rad of tip per rad.
    pub fn ftc_gain(&self) -> [f64; 2] {
        self.ftc_factor.map(|f| f * self.gains.ftc_gain)
    }

    /// K_T in force in pitch and yaw, N/rad.
    pub fn tvc_gain_nprad(&self) -> [f64; 2] {
        self.tvc_factor.map(|f| f * self.gains.tvc_gain_nprad)
    }
}

/// Settings under a script at a flight time. No action acts before
/// `not_before_s`: earlier ones wait until then. The schedule is a design, not a
/// failure: it holds throughout.
pub fn control_settings(
    vehicle: &Vehicle,
    script: &FlightScript,
    not_before_s: f64,
    time_s: f64,
) -> ControlSettings {
    let mut settings = ControlSettings::sound(vehicle, time_s);
    let roll_gain = settings.roll_gain;
    let mut sequencer_s = time_s;
    for action in &script.actions {
        let acts_s = action.at_s.max(not_before_s);
        if time_s < acts_s {
            continue;
        }
        match action.effect {
            // A second freeze of a frozen sequencer changes nothing.
            Effect::FreezeSequencer => sequencer_s = sequencer_s.min(acts_s),
            Effect::RunSequencer => sequencer_s = time_s,
            Effect::Factor(part, factor) => match part {
                Part::RollGain => settings.roll_gain = factor * roll_gain,
                Part::FtcPitch => settings.ftc_factor[0] = factor,
                Part::FtcYaw => settings.ftc_factor[1] = factor,
                Part::TvcPitch => settings.tvc_factor[0] = factor,
                Part::TvcYaw => settings.tvc_factor[1] = factor,
                Part::PitchTips => settings.pitch_tips_effectiveness = factor,
                Part::Tip2 => settings.tip_2_effectiveness = factor,
                Part::Tip4 => settings.tip_4_effectiveness = factor,
            },
        }
    }
    let schedule = match script.schedule {
        Schedule::Designed => vehicle.designed_schedule(),
        Schedule::Reduced => vehicle.reduced_schedule(),
    };
    settings.gains = schedule.at(sequencer_s);
    settings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_acts_from_its_start() {
        let vehicle = Vehicle::shipped().unwrap();
        let at = |mode: FlightMode, not_before_s, time_s| {
            control_settings(&vehicle, mode.script(), not_before_s, time_s)
        };
        let normal = at(FlightMode::Normal, 0.0, 30.0);
        assert_eq!(normal, ControlSettings::sound(&vehicle, 30.0));
        for mode in FlightMode::ALL {
            if mode != FlightMode::ReducedSchedule {
                assert_eq!(at(mode, 31.0, 30.0), normal, "{mode:?}");
            }
        }
        let late = at(FlightMode::SequencerStuck, 26.0, 45.0);
        assert_eq!(late.gains, vehicle.designed_schedule().at(25.0));
    }

    #[test]
    fn a_failure_is_moved_as_a_whole() {
        let action = |at_s| Action { at_s, effect: Effect::Factor(Part::Tip2, 0.0) };
        let script = FlightScript {
            actions: [17.5, 20.0, 19.0].map(action).into(),
            ..FlightScript::sound()
        };
        let times: Vec<f64> = script.occurring_at(0.0).actions.iter().map(|a| a.at_s).collect();
        assert_eq!(times, [0.0, 2.5, 1.5]);
        assert_eq!(FlightScript::sound().occurring_at(3.0), FlightScript::sound());
    }

    #[test]
    fn a_later_action_mends_an_earlier_one() {
        let vehicle = Vehicle::shipped().unwrap();
        let action = |at_s, effect| Action { at_s, effect };
        let script = FlightScript {
            actions: vec![
                action(18.0, Effect::FreezeSequencer),
                action(20.0, Effect::Factor(Part::FtcPitch, 0.0)),
                action(30.0, Effect::Factor(Part::FtcPitch, 1.0)),
                action(41.0, Effect::RunSequencer),
            ],
            ..FlightScript::sound()
        };
        let at = |time_s| control_settings(&vehicle, &script, 0.0, time_s);
        let designed = vehicle.designed_schedule();
        assert_eq!(at(25.0).ftc_gain(), [0.0, designed.at(18.0).ftc_gain]);
        assert_eq!(at(40.9).gains, designed.at(18.0));
        assert_eq!(at(41.0), ControlSettings::sound(&vehicle, 41.0));
    }
}
