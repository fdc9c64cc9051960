//! Where a report's numbers come from: the run's record as a list.

use maud::Markup;

use super::definition_list;
use crate::run_dir::RunRecord;

/// The record's entries, nested parameters with dotted names.
pub fn provenance(record: &RunRecord) -> Markup {
    let mut items = vec![
        ("Command".to_owned(), record.command_line.join(" ")),
        ("Started".to_owned(), record.started.clone()),
        ("Machine profile".to_owned(), record.profile.clone()),
        ("Link".to_owned(), record.link.clone()),
    ];
    if let Some(patch) = &record.patch {
        items.push(("Patch".to_owned(), format!("{}, SHA-256 {}", patch.name, patch.sha256)));
    }
    for (name, version) in &record.versions {
        items.push((format!("Version of {name}"), version.clone()));
    }
    for (name, seed) in &record.seeds {
        items.push((format!("Seed of {name}"), seed.to_string()));
    }
    flatten("", &record.parameters, &mut items);
    definition_list(&items)
}

fn flatten(prefix: &str, table: &toml::Table, items: &mut Vec<(String, String)>) {
    for (key, value) in table {
        let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) => flatten(&name, inner, items),
            toml::Value::String(text) => items.push((name, text.clone())),
            other => items.push((name, other.to_string())),
        }
    }
}
