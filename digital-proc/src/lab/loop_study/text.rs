//! A loop study's text: everything in it that can be judged without the patch.

use super::{LoopCase, LoopStudy, law_text::law};
use desk::{
    faults::{FileFaults, Source},
    reader::{self, ABOVE_ZERO, FileKind, Range::Any, SheetFields},
};
use interface::Tick;
use std::{collections::BTreeMap, path::Path};

/// Reads a user's study.
pub fn load(path: &Path) -> Result<LoopStudy, FileFaults> {
    reader::load(path, parse)
}

/// Reads a text; `file` is only named in faults.
pub fn parse(file: &str, text: &str) -> Result<LoopStudy, FileFaults> {
    reader::read(FileKind::LoopStudy, Source { file, text }, |f| {
        let title = f.text_or_none("title");
        let (patch, measure) = (f.named("patch"), f.named("measure"));
        let stop = f.duration("stop", None, ABOVE_ZERO);
        let window = stop.and_then(|stop| window(f, stop));
        let params: Option<BTreeMap<_, _>> =
            f.by_name("params", |f, key, value| f.number_at(key, value, Any));
        let cases = f.table("sweep", cases);
        let laws = f.tables("law", law);
        let some = laws.as_ref().is_none_or(|laws| !laws.is_empty());
        f.require(some, "law", "the study has no law", "write at least one [[law]]");
        let mut driven = Vec::new();
        for output in laws.iter().flatten().flat_map(|law| &law.outputs) {
            if driven.contains(&&output.name) {
                let fault = format!("`{}` is driven twice", output.name);
                f.fault(output.span, fault, "let one law set each DAC");
            }
            driven.push(&output.name);
        }
        let (from, until) = window?;
        Some(LoopStudy {
            title: title.unwrap_or_else(|| file.to_owned()),
            patch: patch?,
            params: params?.into_iter().collect(),
            stop: stop?,
            from,
            until,
            cases: cases?,
            measure: measure?,
            laws: laws?,
            file: file.to_owned(),
            text: text.to_owned(),
        })
    })
}

/// Start and end of the record that is judged; all of the run where they are not stated.
fn window(f: &mut SheetFields<'_, '_>, stop: Tick) -> Option<(Tick, Tick)> {
    let from = f.duration("from", Some(Tick::ZERO), ABOVE_ZERO);
    let until = f.duration("until", Some(stop), ABOVE_ZERO);
    let (from, until) = (from?, until?);
    let fault = format!("a record from {from} until {until} of a run to {stop}");
    let key = if f.place("from").is_some() { "from" } else { "until" };
    f.require(from < until && until <= stop, key, fault, "give from < until <= stop");
    Some((from, until))
}

fn cases(f: &mut SheetFields<'_, '_>) -> Option<Vec<LoopCase>> {
    let frames = f.each("frame", "[\"20ms\"]", |f, key, item| f.duration_of(key, item, ABOVE_ZERO));
    let latencies = f.maybe("latency", |f| {
        f.each("latency", "", |f, key, item| {
            f.ranged_at(key, item, "0 to 1, in frames", |l| (0.0..=1.0).contains(&l))
        })
    });
    let bits = f.maybe("bits", |f| {
        f.each("bits", "", |f, key, item| {
            let fits = |n: f64| n.fract() == 0.0 && (n == 0.0 || (2.0..=32.0).contains(&n));
            let bits = f.ranged_at(key, item, "2 to 32, or 0 for ideal converters", fits)?;
            Some((bits > 0.0).then_some(bits as u32))
        })
    });
    let has = |empty: Option<bool>| empty != Some(true);
    for (key, some) in [
        ("frame", has(frames.as_ref().map(Vec::is_empty))),
        ("latency", has(latencies.as_ref().map(Vec::is_empty))),
        ("bits", has(bits.as_ref().map(Vec::is_empty))),
    ] {
        let fault = format!("the sweep has no {key}");
        f.require(some, key, fault, "list at least one, or leave out `latency` and `bits`");
    }
    let (latencies, bits) = (latencies.unwrap_or(vec![0.0]), bits.unwrap_or(vec![None]));
    let mut all = Vec::new();
    for frame in frames? {
        for l in &latencies {
            // At most one frame, so that the product fits wherever the frame does.
            let latency = Tick((frame.0 as f64 * l).round() as i64);
            all.extend(bits.iter().map(|bits| LoopCase { frame, latency, bits: *bits }));
        }
    }
    Some(all)
}
