//! A loop study's text: everything in it that can be judged without the patch.

use super::{
    LoopCase, LoopStudy,
    law_text::{self, RawLaw},
    named,
};
use desk::faults::{self, FileFault, FileFaults, Source};
use interface::Tick;
use serde::Deserialize;
use std::{collections::BTreeMap, ops::Range, path::Path};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Raw {
    title: Option<String>,
    patch: Spanned<String>,
    stop: Spanned<String>,
    from: Option<Spanned<String>>,
    until: Option<Spanned<String>>,
    measure: Spanned<String>,
    #[serde(default)]
    params: BTreeMap<String, Spanned<f64>>,
    sweep: RawSweep,
    law: Vec<Spanned<RawLaw>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawSweep {
    frame: Spanned<Vec<Spanned<String>>>,
    latency: Option<Vec<Spanned<f64>>>,
    bits: Option<Vec<Spanned<u32>>>,
}

/// The faults found so far.
pub(super) struct Faults<'a> {
    source: Source<'a>,
    list: Vec<FileFault>,
}

impl Faults<'_> {
    pub(super) fn add(
        &mut self,
        span: Range<usize>,
        fault: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        self.list.push(self.source.fault(span, fault, remedy));
    }

    pub(super) fn count(&self) -> usize {
        self.list.len()
    }

    fn duration(&mut self, value: &Spanned<String>) -> Option<Tick> {
        match value.get_ref().parse::<Tick>() {
            Ok(t) if t > Tick::ZERO => Some(t),
            Ok(t) => {
                self.add(value.span(), format!("a duration of {t}"), "it must be above 0");
                None
            }
            Err(e) => {
                let remedy = "write a number with its unit: s, ms, us or ns, as \"20ms\"";
                self.add(value.span(), e.to_string(), remedy);
                None
            }
        }
    }
}

/// Reads a user's study.
///
/// # Errors
/// Every fault that can be seen without the patch.
pub fn load(path: &Path) -> Result<LoopStudy, FileFaults> {
    faults::load(path, parse)
}

/// Reads a text; `file` is only named in faults.
///
/// # Errors
/// Every fault that can be seen without the patch.
pub fn parse(file: &str, text: &str) -> Result<LoopStudy, FileFaults> {
    let source = Source { file, text };
    let raw: Raw = source.parse()?;
    let mut faults = Faults { source, list: Vec::new() };
    let stop = faults.duration(&raw.stop).unwrap_or(Tick::ZERO);
    let (from, until) = window(&raw, stop, &mut faults);
    let cases = cases(&raw.sweep, &mut faults);
    if raw.law.is_empty() {
        faults.add(raw.measure.span(), "the study has no law", "write at least one [[law]]");
    }
    let mut laws = Vec::new();
    for law in &raw.law {
        if let Some(spec) = law_text::law(law, &mut faults) {
            laws.push(spec);
        }
    }
    let mut driven = Vec::new();
    for output in laws.iter().flat_map(|law| &law.outputs) {
        if driven.contains(&&output.name) {
            let fault = format!("`{}` is driven twice", output.name);
            faults.add(output.span.clone(), fault, "let one law set each DAC");
        }
        driven.push(&output.name);
    }
    for (name, value) in &raw.params {
        if !value.get_ref().is_finite() {
            faults.add(
                value.span(),
                format!("param `{name}` is {}", value.get_ref()),
                "give a finite number",
            );
        }
    }
    FileFaults::unless(
        faults.list,
        LoopStudy {
            title: raw.title.unwrap_or_else(|| file.to_owned()),
            patch: named(&raw.patch),
            params: raw
                .params
                .into_iter()
                .map(|(name, value)| (name, value.into_inner()))
                .collect(),
            stop,
            from,
            until,
            cases,
            measure: named(&raw.measure),
            laws,
            file: file.to_owned(),
            text: text.to_owned(),
        },
    )
}

/// Start and end of the record that is judged; all of the run where they are not stated.
fn window(raw: &Raw, stop: Tick, faults: &mut Faults<'_>) -> (Tick, Tick) {
    let mut stated = |at: &Option<Spanned<String>>, default: Tick| {
        at.as_ref().and_then(|text| faults.duration(text)).unwrap_or(default)
    };
    let (from, until) = (stated(&raw.from, Tick::ZERO), stated(&raw.until, stop));
    let place = raw.from.as_ref().or(raw.until.as_ref());
    if let Some(place) = place
        && stop > Tick::ZERO
        && !(from < until && until <= stop)
    {
        let fault = format!("a record from {from} until {until} of a run to {stop}");
        faults.add(place.span(), fault, "give from < until <= stop");
    }
    (from, until)
}

fn cases(sweep: &RawSweep, faults: &mut Faults<'_>) -> Vec<LoopCase> {
    let mut all = Vec::new();
    if sweep.frame.get_ref().is_empty() {
        faults.add(sweep.frame.span(), "the sweep has no frame", "list at least one, as \"20ms\"");
    }
    if sweep.latency.as_ref().is_some_and(Vec::is_empty)
        || sweep.bits.as_ref().is_some_and(Vec::is_empty)
    {
        faults.add(
            sweep.frame.span(),
            "the sweep has an empty list",
            "leave out `latency` or `bits`, or list at least one",
        );
    }
    let latencies: Vec<f64> = sweep.latency.as_ref().map_or(vec![0.0], |list| {
        list.iter()
            .filter_map(|l| {
                let ok = (0.0..=1.0).contains(l.get_ref());
                if !ok {
                    let message = format!("a latency of {} frames", l.get_ref());
                    faults.add(l.span(), message, "latencies are 0 to 1, in frames");
                }
                ok.then_some(*l.get_ref())
            })
            .collect()
    });
    let bits: Vec<Option<u32>> = sweep.bits.as_ref().map_or(vec![None], |list| {
        list.iter()
            .filter_map(|b| {
                let n = *b.get_ref();
                if n == 0 {
                    return Some(None);
                }
                if !(2..=32).contains(&n) {
                    faults.add(
                        b.span(),
                        format!("a converter of {n} bits"),
                        "2 to 32, or 0 for ideal",
                    );
                    return None;
                }
                Some(Some(n))
            })
            .collect()
    });
    for text in sweep.frame.get_ref() {
        let Some(frame) = faults.duration(text) else {
            continue;
        };
        for l in &latencies {
            for b in &bits {
                all.push(LoopCase {
                    frame,
                    // At most one frame, so that the product fits wherever the frame does.
                    latency: Tick((frame.0 as f64 * l).round() as i64),
                    bits: *b,
                });
            }
        }
    }
    all
}
