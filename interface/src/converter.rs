//! ADC, DAC and digital coefficient unit as quantisers.
//!
//! A converter of b bits and full scale F (problem units) has the codes
//! −2^(b−1) … 2^(b−1)−1 and the least significant bit q = F / 2^(b−1). It rounds
//! to the nearest code, ties to even; a value whose code lies beyond the ends is
//! held at the end and flagged. Inside, the error is at most q/2. Either stage
//! switches off alone: without bits only the range is limited, without a full
//! scale the value passes as it is.
//!
//! A digital coefficient unit, a held number that multiplies an analog signal, has both ends,
//! so that a coefficient equal to its range is exact; a real unit falls one LSB short of it.
//! What lies beyond the range itself is flagged.
//!
//! It refuses bits without a full scale: an LSB needs a range.

/// Largest number of bits; every code and its value are exact in f64.
pub const MAX_BITS: u32 = 24;

/// Why a converter cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ConverterError {
    #[error("a converter has 2 to {MAX_BITS} bits, not {0}")]
    Bits(u32),
    #[error("full scale is a positive number, not {0}")]
    FullScale(f64),
    #[error("{0} bits need a full scale; state the block's `max`")]
    NoFullScale(u32),
}

/// Result of one conversion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conversion {
    /// Converted value in the units of the full scale.
    pub value: f64,
    /// The input lay beyond the range and is held at its end.
    pub saturated: bool,
    /// The input was infinite or not a number. NaN converts to zero; without any
    /// stage switched on it passes.
    pub non_finite: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Converter {
    bits: Option<u32>,
    full_scale: Option<f64>,
    has_both_ends: bool,
}

impl Converter {
    /// A converter of `bits` bits and range ±`full_scale`; `None` switches a stage off.
    pub fn new(bits: Option<u32>, full_scale: Option<f64>) -> Result<Converter, ConverterError> {
        if let Some(scale) = full_scale
            && !(scale.is_finite() && scale >= f64::MIN_POSITIVE)
        {
            return Err(ConverterError::FullScale(scale));
        }
        match (bits, full_scale) {
            (Some(bits), _) if !(2..=MAX_BITS).contains(&bits) => Err(ConverterError::Bits(bits)),
            (Some(bits), None) => Err(ConverterError::NoFullScale(bits)),
            _ => Ok(Converter { bits, full_scale, has_both_ends: false }),
        }
    }

    /// A digital coefficient unit, likewise.
    pub fn coefficient(bits: Option<u32>, range: Option<f64>) -> Result<Converter, ConverterError> {
        Ok(Converter { has_both_ends: true, ..Converter::new(bits, range)? })
    }

    /// Passes every f64 unchanged.
    pub fn ideal() -> Converter {
        Converter { bits: None, full_scale: None, has_both_ends: false }
    }

    /// Least significant bit in the units of the full scale, unless the bits are off.
    pub fn lsb(&self) -> Option<f64> {
        let (bits, scale) = self.bits.zip(self.full_scale)?;
        Some(scale / half_codes(bits))
    }

    /// Converts one value.
    pub fn convert(&self, input: f64) -> Conversion {
        let non_finite = !input.is_finite();
        let Some(scale) = self.full_scale else {
            return Conversion { value: input, saturated: false, non_finite };
        };
        let input = if input.is_nan() { 0.0 } else { input };
        let is_beyond = input.abs() > scale;
        let Some(bits) = self.bits else {
            let value = input.clamp(-scale, scale);
            return Conversion { value, saturated: is_beyond, non_finite };
        };
        let half = half_codes(bits);
        let highest = if self.has_both_ends { half } else { half - 1.0 };
        let ideal = (input / scale * half).round_ties_even();
        let held = ideal.clamp(-half, highest);
        let saturated = if self.has_both_ends { is_beyond } else { held != ideal };
        Conversion { value: held / half * scale, saturated, non_finite }
    }
}

