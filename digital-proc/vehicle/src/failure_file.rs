//! The failure file: operating modes of a long-period flight as TOML scripts.
//!
//! The shipped file is embedded; a user's own file replaces it. Every fault that
//! can be told apart is reported with its line and the nearest known name. A mode
//! says what happens to the control system and when; wind and misalignments
//! belong to the flight, not here.

use crate::flight_mode::{Action, Effect, FlightMode, FlightScript, Part, Schedule};
use desk::faults::{self, FileFault, FileFaults, Source, suggestion};
use serde::Deserialize;
use std::{path::Path, sync::LazyLock};
use toml::Spanned;

/// Text of the shipped failure file.
pub const SHIPPED_TEXT: &str = include_str!("../../data/failures.toml");
/// Name under which its faults would be reported.
pub const SHIPPED_NAME: &str = "digital-proc/data/failures.toml";

/// Largest factor on a gain or an effectiveness.
const LARGEST_FACTOR: f64 = 100.0;

/// A checked failure file.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureFile {
    /// File as named by the caller.
    pub file: String,
    /// The modes in the file's order; at least one.
    pub modes: Vec<FlightScript>,
}

static SHIPPED: LazyLock<FailureFile> = LazyLock::new(|| {
    FailureFile::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
        .expect("the embedded failure file is sound: a unit test reads it")
});

