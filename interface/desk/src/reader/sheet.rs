//! Plain files: every fault is a [`FileFault`], a number is a number.

use super::{Board, Data, Fault, Fields, FileKind, Named, Span, Value, entries, span};
use crate::{
    faults::{FileFault, FileFaults, MOST_FAULTS, Source},
    user_file,
};
use interface::Tick;
use std::{
    collections::{BTreeMap, BTreeSet},
    ops::RangeInclusive,
    path::Path,
};
use toml::de::DeTable;

/// A file while it is read, with the faults found so far.
pub struct Sheet<'t> {
    source: Source<'t>,
    faults: Vec<FileFault>,
    untold: usize,
}

/// Any duration that has a length.
pub const ABOVE_ZERO: RangeInclusive<Tick> = Tick(1)..=Tick(i64::MAX);

/// The fields of a table of a plain file.
pub type SheetFields<'r, 't> = Fields<'r, Sheet<'t>>;

/// Reads a file and hands its name and text to `parse`.
pub fn load<T>(
    path: &Path,
    parse: impl FnOnce(&str, &str) -> Result<T, FileFaults>,
) -> Result<T, FileFaults> {
    let file = path.display().to_string();
    let text = user_file::read_text(path).map_err(|error| {
        let source = Source { file: &file, text: "" };
        let remedy = "name a TOML file, and check its permissions";
        source.whole(format!("cannot be read: {error}"), remedy)
    })?;
    parse(&file, &text)
}

/// Reads a text of a kind by its fields.
pub fn read<T>(
    kind: FileKind,
    source: Source<'_>,
    read: impl FnOnce(&mut SheetFields<'_, '_>) -> Option<T>,
) -> Result<T, FileFaults> {
    let mut sheet = Sheet { source, faults: Vec::new(), untold: 0 };
    let (document, errors) = DeTable::parse_recoverable(source.text);
    for error in &errors {
        let fault = error.message().trim().replace('\n', " ");
        sheet.fault(span(0, error.span().unwrap_or(0..0)), fault, "correct the TOML here");
    }
    let entries = entries(0, document.get_ref());
    let mut value = None;
    if errors.is_empty() {
        if let Some((entry, fault, remedy)) = kind.mistaken(&entries) {
            sheet.fault(entry.key_span, fault, remedy);
        } else {
            let mut fields = Fields::new(&mut sheet, kind.name(), Span::default(), &entries);
            value = read(&mut fields);
            fields.finish(kind.name());
        }
    }
    sheet.faults.sort_by_key(|fault| fault.place);
    match value {
        Some(value) if sheet.faults.is_empty() => Ok(value),
        _ => {
            if sheet.untold > 0 || sheet.faults.is_empty() {
                let fault = format!("and {} faults more", sheet.untold);
                sheet.faults.push(source.whole(fault, "correct those above first"));
            }
            Err(FileFaults(sheet.faults))
        }
    }
}

impl Sheet<'_> {
    fn fault(&mut self, at: Span, fault: impl Into<String>, remedy: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(self.source.fault(at, fault, remedy));
        } else {
            self.untold += 1;
        }
    }
}

impl Board for Sheet<'_> {
    fn tell(&mut self, at: Span, fault: Fault, help: String) {
        self.fault(at, fault.to_string(), help);
    }

    fn number(&mut self, field: &str, value: &Value) -> Option<f64> {
        match value.data {
            Data::Number { value, .. } if value.is_finite() => return Some(value),
            Data::Number { .. } => {
                let fault = Fault::NotFinite { field: field.to_owned() };
                self.tell(value.span, fault, "give a finite number".to_owned());
            }
            _ => self.wrong_type(field, "a number", value),
        }
        None
    }
}

