//! Reading a profile from TOML, with every fault of the file in one go.
//!
//! A number is written `{ value = 14, status = "memory", source = "…" }`; times
//! are texts with a unit (`"10us"`), so that they are exact ticks. Unknown keys
//! are faults: a misspelt stage would otherwise be a stage switched off.

use super::{AdcStage, BlockClass, DacStage, DcuStage, Profile, Provenance, Sourced};
use crate::{Tick, converter::MAX_BITS, hold::HoldKind};
use std::{collections::BTreeMap, fmt, ops::Range};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// One fault of a profile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProfileFault {
    /// Line, from 1; 0 when the file as a whole is at fault.
    pub line: usize,
    /// Bytes of the text at fault.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub remedy: String,
}

/// A profile that cannot be used, with all its faults.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct ProfileError {
    /// The file (or built-in) as it was named.
    pub file: String,
    /// Its faults in order of lines.
    pub faults: Vec<ProfileFault>,
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.faults.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            match fault.line {
                0 => write!(f, "{}", self.file)?,
                line => write!(f, "{}:{line}", self.file)?,
            }
            write!(f, ": {}; {}", fault.message, fault.remedy)?;
        }
        Ok(())
    }
}

impl ProfileError {
    pub(super) fn unreadable(file: &str, error: &std::io::Error) -> ProfileError {
        ProfileError {
            file: file.to_owned(),
            faults: vec![ProfileFault {
                line: 0,
                span: 0..0,
                message: format!("the profile cannot be read ({error})"),
                remedy: format!(
                    "name a file, or one of the built-in profiles {}",
                    Profile::BUILT_IN.join(", ")
                ),
            }],
        }
    }
}

impl Profile {
    /// Reads a profile; `file` names the text in faults.
    ///
    /// # Errors
    /// [`ProfileError`] with every fault found.
    pub fn parse(text: &str, file: &str) -> Result<Profile, ProfileError> {
        let mut reader = Reader { text, faults: Vec::new() };
        let (root, errors) = DeTable::parse_recoverable(text);
        for error in errors {
            let span = error.span().unwrap_or(0..0);
            reader.fault(span, error.message().trim().replace('\n', ", "), "correct the TOML");
        }
        let profile =
            if reader.faults.is_empty() { reader.profile(&root) } else { Profile::ideal() };
        if reader.faults.is_empty() {
            return Ok(profile);
        }
        reader.faults.sort_by_key(|fault| fault.span.start);
        Err(ProfileError { file: file.to_owned(), faults: reader.faults })
    }
}

type Value<'i> = Spanned<DeValue<'i>>;

struct Reader<'t> {
    text: &'t str,
    faults: Vec<ProfileFault>,
}

