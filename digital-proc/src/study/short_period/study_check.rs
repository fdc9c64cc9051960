//! From the text of a study to a checked one: every fault that can be told apart.

use super::point::Quantity;
use super::study_file::{
    Change, Condition, Event, GainSource, How, PitchTest, Place, PointEntry, SHIPPED_NAME,
    SHIPPED_TEXT, Study, YawRollTest,
};
use desk::faults::{FileFaults, Source};
use desk::reader::{self, FileKind, Range::Any, SheetFields};
use std::path::Path;

/// Longest run offered, s.
const LONGEST_S: f64 = 600.0;

impl Study {
    /// The shipped study.
    pub fn shipped() -> Result<Study, FileFaults> {
        Study::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
    }

    /// Reads a user's file.
    pub fn load(path: &Path) -> Result<Study, FileFaults> {
        reader::load(path, Study::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    pub fn from_toml(file: &str, text: &str) -> Result<Study, FileFaults> {
        study(file, text)
    }
}

/// Reads a text; `file` is only named in faults.
fn study(file: &str, text: &str) -> Result<Study, FileFaults> {
    reader::read(FileKind::Study, Source { file, text }, |f| {
        let run = f.table("run", |f| {
            let range = "above 0 and up to 600 s";
            let duration_s = f.ranged("duration-s", None, range, |s| s > 0.0 && s <= LONGEST_S);
            let sample_ms = f.whole_in("sample-ms", None, 1..=100);
            Some((duration_s?, sample_ms?))
        });
        let pitch = f.table("pitch", PitchTest::read);
        let yaw_roll = f.table("yaw-roll", YawRollTest::read);
        let names = f.names_of("point");
        let known: Vec<(&str, ())> = names.iter().map(|n| (n.name.as_str(), ())).collect();
        let points = f.tables("point", point);
        let conditions = f.tables("condition", |f| condition(f, &known));
        let (duration_s, sample_ms) = run?;
        Some(Study {
            file: file.to_owned(),
            text: text.to_owned(),
            duration_s,
            sample_ms,
            pitch: pitch?,
            yaw_roll: yaw_roll?,
            points: points?,
            conditions: conditions?,
            left_out: Vec::new(),
        })
    })
}

fn point(f: &mut SheetFields<'_, '_>) -> Option<PointEntry> {
    let (name, title) = (f.text("name"), f.text_or_none("title"));
    let span = f.place("at");
    let place = f.table("at", |f| {
        let not_before = |f: &mut SheetFields<'_, '_>, key| {
            f.maybe(key, |f| f.ranged(key, None, "0 or greater", |v| v >= 0.0))
        };
        let places = [
            not_before(f, "time-s").map(Place::Time),
            f.maybe("event", |f| f.word("event", None, &Event::ALL)).map(Place::Event),
            not_before(f, "mach").map(Place::Mach),
            f.maybe("gain-switch", |f| f.whole("gain-switch", None))
                .map(|n| Place::GainSwitch(n as usize)),
        ];
        let keys = ["time-s", "event", "mach", "gain-switch"];
        let stated = keys.iter().filter(|key| f.place(key).is_some()).count();
        let remedy = "give exactly one of time-s, event, mach, gain-switch";
        f.require(stated == 1, "", format!("{stated} places for one point"), remedy);
        let offset_s = f.number("offset-s", Some(0.0));
        Some((places.into_iter().flatten().next()?, offset_s?))
    });
    let (at, offset_s) = place?;
    Some(PointEntry { name: name?, title: title.unwrap_or_default(), at, offset_s, span: span? })
}

fn condition(f: &mut SheetFields<'_, '_>, points: &[(&str, ())]) -> Option<Condition> {
    let (name, title) = (f.text("name"), f.text_or_none("title"));
    let changes = f.tables("change", change);
    let stuck = f
        .maybe("gains-stuck-at-s", |f| f.number("gains-stuck-at-s", None))
        .map(GainSource::StuckAt);
    let gains = f.word("gains", Some(stuck.unwrap_or(GainSource::Scheduled)), &GainSource::NAMED);
    let both = stuck.is_some() && f.place("gains").is_some();
    let remedy = "keep one of `gains` and `gains-stuck-at-s`";
    f.require(!both, "gains-stuck-at-s", "gains named and stuck at once", remedy);
    let gyro = f.maybe("gyro-station-m", |f| f.number("gyro-station-m", None));
    let gyro = gyro.zip(f.place("gyro-station-m"));
    let needs_ftc = f.word("where", Some(false), &[("ftc-on", true)]);
    let loops = f.maybe("loops", |f| {
        let loops = [("pitch", [true, false]), ("yaw-roll", [false, true])];
        f.each("loops", "", |f, key, name| f.word_of(key, name, &loops))
    });
    let runs = |which: usize| loops.as_ref().is_none_or(|loops| loops.iter().any(|l| l[which]));
    let (pitch, yaw_roll) = (runs(0), runs(1));
    let limited = f.maybe("points", |f| {
        f.each("points", "", |f, key, name| {
            f.word_of(key, name, points)?;
            name.text().map(str::to_owned)
        })
    });
    let (overshoot, dedicated) = (f.flag("overshoot", false), f.flag("dedicated", false));
    let offsets = f.flag("offsets", false);
    Some(Condition {
        name: name?,
        title: title.unwrap_or_default(),
        changes: changes?,
        gains: gains?,
        gyro,
        needs_ftc: needs_ftc?,
        pitch,
        yaw_roll,
        overshoot: overshoot?,
        dedicated: dedicated?,
        offsets: offsets?,
        points: limited,
    })
}

fn change(f: &mut SheetFields<'_, '_>) -> Option<Change> {
    let quantity = f.word("quantity", None, &Quantity::by_name());
    let range = quantity.map_or(Any, |q| q.range);
    let times = f.maybe("times", |f| f.number_in("times", range));
    let set = f.maybe("set", |f| f.number_in("set", range));
    let one = f.place("times").is_some() != f.place("set").is_some();
    let remedy = "give either `times` or `set`";
    f.require(one, "quantity", "a quantity changed in no way or in two", remedy);
    let quantity = quantity?;
    let how = times.map(How::Times).or(set.map(|value| How::Set(value * quantity.unit_in_si)));
    Some(Change { quantity, how: how? })
}
