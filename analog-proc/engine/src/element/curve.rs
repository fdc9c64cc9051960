//! Piecewise-linear functions of one sum: limiter, dead zone, absolute value,
//! fixed and digitally set function generators.
//!
//! A curve of n breakpoints has n + 1 pieces. Within a step one piece is in
//! force and is extended as a straight line; leaving its interval is an event.

use crate::op::Term;
use crate::signal::Signal;
use serde::{Deserialize, Serialize};

/// A straight line `y = y0 + slope·(u − x0)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    pub x0: f64,
    pub y0: f64,
    pub slope: f64,
}

impl Piece {
    pub fn flat(y0: f64) -> Piece {
        Piece { x0: 0.0, y0, slope: 0.0 }
    }

    #[inline(always)]
    pub fn at<N: Signal>(self, u: N) -> N {
        N::constant(self.y0) + (u - N::constant(self.x0)) * self.slope
    }
}

/// A curve: its breakpoints and pieces lie in the machine's flat tables.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    pub u: Term,
    pub start: u32,
    pub len: u32,
    pub pieces: u32,
    /// Between two slopes a corner counts as crossed when it is exceeded by this much, so that
    /// rounding noise of a signal at rest on a corner makes no events.
    pub band: f64,
}

/// Rounding of a signal as large as the corner itself: a few units in its last place.
const CORNER_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// By how much a corner is exceeded before the piece `from` is left for `to`, of which each is flat
/// or not. A slope ends at the corner itself: what it holds at (a limit, zero) it does not pass.
#[inline(always)]
pub(crate) fn allowance(band: f64, from_flat: bool, to_flat: bool) -> f64 {
    match (from_flat, to_flat) {
        (true, false) => 2.0 * band,
        (false, true) => 0.0,
        _ => band,
    }
}

/// Noise band of a set of corners.
pub fn band(corners: &[f64]) -> f64 {
    let greatest = corners.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if greatest.is_finite() { CORNER_ROUNDING * greatest } else { 0.0 }
}

impl Curve {
    fn corners<'a>(&self, breakpoints: &'a [f64]) -> &'a [f64] {
        &breakpoints[self.start as usize..(self.start + self.len) as usize]
    }

    /// Distances beyond the ends of the present piece; positive outside.
    #[inline]
    pub fn sides<N: Signal>(
        &self,
        region: u32,
        breakpoints: &[f64],
        pieces: &[Piece],
        nets: &[N],
        put: &mut impl FnMut(N),
    ) {
        let u = self.u.of(nets);
        let corners = self.corners(breakpoints);
        let r = region as usize;
        let flat = |r: usize| pieces[self.pieces as usize + r].slope == 0.0;
        let beyond = |to: usize| N::constant(allowance(self.band, flat(r), flat(to)));
        if r > 0 {
            put(N::constant(corners[r - 1]) - u - beyond(r - 1));
        }
        if let Some(high) = corners.get(r) {
            put(u - N::constant(*high) - beyond(r + 1));
        }
    }

    pub fn locate(&self, breakpoints: &[f64], nets: &[f64]) -> u32 {
        let u = self.u.of(nets);
        self.corners(breakpoints).partition_point(|x| *x < u) as u32
    }

    /// The piece of a region, of all pieces.
    pub fn piece(&self, region: u32, pieces: &[Piece]) -> Piece {
        pieces[(self.pieces + region) as usize]
    }
}

/// Roundings of a slope and of what it makes of its interval, and to spare.
const MOST_ROUNDINGS: usize = 8;

/// Pieces of a table: flat beyond its ends.
fn table<'a>(x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = Piece> + 'a {
    let sloping = x.windows(2).zip(y.windows(2)).map(|(x, y)| {
        let mut piece = Piece { x0: x[0], y0: y[0], slope: (y[1] - y[0]) / (x[1] - x[0]) };
        // Rounding takes none beyond its ordinates: what holds at an end is not passed before it.
        let (low, high) = (y[0].min(y[1]), y[0].max(y[1]));
        for _ in 0..MOST_ROUNDINGS {
            if (low..=high).contains(&piece.at(x[1])) {
                break;
            }
            piece.slope *= 1.0 - f64::EPSILON;
        }
        piece
    });
    let below = y.first().map(|y| Piece::flat(*y));
    let above = y.last().map(|y| Piece::flat(*y));
    below.into_iter().chain(sloping).chain(above)
}

/// Pieces of a fixed table.
pub fn pieces_of_table(x: &[f64], y: &[f64]) -> Vec<Piece> {
    table(x, y).collect()
}

/// Pieces of a dead zone of half width `w`.
pub fn pieces_of_dead_zone(w: f64) -> [Piece; 3] {
    [Piece { x0: -w, y0: 0.0, slope: 1.0 }, Piece::flat(0.0), Piece { x0: w, y0: 0.0, slope: 1.0 }]
}

/// Pieces of a limiter.
pub fn pieces_of_limiter(low: f64, high: f64) -> [Piece; 3] {
    [Piece::flat(low), Piece { x0: 0.0, y0: 0.0, slope: 1.0 }, Piece::flat(high)]
}

/// Pieces of the absolute value.
pub fn pieces_of_abs() -> [Piece; 2] {
    [Piece { x0: 0.0, y0: 0.0, slope: -1.0 }, Piece { x0: 0.0, y0: 0.0, slope: 1.0 }]
}

/// A curve whose ordinates are held in coefficient units (Rubin's function generator).
#[derive(Clone, Copy, Debug)]
pub struct DigitalFunction {
    pub curve: Curve,
    /// First ordinate in the flat array of coefficients.
    pub first: u32,
}

impl DigitalFunction {
    /// Rewrites the pieces from the ordinates now held.
    pub fn load(&self, breakpoints: &[f64], dcus: &[f64], pieces: &mut [Piece]) {
        let first = self.first as usize;
        let x = self.curve.corners(breakpoints);
        let y = &dcus[first..first + x.len()];
        let pieces = &mut pieces[self.curve.pieces as usize..];
        for (place, piece) in pieces.iter_mut().zip(table(x, y)) {
            *place = piece;
        }
    }
}
