//! The study as a file: trajectory points, conditions and what disturbs a run.
//!
//! The shipped study is embedded; a user's own file replaces it. Reading finds
//! every fault that does not depend on the vehicle and names its line and, for a
//! misspelt name, the nearest known one. What depends on the vehicle (an event that
//! its flight lacks) is found by [`super::plan`].

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::quantity::{QUANTITIES, Quantity, Range};
use crate::study::fault::{FileFault, Source, suggestion};

/// Text of the shipped study.
pub const SHIPPED_TEXT: &str = include_str!("../../../data/short-period.toml");
/// Name under which its faults would be reported.
pub const SHIPPED_NAME: &str = "digital-proc/data/short-period.toml";

/// Longest run offered, s.
const LONGEST_S: f64 = 600.0;
/// Shortest and longest sampling interval, ms.
const SAMPLE_MS: std::ops::RangeInclusive<u32> = 1..=100;

/// A study that was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {reason}; check the path and its permissions")]
    Unreadable {
        /// File as named by the caller.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// One or more faults in the text.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Faults(Vec<FileFault>),
    /// The nominal flight from which the points are frozen failed.
    #[error("the nominal flight cannot be computed: {0}")]
    Flight(String),
}

/// A checked study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// File as named by the caller.
    pub file: String,
    /// Its text, for later faults.
    pub(super) text: String,
    /// Duration of a run, s.
    pub duration_s: f64,
    /// Sampling interval, ms.
    pub sample_ms: u32,
    /// The pitch test.
    pub pitch: PitchTest,
    /// The yaw–roll test.
    pub yaw_roll: YawRollTest,
    /// Trajectory points.
    pub points: Vec<PointEntry>,
    /// Operating conditions.
    pub conditions: Vec<Condition>,
}

/// The pitch test.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct PitchTest {
    /// Step command, deg.
    pub step_deg: f64,
    /// Fraction of the three-sigma misalignment.
    pub misalignment: f64,
    /// Fraction of the step gust.
    pub gust: f64,
}

/// The yaw–roll test.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct YawRollTest {
    /// Initial yaw, deg.
    pub yaw_deg: f64,
    /// Initial yaw rate, deg/s.
    pub yaw_rate_dps: f64,
    /// Initial roll, deg.
    pub roll_deg: f64,
    /// Initial roll rate, deg/s.
    pub roll_rate_dps: f64,
    /// Fraction of the three-sigma misalignment.
    pub misalignment: f64,
    /// Fraction of the step gust.
    pub gust: f64,
    /// Fraction of the fin-cant moment.
    pub cant: f64,
}

/// A trajectory point as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct PointEntry {
    /// Name.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Where on the trajectory.
    pub at: Place,
    /// Added to the time found, s.
    pub offset_s: f64,
    /// Where it stands in the file.
    pub(super) span: std::ops::Range<usize>,
}

/// Where on the trajectory a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// At a flight time, s.
    Time(f64),
    /// At an event.
    Event(Event),
    /// Where a Mach number is first reached.
    Mach(f64),
    /// At the n-th switching of the designed schedule, counted from 1.
    GainSwitch(usize),
}

/// Events of the nominal flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The pitch programme begins.
    PitchInitiation,
    /// Middle of the interval of greatest pitch rate.
    MaxPitchRate,
    /// Fin-tip control is switched in.
    FtcOn,
    /// Dynamic pressure is greatest.
    MaxQ,
    /// The motor has burnt out.
    BurnOut,
}

