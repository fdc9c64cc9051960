//! Loading a patch with every file that it uses.
//!
//! The only part of the patch language that reads the file system. A sub-patch
//! that cannot be read is left out here: the compiler then reports it at the
//! line that names it, together with the other faults.

use super::diagnostic::PatchFault;
use super::faults::PatchFaults;
use super::text::used_paths;
use interface::{control::PatchBundle, user_file};
use miette::NamedSource;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Longest patch file, bytes. The largest sensible patch is a hundredth of it.
pub const LONGEST_FILE: u64 = user_file::LONGEST_TEXT;
/// Most files of one patch.
pub const MOST_FILES: usize = 1000;

/// Reads a patch file and, through `[use]`, all files that it needs.
///
/// # Errors
/// The root file cannot be read, or one of the files is not UTF-8 text.
pub fn bundle_from_path(path: &Path) -> Result<PatchBundle, PatchFaults> {
    let root =
        path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into());
    let folder = path.parent().map(PathBuf::from).unwrap_or_default();
    let mut bundle = PatchBundle { root: root.clone(), files: Vec::new() };
    let mut waiting = vec![root.clone()];
    while let Some(name) = waiting.pop() {
        if bundle.files.iter().any(|(known, _)| *known == name) || bundle.files.len() >= MOST_FILES
        {
            continue;
        }
        let at = if name == root { path.to_owned() } else { folder.join(&name) };
        let bytes = match user_file::read(&at, LONGEST_FILE) {
            Ok(bytes) => bytes,
            Err(why) if name == root => return Err(unreadable(&root, &at, why.to_string())),
            Err(_) => continue,
        };
        let text = String::from_utf8(bytes).map_err(|error| not_utf8(&root, &name, &error))?;
        let mut used: Vec<String> =
            used_paths(&text).iter().filter_map(|used| join(&name, used)).collect();
        used.reverse();
        waiting.append(&mut used);
        bundle.files.push((name, text));
    }
    Ok(bundle)
}

/// Path of a used file relative to the root's folder, from the file that names it and what it writes.
/// Absolute paths have none: a bundle is the same on every machine.
pub(crate) fn join(user: &str, written: &str) -> Option<String> {
    if written.is_empty() || written.starts_with('/') || written.contains('\0') {
        return None;
    }
    let mut parts: Vec<&str> = user.split('/').collect();
    parts.pop();
    for part in written.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

fn unreadable(root: &str, path: &Path, why: String) -> PatchFaults {
    let file = path.display().to_string();
    PatchFaults::single(
        root,
        PatchFault::MissingFile {
            src: Arc::new(NamedSource::new(&file, String::new())),
            at: (0..0).into(),
            help: "check the path; it is taken from the folder in which the program was started"
                .into(),
            file,
            why,
        },
    )
}

fn not_utf8(root: &str, name: &str, error: &std::string::FromUtf8Error) -> PatchFaults {
    let offset = error.utf8_error().valid_up_to();
    // What can be read is shown, with the offending byte marked by U+FFFD.
    let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
    PatchFaults::single(
        root,
        PatchFault::NotUtf8 {
            src: Arc::new(NamedSource::new(name, text)),
            at: (offset..offset).into(),
            help: "save the file as UTF-8 text".into(),
            file: name.to_owned(),
            offset,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_file_that_names_them() {
        assert_eq!(join("root.toml", "a.toml").unwrap(), "a.toml");
        assert_eq!(join("parts/a.toml", "b.toml").unwrap(), "parts/b.toml");
        assert_eq!(join("parts/a.toml", "../b.toml").unwrap(), "b.toml");
        assert_eq!(join("a.toml", "../x/./b.toml").unwrap(), "../x/b.toml");
        assert_eq!(join("a.toml", "/etc/passwd"), None);
    }
}
