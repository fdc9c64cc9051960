//! Curves that a command keeps in memory until it ends, as a trace.

use super::{Column, RunDirError, RunDirectory};
use interface::Tick;

/// Rows in one batch of the trace.
const BATCH_ROWS: usize = 256;

/// Curves of equal sampling: a column each. A short one has no value past its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Time from row to row.
    pub step: Tick,
    /// The last row stands here, where that comes before a whole step.
    pub end: Tick,
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
}

impl Curves {
    pub fn new(step: Tick) -> Curves {
        Curves { step, end: Tick(i64::MAX), columns: Vec::new(), values: Vec::new() }
    }

    pub fn add(&mut self, name: String, unit: &str, values: &[f64]) {
        self.columns.push(Column::new(name, unit));
        self.values.push(values.to_vec());
    }

    /// Writes them as `name` into a run's directory.
    pub(crate) fn write(&self, directory: &RunDirectory, name: &str) -> Result<(), RunDirError> {
        let mut trace = directory.create_stream(name, &self.columns, BATCH_ROWS)?;
        let rows = self.values.iter().map(Vec::len).max().unwrap_or(0);
        for i in 0..rows {
            let at = |values: &Vec<f64>| values.get(i).copied().unwrap_or(f64::NAN);
            let row: Vec<f64> = self.values.iter().map(at).collect();
            trace.push((self.step * i as i64).min(self.end), &row)?;
        }
        trace.finish()?;
        Ok(())
    }
}
