//! From the text of a study to a checked one: every fault that can be told apart.

use serde::Deserialize;
use toml::Spanned;

use super::places::{Event, Place, PointEntry};
use super::quantity::{QUANTITIES, Quantity, Range};
use super::study_file::{Change, Condition, GainSource, How, PitchTest, Study, YawRollTest};
use desk::faults::{FileFault, FileFaults, Source, suggestion};

/// Longest run offered, s.
const LONGEST_S: f64 = 600.0;
/// Shortest and longest sampling interval, ms.
const SAMPLE_MS: std::ops::RangeInclusive<u32> = 1..=100;

/// Reads a text; `file` is only named in faults.
pub(super) fn study(file: &str, text: &str) -> Result<Study, FileFaults> {
    let source = Source { file, text };
    let raw: RawStudy = source.parse()?;
    let mut check = Check { source, faults: Vec::new() };
    let study = check.study(raw);
    FileFaults::unless(check.faults, study)
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
        self.finite(&raw.pitch, &[pitch.step_deg, pitch.misalignment, pitch.gust]);
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
            conditions: raw.condition.into_iter().map(|c| self.condition(c, &names)).collect(),
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
            self.fault(&raw.at, "a point before lift-off", "give a value of 0 or more");
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
            changes: raw.change.iter().filter_map(|change| self.change(change)).collect(),
            gains,
            gyro_station_m: raw.gyro_station_m,
            needs_ftc,
            pitch: loops.0,
            yaw_roll: loops.1,
            overshoot: raw.overshoot,
            dedicated: raw.dedicated,
            points: raw.points.map(|list| list.into_iter().map(Spanned::into_inner).collect()),
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
