//! How much a run would write, before it fills a disk.

use desk::{failure::Failure, note};
use interface::Tick;
use std::path::Path;

/// More rows than this are worth a word: a plot shows thousands.
const MANY_ROWS: u64 = 100_000_000;
/// Bytes of a number with its comma in 17 significant digits, on average.
const CSV_BYTES: u64 = 24;
/// Bytes of a number in an Arrow batch.
const ARROW_BYTES: u64 = 8;

/// Rows and bytes of a record of `columns` numbers a row, the time included.
fn size(until: Tick, every: Tick, columns: usize, arrow: bool) -> (u64, u64) {
    let rows = (until.0.max(0) / every.0.max(1)) as u64 + 1;
    let each = if arrow { ARROW_BYTES } else { CSV_BYTES };
    let bytes = rows.saturating_mul(columns as u64).saturating_mul(each);
    (rows, bytes)
}

fn words(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{} kB", bytes.div_ceil(1000)),
        1_000_000..1_000_000_000 => format!("{} MB", bytes / 1_000_000),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

/// Bytes that the file system of `out` has left for this user, where it is a file.
fn room(out: &Path) -> Option<u64> {
    if out.as_os_str() == "-" || std::fs::metadata(out).is_ok_and(|m| !m.is_file()) {
        return None;
    }
    let folder = out.parent().filter(|f| !f.as_os_str().is_empty());
    let stat = rustix::fs::statvfs(folder.unwrap_or(Path::new("."))).ok()?;
    Some(stat.f_bavail.saturating_mul(stat.f_frsize))
}

/// Refuses a record that cannot fit on its disk; says so of one that is very long.
pub fn check(out: &Path, until: Tick, every: Tick, columns: usize) -> Result<(), Failure> {
    let arrow = out.extension().is_some_and(|e| e == "arrow");
    let (rows, bytes) = size(until, every, columns, arrow);
    let (what, remedy) = (
        format!("{rows} rows, about {}", words(bytes)),
        "raise --every, or record fewer nets with --record",
    );
    if let Some(room) = room(out).filter(|room| bytes > *room) {
        return Err(Failure::input(format!(
            "{} cannot take {what}: its disk has {} left; {remedy}",
            out.display(),
            words(room)
        )));
    }
    if rows > MANY_ROWS {
        note!("note: this run records {what}; {remedy}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_counted_with_the_first_and_the_last() {
        let second = Tick::SECOND;
        assert_eq!(size(second, second, 2, true), (2, 32));
        assert_eq!(size(Tick::ZERO, second, 2, false), (1, 48));
        assert_eq!(size(Tick(10), Tick(3), 1, true), (4, 32));
        // No number of ticks overflows.
        assert_eq!(size(Tick(i64::MAX), Tick(1), 100, false).1, u64::MAX);
    }

    #[test]
    fn what_no_disk_can_hold_is_refused_before_it_is_begun() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("r.csv");
        let refused = check(&out, Tick(i64::MAX), Tick(1), 10).err().unwrap();
        assert!(refused.text.contains("--every"), "{}", refused.text);
        assert!(!out.exists());
        assert!(check(&out, Tick::SECOND, Tick(1_000_000), 10).is_ok());
        // What is no file has no end.
        assert!(check(Path::new("/dev/null"), Tick(i64::MAX), Tick(1), 10).is_ok());
    }
}
