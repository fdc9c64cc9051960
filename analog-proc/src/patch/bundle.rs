//! A patch from disk that cannot be read, as a fault of the patch.

use super::diagnostic::PatchFault;
use super::faults::{PatchFaults, printable};
use desk::{bundle, user_file};
use interface::control::PatchBundle;
use miette::NamedSource;
use std::path::Path;
use std::sync::Arc;

/// Reads a patch file and, through `[use]`, all files that it needs.
///
/// # Errors
/// The root file cannot be read, or one of the files is not UTF-8 text.
pub fn bundle_from_path(path: &Path) -> Result<PatchBundle, PatchFaults> {
    let name = |path: &Path| match path.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => path.display().to_string(),
    };
    bundle::bundle_from_path(path).map_err(|unreadable| {
        let file = unreadable.path.display().to_string();
        let bytes = user_file::read(&unreadable.path, user_file::LONGEST_TEXT).unwrap_or_default();
        let fault = match std::str::from_utf8(&bytes) {
            Err(error) => {
                // What can be read is shown; of a program or a picture, nothing.
                let is_text = !bytes.contains(&0);
                let text = if is_text { String::from_utf8_lossy(&bytes) } else { "".into() };
                let (file, offset) = (name(&unreadable.path), error.valid_up_to());
                let shown = if is_text { offset } else { 0 };
                PatchFault::NotUtf8 {
                    src: Arc::new(NamedSource::new(&file, printable(&text))),
                    at: (shown..shown).into(),
                    help: "name a patch, and save it as UTF-8 text".into(),
                    file,
                    offset,
                }
            }
            Ok(_) => PatchFault::MissingFile {
                src: Arc::new(NamedSource::new(&file, String::new())),
                at: (0..0).into(),
                help:
                    "check the path; it is taken from the folder in which the program was started"
                        .into(),
                file,
                why: unreadable.cause.to_string(),
            },
        };
        PatchFaults::single(&name(path), fault)
    })
}
