//! What the value of a net can be besides a number.
//!
//! The same operations and the same surfaces are evaluated over three kinds of
//! value: the number itself, the number with its rate of change ([`Rated`], for
//! excluding crossings within a step), and the number with what rounding
//! leaves undecided of it ([`Doubted`], for telling noise from a crossing).

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value that operations and surfaces can be evaluated over.
pub trait Signal:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
{
    /// A value that stands still and is exact.
    fn constant(value: f64) -> Self;
    /// A function of time alone at `t_s`; `rate` is asked only by those who keep it.
    fn of_time(t_s: f64, value: f64, rate: impl FnOnce() -> f64) -> Self;
    fn value(self) -> f64;
    /// Its rate, where it has one.
    fn rate(self) -> Option<f64> {
        None
    }
    fn sin_cos(self) -> (Self, Self);
    /// Root of the positive part, NaN kept.
    fn root(self) -> Self;
    /// Angle of the vector (x, y) on the sheet in force, see [`arctangent`].
    fn angle(y: Self, x: Self, sheet: u32) -> Self;

    /// The same, known to be off by as much besides.
    #[inline(always)]
    fn blurred(self, _doubt: f64) -> Self {
        self
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
}

/// `atan2(y, x)`, continued across the negative x axis on the sheet in force:
/// `sheet` 0 was entered with y ≥ 0, others with y < 0. The sheet changes by an event.
#[inline]
fn arctangent(y: f64, x: f64, sheet: u32) -> f64 {
    let principal = libm::atan2(y, x);
    // The sign of the angle tells the sign of y, that of a zero too.
    if x >= 0.0 {
        principal
    } else if sheet == 0 && principal < 0.0 {
        principal + TAU
    } else if sheet != 0 && principal > 0.0 {
        principal - TAU
    } else {
        principal
    }
}

impl Signal for f64 {
    #[inline(always)]
    fn constant(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn of_time(_t_s: f64, value: f64, _rate: impl FnOnce() -> f64) -> f64 {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn sin_cos(self) -> (f64, f64) {
        libm::sincos(self)
    }

    #[inline(always)]
    fn sin(self) -> f64 {
        libm::sin(self)
    }

    #[inline(always)]
    fn cos(self) -> f64 {
        libm::cos(self)
    }

    #[inline(always)]
    fn root(self) -> f64 {
        if self < 0.0 { 0.0 } else { self.sqrt() }
    }

    #[inline(always)]
    fn angle(y: f64, x: f64, sheet: u32) -> f64 {
        arctangent(y, x, sheet)
    }
}

/// A value with its rate, per second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rated {
    pub value: f64,
    pub rate: f64,
}

impl Add for Rated {
    type Output = Rated;

    #[inline(always)]
    fn add(self, other: Rated) -> Rated {
        Rated { value: self.value + other.value, rate: self.rate + other.rate }
    }
}

impl Sub for Rated {
    type Output = Rated;

    #[inline(always)]
    fn sub(self, other: Rated) -> Rated {
        Rated { value: self.value - other.value, rate: self.rate - other.rate }
    }
}

impl Mul for Rated {
    type Output = Rated;

    #[inline(always)]
    fn mul(self, other: Rated) -> Rated {
        Rated {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
        }
    }
}

impl Div for Rated {
    type Output = Rated;

    #[inline(always)]
    fn div(self, other: Rated) -> Rated {
        let value = self.value / other.value;
        Rated { value, rate: (self.rate - value * other.rate) / other.value }
    }
}

impl Mul<f64> for Rated {
    type Output = Rated;

    #[inline(always)]
    fn mul(self, c: f64) -> Rated {
        Rated { value: self.value * c, rate: self.rate * c }
    }
}

impl Neg for Rated {
    type Output = Rated;

    #[inline(always)]
    fn neg(self) -> Rated {
        Rated { value: -self.value, rate: -self.rate }
    }
}

impl Signal for Rated {
    #[inline(always)]
    fn constant(value: f64) -> Rated {
        Rated { value, rate: 0.0 }
    }

