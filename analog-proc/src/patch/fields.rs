//! Reading the fields of one table: typed, with defaults, every fault told, unknown keys found.
//!
//! Each reader gives `None` after it has told of a fault; the caller reads all
//! fields first and gives up afterwards, so that no fault hides another.

use super::diagnostic::PatchFault;
use super::faults::suggestion;
use super::number::wrong_type;
use super::resolve::Resolver;
use super::value::{Data, Entry};
use crate::block::kind::linkage;
use crate::net::Span;
use interface::control::ChannelKind;

mod lists;
mod nets;

pub(crate) struct Fields<'r, 'a> {
    pub(crate) resolver: &'r mut Resolver<'a>,
    pub(crate) scope: usize,
    pub(crate) owner: String,
    pub(crate) at: Span,
    entries: &'r [Entry],
    asked: Vec<&'static str>,
}

impl<'r, 'a> Fields<'r, 'a> {
    pub(crate) fn new(
        resolver: &'r mut Resolver<'a>,
        scope: usize,
        owner: &str,
        at: Span,
        entries: &'r [Entry],
    ) -> Self {
        Fields { resolver, scope, owner: owner.to_owned(), at, entries, asked: Vec::new() }
    }

    /// The field, if it is there.
    pub(crate) fn entry(&mut self, key: &'static str) -> Option<&'r Entry> {
        self.asked.push(key);
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// Place of the value of a field.
    pub(crate) fn place(&self, key: &str) -> Option<Span> {
        let entry = self.entries.iter().find(|entry| entry.key == key)?;
        Some(entry.value.span)
    }

    pub(crate) fn required(&mut self, key: &'static str, example: &str) -> Option<&'r Entry> {
        let entry = self.entry(key);
        if entry.is_none() {
            self.missing(key, example);
        }
        entry
    }

    pub(crate) fn missing(&mut self, key: &str, example: &str) {
        let owner = format!("`{}`", self.owner);
        self.resolver.faults.push(self.at, |src, at| PatchFault::MissingField {
            src,
            at,
            owner,
            field: key.to_owned(),
            help: format!("add {key} = {example}"),
        });
    }

    /// A number; without a default it must be there.
    pub(crate) fn number(&mut self, key: &'static str, default: Option<f64>) -> Option<f64> {
        let entry = match default {
            Some(_) => self.entry(key),
            None => self.required(key, "NUMBER"),
        };
        match entry {
            Some(entry) => self.resolver.number(self.scope, key, &entry.value),
            None => default,
        }
    }

    /// A number, or nothing where the field is left out (or faulty).
    pub(crate) fn number_or_none(&mut self, key: &'static str) -> Option<f64> {
        let entry = self.entry(key)?;
        self.resolver.number(self.scope, key, &entry.value)
    }

    /// A positive number.
    pub(crate) fn positive(&mut self, key: &'static str, default: Option<f64>) -> Option<f64> {
        let value = self.number(key, default)?;
        if value > 0.0 {
            return Some(value);
        }
        self.fault_at(key, |src, at| PatchFault::NotPositive {
            src,
            at,
            field: key.to_owned(),
            value,
            help: match key {
                "tau" => "a follower without time constant is a `gain` block",
                "delay" => "without delay, wire the net directly",
                "max" => "give the largest magnitude that the net is to reach",
                _ => "give a value greater than 0",
            }
            .into(),
        });
        None
    }

    /// A positive number, or nothing where the field is left out.
    pub(crate) fn positive_or_none(&mut self, key: &'static str) -> Option<f64> {
        if self.place(key).is_some() {
            self.positive(key, None)
        } else {
            self.asked.push(key);
            None
        }
    }

    /// A time that problem time resolves.
    pub(crate) fn duration(&mut self, key: &'static str) -> Option<f64> {
        let value = self.positive(key, None)?;
        if value >= 1e-9 {
            return Some(value);
        }
        self.out_of_range(key, value, "a nanosecond or more");
        None
    }

    /// Whether a pair of limits is the right way round; told if not.
    pub(crate) fn ordered(&mut self, key: &'static str, low: f64, high: f64) -> bool {
        if low < high {
            return true;
        }
        self.fault_at(key, |src, at| PatchFault::InvertedLimits {
            src,
            at,
            field: key.to_owned(),
            low,
            high,
            help: format!("write the lower one first: {key} = [{high}, {low}]"),
        });
        false
    }

    /// A number in a range.
    pub(crate) fn ranged(
        &mut self,
        key: &'static str,
        default: Option<f64>,
        range: &'static str,
        is_inside: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let value = self.number(key, default)?;
        if is_inside(value) {
            return Some(value);
        }
        self.out_of_range(key, value, range);
        None
    }

    pub(crate) fn out_of_range(&mut self, key: &'static str, value: f64, range: &'static str) {
        self.fault_at(key, |src, at| PatchFault::OutOfRange {
            src,
            at,
            field: key.to_owned(),
            value,
            range,
            help: format!("change `{key}` to a value that is {range}"),
        });
    }

    /// Tells of a fault at the value of a field, or at the owner where the field is left out.
    pub(crate) fn fault_at(
        &mut self,
        key: &str,
        make: impl FnOnce(super::diagnostic::Source, miette::SourceSpan) -> PatchFault,
    ) {
        let at = self.place(key).unwrap_or(self.at);
        self.resolver.faults.push(at, make);
    }

    /// A whole number from 0 to 2⁵³, exact.
    pub(crate) fn whole(&mut self, key: &'static str, default: Option<u64>) -> Option<u64> {
        let entry = match default {
            Some(_) => self.entry(key),
            None => self.required(key, "0"),
        };
        let Some(entry) = entry else { return default };
        if let Data::Number { integer: Some(integer), .. } = entry.value.data
            && let Ok(whole) = u64::try_from(integer)
        {
            return Some(whole);
        }
        let value = self.resolver.number(self.scope, key, &entry.value)?;
        // 2⁵³: beyond it an f64 does not hold every whole number.
        if value >= 0.0 && value.fract() == 0.0 && value <= 9_007_199_254_740_992.0 {
            return Some(value as u64);
        }
        self.out_of_range(key, value, "a whole number, 0 or greater");
        None
    }

    /// A converter channel or line.
    pub(crate) fn channel(
        &mut self,
        key: &'static str,
        kind: ChannelKind,
        needed: usize,
    ) -> Option<u32> {
        let (what, count) = linkage(kind);
        let entry = self.required(key, "0")?;
        let first = self.resolver.number(self.scope, key, &entry.value)?;
        let last_used = first + needed.max(1) as f64 - 1.0;
        if first >= 0.0 && first.fract() == 0.0 && last_used < count as f64 {
            return Some(first as u32);
        }
        let number = if first >= 0.0 && first.fract() == 0.0 { last_used } else { first };
        self.fault_at(key, |src, at| PatchFault::ChannelOutOfRange {
            src,
            at,
            what,
            number,
            last: count as u32 - 1,
            help: format!("the linkage numbers them 0 to {}", count - 1),
        });
        None
    }

    pub(crate) fn flag(&mut self, key: &'static str, default: bool) -> Option<bool> {
        let Some(entry) = self.entry(key) else {
            return Some(default);
        };
        match entry.value.data {
            Data::Flag(flag) => Some(flag),
            _ => {
                wrong_type(key, "true or false", &entry.value, self.resolver.faults);
                None
            }
        }
    }

    pub(crate) fn text(&mut self, key: &'static str) -> Option<String> {
        let entry = self.entry(key)?;
        match &entry.value.data {
            Data::Text(text) => Some(text.clone()),
            _ => {
                wrong_type(key, "a string", &entry.value, self.resolver.faults);
                None
            }
        }
    }

    /// One of a few words.
    pub(crate) fn word<T: Copy>(
        &mut self,
        key: &'static str,
        default: Option<T>,
        words: &[(&'static str, T)],
    ) -> Option<T> {
        let entry = match default {
            Some(_) => self.entry(key),
            None => self.required(key, &format!("\"{}\"", words[0].0)),
        };
        let Some(entry) = entry else { return default };
        let Data::Text(text) = &entry.value.data else {
            wrong_type(key, "a word in quotes", &entry.value, self.resolver.faults);
            return None;
        };
        let found = words.iter().find(|(word, _)| word == text);
        if found.is_none() {
            let help = suggestion(text, "words", words.iter().map(|(word, _)| *word));
            let text = text.clone();
            self.fault_at(key, |src, at| PatchFault::UnknownKey {
                src,
                at,
                key: text,
                owner: format!("`{key}`"),
                help,
            });
        }
        found.map(|(_, value)| *value)
    }

    /// Tells of keys that nobody asked for.
    pub(crate) fn finish(self, owner: &str) {
        for entry in self.entries {
            if self.asked.iter().any(|key| *key == entry.key) {
                continue;
            }
            let help = suggestion(&entry.key, "its fields", self.asked.iter().copied());
            self.resolver.faults.push(entry.key_span, |src, at| PatchFault::UnknownKey {
                src,
                at,
                key: entry.key.clone(),
                owner: owner.to_owned(),
                help,
            });
        }
    }
}
