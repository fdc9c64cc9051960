//! Reading the fields of one table: typed, with defaults, every fault told, unknown keys found.
//!
//! Each reader gives `None` after it has told of a fault; the caller reads all
//! fields first and gives up afterwards, so that no fault hides another.

use super::diagnostic::PatchFault;
use super::faults::suggestion;
use super::resolve::Resolver;
use super::scope::{not_finite, wrong_type};
use super::value::{Data, Entry, Value};
use crate::net::{Input, Kind, Level, NetId, Span};

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
        Fields {
            resolver,
            scope,
            owner: owner.to_owned(),
            at,
            entries,
            asked: Vec::new(),
        }
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

    fn required(&mut self, key: &'static str, example: &str) -> Option<&'r Entry> {
        let entry = self.entry(key);
        if entry.is_none() {
            self.missing(key, example);
        }
        entry
    }

    pub(crate) fn missing(&mut self, key: &str, example: &str) {
        let owner = format!("`{}`", self.owner);
        self.resolver
            .faults
            .push(self.at, |src, at| PatchFault::MissingField {
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
        if let Data::Number {
            integer: Some(integer),
            ..
        } = entry.value.data
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
        what: &'static str,
        count: u32,
        needed: usize,
    ) -> Option<u32> {
        let entry = self.required(key, "0")?;
        let first = self.resolver.number(self.scope, key, &entry.value)?;
        let last_used = first + needed.max(1) as f64 - 1.0;
        if first >= 0.0 && first.fract() == 0.0 && last_used < f64::from(count) {
            return Some(first as u32);
        }
        let number = if first >= 0.0 && first.fract() == 0.0 {
            last_used
        } else {
            first
        };
        self.fault_at(key, |src, at| PatchFault::ChannelOutOfRange {
            src,
            at,
            what,
            number,
            last: count - 1,
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

    fn list(&mut self, key: &'static str, entry: &'r Entry) -> Option<&'r [Value]> {
        match &entry.value.data {
            Data::List(items) => Some(items),
            _ => {
                wrong_type(key, "a list", &entry.value, self.resolver.faults);
                None
            }
        }
    }

    fn numbers_of(&mut self, key: &str, items: &[Value]) -> Option<Vec<f64>> {
        // Read all before giving up.
        let read: Vec<Option<f64>> = items
            .iter()
            .map(|item| self.resolver.number(self.scope, key, item))
            .collect();
        read.into_iter().collect()
    }

    /// A list of numbers, or nothing where it is left out.
    pub(crate) fn numbers_or_none(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.entry(key)?;
        let items = self.list(key, entry)?;
        self.numbers_of(key, items)
    }

    /// A list of numbers.
    pub(crate) fn numbers(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.required(key, "[0.0, 1.0]")?;
        let items = self.list(key, entry)?;
        self.numbers_of(key, items)
    }

    /// A pair `[low, high]`; `None` inside where it is left out.
    pub(crate) fn pair_or_none(&mut self, key: &'static str) -> Option<Option<[f64; 2]>> {
        if self.place(key).is_none() {
            self.asked.push(key);
            return Some(None);
        }
        self.pair(key).map(Some)
    }

    /// A pair `[low, high]`.
    pub(crate) fn pair(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let list = self.numbers(key)?;
        if let [low, high] = list[..] {
            return Some([low, high]);
        }
        self.table_size(key, list.len(), "2 (low and high)".into());
        None
    }

    pub(crate) fn table_size(&mut self, key: &str, found: usize, wanted: String) {
        let field = key.to_owned();
        self.fault_at(key, |src, at| PatchFault::TableSize {
            src,
            at,
            field,
            found,
            help: format!("make it {wanted}"),
            wanted,
        });
    }

    /// Breakpoints: at least two, increasing.
    pub(crate) fn breakpoints(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.required(key, "[0.0, 1.0]")?;
        let items = self.list(key, entry)?;
        let values = self.numbers_of(key, items)?;
        if values.len() < 2 {
            self.table_size(key, values.len(), "at least 2".into());
            return None;
        }
        for (pair, item) in values.windows(2).zip(&items[1..]) {
            if pair[1] <= pair[0] {
                self.resolver
                    .faults
                    .push(item.span, |src, at| PatchFault::Breakpoints {
                        src,
                        at,
                        field: key.to_owned(),
                        value: pair[1],
                        previous: pair[0],
                        help: "sort the breakpoints; a step needs two that lie close together"
                            .into(),
                    });
                return None;
            }
        }
        Some(values)
    }

    /// Rows of numbers, each of `columns`; row-major.
    pub(crate) fn grid(
        &mut self,
        key: &'static str,
        size: Option<(usize, usize)>,
    ) -> Option<Vec<f64>> {
        let entry = self.required(key, "[[0.0, 0.0], [0.0, 0.0]]")?;
        let rows = self.list(key, entry)?;
        let mut all = Vec::new();
        let mut is_whole = true;
        for row in rows {
            let values = match &row.data {
                Data::List(items) => self.numbers_of(key, items),
                _ => {
                    wrong_type(
                        key,
                        "a list of rows, one for each x",
                        row,
                        self.resolver.faults,
                    );
                    None
                }
            };
            let Some(values) = values else {
                is_whole = false;
                continue;
            };
            if let Some((_, columns)) = size.filter(|(_, columns)| *columns != values.len()) {
                is_whole = false;
                let found = values.len();
                self.resolver
                    .faults
                    .push(row.span, |src, at| PatchFault::TableSize {
                        src,
                        at,
                        field: key.to_owned(),
                        found,
                        wanted: format!("{columns} (one for each y)"),
                        help: "a row holds the values at one x, in order of y".into(),
                    });
            }
            all.extend(values);
        }
        let (wanted, _) = size?;
        if rows.len() != wanted {
            self.table_size(key, rows.len(), format!("{wanted} rows (one for each x)"));
            return None;
        }
        is_whole.then_some(all)
    }

    /// A net for logic control, without coefficient; `None` inside where it is left out.
    pub(crate) fn net_or_none(&mut self, key: &'static str) -> Option<Option<NetId>> {
        let Some(entry) = self.entry(key) else {
            return Some(None);
        };
        let input = self.resolver.input(self.scope, key, &entry.value)?;
        if input.coefficient == 1.0 {
            return Some(Some(input.net));
        }
        let net = self.resolver.faults.sources.text(input.span).to_owned();
        self.fault_at(key, |src, at| PatchFault::LogicCoefficient {
            src,
            at,
            net: net.trim_matches(['"', '\'']).to_owned(),
            help: "logic is 0 or 1; invert it with a `not` block".into(),
        });
        None
    }

    /// A net for logic control that must be there.
    pub(crate) fn net(&mut self, key: &'static str) -> Option<NetId> {
        if self.place(key).is_none() {
            self.asked.push(key);
            self.missing(key, "\"NET\"");
            return None;
        }
        self.net_or_none(key)?
    }

    /// A weighted input in a field of its own; `None` inside where it is left out.
    pub(crate) fn input_or_none(&mut self, key: &'static str) -> Option<Option<Input>> {
        let Some(entry) = self.entry(key) else {
            return Some(None);
        };
        self.resolver.input(self.scope, key, &entry.value).map(Some)
    }

    /// A number or a net. A weighted net becomes a hidden gain block `NAME.part`.
    pub(crate) fn level(&mut self, key: &'static str, value: &Value, part: &str) -> Option<Level> {
        if let Data::Text(text) = &value.data {
            let last = text.rsplit('*').next().unwrap_or("");
            let last = last.trim().trim_start_matches('-').trim();
            let is_word = last.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
            if is_word && !self.resolver.params(self.scope).contains_key(last) {
                let input = self.resolver.input(self.scope, key, value)?;
                return Some(Level::Net(self.weighted(input, part)));
            }
        }
        let number = self.resolver.number(self.scope, key, value)?;
        if number.is_finite() {
            return Some(Level::Fixed(number));
        }
        not_finite(key, value.span, self.resolver.faults);
        None
    }

    /// The net of an input with its coefficient applied.
    pub(crate) fn weighted(&mut self, input: Input, part: &str) -> NetId {
        if input.coefficient == 1.0 {
            return input.net;
        }
        let name = format!("{}.{part}", self.owner);
        self.resolver.hide(name, self.at, Kind::Summer, input)
    }

    /// Makes a hidden inverter of a net.
    pub(crate) fn inverted(&mut self, net: NetId, part: &str, span: Span) -> NetId {
        let name = format!("{}.{part}", self.owner);
        let input = Input {
            net,
            coefficient: 1.0,
            span,
        };
        self.resolver.hide(name, self.at, Kind::Inverter, input)
    }

    /// Tells of keys that nobody asked for.
    pub(crate) fn finish(self, owner: &str) {
        for entry in self.entries {
            if self.asked.iter().any(|key| *key == entry.key) {
                continue;
            }
            let help = suggestion(&entry.key, "its fields", self.asked.iter().copied());
            self.resolver
                .faults
                .push(entry.key_span, |src, at| PatchFault::UnknownKey {
                    src,
                    at,
                    key: entry.key.clone(),
                    owner: owner.to_owned(),
                    help,
                });
        }
    }
}
