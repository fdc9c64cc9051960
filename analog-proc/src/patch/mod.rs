//! The patch language: from files to a net that can run.
//!
//! Stages: text → net → ordered. Each goes on as far as the faults of
//! the one before allow, so that one run shows every fault; but only a patch
//! without any becomes [`Ordered`].

mod bundle;
pub mod diagnostic;
mod expression;
mod faults;
mod fields;
mod number;
mod resolve;
mod scope;
mod settings;
mod text;

pub use bundle::bundle_from_path;
pub(crate) use diagnostic::Flaw;
pub use diagnostic::PatchFault;
pub use faults::{PatchFaults, Sources};
pub use scope::{DEEPEST, MOST_BLOCKS};

pub(crate) use faults::Faults;
pub(crate) use fields::Fields;
pub(crate) use resolve::Draft;

use crate::check;
use crate::net::Span;
use crate::order::{self, Ordered};
use desk::bundle::{MOST_FILES, join};
use interface::control::PatchBundle;
use std::collections::HashMap;

/// Compiles a patch. `params` override entries of the root's `[params]`.
pub fn compile(bundle: &PatchBundle, params: &[(String, f64)]) -> Result<Ordered, PatchFaults> {
    let sources = Sources::new(bundle);
    let mut faults = Faults::new(sources.clone(), &bundle.root);
    let mut names: HashMap<&str, u32> = HashMap::new();
    for (index, (name, _)) in bundle.files.iter().take(MOST_FILES).enumerate() {
        names.entry(name.as_str()).or_insert(u32::try_from(index).unwrap_or(u32::MAX));
    }
    let Some(&root) = names.get(bundle.root.as_str()) else {
        let (file, why) = (bundle.root.clone(), "the bundle does not hold it".into());
        let help = "a bundle names its root file and holds it";
        faults.push(Span::default(), Flaw::MissingFile { file, why }, help);
        return Err(faults.into_faults());
    };
    let texts = parse_reachable(bundle, &names, root, &mut faults);
    if texts.iter().any(|text| !text.is_toml) {
        return Err(faults.into_faults());
    }
    let Some(draft) = resolve::resolve(&names, &texts, root, params, &mut faults) else {
        return Err(faults.into_faults());
    };
    check::check(&draft, &mut faults);
    order::order(draft, faults)
}

/// Reads the root and all files that it reaches; the others stay empty.
fn parse_reachable(
    bundle: &PatchBundle,
    names: &HashMap<&str, u32>,
    root: u32,
    faults: &mut Faults,
) -> Vec<text::PatchText> {
    let empty = text::PatchText { is_toml: true, ..text::PatchText::default() };
    let mut texts = vec![empty; bundle.files.len()];
    let mut is_read = vec![false; bundle.files.len()];
    let mut waiting = vec![root];
    while let Some(file) = waiting.pop() {
        let index = file as usize;
        if std::mem::replace(&mut is_read[index], true) {
            continue;
        }
        let (name, content) = &bundle.files[index];
        texts[index] = text::parse(file, content, faults);
        for instance in &texts[index].uses {
            let path = instance.path.as_ref();
            let key = path.and_then(|(path, _)| join(name, path));
            waiting.extend(key.and_then(|key| names.get(key.as_str()).copied()));
        }
    }
    texts
}
