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
}

impl fmt::Display for UtcSecond {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What no calendar holds is as far away as 1970.
        let time = chrono::DateTime::from_timestamp(self.0, 0).unwrap_or_default();
        write!(f, "{}", time.format("%Y-%m-%dT%H:%M:%SZ"))
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
