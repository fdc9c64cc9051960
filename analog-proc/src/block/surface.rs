//! Bilinear function of two variables; one cell is in force within a step.

use crate::op::Term;

/// Breakpoints and values, row-major `[x][y]`.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    pub bands: [f64; 2],
}

/// Interval index 0..=n (0 below, n above) → cell index and whether the ends hold.
fn clamp_to(axis: &[f64], interval: usize, u: f64) -> (usize, f64) {
    if interval == 0 {
        (0, 0.0)
    } else if interval >= axis.len() {
        (axis.len() - 1, 0.0)
    } else {
        let cell = interval - 1;
        (cell, (u - axis[cell]) / (axis[cell + 1] - axis[cell]))
    }
}

fn beyond(axis: &[f64], interval: usize, u: f64, band: f64) -> f64 {
    let mut margin = f64::NEG_INFINITY;
    if interval > 0 {
        margin = axis[interval - 1] - u;
    }
    if let Some(high) = axis.get(interval) {
        margin = margin.max(u - high);
    }
    margin - band
}

impl Table {
    fn split(&self, region: u32) -> (usize, usize) {
        let stride = self.y.len() + 1;
        (region as usize / stride, region as usize % stride)
    }

    pub fn at(&self, region: u32, x: f64, y: f64) -> f64 {
        let (i, j) = self.split(region);
        let (i, p) = clamp_to(&self.x, i, x);
        let (j, q) = clamp_to(&self.y, j, y);
        let columns = self.y.len();
        let next_i = (i + 1).min(self.x.len() - 1);
        let next_j = (j + 1).min(columns - 1);
        let z = |i: usize, j: usize| self.z[i * columns + j];
        let low = z(i, j) + q * (z(i, next_j) - z(i, j));
        let high = z(next_i, j) + q * (z(next_i, next_j) - z(next_i, j));
        low + p * (high - low)
    }

    pub fn margin(&self, region: u32, x: f64, y: f64) -> f64 {
        let (i, j) = self.split(region);
        beyond(&self.x, i, x, self.bands[0]).max(beyond(&self.y, j, y, self.bands[1]))
    }

    pub fn locate(&self, x: f64, y: f64) -> u32 {
        let i = self.x.partition_point(|b| *b < x);
        let j = self.y.partition_point(|b| *b < y);
        (i * (self.y.len() + 1) + j) as u32
    }
}

/// The element of a two-variable function.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub table: u32,
    pub x: Term,
    pub y: Term,
}
