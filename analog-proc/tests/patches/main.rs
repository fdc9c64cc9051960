//! Patches as texts: the shipped ones, the bad ones, any; and their drawings.
#![allow(clippy::unwrap_used)]

mod bad;
mod drawings;
mod properties;
mod shipped;

use analog_proc::{
    order::Ordered,
    patch::{PatchFaults, compile},
};
use interface::control::PatchBundle;
use std::path::{Path, PathBuf};

/// A shipped file or folder.
fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../patch-files").join(name)
}

/// The TOML files of a shipped folder.
fn files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(shipped(folder)).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> =
        paths.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    paths.sort();
    paths
}

fn bundle(text: &str) -> PatchBundle {
    PatchBundle { root: "p.toml".into(), files: vec![("p.toml".into(), text.into())] }
}

fn sound(compiled: Result<Ordered, PatchFaults>) -> Ordered {
    compiled.unwrap_or_else(|faults| panic!("{}", faults.render()))
}

fn faults(text: &str) -> PatchFaults {
    compile(&bundle(text), &[]).unwrap_err()
}
