//! Digital coefficient units: a held number that multiplies an analog signal.
//!
//! A unit of b bits (sign included) and range R sets the coefficients k·R/2^(b−1)
//! for |k| ≤ 2^(b−1), rounded to nearest, ties to even. Both ends can be set, so
//! that a coefficient equal to the range is exact; a real unit falls one LSB short
//! of it. What lies beyond is held at the end and flagged. Without bits the
//! coefficient is set as it is, within the range if there is one.

use crate::converter::{ConverterError, MAX_BITS};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientUnit {
    bits: Option<u32>,
    range: Option<f64>,
}

/// A coefficient as it was set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The coefficient that multiplies the signal.
    pub value: f64,
    /// The wanted coefficient lay beyond the range.
    pub saturated: bool,
    /// The wanted coefficient was infinite or not a number (NaN sets zero).
    pub non_finite: bool,
}

impl CoefficientUnit {
    /// A unit of `bits` bits and range ±`range`; `None` switches a stage off.
    pub fn new(bits: Option<u32>, range: Option<f64>) -> Result<CoefficientUnit, ConverterError> {
        match (bits, range) {
            (_, Some(range)) if !(range.is_finite() && range >= f64::MIN_POSITIVE) => {
                Err(ConverterError::FullScale(range))
            }
            (Some(bits), _) if !(2..=MAX_BITS).contains(&bits) => Err(ConverterError::Bits(bits)),
            (Some(bits), None) => Err(ConverterError::NoFullScale(bits)),
            _ => Ok(CoefficientUnit { bits, range }),
        }
    }

    /// Sets every coefficient exactly.
    pub fn ideal() -> CoefficientUnit {
        CoefficientUnit { bits: None, range: None }
    }

    /// Smallest change of the coefficient, unless the bits are off.
    pub fn lsb(&self) -> Option<f64> {
        let (bits, range) = self.bits.zip(self.range)?;
        Some(range / f64::from(1_u32 << (bits - 1)))
    }

    /// Sets a coefficient.
    pub fn set(&self, wanted: f64) -> Setting {
        let non_finite = !wanted.is_finite();
        let Some(range) = self.range else {
            return Setting { value: wanted, saturated: false, non_finite };
        };
        let wanted = if wanted.is_nan() { 0.0 } else { wanted };
        let held = wanted.clamp(-range, range);
        let value = match self.bits {
            Some(bits) => {
                let half = f64::from(1_u32 << (bits - 1));
                (held / range * half).round_ties_even() / half * range
            }
            None => held,
        };
        Setting { value, saturated: held != wanted, non_finite }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn both_ends_and_zero_are_exact() {
        let unit = CoefficientUnit::new(Some(14), Some(1.0)).unwrap();
        assert_eq!(unit.lsb(), Some(1.0 / 8192.0));
        for exact in [-1.0, -0.5, 0.0, 0.25, 1.0] {
            let set = unit.set(exact);
            assert_eq!((set.value, set.saturated), (exact, false));
        }
        assert_eq!(unit.set(1.0 / 3.0).value, 2731.0 / 8192.0);
        assert!(unit.set(1.5).saturated);
        assert_eq!(unit.set(f64::NEG_INFINITY).value, -1.0);
        assert!(unit.set(f64::NAN).non_finite);
        assert_eq!(CoefficientUnit::ideal().set(123.456).value, 123.456);
        assert!(CoefficientUnit::new(Some(14), None).is_err());
        assert!(CoefficientUnit::new(None, Some(f64::NAN)).is_err());
    }

    proptest! {
        /// Error ≤ q/2; the allowance is three roundings of values not above the range.
        #[test]
        fn the_error_is_at_most_half_an_lsb(
            bits in 2_u32..=MAX_BITS, range in 0.1_f64..100.0, x in -1.0_f64..1.0,
        ) {
            let unit = CoefficientUnit::new(Some(bits), Some(range)).unwrap();
            let set = unit.set(x * range);
            let rounding = 3.0 * f64::EPSILON / 2.0 * range;
            prop_assert!((set.value - x * range).abs() <= unit.lsb().unwrap() / 2.0 + rounding);
            prop_assert!(!set.saturated);
        }
    }
}
