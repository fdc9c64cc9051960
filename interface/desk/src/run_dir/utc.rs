//! A whole second of Coordinated Universal Time, for naming runs. It reads no clock.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

/// Seconds since 1970-01-01T00:00:00Z, leap seconds not counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UtcSecond(pub i64);

impl UtcSecond {
    /// The second in which `time` lies; 1970 when the clock stands before it.
    pub fn from_system(time: SystemTime) -> UtcSecond {
        let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
        UtcSecond(i64::try_from(seconds).unwrap_or(i64::MAX))
    }

    /// `2026-03-01T12-34-56`: sorts by time and is a legal name on every file system.
    pub fn file_name(self) -> String {
        self.to_string().replace(':', "-").replace('Z', "")
    }

    /// Year, month, day by the proleptic Gregorian calendar.
    fn date(self) -> (i64, i64, i64) {
        // Counting years from 1 March puts the leap day last, which makes the months'
        // lengths 31,30,31,30,31 repeat: month = (5 d + 2) / 153.
        let days = self.0.div_euclid(86_400) + 719_468; // from 0000-03-01
        let era = days.div_euclid(146_097);
        let day_of_era = days.rem_euclid(146_097);
        let year_of_era =
            (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
        let month = (shifted_month + 2) % 12 + 1;
        let year = era * 400 + year_of_era + i64::from(month <= 2);
        (year, month, day)
    }
}

impl fmt::Display for UtcSecond {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (year, month, day) = self.date();
        let second = self.0.rem_euclid(86_400);
        write!(
            f,
            "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z",
            second / 3_600,
            second / 60 % 60,
            second % 60
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_dates() {
        // Reference values from POSIX `date -u -d @N`.
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_164_800, "2024-02-29T00:00:00Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
            (-1, "1969-12-31T23:59:59Z"),
        ] {
            assert_eq!(UtcSecond(seconds).to_string(), text);
        }
    }
}
