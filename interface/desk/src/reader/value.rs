//! Values of a user's file, each with its place.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A byte range in one of the files that are read together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Index into the list of files.
    pub file: u32,
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

/// A value and where it stands.
#[derive(Clone, Debug)]
pub struct Value {
    pub span: Span,
    pub data: Data,
}

/// What a value is.
#[derive(Clone, Debug)]
pub enum Data {
    /// Any number; `integer` where it is written as one that fits.
    Number {
        value: f64,
        integer: Option<i64>,
    },
    Text(String),
    Flag(bool),
    List(Vec<Value>),
    Table(Vec<Entry>),
    Date,
}

/// A key of a table with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    pub key: String,
    pub key_span: Span,
    pub value: Value,
}

/// A name with its place, for what can be judged only later.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    pub name: String,
    pub span: Span,
}

impl Value {
    pub fn text(&self) -> Option<&str> {
        match &self.data {
            Data::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The type in words.
    pub fn type_name(&self) -> &'static str {
        match self.data {
            Data::Number { .. } => "a number",
            Data::Text(_) => "a string",
            Data::Flag(_) => "true or false",
            Data::List(_) => "a list",
            Data::Table(_) => "a table",
            Data::Date => "a date",
        }
    }

    /// Converts what the parser returns. The parser bounds the depth of nesting.
    pub fn from_toml(file: u32, value: &Spanned<DeValue<'_>>) -> Self {
        let data = match value.get_ref() {
            DeValue::String(text) => Data::Text(text.clone().into_owned()),
            DeValue::Integer(i) => {
                let integer = i64::from_str_radix(i.as_str(), i.radix()).ok();
                // An integer too large for 64 bits is still a number if it is decimal.
                let value = integer
                    .map_or_else(|| i.as_str().parse().unwrap_or(f64::INFINITY), |i| i as f64);
                Data::Number { value, integer }
            }
            DeValue::Float(f) => {
                Data::Number { value: f.as_str().parse().unwrap_or(f64::NAN), integer: None }
            }
            DeValue::Boolean(flag) => Data::Flag(*flag),
            DeValue::Datetime(_) => Data::Date,
            DeValue::Array(items) => {
                Data::List(items.iter().map(|v| Value::from_toml(file, v)).collect())
            }
            DeValue::Table(table) => Data::Table(entries(file, table)),
        };
        Value { span: span(file, value.span()), data }
    }
}

/// Entries of a table in the order in which they stand in the file.
pub fn entries(file: u32, table: &DeTable<'_>) -> Vec<Entry> {
    let mut list: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().clone().into_owned(),
            key_span: span(file, key.span()),
            value: Value::from_toml(file, value),
        })
        .collect();
    list.sort_by_key(|entry| entry.key_span.start);
    list
}

/// A byte range as a span. Files are shorter than 4 GiB (whoever reads them refuses far smaller ones).
pub fn span(file: u32, range: Range<usize>) -> Span {
    let offset = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    Span { file, start: offset(range.start), end: offset(range.end) }
}
