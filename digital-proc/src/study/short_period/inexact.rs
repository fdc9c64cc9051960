//! What a machine leaves uncertain of a patched loop: its components by the profile's error, its
//! converters by half a step of what each is scaled for in the patch.
//!
//! It reads scale factors only (`range` of coefficient units, `max` of sampled channels); that the
//! patch is sound is the analog side's business, and what cannot be read adds nothing here.

use interface::{control::PatchBundle, profile::Profile};
use std::collections::BTreeMap;

/// By a profile and the scaling of a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inexact {
    /// Greatest relative error of the coefficient of an input.
    pub component_error: f64,
    /// Time between neighbouring sampled channels, s.
    pub skew_s: f64,
    half_steps: BTreeMap<String, f64>,
}

impl Inexact {
    /// Of a patch on a machine.
    pub fn new(patch: &PatchBundle, profile: &Profile) -> Inexact {
        let mut inexact = Inexact {
            component_error: profile.component_error(),
            skew_s: profile.skew().secs(),
            half_steps: BTreeMap::new(),
        };
        for (block, kind, scale) in scales(patch) {
            let converter = match kind.as_str() {
                "dcu" => profile.coefficient_unit(Some(scale)),
                _ => profile.adc_converter(Some(scale)),
            };
            if let Some(step) = converter.ok().and_then(|converter| converter.lsb()) {
                inexact.half_steps.insert(block, step / 2.0);
            }
        }
        inexact
    }

    /// Half a step of a coefficient unit or a sampled channel, in its unit; 0 where it has none.
    pub fn half_step(&self, block: &str) -> f64 {
        self.half_steps.get(block).copied().unwrap_or(0.0)
    }

    /// Whether nothing is uncertain.
    pub fn is_none(&self) -> bool {
        self.component_error == 0.0 && self.half_steps.is_empty()
    }
}

/// Block, kind and scale of every coefficient unit and sampled channel that states one; blocks of
/// sub-patches under the name of their use.
pub fn scales(patch: &PatchBundle) -> Vec<(String, String, f64)> {
    let read = |name: &str| -> Option<toml::Table> {
        let (_, text) = patch.files.iter().find(|(file, _)| file == name)?;
        toml::from_str(text).ok()
    };
    let mut found = Vec::new();
    let mut of = |prefix: &str, file: &toml::Table| {
        for (name, block) in file.get("blocks").and_then(|b| b.as_table()).into_iter().flatten() {
            let number = |key: &str| {
                let value = block.get(key)?;
                value.as_float().or(value.as_integer().map(|i| i as f64))
            };
            let kind = block.get("kind").and_then(|k| k.as_str()).unwrap_or_default();
            let scale = match kind {
                "dcu" => number("range"),
                "adc" => number("max"),
                _ => None,
            };
            found.extend(scale.map(|scale| (format!("{prefix}{name}"), kind.to_owned(), scale)));
        }
    };
    let Some(root) = read(&patch.root) else { return Vec::new() };
    of("", &root);
    for (name, used) in root.get("use").and_then(|u| u.as_table()).into_iter().flatten() {
        let file = used.get("patch").and_then(|p| p.as_str()).and_then(read);
        file.iter().for_each(|file| of(&format!("{name}."), file));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::{
        control_loop::ControlLoop, machine::Patches, plan::Plan, study_file::Study,
    };
    use vehicle::Vehicle;

    /// Amplitude scaling of the shipped patches: no coefficient of the study leaves its unit, and
    /// the largest of each uses an eighth of it at least (three of fourteen bits unused).
    #[test]
    fn every_coefficient_is_scaled() {
        let plan = Plan::new(&Study::shipped().unwrap(), &Vehicle::shipped().unwrap()).unwrap();
        let mut faults = Vec::new();
        for control_loop in ControlLoop::ALL {
            let scales = scales(Patches::shipped().of(control_loop));
            for (block, _, scale) in scales.iter().filter(|(_, kind, _)| kind == "dcu") {
                // A sub-patch serves both loops.
                let set = plan.cases.iter().flat_map(|case| case.settings.values());
                let values = set.filter(|(name, _)| name == block).map(|(_, value)| value.abs());
                let greatest = values.fold(0.0, f64::max);
                if !(scale / 8.0..=*scale).contains(&greatest) {
                    faults.push(format!("{block}: {greatest} in {scale}"));
                }
            }
        }
        assert!(faults.is_empty(), "{faults:#?}");
    }
}
