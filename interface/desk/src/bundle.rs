//! A user's patch from disk: the root file and every file that it names in `[use]`.
//!
//! Only names are read here; what the files say is checked by the analog side, which compiles
//! them and tells every fault with its line. Paths are those of the bundle: relative to the
//! root's folder, so that a bundle is the same wherever it lies.

use crate::user_file;
use interface::control::PatchBundle;
use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};
use toml::de::DeTable;

/// Most files of one patch; those beyond it are not followed.
pub const MOST_FILES: usize = 1000;

/// A patch that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read the patch {}: {cause}", path.display())]
pub struct PatchUnreadable {
    pub path: PathBuf,
    #[source]
    pub cause: std::io::Error,
}

/// The patch at `path` with everything it uses. A used file that cannot be read is left out: the
/// analog side names the line that asks for it.
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
            let path = folder.join(&name);
            if known || files.len() >= MOST_FILES {
                continue;
            }
            match user_file::read_text(&path) {
                Ok(text) => files.push((name, text)),
                Err(cause) if cause.kind() == ErrorKind::InvalidData => {
                    return Err(PatchUnreadable { path, cause });
                }
                Err(_) => {}
            }
        }
    }
    Ok(PatchBundle { root, files })
}

/// Files named under `[use]`, as far as the text can be read.
fn used(text: &str) -> Vec<String> {
    let (document, _) = DeTable::parse_recoverable(text);
    let uses = document.get_ref().get("use");
    uses.and_then(|uses| uses.get_ref().as_table())
        .into_iter()
        .flat_map(|table| table.values())
        .filter_map(|instance| instance.get_ref().get("patch"))
        .filter_map(|path| path.get_ref().as_str().map(str::to_owned))
        .collect()
}

/// `written`, as named in the file `user`, relative to the root's folder; none for absolute paths.
pub fn join(user: &str, written: &str) -> Option<String> {
    if written.is_empty() || written.starts_with('/') || written.contains('\0') {
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
        for (user, written, path) in [
            ("root.toml", "a.toml", Some("a.toml")),
            ("parts/a.toml", "b.toml", Some("parts/b.toml")),
            ("parts/a.toml", "../b.toml", Some("b.toml")),
            ("a.toml", "../x/./b.toml", Some("../x/b.toml")),
            ("a.toml", "/etc/passwd", None),
        ] {
            assert_eq!(join(user, written).as_deref(), path);
        }
    }
}
