//! Fields that hold lists: numbers, pairs, breakpoints and their ordinates, rows of a table.

use super::{Board, Data, Fault, Fields, Range, Value};

impl<'r, B: Board> Fields<'r, B> {
    /// The items of a list, which must be there.
    pub fn list(&mut self, key: &'static str, example: &str) -> Option<&'r [Value]> {
        let entry = self.required(key, example)?;
        self.items(key, &entry.value, "a list")
    }

    fn items<'v>(
        &mut self,
        key: &str,
        value: &'v Value,
        what: &'static str,
    ) -> Option<&'v [Value]> {
        if let Data::List(items) = &value.data {
            return Some(items);
        }
        self.board.wrong_type(&self.name(key), what, value);
        None
    }

    /// The numbers of a list within a list.
    pub fn row(&mut self, key: &str, value: &Value) -> Option<Vec<f64>> {
        let items = self.items(key, value, "a list of numbers")?;
        self.numbers_of(key, items)
    }

    fn numbers_of(&mut self, key: &str, items: &[Value]) -> Option<Vec<f64>> {
        let field = self.name(key);
        // Read all before giving up.
        let read: Vec<_> = items.iter().map(|item| self.board.number(&field, item)).collect();
        read.into_iter().collect()
    }

    /// A list of numbers.
    pub fn numbers(&mut self, key: &'static str) -> Option<Vec<f64>> {
        let items = self.list(key, "[0.0, 1.0]")?;
        self.numbers_of(key, items)
    }

    /// A list of numbers, each in a range.
    pub fn numbers_in(&mut self, key: &'static str, range: Range) -> Option<Vec<f64>> {
        self.each(key, "[0.0, 1.0]", |f, key, item| f.number_at(key, item, range))
    }

    /// What `read` makes of each item of a list; all are read before it gives up.
    pub fn each<T>(
        &mut self,
        key: &'static str,
        example: &str,
        mut read: impl FnMut(&mut Self, &str, &Value) -> Option<T>,
    ) -> Option<Vec<T>> {
        let items = self.list(key, example)?;
        let read: Vec<_> = items.iter().map(|item| read(self, key, item)).collect();
        read.into_iter().collect()
    }

    /// A pair `[low, high]`; `None` inside where it is left out.
    pub fn pair_or_none(&mut self, key: &'static str) -> Option<Option<[f64; 2]>> {
        if self.entry(key).is_none() {
            return Some(None);
        }
        self.pair(key).map(Some)
    }

    /// A pair `[low, high]`.
    pub fn pair(&mut self, key: &'static str) -> Option<[f64; 2]> {
        let list = self.numbers(key)?;
        if let [low, high] = list[..] {
            return Some([low, high]);
        }
        self.table_size(key, list.len(), "2 (low and high)".into());
        None
    }

    /// Tells that a list has too few or too many entries.
    pub fn table_size(&mut self, key: &str, found: usize, wanted: String) {
        let help = format!("make it {wanted}");
        self.tell(key, Fault::TableSize { field: self.name(key), found, wanted }, help);
    }

    /// Breakpoints: at least two, increasing.
    pub fn breakpoints(&mut self, key: &'static str) -> Option<Vec<f64>> {
        self.increasing(key, 2)
    }

    /// At least so many increasing numbers.
    pub fn increasing(&mut self, key: &'static str, least: usize) -> Option<Vec<f64>> {
        let items = self.list(key, "[0.0, 1.0]")?;
        let values = self.numbers_of(key, items)?;
        if values.len() < least {
            self.table_size(key, values.len(), format!("at least {least}"));
            return None;
        }
        for (pair, item) in values.windows(2).zip(items.iter().skip(1)) {
            if pair[1] <= pair[0] {
                let (previous, value) = (pair[0], pair[1]);
                let fault = Fault::Breakpoints { field: self.name(key), value, previous };
                let help = "sort the breakpoints; a step needs two that lie close together";
                self.board.tell(item.span, fault, help.into());
                return None;
            }
        }
        Some(values)
    }

    /// As many numbers as there are breakpoints, each in a range.
    pub fn along(
        &mut self,
        key: &'static str,
        breakpoints: &Option<Vec<f64>>,
        range: Range,
    ) -> Option<Vec<f64>> {
        let values = self.numbers_in(key, range)?;
        let wanted = breakpoints.as_ref().map_or(values.len(), Vec::len);
        if values.len() == wanted {
            return Some(values);
        }
        self.table_size(key, values.len(), format!("{wanted}, one for each breakpoint"));
        None
    }

    /// Rows of numbers, each of `columns`; row-major.
    pub fn grid(&mut self, key: &'static str, size: Option<(usize, usize)>) -> Option<Vec<f64>> {
        let rows = self.list(key, "[[0.0, 0.0], [0.0, 0.0]]")?;
        let mut all = Vec::new();
        let mut is_whole = true;
        for row in rows {
            let items = self.items(key, row, "a list of rows, one for each x");
            let Some(values) = items.and_then(|items| self.numbers_of(key, items)) else {
                is_whole = false;
                continue;
            };
            if let Some((_, columns)) = size.filter(|(_, columns)| *columns != values.len()) {
                is_whole = false;
                let wanted = format!("{columns} (one for each y)");
                let found = values.len();
                let fault = Fault::TableSize { field: self.name(key), found, wanted };
                let help = "a row holds the values at one x, in order of y";
                self.board.tell(row.span, fault, help.into());
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
