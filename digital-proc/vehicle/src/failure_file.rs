//! The failure file: operating modes of a long-period flight as TOML scripts.
//!
//! The shipped file is embedded; a user's own file replaces it. Every fault that
//! can be told apart is reported with its line and the nearest known name. A mode
//! says what happens to the control system and when; wind and misalignments
//! belong to the flight, not here.

use crate::flight_mode::{Action, Effect, FlightMode, FlightScript, Part, Schedule};
use desk::faults::{FileFaults, Source, suggestion};
use desk::reader::{self, FileKind, SheetFields};
use std::{path::Path, sync::LazyLock};

pub const SHIPPED_TEXT: &str = include_str!("../../data/failures.toml");
/// Name under which its faults are reported.
pub const SHIPPED_NAME: &str = "the shipped failure file";

/// Largest factor on a gain or an effectiveness.
const LARGEST_FACTOR: f64 = 100.0;
const FACTORS: &str = "0 for dead, 1 for sound, at most 100 either way";

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
    pub fn shipped() -> &'static FailureFile {
        &SHIPPED
    }

    pub fn load(path: &Path) -> Result<FailureFile, FileFaults> {
        reader::load(path, FailureFile::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    pub fn from_toml(file: &str, text: &str) -> Result<FailureFile, FileFaults> {
        let modes = reader::read(FileKind::Failures, Source { file, text }, |f| {
            let modes = f.tables("mode", mode);
            let some = modes.as_ref().is_none_or(|modes| !modes.is_empty());
            f.require(some, "mode", "the file has no mode", "add at least one [[mode]]");
            modes
        })?;
        Ok(FailureFile { file: file.to_owned(), modes })
    }

    pub fn mode(&self, name: &str) -> Result<&FlightScript, FileFaults> {
        let found = self.modes.iter().find(|mode| mode.name == name);
        found.ok_or_else(|| {
            let known = self.modes.iter().map(|m| m.name.as_str());
            let source = Source { file: &self.file, text: "" };
            source.whole(format!("has no mode `{name}`"), suggestion(name, known)).into()
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

fn mode(f: &mut SheetFields<'_, '_>) -> Option<FlightScript> {
    let name = f.text("name");
    let text = f.text_or_none("paper").unwrap_or_default();
    let schedules = [("designed", Schedule::Designed), ("reduced", Schedule::Reduced)];
    let schedule = f.word("schedule", Some(Schedule::Designed), &schedules);
    let mut actions = f.tables("actions", actions)?.concat();
    // Stable: actions of one instant keep the file's order.
    actions.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    Some(FlightScript { name: name?, text, schedule: schedule?, actions })
}

/// All that happens at one time.
fn actions(f: &mut SheetFields<'_, '_>) -> Option<Vec<Action>> {
    let at_s = f.ranged("at-s", None, "a flight time of 0 s or later", |t| t >= 0.0);
    let parts = [
        ("roll-gain", Part::RollGain),
        ("ftc-gain-pitch", Part::FtcPitch),
        ("ftc-gain-yaw", Part::FtcYaw),
        ("tvc-gain-pitch", Part::TvcPitch),
        ("tvc-gain-yaw", Part::TvcYaw),
        ("pitch-tips", Part::PitchTips),
        ("tip-2", Part::Tip2),
        ("tip-4", Part::Tip4),
    ];
    let fits = |k: f64| k.abs() <= LARGEST_FACTOR;
    let mut effects = Vec::new();
    let mut is_idle = f.place("sequencer").is_none();
    for (key, part) in parts {
        is_idle &= f.place(key).is_none();
        let factor = f.maybe(key, |f| f.ranged(key, None, FACTORS, fits));
        effects.extend(factor.map(|k| Effect::Factor(part, k)));
    }
    let states = [("frozen", Effect::FreezeSequencer), ("running", Effect::RunSequencer)];
    effects.extend(f.maybe("sequencer", |f| f.word("sequencer", None, &states)));
    let remedy = "give a factor (roll-gain, pitch-tips, …) or sequencer";
    f.require(!is_idle, "", "an action that does nothing", remedy);
    let at_s = at_s?;
    Some(effects.into_iter().map(|effect| Action { at_s, effect }).collect())
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
    fn what_makes_no_sense_is_told_with_its_place() {
        let of_action =
            |action: &str| format!("[[mode]]\nname = \"a\"\nactions = [{{ {action} }}]");
        for (text, told) in [
            (of_action("at-s = -1.0, tip-2 = 0.0"), "my.toml:3:21: `mode.actions.at-s` = -1"),
            (of_action("at-s = 3.0"), "my.toml:3:12: an action that does nothing"),
            (of_action("at-s = 3.0, roll-gain = nan"), "my.toml:3:38: "),
            (of_action("at-s = 3.0, roll-gain = 1e3"), "at most 100"),
            (of_action("at-s = 0.0, rol-gain = 0.0"), "did you mean `roll-gain`?"),
            (of_action("at-s = 0.0, sequencer = \"frozn\""), "did you mean `frozen`?"),
            ("[[mode]]\nname = \"a\"\n[[mode]]\nname = \"a\"".into(), "my.toml:4:8: a second mode"),
            ("[[mode]]\npaper = \"a\"".into(), "my.toml:1:1: [mode] lacks `name`"),
            (String::new(), "[[mode]]"),
        ] {
            let error = FailureFile::from_toml("my.toml", &text).unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
        }
        let error = FailureFile::shipped().mode("rol-lost").unwrap_err();
        assert!(error.to_string().contains("roll-lost"), "{error}");
    }
}
