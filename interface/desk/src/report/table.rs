//! Tables with units in their headings, and definition lists.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::format::{significant, typeset};

/// What a cell holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number, formatted by its column.
    Number(f64),
    Text(String),
    /// Words that lead to an anchor of the page.
    Link(String, String),
    /// No value: a dash for people, null in JSON, nothing in CSV.
    Missing,
}

impl Cell {
    fn words(&self, number: impl Fn(f64) -> String, missing: &str) -> String {
        match self {
            Cell::Number(value) => number(*value),
            Cell::Text(text) | Cell::Link(text, _) => text.clone(),
            Cell::Missing => missing.to_owned(),
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Cell {
        Cell::Number(value)
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Cell {
        value.map_or(Cell::Missing, Cell::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Cell {
        Cell::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::Text(text)
    }
}

/// A column's heading and the form of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// The quantity.
    pub label: String,
    /// Its unit; empty when dimensionless or words.
    pub unit: String,
    /// Significant digits of its numbers.
    pub digits: usize,
}

impl Heading {
    /// A heading with four significant digits.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Heading {
        Heading { label: label.into(), unit: unit.into(), digits: 4 }
    }

    /// Name for machines: label and unit in snake_case, `Max Qα` in `kPa·°` as
    /// `max_q_alpha_kpa_deg`.
    pub fn key(&self) -> String {
        let mut key = String::new();
        for c in format!("{} {}", self.label, self.unit).chars() {
            let word = match c {
                'α' => "_alpha",
                'β' => "_beta",
                'γ' => "_gamma",
                'ζ' => "_zeta",
                'η' => "_eta",
                'λ' => "_lambda",
                'σ' => "_sigma",
                'τ' => "_tau",
                'ω' => "_omega",
                'Δ' => "delta_",
                '°' => "deg",
                '%' => "percent",
                '+' => "_plus_",
                '−' | '-' if key.ends_with('_') => "minus_",
                _ if c.is_ascii_alphanumeric() => {
                    key.push(c.to_ascii_lowercase());
                    continue;
                }
                _ => "_",
            };
            key.push_str(if key.is_empty() || key.ends_with('_') {
                word.trim_start_matches('_')
            } else {
                word
            });
        }
        key.trim_matches('_').to_owned()
    }

    pub fn digits(mut self, digits: usize) -> Heading {
        self.digits = digits;
        self
    }
}

/// A column of a table whose rows are made from values of `R`: all that there is to say of it.
#[derive(Clone, Debug)]
pub struct Column<R> {
    pub heading: Heading,
    pub of: fn(&R) -> Cell,
}

impl<R> Column<R> {
    /// A column with four significant digits.
    pub fn new(label: &str, unit: &str, of: fn(&R) -> Cell) -> Column<R> {
        Column { heading: Heading::new(label, unit), of }
    }

    pub fn digits(mut self, digits: usize) -> Column<R> {
        self.heading.digits = digits;
        self
    }

    /// A column with so many digits whose accessor needs no type: in a list the first one's tells.
    pub fn of(label: &str, unit: &str, digits: usize, of: fn(&R) -> Cell) -> Column<R> {
        Column { heading: Heading::new(label, unit).digits(digits), of }
    }
}

/// A table. Rows shorter than the headings are filled with blanks; longer ones are cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub headings: Vec<Heading>,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    pub fn new(headings: Vec<Heading>) -> Table {
        Table { headings, rows: Vec::new() }
    }

    pub fn of<'r, R: 'r>(columns: &[Column<R>], rows: impl IntoIterator<Item = &'r R>) -> Table {
        let cells = |row: &R| columns.iter().map(|c| (c.of)(row)).collect();
        Table {
            headings: columns.iter().map(|c| c.heading.clone()).collect(),
            rows: rows.into_iter().map(cells).collect(),
        }
    }

    pub fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    pub fn markup(&self) -> Markup {
        let numeric: Vec<bool> = (0..self.headings.len())
            .map(|c| self.column(c).any(|cell| matches!(cell, Cell::Number(_))))
            .collect();
        html! {
            div.wide { table {
                thead { tr {
                    @for (heading, numeric) in self.headings.iter().zip(&numeric) {
                        th scope="col" class=[numeric.then_some("n")] {
                            (heading.label)
                            @if !heading.unit.is_empty() { small { (heading.unit) } }
                        }
                    }
                } }
                tbody { @for row in &self.rows { tr {
                    @for (c, heading) in self.headings.iter().enumerate() {
                        @match row.get(c) {
                            Some(Cell::Number(value)) => { td.n { (typeset(*value, heading.digits)) } }
                            Some(Cell::Text(text)) => { td { (text) } }
                            Some(Cell::Link(text, href)) => { td { a href=(href) { (text) } } }
                            Some(Cell::Missing) => { td.n { "–" } }
                            None => { td {} }
                        }
                    }
                } } }
            } }
        }
    }

    /// The table for a terminal: columns aligned, units under the headings.
    pub fn text(&self) -> String {
        let content = |row: &[Cell], c: usize| {
            let number = |value| significant(value, self.headings[c].digits);
            row.get(c).map_or_else(String::new, |cell| cell.words(number, "–"))
        };
        let mut lines: Vec<Vec<String>> =
            vec![self.headings.iter().map(|h| h.label.clone()).collect()];
        if self.headings.iter().any(|h| !h.unit.is_empty()) {
            let unit = |h: &Heading| match h.unit.as_str() {
                "" => String::new(),
                unit => format!("[{unit}]"),
            };
            lines.push(self.headings.iter().map(unit).collect());
        }
        let head = lines.len();
        for row in &self.rows {
            lines.push((0..self.headings.len()).map(|c| content(row, c)).collect());
        }
        let widths: Vec<usize> = (0..self.headings.len())
            .map(|c| lines.iter().map(|line| line[c].chars().count()).max().unwrap_or(0))
            .collect();
        let mut out = String::new();
        for (n, line) in lines.iter().enumerate() {
            let mut text = String::new();
            for (c, field) in line.iter().enumerate() {
                let pad = " ".repeat(widths[c].saturating_sub(field.chars().count()));
                let right = self.column(c).any(|cell| matches!(cell, Cell::Number(_)));
                // Writing to a String cannot fail.
                let _ = if right {
                    write!(text, "{pad}{field}  ")
                } else {
                    write!(text, "{field}{pad}  ")
                };
            }
            out.push_str(text.trim_end());
            out.push('\n');
            if n + 1 == head {
                let rule = widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
                out.push_str(&"-".repeat(rule));
                out.push('\n');
            }
        }
        out
    }

    /// Every digit of its numbers, the unit in brackets in the heading.
    pub fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.headings.iter().map(|h| {
            if h.unit.is_empty() { h.label.clone() } else { format!("{} [{}]", h.label, h.unit) }
        }))?;
        for row in &self.rows {
            let cell = |i: usize| row.get(i).map(|cell| cell.words(|v| v.to_string(), ""));
            writer.write_record((0..self.headings.len()).map(|i| cell(i).unwrap_or_default()))?;
        }
        writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
    }

    /// The table for machines: an array of objects keyed by [`Heading::key`], with `_2` and so on
    /// behind one that stands there already; a number that is not finite becomes null.
    pub fn json(&self) -> serde_json::Value {
        let mut keys: Vec<String> = Vec::with_capacity(self.headings.len());
        for heading in &self.headings {
            let key = heading.key();
            let others = (2..).map(|n| format!("{key}_{n}"));
            let free = std::iter::once(key.clone()).chain(others).find(|key| !keys.contains(key));
            keys.extend(free);
        }
        self.rows
            .iter()
            .map(|row| {
                let pairs = keys.iter().zip(row).map(|(key, cell)| {
                    let value = match cell {
                        Cell::Number(value) => serde_json::Value::from(*value),
                        Cell::Text(text) | Cell::Link(text, _) => {
                            serde_json::Value::from(text.as_str())
                        }
                        Cell::Missing => serde_json::Value::Null,
                    };
                    (key.clone(), value)
                });
                serde_json::Value::Object(pairs.collect())
            })
            .collect()
    }

    fn column(&self, c: usize) -> impl Iterator<Item = &Cell> {
        self.rows.iter().filter_map(move |row| row.get(c))
    }
}