fn half_codes(bits: u32) -> f64 {
    f64::from(1_u32 << (bits - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn codes_of_a_three_bit_converter() {
        // F = 4, b = 3: q = 1, codes −4 … 3.
        let converter = Converter::new(Some(3), Some(4.0)).unwrap();
        for (input, code, saturated) in [
            (0.0, 0, false),
            (0.5, 0, false),
            (1.5, 2, false),
            (-0.51, -1, false),
            (3.49, 3, false),
            (3.51, 3, true),
            (4.0, 3, true),
            (-4.0, -4, false),
            (-4.6, -4, true),
            (f64::INFINITY, 3, true),
            (f64::NEG_INFINITY, -4, true),
        ] {
            let got = converter.convert(input);
            // q = 1: a code is its value.
            assert_eq!(got.value, f64::from(code), "{input}");
            assert_eq!(got.saturated, saturated, "{input}");
            assert_eq!(got.non_finite, input.is_infinite());
        }
        let nan = converter.convert(f64::NAN);
        assert!(nan.non_finite && !nan.saturated && nan.value == 0.0);
    }

    #[test]
    fn stages_switch_off_alone() {
        assert_eq!(Converter::ideal().convert(1e300).value, 1e300);
        assert!(Converter::ideal().convert(f64::NAN).non_finite);
        let limited = Converter::new(None, Some(2.0)).unwrap();
        assert_eq!(limited.convert(1.234_567).value, 1.234_567);
        assert!(limited.convert(-3.0).saturated);
        assert_eq!(limited.convert(-3.0).value, -2.0);
        assert_eq!(Converter::new(Some(12), None), Err(ConverterError::NoFullScale(12)));
        for bits in [0, 1, 25, u32::MAX] {
            assert_eq!(Converter::new(Some(bits), Some(1.0)), Err(ConverterError::Bits(bits)));
        }
        for scale in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(Converter::new(None, Some(scale)).is_err());
        }
    }

    #[test]
    fn both_ends_and_zero_are_exact() {
        let unit = Converter::coefficient(Some(14), Some(1.0)).unwrap();
        assert_eq!(unit.lsb(), Some(1.0 / 8192.0));
        for exact in [-1.0, -0.5, 0.0, 0.25, 1.0] {
            let set = unit.convert(exact);
            assert_eq!((set.value, set.saturated), (exact, false));
        }
        assert_eq!(unit.convert(1.0 / 3.0).value, 2731.0 / 8192.0);
        assert!(unit.convert(1.5).saturated);
        assert_eq!(unit.convert(f64::NEG_INFINITY).value, -1.0);
        assert!(unit.convert(f64::NAN).non_finite);
        assert_eq!(Converter::ideal().convert(123.456).value, 123.456);
        assert!(Converter::coefficient(Some(14), None).is_err());
        assert!(Converter::coefficient(None, Some(f64::NAN)).is_err());
    }

    proptest! {
        /// Error ≤ q/2; the allowance is three roundings of values not above the range.
        #[test]
        fn a_coefficient_is_off_by_at_most_half_an_lsb(
            bits in 2_u32..=MAX_BITS, range in 0.1_f64..100.0, x in -1.0_f64..1.0,
        ) {
            let unit = Converter::coefficient(Some(bits), Some(range)).unwrap();
            let set = unit.convert(x * range);
            let rounding = 3.0 * f64::EPSILON / 2.0 * range;
            prop_assert!((set.value - x * range).abs() <= unit.lsb().unwrap() / 2.0 + rounding);
            prop_assert!(!set.saturated);
        }

        /// |error| ≤ q/2 inside the range. The allowance is for the three roundings of
        /// input/F·2^(b−1) and back, each at most 2⁻⁵³ of a value not above F.
        #[test]
        fn the_error_is_at_most_half_an_lsb(
            bits in 2_u32..=MAX_BITS, scale in 1e-3_f64..1e6, x in -1.0_f64..1.0,
        ) {
            let converter = Converter::new(Some(bits), Some(scale)).unwrap();
            let lsb = converter.lsb().unwrap();
            let input = x * scale;
            let got = converter.convert(input);
            let rounding = 3.0 * f64::EPSILON / 2.0 * scale;
            if got.saturated {
                prop_assert!(input > scale - lsb / 2.0 - rounding);
            } else {
                prop_assert!((got.value - input).abs() <= lsb / 2.0 + rounding);
            }
            // A converted value converts to itself.
            prop_assert_eq!(converter.convert(got.value).value, got.value);
        }

        #[test]
        fn any_bits_are_converted_without_a_panic(raw in any::<u64>(), bits in 2_u32..=24) {
            let converter = Converter::new(Some(bits), Some(10.0)).unwrap();
            let got = converter.convert(f64::from_bits(raw));
            prop_assert!(got.value.abs() <= 10.0);
        }
    }
}