impl FailureFile {
    /// The shipped file.
    pub fn shipped() -> &'static FailureFile {
        &SHIPPED
    }

    /// Reads a user's file.
    ///
    /// # Errors
    /// Every fault found.
    pub fn load(path: &Path) -> Result<FailureFile, FileFaults> {
        faults::load(path, FailureFile::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    ///
    /// # Errors
    /// Every fault found.
    pub fn from_toml(file: &str, text: &str) -> Result<FailureFile, FileFaults> {
        let source = Source { file, text };
        let raw: RawFile = source.parse()?;
        let mut faults = Vec::new();
        let mut modes: Vec<FlightScript> = Vec::new();
        for raw in raw.mode {
            let name = raw.name.get_ref().clone();
            if modes.iter().any(|m| m.name == name) {
                faults.push(source.fault(
                    raw.name.span(),
                    format!("a second mode named `{name}`"),
                    "rename one of them",
                ));
            }
            modes.push(raw.script(&source, &mut faults));
        }
        if modes.is_empty() {
            faults.push(source.fault(
                0..0,
                "there is no mode",
                "write at least one [[mode]] with a name",
            ));
        }
        let file = file.to_owned();
        FileFaults::unless(faults, FailureFile { file, modes })
    }

    /// The mode of a name.
    ///
    /// # Errors
    /// There is none; the remedy names the nearest.
    pub fn mode(&self, name: &str) -> Result<&FlightScript, FileFaults> {
        let found = self.modes.iter().find(|mode| mode.name == name);
        found.ok_or_else(|| {
            let known = self.modes.iter().map(|m| m.name.as_str());
            let fault = FileFault {
                file: self.file.clone(),
                place: None,
                fault: format!("has no mode `{name}`"),
                remedy: suggestion(name, known),
            };
            fault.into()
        })
    }
}

impl FlightMode {
    /// Its script in the shipped failure file.
    pub fn script(self) -> &'static FlightScript {
        FailureFile::shipped()
            .mode(self.name())
            .expect("the embedded failure file has every named mode: a unit test asks for each")
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    #[serde(default)]
    mode: Vec<RawMode>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawMode {
    name: Spanned<String>,
    #[serde(default)]
    paper: String,
    schedule: Option<Schedule>,
    #[serde(default)]
    actions: Vec<Spanned<RawAction>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawAction {
    at_s: Spanned<f64>,
    roll_gain: Option<Spanned<f64>>,
    ftc_gain_pitch: Option<Spanned<f64>>,
    ftc_gain_yaw: Option<Spanned<f64>>,
    tvc_gain_pitch: Option<Spanned<f64>>,
    tvc_gain_yaw: Option<Spanned<f64>>,
    pitch_tips: Option<Spanned<f64>>,
    #[serde(rename = "tip-2")]
    tip_2: Option<Spanned<f64>>,
    #[serde(rename = "tip-4")]
    tip_4: Option<Spanned<f64>>,
    sequencer: Option<RawSequencer>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawSequencer {
    Frozen,
    Running,
}

impl RawMode {
    fn script(self, source: &Source<'_>, faults: &mut Vec<FileFault>) -> FlightScript {
        let mut actions = Vec::new();
        for raw in &self.actions {
            raw.get_ref().effects(source, faults, &mut actions, raw);
        }
        // Stable: actions of one instant keep the file's order.
        actions.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        FlightScript {
            name: self.name.into_inner(),
            text: self.paper,
            schedule: self.schedule.unwrap_or(Schedule::Designed),
            actions,
        }
    }
}

impl RawAction {
    fn effects(
        &self,
        source: &Source<'_>,
        faults: &mut Vec<FileFault>,
        actions: &mut Vec<Action>,
        whole: &Spanned<RawAction>,
    ) {
        let at_s = *self.at_s.get_ref();
        if !(at_s >= 0.0 && at_s.is_finite()) {
            faults.push(source.fault(
                self.at_s.span(),
                format!("an action at {at_s} s"),
                "give a flight time of 0 s or later".to_owned(),
            ));
        }
        let before = actions.len();
        let factors = [
            (Part::RollGain, &self.roll_gain),
            (Part::FtcPitch, &self.ftc_gain_pitch),
            (Part::FtcYaw, &self.ftc_gain_yaw),
            (Part::TvcPitch, &self.tvc_gain_pitch),
            (Part::TvcYaw, &self.tvc_gain_yaw),
            (Part::PitchTips, &self.pitch_tips),
            (Part::Tip2, &self.tip_2),
            (Part::Tip4, &self.tip_4),
        ];
        for (part, factor) in factors {
            let Some(factor) = factor else { continue };
            let value = *factor.get_ref();
            // Also refuses a NaN.
            if value.is_nan() || value.abs() > LARGEST_FACTOR {
                faults.push(source.fault(
                    factor.span(),
                    format!("a factor of {value}"),
                    format!(
                        "factors multiply the sound value: give 0 for dead, 1 for sound, at most {LARGEST_FACTOR}"
                    ),
                ));
            }
            actions.push(Action { at_s, effect: Effect::Factor(part, value) });
        }
        if let Some(sequencer) = &self.sequencer {
            let effect = match sequencer {
                RawSequencer::Frozen => Effect::FreezeSequencer,
                RawSequencer::Running => Effect::RunSequencer,
            };
            actions.push(Action { at_s, effect });
        }
        if actions.len() == before {
            faults.push(source.fault(
                whole.span(),
                "an action that does nothing".to_owned(),
                "give a factor (roll-gain, pitch-tips, …) or sequencer".to_owned(),
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_mode_is_in_the_shipped_file() {
        let names: Vec<&str> =
            FailureFile::shipped().modes.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, FlightMode::ALL.map(FlightMode::name));
        for mode in FlightMode::ALL {
            assert_eq!(mode.script().name, mode.name());
        }
    }

    #[test]
    fn mistakes_are_reported_with_their_lines_all_together() {
        let text = r#"
[[mode]]
name = "a"
actions = [
  { at-s = -1.0, tip-2 = 0.0 },
  { at-s = 3.0 },
  { at-s = 3.0, roll-gain = nan },
]
[[mode]]
name = "a"
"#;
        let faults = FailureFile::from_toml("my.toml", text).unwrap_err().0;
        let lines: Vec<usize> = faults.iter().map(|f| f.place.unwrap().0).collect();
        assert_eq!(lines, [5, 6, 7, 10], "{faults:?}");
    }

    #[test]
    fn a_misspelt_key_or_name_is_answered_with_the_nearest() {
        for (text, words) in [
            (
                "[[mode]]\nname = \"a\"\nactions = [{ at-s = 0.0, rol-gain = 0.0 }]",
                ["my.toml:3", "roll-gain"],
            ),
            (
                "[[mode]]\nname = \"a\"\nactions = [{ at-s = 0.0, sequencer = \"frozn\" }]",
                ["my.toml:3", "frozen"],
            ),
            ("[[mode]]\nname = \"a\"\nschedule = \"reducd\"", ["my.toml:3", "reduced"]),
            ("[[mode]]\npaper = \"a\"", ["my.toml:", "name"]),
            ("", ["my.toml", "[[mode]]"]),
        ] {
            let error = FailureFile::from_toml("my.toml", text).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{text}: {error}");
            }
        }
        let error = FailureFile::shipped().mode("rol-lost").unwrap_err();
        assert!(error.to_string().contains("roll-lost"), "{error}");
    }
}