/// Terms and what they are: a run's provenance, a profile's numbers.
pub fn definition_list(items: &[(String, String)]) -> Markup {
    html! { dl { @for (term, meaning) in items { dt { (term) } dd { (meaning) } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table =
            Table::new(vec![Heading::new("Variable", ""), Heading::new("Maximum", "kPa")]);
        table.row(["Q".into(), 94.871_23.into()]);
        table.row(["nothing".into(), f64::NAN.into()]);
        table
    }

    #[test]
    fn text_is_aligned() {
        assert_eq!(
            sample().text(),
            "Variable  Maximum\n            [kPa]\n-----------------\nQ           94.87\nnothing       NaN\n"
        );
    }

    #[test]
    fn keys_are_snake_case_with_their_unit() {
        for (label, unit, key) in [
            ("Max Qα", "kPa·°", "max_q_alpha_kpa_deg"),
            ("ΔV", "%", "delta_v_percent"),
            ("omega measured", "rad/s", "omega_measured_rad_s"),
            ("η by 6.5 s", "%", "eta_by_6_5_s_percent"),
            ("greatest |z|", "", "greatest_z"),
            ("design -0.5", "kg", "design_minus_0_5_kg"),
        ] {
            assert_eq!(Heading::new(label, unit).key(), key);
        }
    }

    #[test]
    fn json_keeps_full_precision() {
        let json = sample().json();
        assert_eq!(json[0]["maximum_kpa"], 94.871_23);
        assert!(json[1]["maximum_kpa"].is_null());
    }

    #[test]
    fn no_column_is_lost_to_another_of_the_same_key() {
        let headings = ["x", "X", "x 2"].map(|label| Heading::new(label, "")).to_vec();
        let mut table = Table::new(headings);
        table.row([1.0, 2.0, 3.0].map(Cell::from));
        assert_eq!(table.json()[0], serde_json::json!({ "x": 1.0, "x_2": 2.0, "x_2_2": 3.0 }));
    }
}
