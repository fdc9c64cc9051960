//! Reading a user's file: fields asked for by key, each with its rule; every fault told.
//!
//! Each method gives `None` after it has told of a fault. Whoever reads asks for all fields
//! first and gives up afterwards, so that one run shows every fault. Keys that nobody asked for
//! are faults: a misspelt one would otherwise be a setting left out. What is told of a fault,
//! and what may stand for a number, is the [`Board`]'s part: a [`Sheet`] for plain files; patches
//! have one of their own. Long, for it is the list of rules that a field may have.

mod kind;
mod lists;
mod sheet;
mod value;

pub use kind::FileKind;
pub use sheet::{ABOVE_ZERO, Sheet, SheetFields, load, read};
pub use value::{Data, Entry, Named, Span, Value, entries, span};

use crate::faults::{nearest, suggestion};

/// A struct that is a table of a file, `field: type = rule("key", …), "what it is";` for each of
/// its fields: written as it is read, with `read` that asks for each field by its rule, a method
/// of [`SheetFields`].
#[macro_export]
macro_rules! table {
    ($about:literal $name:ident
        $($field:ident: $type:ty = $rule:ident($key:literal $(, $more:expr)*), $what:literal;)+
    ) => {
        #[doc = $about]
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $(#[doc = $what] #[serde(rename = $key)] pub $field: $type,)+
        }

        impl $name {
            pub(crate) fn read(f: &mut $crate::reader::SheetFields<'_, '_>) -> Option<Self> {
                $(let $field = f.$rule($key $(, $more)*);)+
                Some($name { $($field: $field?),+ })
            }
        }
    };
}

/// A fault that every file can have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    #[error("unknown key `{key}` in {owner}")]
    UnknownKey { key: String, owner: String },
    #[error("`{field}` cannot be `{word}`")]
    UnknownWord { field: String, word: String },
    #[error("{owner} lacks `{field}`")]
    MissingField { owner: String, field: String },
    #[error("`{field}` takes {wanted}, not {found}")]
    WrongType { field: String, wanted: &'static str, found: &'static str },
    #[error("`{field}` is not a finite number")]
    NotFinite { field: String },
    #[error("`{field}` = {value} is out of range: it must be {range}")]
    OutOfRange { field: String, value: f64, range: String },
    #[error("`{field}` = {value} must be positive")]
    NotPositive { field: String, value: f64 },
    #[error("`{field}` = [{low}, {high}]: the first must lie below the second")]
    InvertedLimits { field: String, low: f64, high: f64 },
    #[error("breakpoints of `{field}` must increase: {value} follows {previous}")]
    Breakpoints { field: String, value: f64, previous: f64 },
    #[error("`{field}` has {found} entries where {wanted} are needed")]
    TableSize { field: String, found: usize, wanted: String },
}

/// Who is told of faults, and knows what may stand for a number.
pub trait Board {
    /// Tells of a fault with its remedy.
    fn tell(&mut self, at: Span, fault: Fault, help: String);

    /// The finite number that a value stands for.
    fn number(&mut self, field: &str, value: &Value) -> Option<f64>;

    /// The entries of a table.
    fn entries_of<'v>(&mut self, field: &str, value: &'v Value) -> &'v [Entry] {
        if let Data::Table(entries) = &value.data {
            return entries;
        }
        self.wrong_type(field, "a table", value);
        &[]
    }

    /// Tells of a value of another type than its field takes.
    fn wrong_type(&mut self, field: &str, wanted: &'static str, value: &Value) {
        let (field, found) = (field.to_owned(), value.type_name());
        let fault = Fault::WrongType { field, wanted, found };
        self.tell(value.span, fault, format!("write {wanted}"));
    }
}

/// Which finite values of a physical quantity make sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Any.
    Any,
    /// A limit or a width: 0 or more.
    NotNegative,
    /// Something is divided by it: above 0.
    Positive,
}

impl Range {
    /// Whether a value is finite and in the range.
    pub fn contains(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Range::Any => true,
                Range::NotNegative => value >= 0.0,
                Range::Positive => value > 0.0,
            }
    }

    /// In a table.
    pub fn words(self) -> &'static str {
        match self {
            Range::Any => "any",
            Range::NotNegative => "0 or greater",
            Range::Positive => "greater than 0",
        }
    }
}

/// The fields of one table.
pub struct Fields<'r, B> {
    /// Who is told.
    pub board: &'r mut B,
    /// The table in words.
    pub owner: String,
    /// Its place.
    pub at: Span,
    /// What stands before its keys in messages: the tables around it.
    path: String,
    entries: &'r [Entry],
    asked: Vec<&'static str>,
    missing: Vec<(&'static str, String)>,
}

impl<'r, B: Board> Fields<'r, B> {
    /// None asked for yet.
    pub fn new(board: &'r mut B, owner: &str, at: Span, entries: &'r [Entry]) -> Self {
        let (owner, path) = (owner.to_owned(), String::new());
        Fields { board, owner, at, path, entries, asked: Vec::new(), missing: Vec::new() }
    }

