//! How fast functions turn: the longest step over which each has no hidden feature.
//!
//! Sums and products of smooth signals show in their ends what they do between
//! them. A sine, an angle, a quotient, a root or a delayed signal need not: their
//! arguments can run through a whole period, or past a pole, within one step. So a
//! step ends before an argument has gone far on the function's own scale, whether
//! it comes from time, an integrated phase or anything else.

use crate::element::delay::DelayLine;
use crate::op::{Op, Slot, Term};
use crate::signal::Rated;

/// Greatest turn of an angle over a step, rad: an eighth of a circle. A sine is then near its
/// own cubic, so that surfaces are judged from the ends of a step.
const TURN: f64 = std::f64::consts::FRAC_PI_4;

/// The degree up to which [`TURN`] holds.
const SEEN_DEGREE: u32 = 4;

/// Greatest part of its way to zero that a divisor or a radicand makes in a step …
const APPROACH: f64 = 0.5;
/// … and by how often it may grow.
const GROWTH: f64 = 4.0;
/// Closer to zero than this part of its greatest value it is at zero: the surface of the
/// block itself tells whether it passes through.
const NEAR_ZERO: f64 = 1e-12;

/// A vector that is no longer than this part of its greatest value, and that its rate brings to
/// zero or back within some resolutions of time, is at its origin; a longer one spins.
const AT_ORIGIN: f64 = 1e-9;
const ORIGIN_SPAN: f64 = 64.0;

/// A step that turns out longer than its bound by this factor is not accepted.
const SLACK: f64 = 1.5;

/// Tangent of the greatest turn of a direction between the ends of a step, three sixteenths of
/// a circle: [`SLACK`] times [`TURN`].
const MOST_TURN: f64 = 1.0 + std::f64::consts::SQRT_2;

/// Greatest turn of an angle whose sine goes into a product of this degree, rad: the peaks of
/// a product of n sines are narrower by √n.
pub fn turn(degree: u32) -> f64 {
    TURN * (f64::from(SEEN_DEGREE) / f64::from(degree.max(SEEN_DEGREE))).sqrt()
}

/// Something whose scale bounds the step.
#[derive(Clone, Copy, Debug)]
pub enum Pace {
    /// A sine or cosine of the term, which turns by so much at most, rad.
    Angle(Term, f64),
    /// The direction of the vector (x, y) of an arctangent whose element is `e`.
    Direction { e: u32, y: Term, x: Term },
    /// A net divided by, or under a root.
    Pole(Slot),
    /// A delay line.
    Line(u32),
}

/// The vector of an arctangent.
struct Vector {
    y: Rated,
    x: Rated,
}

impl Vector {
    #[inline(always)]
    fn of(y: Term, x: Term, nets: &[Rated]) -> Vector {
        Vector { y: y.of(nets), x: x.of(nets) }
    }

    #[inline(always)]
    fn square(&self) -> f64 {
        self.x.value * self.x.value + self.y.value * self.y.value
    }

    /// The rate of its angle, times its square.
    #[inline(always)]
    fn turn(&self) -> f64 {
        self.x.value * self.y.rate - self.y.value * self.x.rate
    }

    /// Half the rate of its square.
    #[inline(always)]
    fn growth(&self) -> f64 {
        self.x.value * self.x.rate + self.y.value * self.y.rate
    }

    fn size(&self) -> f64 {
        self.x.value.abs().max(self.y.value.abs())
    }

    fn is_zero(&self) -> bool {
        self.x.value == 0.0 && self.y.value == 0.0
    }

    fn moves(&self) -> bool {
        self.x.rate != 0.0 || self.y.rate != 0.0
    }
}

impl Pace {
    /// What bounds the step in an operation; `powers` are the degrees that nets go into.
    pub fn of(op: &Op, powers: &[u32]) -> Option<Pace> {
        match *op {
            Op::Sine { o, a, c } | Op::Cosine { o, a, c } | Op::SinCos { o, a, c } => {
                Some(Pace::Angle(Term { slot: a, c }, turn(powers[o as usize])))
            }
            Op::Arctangent { e, y, x, .. } => Some(Pace::Direction { e, y, x }),
            Op::Quotient { b, .. } => Some(Pace::Pole(b)),
            Op::Root { a, .. } => Some(Pace::Pole(a)),
            Op::Delay { line, .. } => Some(Pace::Line(line)),
            _ => None,
        }
    }

