//! The runs under a base directory, and which of them a user means.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::faults::nearest;

use super::{RECORD_FILE, RunDirError, RunDirectory, SUMMARY_FILE, holds_record};

/// How far a run got, told by the files that it left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunState {
    /// It wrote its summary.
    Complete,
    /// It is still going, or was cut off.
    Unfinished,
    /// Its record cannot be read.
    Unreadable,
}

/// One line of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunEntry {
    pub name: String,
    pub path: PathBuf,
    /// The command, or what is wrong with the record.
    pub command: String,
    /// When it started; empty when the record cannot be read.
    pub started: String,
    pub state: RunState,
}

/// The runs under `base`, oldest first (names begin with the time). No base: no runs.
/// Directories without `run.toml` are passed over.
pub fn list_runs(base: &Path) -> Result<Vec<RunEntry>, RunDirError> {
    Ok(names(base)?
        .into_iter()
        .map(|name| {
            let path = base.join(&name);
            let whole = if path.join(SUMMARY_FILE).is_file() {
                RunState::Complete
            } else {
                RunState::Unfinished
            };
            let record = RunDirectory::open(&path).and_then(|run| run.read_record());
            let (command, started, state) = match record {
                Ok(record) => (record.command, record.started, whole),
                Err(error) => {
                    (format!("({error})").replace('\n', " "), String::new(), RunState::Unreadable)
                }
            };
            RunEntry { name, path, command, started, state }
        })
        .collect())
}

/// The run that `text` names: a path, a name under `base`, `last`, or the beginning of exactly
/// one name, up to a whole part of it. A namesake's number is no continuation: `X` may be the
/// whole name of a run that is gone, and never means `X-2`.
pub fn resolve(base: &Path, text: &str) -> Result<RunDirectory, RunDirError> {
    let as_path = Path::new(text);
    if as_path.components().count() > 1 || as_path.is_absolute() {
        return RunDirectory::open(as_path);
    }
    let names = names(base)?;
    if names.iter().any(|name| name == text) {
        return RunDirectory::open(&base.join(text));
    }
    if as_path.join(RECORD_FILE).is_file() {
        return RunDirectory::open(as_path);
    }
    if text == "last"
        && let Some(name) = names.last()
    {
        return RunDirectory::open(&base.join(name));
    }
    let candidates: Vec<&String> =
        names.iter().filter(|name| !text.is_empty() && begins(name, text)).collect();
    match candidates.as_slice() {
        [one] => RunDirectory::open(&base.join(one)),
        [] => {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let near = nearest(text, &names).map(|name| format!(", did you mean `{name}`?"));
            Err(RunDirError::Refused(format!(
                "no run `{text}` in `{}`{}; `digital-proc list` shows the runs",
                base.display(),
                near.unwrap_or_default()
            )))
        }
        several => {
            let few: Vec<&str> = several.iter().take(6).map(|name| name.as_str()).collect();
            let few = few.join(", ");
            Err(RunDirError::Refused(format!(
                "`{text}` may be any of {few}; give more of the name"
            )))
        }
    }
}

/// Whether `text` is the beginning of `name` up to a whole part of it: the time or a part of it,
/// the command, a word of the command; not all but the number of a namesake.
fn begins(name: &str, text: &str) -> bool {
    let Some(rest) = name.strip_prefix(text) else {
        return false;
    };
    let whole = rest.is_empty() || text.ends_with(['-', 'T']) || rest.starts_with(['-', 'T']);
    let number = rest.strip_prefix('-').unwrap_or(rest);
    whole && !(text.len() >= TIME.len() && number.bytes().all(|b| b.is_ascii_digit()))
}

/// Form of the time with which every name begins.
const TIME: &str = "0000-00-00T00-00-00";

/// Names of the run directories under `base`, oldest first.
fn names(base: &Path) -> Result<Vec<String>, RunDirError> {
    let fail = RunDirError::read(base);
    let entries = match fs::read_dir(base) {
        Ok(entries) => entries,
        Err(cause) if cause.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(cause) => return Err(fail(cause)),
    };
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(&fail)?;
        // What cannot be looked into may be a run: it is listed with the reason.
        if holds_record(&entry.path()).unwrap_or(true) {
            let made = entry.metadata().and_then(|about| about.created()).ok();
            names.push((entry.file_name().to_string_lossy().into_owned(), made));
        }
    }
    // Runs of two commands in one second: the one whose directory was made first.
    let second = |name: &str| name.get(..TIME.len()).unwrap_or(name).to_owned();
    names.sort_by_key(|(name, made)| (second(name), *made, chronological(name)));
    Ok(names.into_iter().map(|(name, _)| name).collect())
}