    fn name(&self, key: &str) -> String {
        format!("{}{key}", self.path)
    }

    /// The field, if it is there.
    pub fn entry(&mut self, key: &'static str) -> Option<&'r Entry> {
        if !self.asked.contains(&key) {
            self.asked.push(key);
        }
        self.entries.iter().find(|entry| entry.key == key)
    }

    /// What `read` makes of a field, or nothing where it is left out.
    pub fn maybe<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&mut Self) -> Option<T>,
    ) -> Option<T> {
        self.entry(key)?;
        read(self)
    }

    /// All fields, for a table whose keys are names of the user's own.
    pub fn all(&mut self) -> &'r [Entry] {
        std::mem::take(&mut self.entries)
    }

    /// Place of the value of a field, or of one in a table below: `key` or `table.key`.
    pub fn place(&self, path: &str) -> Option<Span> {
        let (mut entries, mut path) = (self.entries, path);
        loop {
            if let Some(entry) = entries.iter().find(|entry| entry.key == path) {
                return Some(entry.value.span);
            }
            let (table, rest) = path.split_once('.')?;
            match &entries.iter().find(|entry| entry.key == table)?.value.data {
                Data::Table(below) => (entries, path) = (below, rest),
                _ => return None,
            }
        }
    }

    /// The field, which must be there.
    pub fn required(&mut self, key: &'static str, example: &str) -> Option<&'r Entry> {
        let entry = self.entry(key);
        if entry.is_none() {
            self.missing(key, example);
        }
        entry
    }

    fn entry_or<T>(
        &mut self,
        key: &'static str,
        default: &Option<T>,
        example: &str,
    ) -> Option<&'r Entry> {
        if default.is_some() { self.entry(key) } else { self.required(key, example) }
    }

    /// Tells that a field is missing, once it is known that no misspelt key stands for it.
    pub fn missing(&mut self, key: &'static str, example: &str) {
        self.missing.push((key, format!("add {key} = {example}")));
    }

    /// Tells of the fields that are missing, but for those meant by misspelt keys.
    pub fn tell_missing(&mut self, misspelt: &[&str]) {
        for (key, help) in std::mem::take(&mut self.missing) {
            if !misspelt.contains(&key) {
                let fault =
                    Fault::MissingField { owner: self.owner.clone(), field: key.to_owned() };
                self.board.tell(self.at, fault, help);
            }
        }
    }

    /// Tells of a fault at the value of a field, or at the owner where the field is left out.
    fn tell(&mut self, key: &str, fault: Fault, help: String) {
        self.board.tell(self.place(key).unwrap_or(self.at), fault, help);
    }

    /// Tells that a number is not what it must be.
    pub fn out_of_range(&mut self, key: &str, value: f64, range: impl Into<String>) {
        let range = range.into();
        let help = format!("change `{key}` to a value that is {range}");
        self.tell(key, Fault::OutOfRange { field: self.name(key), value, range }, help);
    }

    /// A number; without a default it must be there.
    pub fn number(&mut self, key: &'static str, default: Option<f64>) -> Option<f64> {
        self.number_or(key, default, |f, value| f.number_at(key, value, Range::Any))
    }

    fn number_or(
        &mut self,
        key: &'static str,
        default: Option<f64>,
        read: impl FnOnce(&mut Self, &Value) -> Option<f64>,
    ) -> Option<f64> {
        match self.entry_or(key, &default, "NUMBER") {
            Some(entry) => read(self, &entry.value),
            None => default,
        }
    }

    /// A number of a physical quantity.
    pub fn number_in(&mut self, key: &'static str, range: Range) -> Option<f64> {
        self.number_or(key, None, |f, value| f.number_at(key, value, range))
    }

    /// A positive number.
    pub fn positive(&mut self, key: &'static str, default: Option<f64>) -> Option<f64> {
        self.number_or(key, default, |f, value| f.number_at(key, value, Range::Positive))
    }

    /// A number in a range.
    pub fn ranged(
        &mut self,
        key: &'static str,
        default: Option<f64>,
        range: &'static str,
        is_inside: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        self.number_or(key, default, |f, value| f.ranged_at(key, value, range, is_inside))
    }

    /// The number that a value stands for, if it is in a range.
    pub fn number_at(&mut self, key: &str, value: &Value, range: Range) -> Option<f64> {
        let field = self.name(key);
        let number = self.board.number(&field, value)?;
        let (fault, help) = match range {
            Range::Any => return Some(number),
            _ if range.contains(number) => return Some(number),
            Range::Positive => {
                (Fault::NotPositive { field, value: number }, "give a value greater than 0")
            }
            Range::NotNegative => {
                let range = "0 or greater".to_owned();
                (Fault::OutOfRange { field, value: number, range }, "give a value of 0 or greater")
            }
        };
        self.board.tell(value.span, fault, help.to_owned());
        None
    }

    /// The number that a value stands for, if it is in a range.
    pub fn ranged_at(
        &mut self,
        key: &str,
        value: &Value,
        range: &'static str,
        is_inside: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        let field = self.name(key);
        let number = self.board.number(&field, value)?;
        if is_inside(number) {
            return Some(number);
        }
        let fault = Fault::OutOfRange { field, value: number, range: range.to_owned() };
        let help = format!("change `{key}` to a value that is {range}");
        self.board.tell(value.span, fault, help);
        None
    }

    /// Whether a pair of limits is the right way round; told if not.
    pub fn ordered(&mut self, key: &'static str, low: f64, high: f64) -> bool {
        if low < high {
            return true;
        }
        let help = format!("write the lower one first: {key} = [{high}, {low}]");
        self.tell(key, Fault::InvertedLimits { field: self.name(key), low, high }, help);
        false
    }

    /// A whole number from 0 to 2⁵³, exact.
    pub fn whole(&mut self, key: &'static str, default: Option<u64>) -> Option<u64> {
        let Some(entry) = self.entry_or(key, &default, "0") else { return default };
        if let Data::Number { integer: Some(integer), .. } = entry.value.data
            && let Ok(whole) = u64::try_from(integer)
        {
            return Some(whole);
        }
        let value = self.board.number(&self.name(key), &entry.value)?;
        // 2⁵³: beyond it an f64 does not hold every whole number.
        if value >= 0.0 && value.fract() == 0.0 && value <= 9_007_199_254_740_992.0 {
            return Some(value as u64);
        }
        self.out_of_range(key, value, "a whole number, 0 or greater");
        None
    }

    pub fn flag(&mut self, key: &'static str, default: bool) -> Option<bool> {
        let Some(entry) = self.entry(key) else {
            return Some(default);
        };
        if let Data::Flag(flag) = entry.value.data {
            return Some(flag);
        }
        self.board.wrong_type(&self.name(key), "true or false", &entry.value);
        None
    }

    /// A text, or nothing where the field is left out.
    pub fn text_or_none(&mut self, key: &'static str) -> Option<String> {
        self.maybe(key, |f| f.named(key)).map(|named| named.name)
    }

    /// A text with its place, which must be there.
    pub fn named(&mut self, key: &'static str) -> Option<Named> {
        let entry = self.required(key, "\"…\"")?;
        self.named_of(key, &entry.value)
    }

    fn named_of(&mut self, key: &str, value: &Value) -> Option<Named> {
        if let Some(text) = value.text() {
            return Some(Named { name: text.to_owned(), span: value.span });
        }
        self.board.wrong_type(&self.name(key), "a string", value);
        None
    }

    /// A list of texts, which must be there.
    pub fn names(&mut self, key: &'static str) -> Option<Vec<Named>> {
        self.each(key, "[\"…\"]", Self::named_of)
    }

    /// The entries of a table, none where it is left out.
    pub fn entries(&mut self, key: &'static str) -> &'r [Entry] {
        let name = self.name(key);
        self.entry(key).map_or(&[], |entry| self.board.entries_of(&name, &entry.value))
    }

    /// What `read` makes of each value of a table whose keys are names of the user's own.
    pub fn by_name<T, C: FromIterator<(String, T)>>(
        &mut self,
        key: &'static str,
        read: impl Fn(&mut Self, &str, &Value) -> Option<T>,
    ) -> Option<C> {
        let entries = self.entries(key).iter();
        entries.map(|e| Some((e.key.clone(), read(self, &e.key, &e.value)?))).collect()
    }

    /// One of a few words.
    pub fn word<T: Copy>(
        &mut self,
        key: &'static str,
        default: Option<T>,
        words: &[(&str, T)],
    ) -> Option<T> {
        let example = format!("\"{}\"", words.first().map_or("", |(word, _)| *word));
        match self.entry_or(key, &default, &example) {
            Some(entry) => self.word_of(key, &entry.value, words),
            None => default,
        }
    }

    /// The meaning of a value that is one of a few words.
    pub fn word_of<T: Copy>(&mut self, key: &str, value: &Value, words: &[(&str, T)]) -> Option<T> {
        let field = self.name(key);
        let Some(text) = value.text() else {
            self.board.wrong_type(&field, "a word in quotes", value);
            return None;
        };
        let found = words.iter().find(|(word, _)| *word == text);
        if found.is_none() {
            let help = suggestion(text, words.iter().map(|(word, _)| *word));
            self.board.tell(value.span, Fault::UnknownWord { field, word: text.to_owned() }, help);
        }
        found.map(|(_, value)| *value)
    }

    /// Tells of keys that nobody asked for, and of fields that are missing.
    pub fn finish(mut self, owner: &str) {
        let mut misspelt = Vec::new();
        for entry in self.entries.iter().filter(|e| !self.asked.contains(&e.key.as_str())) {
            misspelt.extend(nearest(&entry.key, &self.asked));
            let help = suggestion(&entry.key, self.asked.iter().copied());
            let fault = Fault::UnknownKey { key: entry.key.clone(), owner: owner.to_owned() };
            self.board.tell(entry.key_span, fault, help);
        }
        self.tell_missing(&misspelt);
    }
}
