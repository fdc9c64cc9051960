//! Every patch that is shipped compiles, and says in its first line what to see.

use crate::{files, sound};
use analog_proc::patch::{bundle_from_path, compile};

/// A sub-patch needs a user: each of its ports is bound to a constant.
fn wrapped(name: &str, ports: &[String]) -> String {
    let bindings: Vec<String> = ports.iter().map(|p| format!("{p} = \"zero\"")).collect();
    format!(
        "[use]\nu = {{ patch = \"{name}\", in = {{ {} }} }}\n[blocks]\nzero = {{ kind = \"constant\", value = 0.0 }}\n",
        bindings.join(", ")
    )
}

#[test]
fn every_shipped_patch_compiles() {
    let paths = files("");
    assert!(paths.len() >= 14, "patch files are missing: {paths:?}");
    for path in paths {
        let mut bundle = bundle_from_path(&path).unwrap_or_else(|e| panic!("{}", e.render()));
        let table: toml::Table = bundle.files[0].1.parse().unwrap();
        if let Some(ports) = table.get("ports") {
            let ports: Vec<String> = ports["in"].clone().try_into().unwrap();
            let text = wrapped(&bundle.root, &ports);
            bundle.root = "wrapper.toml".into();
            bundle.files.push((bundle.root.clone(), text));
        }
        let ordered = sound(compile(&bundle, &[]));
        assert_eq!(ordered.order.len(), ordered.netlist.blocks.len());
    }
}

#[test]
fn every_shipped_patch_says_what_to_see() {
    for path in files("") {
        let text = std::fs::read_to_string(&path).unwrap();
        let comment: Vec<&str> = text.lines().take_while(|l| l.starts_with('#')).collect();
        assert!(comment.len() >= 2, "{} begins without comment", path.display());
        assert!(text.contains("\ntitle = "), "{} has no title", path.display());
    }
}
