//! Rows of a trace of any length, of which only those are kept that a picture shows.
//!
//! Rows are divided into spans of equal length. Of each span the first and the last row
//! are kept, and those in which a column is lowest or highest: no spike is lost. When
//! too many are held the spans are doubled; as the extremes of a span are extremes of one
//! of its halves, this loses nothing that reading it in one go would have kept.

/// Rows kept so far, column by column.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Rows {
    pub ticks: Vec<i64>,
    pub values: Vec<Vec<f64>>,
    /// Number of each row kept, in the order of the file.
    numbers: Vec<usize>,
    seen: usize,
    span: usize,
    most: usize,
}

impl Rows {
    /// None yet, and never more than `most` for long.
    pub fn new(columns: usize, most: usize) -> Rows {
        Rows {
            ticks: Vec::new(),
            values: vec![Vec::new(); columns],
            numbers: Vec::new(),
            seen: 0,
            span: 1,
            most,
        }
    }

    pub fn seen(&self) -> usize {
        self.seen
    }

    /// Adds rows: their ticks, and the values of each column.
    pub fn push(&mut self, ticks: &[i64], values: &[&[f64]]) {
        self.numbers.extend(self.seen..self.seen + ticks.len());
        self.seen += ticks.len();
        self.ticks.extend_from_slice(ticks);
        for (column, new) in self.values.iter_mut().zip(values) {
            column.extend_from_slice(new);
        }
        // A span of all rows keeps a first, a last and two a column: no more can go.
        while self.ticks.len() > self.most && self.span < self.seen {
            self.span *= 2;
            self.thin();
        }
    }

    fn thin(&mut self) {
        let mut kept = Vec::new();
        let mut start = 0;
        while start < self.numbers.len() {
            let bucket = self.numbers[start] / self.span;
            let rest = &self.numbers[start..];
            let end = start + rest.partition_point(|n| n / self.span == bucket);
            let from = kept.len();
            kept.extend([start, end - 1]);
            for column in &self.values {
                let (mut low, mut high) = (start, start);
                for i in start..end {
                    // A value that does not exist is no extreme.
                    if column[i] < column[low] || column[low].is_nan() {
                        low = i;
                    }
                    if column[i] > column[high] || column[high].is_nan() {
                        high = i;
                    }
                }
                kept.extend([low, high]);
            }
            kept[from..].sort_unstable();
            start = end;
        }
        kept.dedup();
        self.ticks = kept.iter().map(|&i| self.ticks[i]).collect();
        self.numbers = kept.iter().map(|&i| self.numbers[i]).collect();
        for column in &mut self.values {
            *column = kept.iter().map(|&i| column[i]).collect();
        }
    }
}
