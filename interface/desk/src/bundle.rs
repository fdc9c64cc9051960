//! A user's patch from disk: the root file and every file that it names in `[use]`.
//!
//! Only names are read here; what the files say is checked by the analog side, which compiles
//! them and tells every fault with its line. Paths are those of the bundle: relative to the
//! root's folder, so that a bundle is the same wherever it lies.

use interface::{control::PatchBundle, user_file};
use std::path::{Path, PathBuf};

/// Files beyond this are not followed: a patch that uses itself would have no end.
const MOST_FILES: usize = 256;

/// A patch that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read the patch {}: {cause}", path.display())]
pub struct PatchUnreadable {
    /// The file.
    pub path: PathBuf,
    /// Why.
    #[source]
    pub cause: std::io::Error,
}

/// The patch at `path` with everything it uses. A used file that cannot be read is left out: the
/// analog side names the line that asks for it.
///
/// # Errors
/// When the root itself cannot be read.
pub fn bundle_from_path(path: &Path) -> Result<PatchBundle, PatchUnreadable> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let root = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let text = user_file::read_text(path)
        .map_err(|cause| PatchUnreadable { path: path.to_owned(), cause })?;
    let mut files = vec![(root.clone(), text)];
    let mut next = 0;
    while next < files.len() {
        let (user, text) = &files[next];
        next += 1;
        for name in used(text).iter().filter_map(|w| join(user, w)).collect::<Vec<_>>() {
            let known = files.iter().any(|(n, _)| *n == name);
            if !known
                && files.len() < MOST_FILES
                && let Ok(text) = user_file::read_text(&folder.join(&name))
            {
                files.push((name, text));
            }
        }
    }
    Ok(PatchBundle { root, files })
}

/// Files named under `[use]`; none when the text is no TOML.
fn used(text: &str) -> Vec<String> {
    let Ok(table) = text.parse::<toml::Table>() else {
        return Vec::new();
    };
    table
        .get("use")
        .and_then(|u| u.as_table())
        .into_iter()
        .flat_map(|u| u.values())
        .filter_map(|entry| entry.get("patch")?.as_str().map(str::to_owned))
        .collect()
}

/// `written`, as named in the file `user`, relative to the root's folder; none for absolute paths.
fn join(user: &str, written: &str) -> Option<String> {
    if written.starts_with('/') {
        return None;
    }
    let mut parts: Vec<&str> = user.split('/').collect();
    parts.pop();
    for part in written.split('/') {
        match (part, parts.last()) {
            ("" | ".", _) => {}
            ("..", Some(last)) if *last != ".." => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_brings_the_files_that_it_uses() {
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patch-files");
        let names = |root: &str| -> Vec<String> {
            let bundle = bundle_from_path(&shipped.join(root)).unwrap();
            bundle.files.into_iter().map(|(n, _)| n).collect()
        };
        assert_eq!(
            names("lab/alpha-redundant.toml"),
            ["alpha-redundant.toml", "../redundant-integrator.toml"]
        );
        assert!(names("long-period.toml").contains(&"fin-tip.toml".to_owned()));
        assert!(bundle_from_path(&shipped.join("none.toml")).is_err());
        assert_eq!(join("a.toml", "/etc/passwd"), None);
    }
}
