//! Bilinear function of two variables; one cell is in force within a step.

use crate::element::curve::allowance;
use crate::op::Term;
use crate::signal::Signal;

/// Breakpoints and values, row-major `[x][y]`.
#[derive(Clone, Debug)]
pub struct Table {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    pub bands: [f64; 2],
}

/// Interval index 0..=n (0 below, n above) → cell index and the place in it; the ends hold.
fn clamp_to<N: Signal>(axis: &[f64], interval: usize, u: N) -> (usize, N) {
    if interval == 0 {
        (0, N::constant(0.0))
    } else if interval >= axis.len() {
        (axis.len() - 1, N::constant(0.0))
    } else {
        let cell = interval - 1;
        let width = N::constant(axis[cell + 1] - axis[cell]);
        (cell, (u - N::constant(axis[cell])) / width)
    }
}

/// `low` + `part`·(`high` − `low`), from the nearer end: rounding takes it beyond neither.
fn between<N: Signal>(low: N, high: N, part: N) -> N {
    let rise = high - low;
    if part.value() < 0.5 { low + part * rise } else { high - (N::constant(1.0) - part) * rise }
}

fn beyond<N: Signal>(axis: &[f64], interval: usize, u: N, band: f64, put: &mut impl FnMut(N)) {
    let flat = |interval: usize| interval == 0 || interval == axis.len();
    let band = |to: usize| N::constant(allowance(band, flat(interval), flat(to)));
    if interval > 0 {
        put(N::constant(axis[interval - 1]) - u - band(interval - 1));
    }
    if let Some(high) = axis.get(interval) {
        put(u - N::constant(*high) - band(interval + 1));
    }
}

impl Table {
    fn split(&self, region: u32) -> (usize, usize) {
        let stride = self.y.len() + 1;
        (region as usize / stride, region as usize % stride)
    }

    pub fn at<N: Signal>(&self, region: u32, x: N, y: N) -> N {
        let (i, j) = self.split(region);
        let (i, p) = clamp_to(&self.x, i, x);
        let (j, q) = clamp_to(&self.y, j, y);
        let columns = self.y.len();
        let next_i = (i + 1).min(self.x.len() - 1);
        let next_j = (j + 1).min(columns - 1);
        let z = |i: usize, j: usize| self.z[i * columns + j];
        let along = |i: usize| between(N::constant(z(i, j)), N::constant(z(i, next_j)), q);
        between(along(i), along(next_i), p)
    }

    /// Distances beyond the ends of the present cell; positive outside.
    pub fn sides<N: Signal>(&self, region: u32, x: N, y: N, put: &mut impl FnMut(N)) {
        let (i, j) = self.split(region);
        beyond(&self.x, i, x, self.bands[0], put);
        beyond(&self.y, j, y, self.bands[1], put);
    }

    pub fn locate(&self, x: f64, y: f64) -> u32 {
        let i = self.x.partition_point(|b| *b < x);
        let j = self.y.partition_point(|b| *b < y);
        (i * (self.y.len() + 1) + j) as u32
    }
}

/// The element of a two-variable function.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub table: u32,
    pub x: Term,
    pub y: Term,
}