impl<'r> SheetFields<'r, '_> {
    /// Tells of a fault in words.
    pub fn fault(&mut self, at: Span, fault: impl Into<String>, remedy: impl Into<String>) {
        self.board.fault(at, fault, remedy);
    }

    /// Whether something holds; told at the value of a field if not.
    pub fn require(
        &mut self,
        holds: bool,
        key: &str,
        fault: impl Into<String>,
        remedy: impl Into<String>,
    ) -> bool {
        if !holds {
            self.fault(self.place(key).unwrap_or(self.at), fault, remedy);
        }
        holds
    }

    /// A text, which must be there.
    pub fn text(&mut self, key: &'static str) -> Option<String> {
        self.named(key).map(|named| named.name)
    }

    /// Free texts under keys of the user's own, none where the table is left out.
    pub fn texts(&mut self, key: &'static str) -> Option<BTreeMap<String, String>> {
        self.by_name(key, |f, key, value| f.named_of(key, value).map(|named| named.name))
    }

    /// A whole number in a range.
    pub fn whole_in(
        &mut self,
        key: &'static str,
        default: Option<u32>,
        range: RangeInclusive<u32>,
    ) -> Option<u32> {
        let value = self.whole(key, default.map(u64::from))?;
        let fits = u32::try_from(value).ok().filter(|n| range.contains(n));
        if fits.is_none() {
            let range = format!("a whole number from {} to {}", range.start(), range.end());
            self.out_of_range(key, value as f64, range);
        }
        fits
    }

    /// A time as text with its unit; without a default it must be there.
    pub fn duration(
        &mut self,
        key: &'static str,
        default: Option<Tick>,
        range: RangeInclusive<Tick>,
    ) -> Option<Tick> {
        match self.entry_or(key, &default, "\"20ms\"") {
            Some(entry) => self.duration_of(key, &entry.value, range),
            None => default,
        }
    }

    /// A time as text with its unit.
    pub fn duration_of(
        &mut self,
        key: &str,
        value: &Value,
        range: RangeInclusive<Tick>,
    ) -> Option<Tick> {
        let Some(text) = value.text() else {
            self.board.wrong_type(&self.name(key), "a time in quotes such as \"20ms\"", value);
            return None;
        };
        let (fault, remedy) = match text.parse::<Tick>() {
            Ok(tick) if range.contains(&tick) => return Some(tick),
            Ok(tick) => (
                format!("`{}` = {tick} is out of range", self.name(key)),
                match *range.end() {
                    Tick(i64::MAX) => "give a duration above 0".to_owned(),
                    end => format!("give a duration from {} to {end}", range.start()),
                },
            ),
            Err(error) => (
                format!("`{}`: {error}", self.name(key)),
                "write a number with its unit: s, ms, us or ns, as \"20ms\"".to_owned(),
            ),
        };
        self.fault(value.span, fault, remedy);
        None
    }

    /// A table, which must be there.
    pub fn table<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut SheetFields<'_, '_>) -> Option<T>,
    ) -> Option<T> {
        let entry = self.required(key, "{ … }")?;
        self.table_of(key, &entry.value, read)
    }

    /// A table; `None` inside where it is left out.
    pub fn table_or_none<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut SheetFields<'_, '_>) -> Option<T>,
    ) -> Option<Option<T>> {
        match self.entry(key) {
            Some(entry) => self.table_of(key, &entry.value, read).map(Some),
            None => Some(None),
        }
    }

    /// A list of tables, empty where it is left out. Where they have names, each has its own.
    pub fn tables<T>(
        &mut self,
        key: &'static str,
        mut read: impl FnMut(&mut SheetFields<'_, '_>) -> Option<T>,
    ) -> Option<Vec<T>> {
        if self.entry(key).is_none() {
            return Some(Vec::new());
        }
        let mut seen = BTreeSet::new();
        for Named { name, span } in self.names_of(key) {
            if !seen.insert(name.clone()) {
                self.fault(span, format!("a second {key} named `{name}`"), "rename one of them");
            }
        }
        self.each(key, "", |f, key, item| f.table_of(key, item, &mut read))
    }

    /// The names of a list of tables, as far as they have one.
    pub fn names_of(&mut self, key: &'static str) -> Vec<Named> {
        let items = self.entry(key).map(|entry| &entry.value.data);
        let Some(Data::List(items)) = items else { return Vec::new() };
        let name = |item: &Value| {
            let Data::Table(fields) = &item.data else { return None };
            let name = fields.iter().find(|field| field.key == "name")?;
            Some(Named { name: name.value.text()?.to_owned(), span: name.value.span })
        };
        items.iter().filter_map(name).collect()
    }

    fn table_of<T>(
        &mut self,
        key: &str,
        value: &Value,
        read: impl FnOnce(&mut SheetFields<'_, '_>) -> Option<T>,
    ) -> Option<T> {
        let name = self.name(key);
        let Data::Table(entries) = &value.data else {
            self.board.wrong_type(&name, "a table", value);
            return None;
        };
        let owner = format!("[{name}]");
        let mut fields = Fields::new(&mut *self.board, &owner, value.span, entries);
        fields.path = format!("{name}.");
        let read = read(&mut fields);
        fields.finish(&owner);
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Vec<String> {
        let source = Source { file: "f", text };
        let read = read(FileKind::Failures, source, |f| {
            let (name, gain) = (f.text("name"), f.positive("gain", None));
            f.each("list", "[1.0]", |f, key, item| {
                f.number_at(key, item, super::super::Range::Any)
            });
            Some((name?, gain?))
        });
        read.map_or_else(|faults| faults.0.iter().map(ToString::to_string).collect(), |_| vec![])
    }

    #[test]
    fn every_fault_is_told_once_with_its_place() {
        assert_eq!(faults("name = \"a\"\ngain = 1\nlist = []"), [""; 0]);
        assert_eq!(
            faults("nam = \"a\"\ngain = 0\nlist = [1, true]"),
            [
                "f:1:1: unknown key `nam` in a failure file; did you mean `name`?",
                "f:2:8: `gain` = 0 must be positive; give a value greater than 0",
                "f:3:12: `list` takes a number, not true or false; write a number",
            ]
        );
        assert_eq!(
            faults("gain = 1\nlist = []")[0],
            "f:1:1: a failure file lacks `name`; add name = \"…\""
        );
        let many = format!("name = \"a\"\ngain = 1\nlist = [{}]", "nan, ".repeat(300));
        let told = faults(&many);
        assert_eq!(
            (told.len(), told[200].as_str()),
            (201, "f: and 100 faults more; correct those above first")
        );
        assert!(faults("x = [1, \ny = 2\n")[0].starts_with("f:"), "what is no TOML");
    }
}
