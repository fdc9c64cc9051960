//! A patch from disk that cannot be read, as a fault of the patch.

use super::diagnostic::{Flaw, PatchFault};
use super::faults::{PatchFaults, printable};
use desk::{bundle, user_file};
use interface::control::PatchBundle;
use miette::NamedSource;
use std::path::Path;
use std::sync::Arc;

/// Reads a patch file and, through `[use]`, all files that it needs.
pub fn bundle_from_path(path: &Path) -> Result<PatchBundle, PatchFaults> {
    let name = |path: &Path| match path.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => path.display().to_string(),
    };
    bundle::bundle_from_path(path).map_err(|unreadable| {
        let root = name(path);
        let file = unreadable.path.display().to_string();
        let bytes = user_file::read(&unreadable.path, user_file::LONGEST_TEXT).unwrap_or_default();
        let (name, text, shown, flaw, help) = match std::str::from_utf8(&bytes) {
            Err(error) => {
                // What can be read is shown; of a program or a picture, nothing.
                let is_text = !bytes.contains(&0);
                let text = if is_text {
                    printable(&String::from_utf8_lossy(&bytes))
                } else {
                    String::new()
                };
                let (file, offset) = (name(&unreadable.path), error.valid_up_to());
                let shown = if is_text { offset } else { 0 };
                let help = "name a patch, and save it as UTF-8 text";
                (file.clone(), text, shown, Flaw::NotUtf8 { file, offset }, help)
            }
            Ok(_) => {
                let help =
                    "check the path; it is taken from the folder in which the program was started";
                let why = unreadable.cause.to_string();
                (file.clone(), String::new(), 0, Flaw::MissingFile { file, why }, help)
            }
        };
        let (src, at) = (Arc::new(NamedSource::new(name, text)), (shown..shown).into());
        let fault = PatchFault { src, at, flaw, help: help.to_owned(), beside: Vec::new() };
        PatchFaults::single(&root, fault)
    })
}