impl Event {
    const ALL: [(&'static str, Event); 5] = [
        ("pitch-initiation", Event::PitchInitiation),
        ("max-pitch-rate", Event::MaxPitchRate),
        ("ftc-on", Event::FtcOn),
        ("max-q", Event::MaxQ),
        ("burn-out", Event::BurnOut),
    ];
}

/// An operating condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Name.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Changed quantities, in order.
    pub changes: Vec<Change>,
    /// Loop gains in force.
    pub gains: GainSource,
    /// Rate gyro moved to this station, m from the nozzle exit.
    pub gyro_station_m: Option<f64>,
    /// Only at points where the fin tips work.
    pub needs_ftc: bool,
    /// Runs the pitch loop.
    pub pitch: bool,
    /// Runs the yaw and roll loops.
    pub yaw_roll: bool,
    /// Adds a pitch run without disturbances.
    pub overshoot: bool,
    /// Adds a yaw–roll run with the tips dedicated to roll.
    pub dedicated: bool,
    /// Points it is limited to, by name; all if none is given.
    pub points: Option<Vec<String>>,
}

/// A changed quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Which.
    pub quantity: &'static Quantity,
    /// How.
    pub how: How,
}

/// How a quantity is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    /// Multiplied.
    Times(f64),
    /// Replaced; SI value.
    Set(f64),
}

/// Which loop gains are in force at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GainSource {
    /// Those of the designed schedule.
    Scheduled,
    /// Those of the interval before: the last switching did not happen.
    PreviousInterval,
    /// Those of the interval to come: the next switching came early.
    NextInterval,
    /// Those of the reduced schedule.
    Reduced,
    /// The sequencer stopped at this time, s.
    StuckAt(f64),
}

