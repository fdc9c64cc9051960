//! Machine profiles as files; three are built in.
//!
//! A number is written `{ value = 14, status = "memory", source = "…" }`; times are texts with a
//! unit (`"10us"`), so that they are exact ticks.

use crate::{
    faults::{FileFaults, Source},
    reader::{self, FileKind, SheetFields},
};
use interface::{
    Tick,
    converter::MAX_BITS,
    hold::HoldKind,
    profile::{AdcStage, BlockClass, DacStage, DcuStage, Profile, Provenance, Sourced},
};
use std::{ops::RangeInclusive, path::Path};

/// The built-in profiles by name.
pub const BUILT_IN: [(&str, &str); 3] = [
    ("ideal", include_str!("../../../patch-files/machines/ideal.toml")),
    ("paper-class", include_str!("../../../patch-files/machines/paper-class.toml")),
    ("ad4", include_str!("../../../patch-files/machines/ad4.toml")),
];

/// A built-in profile by name, or a user's file by path.
pub fn load(name_or_path: &str) -> Result<Profile, FileFaults> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_path) {
        return parse(&format!("machines/{name}.toml"), text);
    }
    let path = Path::new(name_or_path);
    reader::load(path, parse).map_err(|mut faults| {
        if !path.is_file() {
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            faults.0[0].remedy = format!("name a file, or one of the built-in profiles {names}");
        }
        faults
    })
}

/// Reads a text; `file` is only named in faults.
pub fn parse(file: &str, text: &str) -> Result<Profile, FileFaults> {
    reader::read(FileKind::Profile, Source { file, text }, profile)
}

fn profile(f: &mut SheetFields<'_, '_>) -> Option<Profile> {
    let name = f.text("name");
    let note = f.text_or_none("note");
    let mut profile = Profile::ideal();
    f.table_or_none("machine", |f| {
        profile.reference_v = sourced(f, "reference-v", |f| f.positive("value", None));
        profile.overload_level = sourced(f, "overload-level", |f| {
            f.ranged("value", None, "at least 1 machine unit", |v| v >= 1.0)
        });
        profile.component_error = sourced(f, "component-error", |f| {
            f.ranged("value", None, "a fraction from 0 to below 1", |v| (0.0..1.0).contains(&v))
        });
        Some(())
    });
    f.table_or_none("counts", |f| {
        for class in BlockClass::ALL {
            let count = whole(f, class.key(), 0..=1_000_000);
            profile.counts.extend(count.map(|count| (class, count)));
        }
        Some(())
    });
    f.table_or_none("adc", |f| {
        profile.adc = AdcStage {
            bits: bits(f),
            conversion: duration(f, "conversion"),
            skew: duration(f, "skew"),
            aperture: duration(f, "aperture"),
        };
        Some(())
    });
    f.table_or_none("dac", |f| {
        profile.dac = DacStage {
            bits: bits(f),
            settling: duration(f, "settling"),
            hold: sourced(f, "hold", |f| {
                let kinds = [
                    ("zero-order", HoldKind::ZeroOrder),
                    ("extrapolating", HoldKind::Extrapolating),
                    ("interpolating", HoldKind::Interpolating),
                ];
                f.word("value", None, &kinds)
            }),
        };
        Some(())
    });
    f.table_or_none("dcu", |f| {
        let range = sourced(f, "range", |f| f.positive("value", None));
        profile.dcu = DcuStage { bits: bits(f), range };
        let has_range = profile.dcu.bits.is_none() || f.place("range").is_some();
        f.require(has_range, "bits", "`dcu.bits` needs a range", "add `range`");
        Some(())
    });
    f.table_or_none("timing", |f| {
        profile.latency = duration(f, "latency");
        profile.compute = duration(f, "compute");
        Some(())
    });
    Some(Profile { name: name?, note: note.unwrap_or_default(), ..profile })
}

/// The three parts of a number; its value is read by `read`.
fn sourced<T>(
    f: &mut SheetFields<'_, '_>,
    key: &'static str,
    read: impl FnOnce(&mut SheetFields<'_, '_>) -> Option<T>,
) -> Option<Sourced<T>> {
    let read = f.table_or_none(key, |f| {
        let statuses = [
            ("verified", Provenance::Verified),
            ("excerpt", Provenance::Excerpt),
            ("memory", Provenance::Memory),
            ("assumed", Provenance::Assumed),
        ];
        let (value, status, source) =
            (read(f), f.word("status", None, &statuses), f.text("source"));
        let remedy = "say where the number is from, or why it was assumed";
        let named = source.as_ref().is_none_or(|text| !text.trim().is_empty());
        f.require(named, "source", format!("the source of `{key}` is empty"), remedy);
        Some(Sourced { value: value?, status: status?, source: source? })
    });
    read.flatten()
}

fn whole(
    f: &mut SheetFields<'_, '_>,
    key: &'static str,
    range: RangeInclusive<u32>,
) -> Option<Sourced<u32>> {
    sourced(f, key, |f| f.whole_in("value", None, range))
}

fn bits(f: &mut SheetFields<'_, '_>) -> Option<Sourced<u32>> {
    whole(f, "bits", 2..=MAX_BITS)
}

/// A second is far beyond any converter, and keeps sums of ticks from overflow.
fn duration(f: &mut SheetFields<'_, '_>, key: &'static str) -> Option<Sourced<Tick>> {
    sourced(f, key, |f| f.duration("value", None, Tick::ZERO..=Tick::SECOND))
}

#[cfg(test)]
mod tests;
