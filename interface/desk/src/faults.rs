//! Faults of a user's file, with the place and the remedy.
//!
//! All that can be told apart are reported together; what is no TOML ends the reading.

use crate::reader::Span;
use serde::{Serialize, Serializer};
use std::fmt;

/// More faults than anyone reads at once; the rest are counted.
pub const MOST_FAULTS: usize = 200;

/// One fault of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileFault {
    /// Kind of fault, where kinds have names (`unknown-net`).
    pub code: Option<&'static str>,
    /// File as named by the caller.
    pub file: String,
    /// Line and column, counted from 1 in characters.
    #[serde(flatten, serialize_with = "line_and_column")]
    pub place: Option<(usize, usize)>,
    pub fault: String,
    pub remedy: String,
}

fn line_and_column<S: Serializer>(
    place: &Option<(usize, usize)>,
    to: S,
) -> Result<S::Ok, S::Error> {
    let (line, column) = place.unzip();
    to.collect_map([("line", line), ("column", column)])
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
    pub fn unless<T>(mut faults: Vec<FileFault>, value: T) -> Result<T, FileFaults> {
        if faults.is_empty() {
            return Ok(value);
        }
        faults.sort_by_key(|fault| fault.place);
        Err(FileFaults(faults))
    }
}

/// A file being checked: its name and text, to turn byte offsets into lines.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// File as named by the caller.
    pub file: &'a str,
    pub text: &'a str,
}

impl Source<'_> {
    /// Reads a text that the program wrote, as TOML.
    pub fn parse<T: serde::de::DeserializeOwned>(&self) -> Result<T, FileFaults> {
        toml::from_str(self.text).map_err(|error| {
            let place = error.span().map(|span| self.line_and_column(span.start));
            let fault = error.message().trim().replace('\n', " ");
            FileFault { place, ..self.whole(fault, "correct it here") }.into()
        })
    }

    /// A fault at a place in the text.
    pub fn fault(
        &self,
        at: Span,
        fault: impl Into<String>,
        remedy: impl Into<String>,
    ) -> FileFault {
        let place = Some(self.line_and_column(at.start as usize));
        FileFault { place, ..self.whole(fault, remedy) }
    }

    pub fn whole(&self, fault: impl Into<String>, remedy: impl Into<String>) -> FileFault {
        let file = self.file.to_owned();
        FileFault { code: None, file, place: None, fault: fault.into(), remedy: remedy.into() }
    }

    /// Line and column, counted from 1 in characters, of a byte.
    pub fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |n| n + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// "did you mean `x`?" with the nearest of the known names, or the first of them if none is near.
pub fn suggestion<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    const LISTED: usize = 40;
    let mut known: Vec<&str> = known.into_iter().collect();
    match nearest(unknown, &known) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => "there is none to name".to_owned(),
        None => {
            let more = if known.len() > LISTED { ", …" } else { "" };
            known.truncate(LISTED);
            format!("known are {}{more}", known.join(", "))
        }
    }
}

/// The name that was meant: the one that differs in its capitals alone, or else the one with the
/// fewest letters wrong, no more than a third of them.
pub(crate) fn nearest<'a>(unknown: &str, known: &[&'a str]) -> Option<&'a str> {
    let length = unknown.chars().count();
    let most = (length / 3).clamp(1, 4).min(length.saturating_sub(1));
    let small = unknown.to_lowercase();
    known
        .iter()
        .filter(|name| name.len().abs_diff(unknown.len()) <= 4 && name.len() < 200)
        .map(|name| (strsim::damerau_levenshtein(&small, &name.to_lowercase()), *name))
        .filter(|(distance, _)| *distance <= most)
        .min()
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_the_one_that_was_meant() {
        for (unknown, known, said) in [
            ("velocty", vec!["x", "velocity"], "did you mean `velocity`?"),
            ("Y", vec!["x", "y"], "did you mean `y`?"),
            ("q", vec!["x", "y"], "known are x, y"),
            ("max-Q", vec!["max-p", "max-q"], "did you mean `max-q`?"),
            ("a", vec![], "there is none to name"),
        ] {
            assert_eq!(suggestion(unknown, known), said);
        }
    }
}