impl GainSource {
    const NAMED: [(&'static str, GainSource); 4] = [
        ("scheduled", GainSource::Scheduled),
        ("previous-interval", GainSource::PreviousInterval),
        ("next-interval", GainSource::NextInterval),
        ("reduced", GainSource::Reduced),
    ];
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawStudy {
    run: RawRun,
    pitch: Spanned<PitchTest>,
    yaw_roll: Spanned<YawRollTest>,
    #[serde(default)]
    point: Vec<RawPoint>,
    #[serde(default)]
    condition: Vec<RawCondition>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawRun {
    duration_s: Spanned<f64>,
    sample_ms: Spanned<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawPoint {
    name: Spanned<String>,
    #[serde(default)]
    title: String,
    at: Spanned<RawPlace>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawPlace {
    time_s: Option<f64>,
    event: Option<Spanned<String>>,
    mach: Option<f64>,
    gain_switch: Option<usize>,
    #[serde(default)]
    offset_s: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawCondition {
    name: Spanned<String>,
    #[serde(default)]
    title: String,
    #[serde(default)]
    change: Vec<RawChange>,
    gains: Option<Spanned<String>>,
    gains_stuck_at_s: Option<Spanned<f64>>,
    gyro_station_m: Option<Spanned<f64>>,
    #[serde(rename = "where")]
    limited_to: Option<Spanned<String>>,
    loops: Option<Vec<Spanned<String>>>,
    points: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    overshoot: bool,
    #[serde(default)]
    dedicated: bool,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawChange {
    quantity: Spanned<String>,
    times: Option<Spanned<f64>>,
    set: Option<Spanned<f64>>,
}

impl Study {
    /// The shipped study.
    pub fn shipped() -> Result<Study, StudyError> {
        Study::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
    }

    /// Reads a user's file.
    pub fn load(path: &Path) -> Result<Study, StudyError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| StudyError::Unreadable {
            file: file.clone(),
            reason: error.to_string(),
        })?;
        Study::from_toml(&file, &text)
    }

    /// Reads a text; `file` is only named in faults.
    pub fn from_toml(file: &str, text: &str) -> Result<Study, StudyError> {
        let source = Source { file, text };
        let raw: RawStudy = toml::from_str(text)
            .map_err(|error| StudyError::Faults(vec![source.reader_fault(&error)]))?;
        let mut check = Check {
            source,
            faults: Vec::new(),
        };
        let study = check.study(raw);
        if check.faults.is_empty() {
            Ok(study)
        } else {
            check.faults.sort_by_key(|f| f.place);
            Err(StudyError::Faults(check.faults))
        }
    }
}

struct Check<'a> {
    source: Source<'a>,
    faults: Vec<FileFault>,
}

impl Check<'_> {
    fn fault<T>(&mut self, at: &Spanned<T>, fault: impl Into<String>, remedy: impl Into<String>) {
        let fault = self.source.fault(at.span(), fault.into(), remedy.into());
        self.faults.push(fault);
    }

    fn study(&mut self, raw: RawStudy) -> Study {
        let duration = *raw.run.duration_s.get_ref();
        if !(duration > 0.0 && duration <= LONGEST_S) {
            self.fault(
                &raw.run.duration_s,
                format!("a run of {duration} s"),
                format!("give a duration above 0 and up to {LONGEST_S} s"),
            );
        }
        let sample_ms = *raw.run.sample_ms.get_ref();
        if !SAMPLE_MS.contains(&sample_ms) {
            self.fault(
                &raw.run.sample_ms,
                format!("a sampling interval of {sample_ms} ms"),
                format!("give {} to {} ms", SAMPLE_MS.start(), SAMPLE_MS.end()),
            );
        }
        let pitch = *raw.pitch.get_ref();
        self.finite(
            &raw.pitch,
            &[pitch.step_deg, pitch.misalignment, pitch.gust],
        );
        if pitch.step_deg == 0.0 {
            self.fault(
                &raw.pitch,
                "a step command of 0 deg",
                "give a step, measures are fractions of it",
            );
        }
        let yaw = *raw.yaw_roll.get_ref();
        self.finite(
            &raw.yaw_roll,
            &[
                yaw.yaw_deg,
                yaw.yaw_rate_dps,
                yaw.roll_deg,
                yaw.roll_rate_dps,
                yaw.misalignment,
                yaw.gust,
                yaw.cant,
            ],
        );
        self.unique(raw.point.iter().map(|p| &p.name), "point");
        self.unique(raw.condition.iter().map(|c| &c.name), "condition");
        let names: Vec<String> = raw.point.iter().map(|p| p.name.get_ref().clone()).collect();
        Study {
            file: self.source.file.to_owned(),
            text: self.source.text.to_owned(),
            duration_s: duration,
            sample_ms,
            pitch,
            yaw_roll: yaw,
            points: raw.point.into_iter().map(|p| self.point(p)).collect(),
            conditions: raw
                .condition
                .into_iter()
                .map(|c| self.condition(c, &names))
                .collect(),
        }
    }

    fn finite<T>(&mut self, at: &Spanned<T>, values: &[f64]) {
        if values.iter().any(|v| !v.is_finite()) {
            self.fault(at, "a value is not finite", "give finite numbers");
        }
    }

    fn unique<'n>(&mut self, names: impl Iterator<Item = &'n Spanned<String>>, what: &str) {
        let mut seen = std::collections::BTreeSet::new();
        for name in names {
            if !seen.insert(name.get_ref()) {
                self.fault(
                    name,
                    format!("a second {what} named `{}`", name.get_ref()),
                    "rename one of them",
                );
            }
        }
    }

    fn point(&mut self, raw: RawPoint) -> PointEntry {
        let place = raw.at.get_ref();
        let mut found = Vec::new();
        let mut misnamed = false;
        if let Some(time) = place.time_s {
            found.push(Place::Time(time));
        }
        if let Some(mach) = place.mach {
            found.push(Place::Mach(mach));
        }
        if let Some(number) = place.gain_switch {
            found.push(Place::GainSwitch(number));
        }
        if let Some(event) = &place.event {
            match Event::ALL.iter().find(|(name, _)| name == event.get_ref()) {
                Some((_, event)) => found.push(Place::Event(*event)),
                None => {
                    misnamed = true;
                    let near = suggestion(event.get_ref(), Event::ALL.iter().map(|e| e.0));
                    self.fault(event, format!("no event `{}`", event.get_ref()), near);
                }
            }
        }
        let at = match found.as_slice() {
            [one] => *one,
            _ => {
                if !misnamed {
                    self.fault(
                        &raw.at,
                        format!("{} places for one point", found.len()),
                        "give exactly one of time-s, event, mach, gain-switch",
                    );
                }
                Place::Time(0.0)
            }
        };
        let numbers = match at {
            Place::Time(value) | Place::Mach(value) => [value, place.offset_s],
            _ => [0.0, place.offset_s],
        };
        self.finite(&raw.at, &numbers);
        if numbers[0] < 0.0 {
            self.fault(
                &raw.at,
                "a point before lift-off",
                "give a value of 0 or more",
            );
        }
        PointEntry {
            name: raw.name.get_ref().clone(),
            title: raw.title,
            at,
            offset_s: place.offset_s,
            span: raw.at.span(),
        }
    }

    fn condition(&mut self, raw: RawCondition, points: &[String]) -> Condition {
        let mut gains = GainSource::Scheduled;
        if let Some(name) = &raw.gains {
            match GainSource::NAMED.iter().find(|(n, _)| n == name.get_ref()) {
                Some((_, source)) => gains = *source,
                None => {
                    let near = suggestion(name.get_ref(), GainSource::NAMED.iter().map(|g| g.0));
                    self.fault(name, format!("no gains `{}`", name.get_ref()), near);
                }
            }
        }
        if let Some(stuck) = &raw.gains_stuck_at_s {
            self.finite(stuck, &[*stuck.get_ref()]);
            if raw.gains.is_some() {
                self.fault(
                    stuck,
                    "gains named and stuck at once",
                    "keep one of `gains` and `gains-stuck-at-s`",
                );
            }
            gains = GainSource::StuckAt(*stuck.get_ref());
        }
        if let Some(station) = &raw.gyro_station_m {
            self.finite(station, &[*station.get_ref()]);
        }
        let mut needs_ftc = false;
        if let Some(limited) = &raw.limited_to {
            needs_ftc = true;
            if limited.get_ref() != "ftc-on" {
                self.fault(
                    limited,
                    format!("no limitation `{}`", limited.get_ref()),
                    "the one limitation is `ftc-on`",
                );
            }
        }
        let mut loops = (true, true);
        if let Some(list) = &raw.loops {
            const LOOPS: [&str; 2] = ["pitch", "yaw-roll"];
            loops = (false, false);
            for name in list {
                match name.get_ref().as_str() {
                    "pitch" => loops.0 = true,
                    "yaw-roll" => loops.1 = true,
                    other => {
                        let near = suggestion(other, LOOPS.into_iter());
                        self.fault(name, format!("no loop `{other}`"), near);
                    }
                }
            }
        }
        for name in raw.points.iter().flatten() {
            if !points.contains(name.get_ref()) {
                let near = suggestion(name.get_ref(), points.iter().map(String::as_str));
                self.fault(name, format!("no point `{}`", name.get_ref()), near);
            }
        }
        Condition {
            name: raw.name.get_ref().clone(),
            title: raw.title,
            changes: raw
                .change
                .iter()
                .filter_map(|change| self.change(change))
                .collect(),
            gains,
            gyro_station_m: raw.gyro_station_m.map(Spanned::into_inner),
            needs_ftc,
            pitch: loops.0,
            yaw_roll: loops.1,
            overshoot: raw.overshoot,
            dedicated: raw.dedicated,
            points: raw
                .points
                .map(|list| list.into_iter().map(Spanned::into_inner).collect()),
        }
    }

    fn change(&mut self, raw: &RawChange) -> Option<Change> {
        let name = raw.quantity.get_ref();
        let Some(quantity) = Quantity::find(name) else {
            let near = suggestion(name, QUANTITIES.iter().map(|q| q.name));
            self.fault(&raw.quantity, format!("no quantity `{name}`"), near);
            return None;
        };
        let (how, number) = match (&raw.times, &raw.set) {
            (Some(factor), None) => (How::Times(*factor.get_ref()), factor),
            (None, Some(value)) => (How::Set(*value.get_ref() * quantity.unit_in_si), value),
            _ => {
                self.fault(
                    &raw.quantity,
                    format!("`{name}` is to be changed in no way or in two"),
                    "give either `times` or `set`",
                );
                return None;
            }
        };
        if !quantity.range.contains(*number.get_ref()) {
            self.fault(
                number,
                format!("`{name}` cannot be {} by {}", verb(how), number.get_ref()),
                match quantity.range {
                    Range::Any => "give a finite number",
                    Range::NotNegative => "give a number of 0 or more, it is a limit",
                    Range::Positive => "give a number above 0, the model divides by it",
                },
            );
        }
        Some(Change { quantity, how })
    }
}

fn verb(how: How) -> &'static str {
    match how {
        How::Times(_) => "multiplied",
        How::Set(_) => "replaced",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(change: impl Fn(&str) -> String) -> Vec<FileFault> {
        match Study::from_toml("user.toml", &change(SHIPPED_TEXT)) {
            Err(StudyError::Faults(faults)) => faults,
            other => panic!("{other:?}"),
        }
    }

    /// Line (from 1) of the first occurrence of a text.
    fn line_of(text: &str, part: &str) -> usize {
        text[..text.find(part).unwrap()].matches('\n').count() + 1
    }

    #[test]
    fn the_shipped_study_has_every_point_and_condition_of_the_paper() {
        let study = Study::shipped().unwrap();
        assert_eq!(study.points.len(), 13);
        let names: Vec<_> = study.conditions.iter().map(|c| c.name.as_str()).collect();
        for name in [
            "normal",
            "gyro-aft",
            "tvc-slow",
            "tvc-fast",
            "ftc-gain-lost",
            "gains-not-switched",
        ] {
            assert!(names.contains(&name), "{name}");
        }
    }

    #[test]
    fn misspelt_names_get_their_line_and_the_nearest_known_one() {
        for (right, wrong, near) in [
            (
                "\"tip-force-slope\"",
                "\"tip-force-slop\"",
                "tip-force-slope",
            ),
            ("event = \"max-q\"", "event = \"max-Q\"", "max-q"),
            ("gains = \"reduced\"", "gains = \"reducd\"", "reduced"),
            ("gyro-station-m", "gyro-staton-m", "gyro-station-m"),
            ("duration-s", "duraton-s", "duration-s"),
            ("where = \"ftc-on\"", "where = \"ftc\"", "ftc-on"),
        ] {
            let line = line_of(SHIPPED_TEXT, right);
            let found = faults(|text| text.replacen(right, wrong, 1));
            assert_eq!(found.len(), 1, "{wrong}: {found:?}");
            assert_eq!(found[0].place.unwrap().0, line, "{wrong}");
            assert!(found[0].remedy.contains(near), "{}", found[0]);
        }
    }

    #[test]
    fn all_faults_are_reported_together() {
        let found = faults(|text| {
            text.replace("sample-ms = 20", "sample-ms = 0")
                .replace("step-deg = 2.0", "step-deg = 0.0")
                .replace("set = 1.0 }", "set = 0.0 }")
                .replace("at = { mach = 1.05 }", "at = { mach = 1.05, time-s = 3.0 }")
                .replacen("times = 0.05", "times = nan", 1)
                + "[[point]]\nname = \"max-q\"\nat = { time-s = -1.0 }\n"
        });
        let said: Vec<_> = found.iter().map(|f| f.fault.as_str()).collect();
        assert_eq!(said.len(), 7, "{said:#?}");
        assert!(found.windows(2).all(|f| f[0].place <= f[1].place));
    }

    #[test]
    fn a_change_is_one_thing() {
        let both = faults(|text| text.replacen("times = 2.0", "times = 2.0, set = 1.0", 1));
        assert!(both[0].remedy.contains("either"), "{}", both[0]);
        let neither = faults(|text| text.replacen(", times = 2.0", "", 1));
        assert_eq!(neither.len(), 1);
    }
}