/// Sorting key: the name with a trailing serial number set apart, so that `-10` follows `-9`.
fn chronological(name: &str) -> (String, u64) {
    match name.rsplit_once('-') {
        Some((stem, serial)) if stem.len() > TIME.len() => match serial.parse() {
            Ok(serial) => (stem.to_owned(), serial),
            Err(_) => (name.to_owned(), 1),
        },
        _ => (name.to_owned(), 1),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RunDirectory, RunRecord, UtcSecond};
    use super::*;

    fn sample() -> RunRecord {
        RunRecord::begin("fly normal", UtcSecond(0), "ideal", "shm")
    }

    fn base_with(commands: &[(&str, i64)]) -> tempfile::TempDir {
        let base = tempfile::tempdir().unwrap();
        for (command, second) in commands {
            let run = RunDirectory::create(base.path(), command, UtcSecond(*second)).unwrap();
            run.write_record(&sample()).unwrap();
        }
        base
    }

    #[test]
    fn runs_are_listed_in_order_with_their_state() {
        let mut runs = vec![("circle", 5)];
        runs.extend(std::iter::repeat_n(("fly", 86_400), 11));
        let base = base_with(&runs);
        std::fs::create_dir(base.path().join("not-a-run")).unwrap();
        let last = resolve(base.path(), "last").unwrap();
        last.write_summary(&1).unwrap();
        let list = list_runs(base.path()).unwrap();
        assert_eq!(list.len(), 12);
        assert_eq!(list[0].name, "1970-01-01T00-00-05-circle");
        assert_eq!(list[11].name, "1970-01-02T00-00-00-fly-11");
        assert_eq!(list[11].state, RunState::Complete);
        assert_eq!(list[10].state, RunState::Unfinished);
        assert!(list_runs(Path::new("/nonexistent/runs")).unwrap().is_empty());
    }

    /// A record that leads nowhere stands for one that the system does not let be read, which
    /// cannot be made where tests run as the administrator.
    #[test]
    fn a_run_that_cannot_be_read_is_listed_with_the_reason() {
        let base = base_with(&[("fly", 0)]);
        let run = base.path().join("1970-01-01T00-00-01-fly");
        std::fs::create_dir(&run).unwrap();
        std::os::unix::fs::symlink("run.toml", run.join("run.toml")).unwrap();
        let list = list_runs(base.path()).unwrap();
        assert_eq!(list[0].state, RunState::Unfinished);
        assert_eq!(list[1].state, RunState::Unreadable);
        assert!(list[1].command.contains("cannot read"), "{list:?}");
        let error = resolve(base.path(), "1970-01-01T00-00-01-fly").unwrap_err();
        assert!(matches!(error, RunDirError::Read { .. }), "{error}");
    }

    #[test]
    fn a_run_is_found_by_name_path_or_unique_prefix() {
        let base = base_with(&[("fly", 0), ("fly", 0), ("root", 60)]);
        let path = base.path().join("1970-01-01T00-01-00-root");
        for text in ["1970-01-01T00-01-00-root", "1970-01-01T00-01", path.to_str().unwrap()] {
            assert_eq!(resolve(base.path(), text).unwrap().path(), path);
        }
        // The full name of a run that is gone is no other run, and no part is cut in a word.
        let gone = RunDirectory::create(base.path(), "budget", UtcSecond(90)).unwrap();
        let again = RunDirectory::create(base.path(), "budget", UtcSecond(90)).unwrap();
        again.write_record(&sample()).unwrap();
        std::fs::remove_dir_all(gone.path()).unwrap();
        for text in [
            "1970-01-01T00-01-30-budget",
            "1970-01-01T00-01-30-budget-",
            "1970-01-01T00-01-30-bud",
            "1970-01-01T00-01-3",
        ] {
            let error = resolve(base.path(), text).unwrap_err();
            assert!(error.to_string().starts_with("no run"), "{error}");
        }
        assert_eq!(resolve(base.path(), "1970-01-01T00-01-30").unwrap().name(), again.name());
        std::fs::remove_dir_all(again.path()).unwrap();
        // A name that is also a prefix of another is itself.
        let exact = resolve(base.path(), "1970-01-01T00-00-00-fly").unwrap();
        assert_eq!(exact.name(), "1970-01-01T00-00-00-fly");
        let error = resolve(base.path(), "1970").unwrap_err().to_string();
        assert_eq!(error.matches("1970-01-01T").count(), 3, "{error}");
        let error = resolve(base.path(), "1970-01-01T00-01-00-rot").unwrap_err();
        assert!(error.to_string().contains("did you mean `1970-01-01T00-01-00-root`"));
        let error = resolve(base.path(), "./nowhere").unwrap_err().to_string();
        assert!(error.contains("not a run directory"), "{error}");
        assert!(resolve(base.path(), "").is_err());
    }
}
