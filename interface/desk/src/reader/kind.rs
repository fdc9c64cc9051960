//! The kinds of file that users write, told apart by the keys at their top.

use super::Entry;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Patch,
    Profile,
    Vehicle,
    Failures,
    Study,
    Dispersions,
    LoopStudy,
    RunRecord,
}

/// Kind, its name, where it is given, keys that no other kind has; the first as it is written.
type Line = (FileKind, &'static str, &'static str, &'static [&'static str]);

const KINDS: [Line; 8] = [
    (
        FileKind::Patch,
        "a patch",
        "`analog-proc check FILE`",
        &["blocks", "ports", "use", "integration", "expect"],
    ),
    (
        FileKind::Profile,
        "a machine profile",
        "`--profile FILE`",
        &["counts", "machine", "adc", "dac", "dcu", "timing"],
    ),
    (
        FileKind::Vehicle,
        "a vehicle",
        "`--vehicle FILE`",
        &["geometry", "site", "mass", "thrust", "aero", "gains", "gains_reduced"],
    ),
    (FileKind::Failures, "a failure file", "`--failures FILE`", &["mode"]),
    (
        FileKind::Study,
        "a short-period study",
        "`digital-proc short-period pitch --study FILE`",
        &["condition", "point", "run", "pitch", "yaw-roll"],
    ),
    (
        FileKind::Dispersions,
        "a dispersion file",
        "`digital-proc sensitivity --dispersions FILE`",
        &["dispersion", "points"],
    ),
    (
        FileKind::LoopStudy,
        "a loop study",
        "`digital-proc sampling loop FILE`",
        &["law", "patch", "measure", "sweep"],
    ),
    (
        FileKind::RunRecord,
        "the record of a run",
        "`digital-proc list`",
        &["parameters", "command", "command-line", "started", "versions"],
    ),
];

impl FileKind {
    fn line(self) -> &'static Line {
        &KINDS[self as usize]
    }

    /// "a failure file".
    pub fn name(self) -> &'static str {
        self.line().1
    }

    /// The key that shows a file to be of another kind, with what to say about it; none where it
    /// has a key of this kind, or none of any.
    pub fn mistaken(self, entries: &[Entry]) -> Option<(&Entry, String, String)> {
        let marks =
            |line: &Line| entries.iter().filter(|e| line.3.contains(&e.key.as_str())).count();
        if marks(self.line()) > 0 {
            return None;
        }
        let found = KINDS.iter().max_by_key(|line| marks(line)).filter(|line| marks(line) > 0)?;
        let entry = entries.iter().find(|e| found.3.contains(&e.key.as_str()))?;
        let (_, name, _, keys) = self.line();
        let fault = format!("this is {} (it has `{}`), not {name}", found.1, entry.key);
        let remedy = format!("give {name}, which has `{}`; this file is for {}", keys[0], found.2);
        Some((entry, fault, remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reader::entries;
    use toml::de::DeTable;

    macro_rules! shipped {
        ($($kind:ident $file:literal)+) => {
            [$((FileKind::$kind, include_str!(concat!("../../../../", $file)))),+]
        };
    }

    #[test]
    fn each_shipped_file_is_told_from_the_other_kinds() {
        for (kind, text) in shipped! {
            Patch "patch-files/van-der-pol.toml"
            Profile "patch-files/machines/ad4.toml"
            Vehicle "digital-proc/data/vehicle.toml"
            Failures "digital-proc/data/failures.toml"
            Study "digital-proc/data/short-period.toml"
            Dispersions "digital-proc/data/dispersions.toml"
            LoopStudy "patch-files/studies/servo-loop.toml"
        } {
            let document = DeTable::parse(text).unwrap();
            let entries = entries(0, document.get_ref());
            for other in KINDS.map(|line| line.0) {
                let mistaken = other.mistaken(&entries);
                assert_eq!(mistaken.is_some(), kind != other, "{kind:?} as {other:?}");
                if let Some((_, fault, remedy)) = mistaken {
                    assert!(fault.starts_with(&format!("this is {}", kind.name())), "{fault}");
                    assert!(remedy.contains(kind.line().2), "{remedy}");
                }
            }
        }
    }
}
