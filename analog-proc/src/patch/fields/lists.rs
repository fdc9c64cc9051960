//! Fields that hold lists: pairs, breakpoints, ordinates, rows of a table.

use super::Fields;
use crate::patch::diagnostic::PatchFault;
use crate::patch::number::wrong_type;
use crate::patch::value::{Data, Entry, Value};

impl<'r> Fields<'r, '_> {
    fn list(&mut self, key: &'static str, entry: &'r Entry) -> Option<&'r [Value]> {
        match &entry.value.data {
            Data::List(items) => Some(items),
            _ => {
                wrong_type(key, "a list", &entry.value, self.resolver.faults);
                None
            }
        }
    }

    fn numbers_of(&mut self, key: &str, items: &[Value]) -> Option<Vec<f64>> {
        // Read all before giving up.
        let read: Vec<Option<f64>> =
            items.iter().map(|item| self.resolver.number(self.scope, key, item)).collect();
        read.into_iter().collect()
    }

    /// A list of numbers, or nothing where it is left out.
    pub(crate) fn numbers_or_none(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.entry(key)?;
        let items = self.list(key, entry)?;
        self.numbers_of(key, items)
    }

    /// A list of numbers.
    pub(crate) fn numbers(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.required(key, "[0.0, 1.0]")?;
        let items = self.list(key, entry)?;
        self.numbers_of(key, items)
    }

    /// A pair `[low, high]`; `None` inside where it is left out.
    pub(crate) fn pair_or_none(&mut self, key: &'static str) -> Option<Option<[f64; 2]>> {
        if self.place(key).is_none() {
            self.asked.push(key);
            return Some(None);
        }
        self.pair(key).map(Some)
    }

    /// A pair `[low, high]`.
    pub(crate) fn pair(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let list = self.numbers(key)?;
        if let [low, high] = list[..] {
            return Some([low, high]);
        }
        self.table_size(key, list.len(), "2 (low and high)".into());
        None
    }

    pub(crate) fn table_size(&mut self, key: &str, found: usize, wanted: String) {
        let field = key.to_owned();
        self.fault_at(key, |src, at| PatchFault::TableSize {
            src,
            at,
            field,
            found,
            help: format!("make it {wanted}"),
            wanted,
        });
    }

    /// Breakpoints: at least two, increasing.
    pub(crate) fn breakpoints(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let entry = self.required(key, "[0.0, 1.0]")?;
        let items = self.list(key, entry)?;
        let values = self.numbers_of(key, items)?;
        if values.len() < 2 {
            self.table_size(key, values.len(), "at least 2".into());
            return None;
        }
        for (pair, item) in values.windows(2).zip(&items[1..]) {
            if pair[1] <= pair[0] {
                self.resolver.faults.push(item.span, |src, at| PatchFault::Breakpoints {
                    src,
                    at,
                    field: key.to_owned(),
                    value: pair[1],
                    previous: pair[0],
                    help: "sort the breakpoints; a step needs two that lie close together".into(),
                });
                return None;
            }
        }
        Some(values)
    }

    /// Rows of numbers, each of `columns`; row-major.
    pub(crate) fn grid(
        &mut self,
        key: &'static str,
        size: Option<(usize, usize)>,
    ) -> Option<Vec<f64>> {
        let entry = self.required(key, "[[0.0, 0.0], [0.0, 0.0]]")?;
        let rows = self.list(key, entry)?;
        let mut all = Vec::new();
        let mut is_whole = true;
        for row in rows {
            let values = match &row.data {
                Data::List(items) => self.numbers_of(key, items),
                _ => {
                    wrong_type(key, "a list of rows, one for each x", row, self.resolver.faults);
                    None
                }
            };
            let Some(values) = values else {
                is_whole = false;
                continue;
            };
            if let Some((_, columns)) = size.filter(|(_, columns)| *columns != values.len()) {
                is_whole = false;
                let found = values.len();
                self.resolver.faults.push(row.span, |src, at| PatchFault::TableSize {
                    src,
                    at,
                    field: key.to_owned(),
                    found,
                    wanted: format!("{columns} (one for each y)"),
                    help: "a row holds the values at one x, in order of y".into(),
                });
            }
            all.extend(values);
        }
        let (wanted, _) = size?;
        if rows.len() != wanted {
            self.table_size(key, rows.len(), format!("{wanted} rows (one for each x)"));
            return None;
        }
        is_whole.then_some(all)
    }
}
