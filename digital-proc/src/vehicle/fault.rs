//! Faults of a vehicle file, with the place and the remedy.
//!
//! All semantic faults of a file are collected and reported together; each
//! names the line on which its key stands. What the TOML reader itself refuses
//! (syntax, a wrong type, an unknown or missing key) ends the reading, so such
//! a fault comes alone.

use std::fmt;

use toml::de::{DeTable, DeValue};

/// A vehicle file that was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VehicleError {
    /// The file could not be read.
    #[error("{file}: cannot be read: {reason}; check the path and its permissions")]
    Unreadable {
        /// File as named by the caller.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// One or more faults in the text.
    #[error("{}", list(.0))]
    Faults(Vec<VehicleFault>),
}

/// One fault.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleFault {
    /// File as named by the caller.
    pub file: String,
    /// Line and column, counted from 1; absent for data that never was a text.
    pub place: Option<(usize, usize)>,
    /// Key, such as `aero.C_A[3]`; empty when the text is not TOML at all.
    pub key: String,
    /// What is wrong.
    pub fault: String,
    /// What to do about it.
    pub remedy: String,
}

impl fmt::Display for VehicleFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some((line, column)) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        if !self.key.is_empty() {
            write!(f, ": {}", self.key)?;
        }
        write!(f, ": {}; {}", self.fault, self.remedy)
    }
}

fn list(faults: &[VehicleFault]) -> String {
    let lines: Vec<_> = faults.iter().map(VehicleFault::to_string).collect();
    lines.join("\n")
}

/// Turns the TOML reader's error into a fault, naming the nearest known key
/// where an unknown one was written.
pub(crate) fn reader_fault(file: &str, text: &str, error: &toml::de::Error) -> VehicleFault {
    let message = error.message().trim().replace('\n', " ");
    let mut quoted = message.split('`').skip(1).step_by(2);
    let remedy = if message.starts_with("unknown field") {
        let unknown = quoted.next().unwrap_or_default();
        let nearest = quoted
            .map(|known| (strsim::jaro_winkler(unknown, known), known))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((score, known)) if score > 0.7 => format!("did you mean `{known}`?"),
            _ => "remove it, or spell it as the data set does".to_owned(),
        }
    } else if message.starts_with("missing field") {
        "add the key to this section; the shipped data set shows its unit".to_owned()
    } else if message.starts_with("invalid type") {
        "give the type that the shipped data set has for this key".to_owned()
    } else {
        "correct the TOML syntax here".to_owned()
    };
    VehicleFault {
        file: file.to_owned(),
        place: error.span().map(|span| line_and_column(text, span.start)),
        key: String::new(),
        fault: message,
        remedy,
    }
}

/// Line and column (from 1, in characters) of a byte offset.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |n| n + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

/// Finds where keys stand in a text.
pub(crate) struct Places<'t> {
    text: &'t str,
    document: Option<DeTable<'t>>,
}

impl<'t> Places<'t> {
    /// Of a text that has already been read once without error.
    pub(crate) fn of(text: &'t str) -> Self {
        Self {
            text,
            document: DeTable::parse(text).ok().map(toml::Spanned::into_inner),
        }
    }

    /// Place of `section.key`, or of its element `index`; of the section when
    /// the key is absent.
    pub(crate) fn find(
        &self,
        section: &str,
        key: &str,
        index: Option<usize>,
    ) -> Option<(usize, usize)> {
        let table = self.document.as_ref()?.get(section)?;
        let mut start = table.span().start;
        if let Some(value) = table.get_ref().as_table().and_then(|t| t.get(key)) {
            start = value.span().start;
            if let (Some(index), DeValue::Array(array)) = (index, value.get_ref())
                && let Some(element) = array.get(index)
            {
                start = element.span().start;
            }
        }
        Some(line_and_column(self.text, start))
    }
}