impl Reader<'_> {
    fn fault(&mut self, span: Range<usize>, message: impl Into<String>, remedy: impl Into<String>) {
        let before = self.text.as_bytes().get(..span.start).unwrap_or_default();
        self.faults.push(ProfileFault {
            line: 1 + before.iter().filter(|b| **b == b'\n').count(),
            span,
            message: message.into(),
            remedy: remedy.into(),
        });
    }

    /// Reports keys that mean nothing.
    fn known(&mut self, table: &DeTable<'_>, keys: &[&str]) {
        for key in table.keys() {
            let name: &str = key.get_ref();
            if !keys.contains(&name) {
                let message = format!("`{name}` means nothing here");
                self.fault(key.span(), message, format!("use {}", keys.join(", ")));
            }
        }
    }

    fn profile(&mut self, root: &Spanned<DeTable<'_>>) -> Profile {
        let table = root.get_ref();
        self.known(table, &["name", "note", "machine", "counts", "adc", "dac", "dcu", "timing"]);
        let mut profile = Profile::ideal();
        profile.name = match table.get("name") {
            Some(value) => self.string(value),
            None => {
                self.fault(0..0, "the profile has no name", "add `name = \"…\"`");
                String::new()
            }
        };
        profile.note = table.get("note").map_or(String::new(), |v| self.string(v));
        self.section(table, "machine", |reader, t| {
            reader.known(t, &["reference-v", "overload-level", "component-error"]);
            let positive = |v: f64| v > 0.0;
            profile.reference_v = reader.number(t, "reference-v", positive, "above 0 V");
            profile.overload_level =
                reader.number(t, "overload-level", |v| v >= 1.0, "at least 1 machine unit");
            profile.component_error = reader.number(
                t,
                "component-error",
                |v| (0.0..1.0).contains(&v),
                "a fraction from 0 to below 1",
            );
        });
        self.section(table, "counts", |reader, t| {
            profile.counts = reader.counts(t);
        });
        self.section(table, "adc", |reader, t| {
            reader.known(t, &["bits", "conversion", "skew", "aperture"]);
            profile.adc = AdcStage {
                bits: reader.bits(t),
                conversion: reader.duration(t, "conversion"),
                skew: reader.duration(t, "skew"),
                aperture: reader.duration(t, "aperture"),
            };
        });
        self.section(table, "dac", |reader, t| {
            reader.known(t, &["bits", "settling", "hold"]);
            profile.dac = DacStage {
                bits: reader.bits(t),
                settling: reader.duration(t, "settling"),
                hold: reader.hold(t),
            };
        });
        self.section(table, "dcu", |reader, t| {
            reader.known(t, &["bits", "range"]);
            profile.dcu = DcuStage {
                bits: reader.bits(t),
                range: reader.number(t, "range", |v| v > 0.0, "above 0"),
            };
            if profile.dcu.bits.is_some() && profile.dcu.range.is_none() {
                let span = t.get("bits").map_or(0..0, Spanned::span);
                reader.fault(span, "bits need a range", "add `range`");
            }
        });
        self.section(table, "timing", |reader, t| {
            reader.known(t, &["latency", "compute"]);
            profile.latency = reader.duration(t, "latency");
            profile.compute = reader.duration(t, "compute");
        });
        profile
    }

    fn section(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        read: impl FnOnce(&mut Self, &DeTable<'_>),
    ) {
        if let Some(value) = table.get(key) {
            match value.get_ref() {
                DeValue::Table(section) => read(self, section),
                _ => self.fault(
                    value.span(),
                    format!("`{key}` is not a section"),
                    format!("write it as [{key}]"),
                ),
            }
        }
    }

    fn string(&mut self, value: &Value<'_>) -> String {
        match value.get_ref() {
            DeValue::String(text) => text.clone().into_owned(),
            other => {
                let message = format!("a text was expected, not a {}", other.type_str());
                self.fault(value.span(), message, "put it in quotes");
                String::new()
            }
        }
    }

    /// The three parts of a number; its value is read by `read`.
    fn sourced<T>(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        read: impl FnOnce(&mut Self, &Value<'_>) -> Option<T>,
    ) -> Option<Sourced<T>> {
        const FORM: &str = "write it as { value = …, status = \"verified|excerpt|memory|assumed\", source = \"…\" }";
        let entry = table.get(key)?;
        let DeValue::Table(parts) = entry.get_ref() else {
            self.fault(entry.span(), format!("`{key}` has no provenance"), FORM);
            return None;
        };
        self.known(parts, &["value", "status", "source"]);
        for part in ["value", "status", "source"] {
            if parts.get(part).is_none() {
                self.fault(entry.span(), format!("`{key}` has no {part}"), FORM);
            }
        }
        let value = parts.get("value").and_then(|v| read(self, v));
        let status = parts.get("status").and_then(|v| {
            let status = match self.string(v).as_str() {
                "verified" => Provenance::Verified,
                "excerpt" => Provenance::Excerpt,
                "memory" => Provenance::Memory,
                "assumed" => Provenance::Assumed,
                other => {
                    let message = format!("`{other}` is no status");
                    let remedy = "use verified, excerpt, memory or assumed";
                    self.fault(v.span(), message, remedy);
                    return None;
                }
            };
            Some(status)
        });
        let source = parts.get("source").map(|v| (self.string(v), v.span()));
        if let Some((text, span)) = &source
            && text.trim().is_empty()
        {
            self.fault(
                span.clone(),
                format!("the source of `{key}` is empty"),
                "say where the number is from, or why it was assumed",
            );
        }
        Some(Sourced { value: value?, status: status?, source: source?.0 })
    }

    fn number(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        fits: impl Fn(f64) -> bool,
        rule: &str,
    ) -> Option<Sourced<f64>> {
        self.sourced(table, key, |reader, value| {
            let number = match value.get_ref() {
                DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
                DeValue::Integer(integer) => {
                    i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64)
                }
                _ => None,
            };
            let number = number.filter(|n| n.is_finite() && fits(*n));
            if number.is_none() {
                let message = format!("`{key}` is not a number {rule}");
                reader.fault(value.span(), message, format!("give a number {rule}"));
            }
            number
        })
    }

    fn whole(
        &mut self,
        table: &DeTable<'_>,
        key: &str,
        range: std::ops::RangeInclusive<u32>,
    ) -> Option<Sourced<u32>> {
        self.sourced(table, key, |reader, value| {
            let number = match value.get_ref() {
                DeValue::Integer(integer) => {
                    u32::from_str_radix(integer.as_str(), integer.radix()).ok()
                }
                _ => None,
            };
            let number = number.filter(|n| range.contains(n));
            if number.is_none() {
                let rule = format!("from {} to {}", range.start(), range.end());
                let message = format!("`{key}` is not a whole number {rule}");
                reader.fault(value.span(), message, format!("give a whole number {rule}"));
            }
            number
        })
    }

    fn bits(&mut self, table: &DeTable<'_>) -> Option<Sourced<u32>> {
        self.whole(table, "bits", 2..=MAX_BITS)
    }

    fn duration(&mut self, table: &DeTable<'_>, key: &str) -> Option<Sourced<Tick>> {
        // A second is far beyond any converter, and keeps sums of ticks from overflow.
        let limit = Tick::SECOND;
        self.sourced(table, key, |reader, value| {
            let text = match value.get_ref() {
                DeValue::String(text) => text,
                other => {
                    let message = format!("`{key}` is a {}, not a time", other.type_str());
                    reader.fault(value.span(), message, "write a text such as \"10us\"");
                    return None;
                }
            };
            match text.parse::<Tick>() {
                Ok(tick) if (Tick::ZERO..=limit).contains(&tick) => Some(tick),
                Ok(tick) => {
                    let message = format!("`{key}` is {tick}");
                    reader.fault(value.span(), message, "give a time from 0s to 1s");
                    None
                }
                Err(error) => {
                    reader.fault(
                        value.span(),
                        format!("`{key}`: {}", error.reason),
                        "write for example \"10us\" or \"1ms\"",
                    );
                    None
                }
            }
        })
    }

    fn hold(&mut self, table: &DeTable<'_>) -> Option<Sourced<HoldKind>> {
        self.sourced(table, "hold", |reader, value| {
            let kind = match reader.string(value).as_str() {
                "zero-order" => HoldKind::ZeroOrder,
                "extrapolating" => HoldKind::Extrapolating,
                "interpolating" => HoldKind::Interpolating,
                other => {
                    let message = format!("`{other}` is no hold");
                    let remedy = "use zero-order, extrapolating or interpolating";
                    reader.fault(value.span(), message, remedy);
                    return None;
                }
            };
            Some(kind)
        })
    }

    fn counts(&mut self, table: &DeTable<'_>) -> BTreeMap<BlockClass, Sourced<u32>> {
        let keys: Vec<&str> = BlockClass::ALL.iter().map(|class| class.key()).collect();
        self.known(table, &keys);
        BlockClass::ALL
            .into_iter()
            .filter_map(|class| {
                let count = self.whole(table, class.key(), 0..=1_000_000)?;
                Some((class, count))
            })
            .collect()
    }
}
