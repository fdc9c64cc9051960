//! Faults of a user's file, with the place and the remedy.
//!
//! All faults that can be told apart are reported together, each with its line;
//! what the TOML reader itself refuses ends the reading and comes alone.

use interface::user_file;
use std::{fmt, ops::Range, path::Path};

/// One fault of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileFault {
    /// File as named by the caller.
    pub file: String,
    /// Line and column, counted from 1.
    pub place: Option<(usize, usize)>,
    /// What is wrong.
    pub fault: String,
    /// What to do about it.
    pub remedy: String,
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some((line, column)) = self.place {
            write!(f, ":{line}:{column}")?;
        }
        write!(f, ": {}; {}", self.fault, self.remedy)
    }
}

/// A file that was refused, with every fault found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct FileFaults(pub Vec<FileFault>);

impl From<FileFault> for FileFaults {
    fn from(fault: FileFault) -> FileFaults {
        FileFaults(vec![fault])
    }
}

impl FileFaults {
    /// `value`, unless there are faults.
    ///
    /// # Errors
    /// The faults, in the order of the file.
    pub fn unless<T>(mut faults: Vec<FileFault>, value: T) -> Result<T, FileFaults> {
        if faults.is_empty() {
            return Ok(value);
        }
        faults.sort_by_key(|fault| fault.place);
        Err(FileFaults(faults))
    }
}

/// Reads a file and hands its name and text to `parse`.
///
/// # Errors
/// A file that cannot be read, and what `parse` finds.
pub fn load<T>(
    path: &Path,
    parse: impl FnOnce(&str, &str) -> Result<T, FileFaults>,
) -> Result<T, FileFaults> {
    let file = path.display().to_string();
    let text = user_file::read_text(path).map_err(|error| FileFault {
        file: file.clone(),
        place: None,
        fault: format!("cannot be read: {error}"),
        remedy: "name a TOML file, and check its permissions".to_owned(),
    })?;
    parse(&file, &text)
}

/// A file being checked: its name and text, to turn byte offsets into lines.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// File as named by the caller.
    pub file: &'a str,
    /// Its text.
    pub text: &'a str,
}

impl Source<'_> {
    /// Reads the text as TOML.
    ///
    /// # Errors
    /// What the reader refuses, with its place.
    pub fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, FileFaults> {
        toml::from_str(self.text).map_err(|error| self.reader_fault(&error).into())
    }

    /// A fault at a byte range of the text.
    pub fn fault(
        &self,
        span: Range<usize>,
        fault: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FileFault {
        FileFault {
            file: self.file.to_owned(),
            place: Some(self.line_and_column(span.start)),
            fault: fault.into(),
            remedy: remedy.into(),
        }
    }

    /// What the TOML reader refused.
    pub fn reader_fault(&self, error: &toml::de::Error) -> FileFault {
        let message = error.message().trim().replace('\n', " ");
        let mut quoted = message.split('`').skip(1).step_by(2);
        let remedy =
            if message.starts_with("unknown field") || message.starts_with("unknown variant") {
                let unknown = quoted.next().unwrap_or_default();
                suggestion(unknown, quoted)
            } else if message.starts_with("missing field") {
                "add the key".to_owned()
            } else if message.starts_with("invalid type") {
                "give a value of the expected type".to_owned()
            } else {
                "correct it here".to_owned()
            };
        FileFault {
            file: self.file.to_owned(),
            place: error.span().map(|span| self.line_and_column(span.start)),
            fault: message,
            remedy,
        }
    }

    /// Line and column, counted from 1 in characters, of a byte.
    pub fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |n| n + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// "did you mean `x`?" with the nearest of the known names, or all of them if none is near.
pub fn suggestion<'a>(unknown: &str, known: impl Iterator<Item = &'a str>) -> String {
    // Below this similarity a suggestion misleads more often than it helps.
    const SIMILAR: f64 = 0.7;
    let known: Vec<&str> = known.collect();
    let nearest = known
        .iter()
        .map(|name| (strsim::jaro_winkler(unknown, name), *name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((similarity, name)) if similarity > SIMILAR => format!("did you mean `{name}`?"),
        Some(_) => format!("known are {}", known.join(", ")),
        None => "there is none to name".to_owned(),
    }
}