    /// Calls `f` with every net that it reads.
    pub fn reads(&self, mut f: impl FnMut(Slot)) {
        match *self {
            Pace::Angle(term, _) => f(term.slot),
            Pace::Direction { y, x, .. } => {
                f(y.slot);
                f(x.slot);
            }
            Pace::Pole(slot) => f(slot),
            Pace::Line(_) => {}
        }
    }

    /// The magnitude of a divisor, a radicand or a vector.
    pub(crate) fn size(&self, nets: &[Rated]) -> f64 {
        match *self {
            Pace::Pole(slot) => nets[slot as usize].value.abs(),
            Pace::Direction { y, x, .. } => Vector::of(y, x, nets).size(),
            Pace::Angle(..) | Pace::Line(_) => 0.0,
        }
    }

    /// The element of a vector that is at its origin as far as time is resolved, to `resolution_s`.
    pub(crate) fn at_origin(&self, resolution_s: f64, nets: &[Rated], largest: f64) -> Option<u32> {
        let Pace::Direction { e, y, x } = *self else { return None };
        let vector = Vector::of(y, x, nets);
        let (size, rate) = (vector.size(), vector.x.rate.abs().max(vector.y.rate.abs()));
        let near = size <= AT_ORIGIN * largest && size <= ORIGIN_SPAN * resolution_s * rate;
        near.then_some(e)
    }

    /// The longest step from here, s; `largest` is the greatest magnitude that a divisor or
    /// radicand has had.
    #[inline]
    pub(crate) fn limit_s(
        &self,
        lines: &[DelayLine],
        t_s: f64,
        nets: &[Rated],
        largest: f64,
    ) -> f64 {
        match *self {
            Pace::Angle(term, turn) => turn / (term.c * nets[term.slot as usize].rate).abs(),
            Pace::Direction { y, x, .. } => {
                let vector = Vector::of(y, x, nets);
                let (square, growth) = (vector.square(), vector.growth());
                if square < f64::MIN_POSITIVE {
                    return f64::INFINITY;
                }
                let turn_s = TURN * square / vector.turn().abs();
                if growth < 0.0 { turn_s.min(APPROACH * square / -growth) } else { turn_s }
            }
            Pace::Pole(slot) => {
                let u = nets[slot as usize];
                if u.value.abs() <= NEAR_ZERO * largest {
                    return f64::INFINITY;
                }
                let towards = u.value * u.rate < 0.0;
                let part = if towards { APPROACH } else { GROWTH };
                part * (u.value / u.rate).abs()
            }
            Pace::Line(line) => lines[line as usize].reach_s(t_s),
        }
    }

    /// Whether the step of `h_s` that ends here stayed within the bound, seen from its end. A vector
    /// that passes zero is refused: its angle jumps.
    #[inline]
    pub(crate) fn kept(&self, h_s: f64, start: &[Rated], end: &[Rated], largest: f64) -> bool {
        match *self {
            Pace::Angle(term, turn) => {
                let slot = term.slot as usize;
                let turned = (end[slot].value - start[slot].value).abs();
                let most = turned.max(h_s * end[slot].rate.abs());
                term.c.abs() * most <= SLACK * turn
            }
            Pace::Direction { y, x, .. } => {
                let (from, to) = (Vector::of(y, x, start), Vector::of(y, x, end));
                // At its origin it has the angle of its rate, which an event finds.
                let lost = if to.is_zero() { to.moves() } else { from.is_zero() && !from.moves() };
                let ahead = from.x.value * to.x.value + from.y.value * to.y.value;
                let across = (from.x.value * to.y.value - from.y.value * to.x.value).abs();
                !lost
                    && h_s * to.turn().abs() <= SLACK * TURN * to.square()
                    && -h_s * to.growth() <= SLACK * GROWTH * to.square()
                    && across <= MOST_TURN * ahead
            }
            Pace::Pole(slot) => {
                let u = end[slot as usize];
                u.value.abs() <= NEAR_ZERO * largest
                    || h_s * u.rate.abs() <= SLACK * GROWTH * u.value.abs()
            }
            Pace::Line(_) => true,
        }
    }
}
