//! `run.toml`: everything needed to repeat a run, and when it was made.

use std::collections::BTreeMap;
use std::fmt;

use super::UtcSecond;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The record of one run. Times live here and never in the trace, so that equal runs have
/// equal traces. TOML integers end at 2⁶³−1: larger numbers among `parameters` are refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunRecord {
    /// The command, in short (`fly normal`).
    pub command: String,
    /// The command line as typed, word by word.
    pub command_line: Vec<String>,
    /// When it started, `2026-03-01T12:34:56Z`.
    pub started: String,
    pub profile: String,
    /// How the two processes were joined: `shm` or `memory`.
    pub link: String,
    /// Programs and data sets with their versions.
    pub versions: BTreeMap<String, String>,
    /// The patch that ran.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub patch: Option<PatchIdentity>,
    /// Seeds of every random source.
    #[serde(skip_serializing_if = "BTreeMap::is_empty", default)]
    pub seeds: BTreeMap<String, Seed>,
    /// Everything else that was set: numbers, texts, nested tables.
    #[serde(skip_serializing_if = "toml::Table::is_empty", default)]
    pub parameters: toml::Table,
}

/// Which patch, by content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PatchIdentity {
    /// Path or built-in name.
    pub name: String,
    /// SHA-256 of its text with all sub-patches, hexadecimal.
    pub sha256: String,
}

/// A 64-bit seed, written `0x0123456789abcdef` because a TOML integer has only 63 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seed(pub u64);

impl fmt::Display for Seed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "0x{:016x}", self.0)
    }
}

impl Serialize for Seed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Seed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Seed, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.strip_prefix("0x")
            .and_then(|digits| u64::from_str_radix(digits, 16).ok())
            .map(Seed)
            .ok_or_else(|| {
                serde::de::Error::custom(format!(
                    "seed `{text}` is not 0x and up to 16 hexadecimal digits"
                ))
            })
    }
}

impl RunRecord {
    /// The record of a run of this command line that starts now, with nothing set yet.
    pub fn begin(
        command: impl Into<String>,
        started: UtcSecond,
        profile: &str,
        link: &str,
    ) -> RunRecord {
        RunRecord {
            command: command.into(),
            command_line: std::env::args_os().map(|w| w.to_string_lossy().into_owned()).collect(),
            started: started.to_string(),
            profile: profile.to_owned(),
            link: link.to_owned(),
            versions: BTreeMap::from([(
                "hybrid-computer".to_owned(),
                env!("CARGO_PKG_VERSION").to_owned(),
            )]),
            patch: None,
            seeds: BTreeMap::new(),
            parameters: toml::Table::new(),
        }
    }

    /// The record as the text of `run.toml`.
    pub(super) fn to_toml(&self) -> Result<String, toml::ser::Error> {
        Ok(format!("# Everything needed to repeat this run.\n{}", toml::to_string_pretty(self)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_reads_back_and_a_bad_seed_says_so() {
        let mut record = RunRecord::begin("fly normal", UtcSecond(0), "ideal", "shm");
        record.seeds.insert("gyro-noise".to_owned(), Seed(u64::MAX));
        record.parameters = toml::toml! { frame = "100ms" [wind] shear_per_s = 0.028 };
        let text = record.to_toml().unwrap();
        assert_eq!(toml::from_str::<RunRecord>(&text).unwrap(), record);
        assert!(text.contains("gyro-noise = \"0xffffffffffffffff\""), "{text}");
        let damaged = text.replace("0xffff", "ffff");
        let error = toml::from_str::<RunRecord>(&damaged).unwrap_err().to_string();
        assert!(error.contains("hexadecimal"), "{error}");
    }
}
