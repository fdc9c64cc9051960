//! A run's results on one screen, and the same for machines.

use serde_json::{Map, Value};

use super::format::significant;
use super::table::{Cell, Heading, Table};

/// Named results in the order in which they are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key: String,
    label: String,
    value: f64,
    digits: usize,
    unit: String,
    note: String,
}

impl Summary {
    pub fn new() -> Summary {
        Summary::default()
    }

    /// Adds a result: `key` is its name for machines and carries the unit
    /// (`max_q_kpa`), `label` its name for people, `note` a remark (`at 32.1 s`).
    pub fn add(
        &mut self,
        key: &str,
        label: &str,
        value: f64,
        digits: usize,
        unit: &str,
        note: impl Into<String>,
    ) {
        self.entries.push(Entry {
            key: key.to_owned(),
            label: label.to_owned(),
            value,
            digits,
            unit: unit.to_owned(),
            note: note.into(),
        });
    }

    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Aligned lines for a terminal.
    pub fn text(&self) -> String {
        let numbers: Vec<String> =
            self.entries.iter().map(|entry| significant(entry.value, entry.digits)).collect();
        let width = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
        let labels = width(&mut self.entries.iter().map(|e| e.label.chars().count()));
        let values = width(&mut numbers.iter().map(String::len));
        let units = width(&mut self.entries.iter().map(|e| e.unit.chars().count()));
        let mut out = String::new();
        for (entry, number) in self.entries.iter().zip(&numbers) {
            let line = format!(
                "  {:labels$}  {number:>values$} {:units$}  {}",
                entry.label, entry.unit, entry.note
            );
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out
    }

    /// An object of full-precision numbers by key; not finite becomes null.
    pub fn json(&self) -> Value {
        let entries = self.entries.iter().map(|e| (e.key.clone(), Value::from(e.value)));
        Value::Object(entries.collect::<Map<_, _>>())
    }

    /// A table for a page.
    pub fn table(&self) -> Table {
        let mut table = Table::new(
            ["Result", "Value", "Unit", ""].map(|label| Heading::new(label, "")).to_vec(),
        );
        for entry in &self.entries {
            table.row([
                entry.label.as_str().into(),
                Cell::Text(super::format::typeset(entry.value, entry.digits)),
                entry.unit.as_str().into(),
                entry.note.as_str().into(),
            ]);
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_aligned_and_json_is_exact() {
        let mut summary = Summary::new();
        summary.add("max_q_kpa", "Maximum dynamic pressure", 94.871_234, 4, "kPa", "at 32.1 s");
        summary.add("range_km", "Range", 8.1, 2, "km", "");
        assert_eq!(
            summary.text(),
            "  Maximum dynamic pressure  94.87 kPa  at 32.1 s\n  Range                       8.1 km\n"
        );
        assert_eq!(summary.json()["max_q_kpa"], 94.871_234);
    }
}