    #[inline(always)]
    fn of_time(_t_s: f64, value: f64, rate: impl FnOnce() -> f64) -> Rated {
        let rate = rate();
        Rated { value, rate }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn rate(self) -> Option<f64> {
        Some(self.rate)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Rated, Rated) {
        let (sin, cos) = Signal::sin_cos(self.value);
        let rated = |value, slope: f64| Rated { value, rate: slope * self.rate };
        (rated(sin, cos), rated(cos, -sin))
    }

    #[inline(always)]
    fn root(self) -> Rated {
        let value = self.value.root();
        let rate = if self.rate == 0.0 || self.value < 0.0 { 0.0 } else { 0.5 * self.rate / value };
        Rated { value, rate }
    }

    #[inline(always)]
    fn angle(y: Rated, x: Rated, sheet: u32) -> Rated {
        let square = x.value * x.value + y.value * y.value;
        let turn = x.value * y.rate - y.value * x.rate;
        Rated {
            value: arctangent(y.value, x.value, sheet),
            rate: if turn == 0.0 { 0.0 } else { turn / square },
        }
    }
}

/// A value and by how much it may be off, to first order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Doubted {
    pub value: f64,
    /// Not negative.
    pub doubt: f64,
}

impl Doubted {
    /// A result with its own rounding.
    #[inline(always)]
    fn rounded(value: f64, doubt: f64) -> Doubted {
        Doubted { value, doubt: doubt + f64::EPSILON * value.abs() }
    }
}

impl Add for Doubted {
    type Output = Doubted;

    fn add(self, other: Doubted) -> Doubted {
        Doubted::rounded(self.value + other.value, self.doubt + other.doubt)
    }
}

impl Sub for Doubted {
    type Output = Doubted;

    fn sub(self, other: Doubted) -> Doubted {
        Doubted::rounded(self.value - other.value, self.doubt + other.doubt)
    }
}

impl Mul for Doubted {
    type Output = Doubted;

    fn mul(self, other: Doubted) -> Doubted {
        let doubt = self.doubt * other.value.abs() + self.value.abs() * other.doubt;
        Doubted::rounded(self.value * other.value, doubt + self.doubt * other.doubt)
    }
}

impl Div for Doubted {
    type Output = Doubted;

    fn div(self, other: Doubted) -> Doubted {
        let value = self.value / other.value;
        let doubt = (self.doubt + value.abs() * other.doubt) / other.value.abs();
        Doubted::rounded(value, doubt)
    }
}

impl Mul<f64> for Doubted {
    type Output = Doubted;

    fn mul(self, c: f64) -> Doubted {
        Doubted::rounded(self.value * c, self.doubt * c.abs())
    }
}

impl Neg for Doubted {
    type Output = Doubted;

    fn neg(self) -> Doubted {
        Doubted { value: -self.value, doubt: self.doubt }
    }
}

impl Signal for Doubted {
    fn constant(value: f64) -> Doubted {
        Doubted { value, doubt: 0.0 }
    }

    fn of_time(t_s: f64, value: f64, rate: impl FnOnce() -> f64) -> Doubted {
        Doubted::rounded(value, f64::EPSILON * (t_s * rate()).abs())
    }

    fn value(self) -> f64 {
        self.value
    }

    fn blurred(self, doubt: f64) -> Doubted {
        Doubted { value: self.value, doubt: self.doubt + doubt }
    }

    fn sin_cos(self) -> (Doubted, Doubted) {
        let (sin, cos) = Signal::sin_cos(self.value);
        let doubt = self.doubt.min(2.0);
        (Doubted::rounded(sin, doubt), Doubted::rounded(cos, doubt))
    }

    fn root(self) -> Doubted {
        let value = self.value.root();
        let near = self.doubt.sqrt();
        let doubt = if value > 0.0 { near.min(0.5 * self.doubt / value) } else { near };
        Doubted::rounded(value, doubt)
    }

    fn angle(y: Doubted, x: Doubted, sheet: u32) -> Doubted {
        let square = x.value * x.value + y.value * y.value;
        let doubt = (x.value.abs() * y.doubt + y.value.abs() * x.doubt) / square;
        Doubted::rounded(arctangent(y.value, x.value, sheet), doubt)
    }
}
