//! Problem time as integer nanoseconds.
//!
//! Every instant at which something happens (a sample, a transfer, a located
//! event) is a [`Tick`]; `t_n = n·T` is a product of integers, never a sum of
//! floating-point increments. It refuses to represent fractions of a nanosecond.

use serde::{Deserialize, Serialize};

/// Nanoseconds of problem time since the start of OPERATE (also used for durations).
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[repr(transparent)]
pub struct Tick(pub i64);

/// A text that is not a duration, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not a duration: {reason}; write for example 100ms, 2.5us or 49s")]
pub struct TickParseError {
    pub text: String,
    pub reason: &'static str,
}

impl Tick {
    /// The start of problem time.
    pub const ZERO: Tick = Tick(0);
    pub const SECOND: Tick = Tick(1_000_000_000);

    /// The nearest tick to `seconds`; `None` when not finite or out of range.
    pub fn from_secs(seconds: f64) -> Option<Tick> {
        let ns = (seconds * 1e9).round();
        // i64::MAX as f64 rounds up to 2^63, which itself does not fit.
        (ns.abs() < i64::MAX as f64).then_some(Tick(ns as i64))
    }

    /// Seconds of problem time, rounded once.
    pub fn secs(self) -> f64 {
        // Exact for |t| < 2^53 ns (104 days), then one correctly rounded division.
        self.0 as f64 / 1e9
    }

    /// `n` times this duration; `None` on overflow.
    pub fn checked_mul(self, n: u64) -> Option<Tick> {
        i64::try_from(n).ok().and_then(|n| self.0.checked_mul(n)).map(Tick)
    }
}

/// Arithmetic ends at 292 years, beyond any stop, instead of wrapping round.
impl std::ops::Add for Tick {
    type Output = Tick;
    fn add(self, other: Tick) -> Tick {
        Tick(self.0.saturating_add(other.0))
    }
}

impl std::ops::Sub for Tick {
    type Output = Tick;
    fn sub(self, other: Tick) -> Tick {
        Tick(self.0.saturating_sub(other.0))
    }
}

impl std::ops::Mul<i64> for Tick {
    type Output = Tick;
    fn mul(self, n: i64) -> Tick {
        Tick(self.0.saturating_mul(n))
    }
}

impl std::fmt::Display for Tick {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ns = self.0;
        let (unit, name) = match ns.unsigned_abs() {
            0 => return f.write_str("0s"),
            n if n % 1_000_000_000 == 0 => (1_000_000_000, "s"),
            n if n % 1_000_000 == 0 => (1_000_000, "ms"),
            n if n % 1_000 == 0 => (1_000, "us"),
            _ => (1, "ns"),
        };
        write!(f, "{}{name}", ns / unit)
    }
}

impl std::str::FromStr for Tick {
    type Err = TickParseError;

    /// Reads a decimal number with a unit `s`, `ms`, `us` (or `µs`), `ns`; exact, no rounding.
    fn from_str(text: &str) -> Result<Tick, TickParseError> {
        let fail = |reason| TickParseError { text: text.to_owned(), reason };
        let trimmed = text.trim();
        let split = trimmed
            .find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-' || c == '+'))
            .ok_or_else(|| fail("its unit is missing"))?;
        let (number, unit) = trimmed.split_at(split);
        let digits: u32 = match unit.trim() {
            "s" => 9,
            "ms" => 6,
            "us" | "µs" => 3,
            "ns" => 0,
            _ => return Err(fail("its unit is not s, ms, us or ns")),
        };
        let (negative, number) = match number.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, number.strip_prefix('+').unwrap_or(number)),
        };
        let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
        if whole.is_empty() && fraction.is_empty() {
            return Err(fail("it has no digits"));
        }
        // `parse` below would take a second sign.
        if [whole, fraction].iter().any(|s| s.contains(['-', '+'])) {
            return Err(fail("it has two signs"));
        }
        let fraction = fraction.trim_end_matches('0');
        if fraction.len() > digits as usize {
            return Err(fail("it is finer than a nanosecond"));
        }
        let parse = |s: &str| {
            if s.is_empty() { Some(0) } else { s.parse::<i64>().ok() }
        };
        let scale = 10_i64.pow(digits);
        let fraction_scale = 10_i64.pow(digits - fraction.len() as u32);
        parse(whole)
            .and_then(|w| w.checked_mul(scale))
            .zip(parse(fraction).map(|f| f * fraction_scale))
            .and_then(|(w, f)| w.checked_add(f))
            .map(|ns| Tick(if negative { -ns } else { ns }))
            .ok_or_else(|| fail("it is not a number within 292 years"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_parse_exactly() {
        for (text, ns) in [
            ("100ms", 100_000_000),
            ("2.5us", 2_500),
            ("0.1s", 100_000_000),
            ("-1.5 s", -1_500_000_000),
            (".5s", 500_000_000),
            ("7ns", 7),
        ] {
            assert_eq!(text.parse::<Tick>().unwrap(), Tick(ns), "{text}");
        }
        for text in ["", "1", "s", "1h", "0.5ns", "1.2.3s", "9999999999999s", "--1s", "1e3s"] {
            assert!(text.parse::<Tick>().is_err(), "{text}");
        }
    }

    #[test]
    fn display_reads_back() {
        for ns in [0, 1, 1_500, 100_000_000, 49_000_000_000, -2_000] {
            assert_eq!(Tick(ns).to_string().parse::<Tick>().unwrap(), Tick(ns));
        }
    }
}
