//! The machine on which plans run, one after the other in one session.
//!
//! The law sees every frame but the last one, whose updates would never take effect. Every run
//! begins with a load: the patch's own initial values stand in every DAC and coefficient, so
//! that no run can see what another one left there, and a sweep gives the same numbers in any
//! order.

use super::plan::{LabError, Machine, RunPlan};
use crate::linkage::{
    console::{Console, ConsoleFault},
    saturation::Saturations,
};
use desk::progress::Progress;
use interface::{
    control::{Channel, LinearModel, PatchBundle, RunSpec},
    frame::{RunState, Samples, Updates},
    profile::{Profile, Provenance, Sourced},
};

macro_rules! shipped {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("../../../patch-files/", $name)))),*]
    };
}

/// Patch files of the laboratory with every file that they use, by path under `patch-files/`.
const SHIPPED: &[(&str, &str)] = shipped![
    "lab/alpha-conventional.toml"
    "lab/alpha-redundant.toml"
    "lab/axes.toml"
    "lab/circle.toml"
    "lab/coefficient.toml"
    "lab/function-generation.toml"
    "lab/quantisation.toml"
    "lab/root.toml"
    "lab/skew.toml"
    "redundant-integrator.toml"
];

/// A shipped patch and what it uses. A name that is not shipped has no files, which the
/// analog side refuses by that name.
fn shipped(root: &str) -> PatchBundle {
    let root_text = SHIPPED.iter().find(|(name, _)| *name == root).map_or("", |(_, text)| text);
    let files = SHIPPED
        .iter()
        .filter(|(name, _)| *name == root || root_text.contains(&format!("../{name}")))
        .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()))
        .collect();
    PatchBundle { root: root.to_owned(), files }
}

/// A number set by an experiment, not by a machine's data sheet.
pub(super) fn chosen<T>(value: T) -> Option<Sourced<T>> {
    Some(Sourced { value, status: Provenance::Assumed, source: "set by the experiment".to_owned() })
}

/// Converters and coefficients that saturated in a run, and when.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saturated {
    /// By name, as `DAC u`.
    pub channels: Vec<String>,
    /// Frames in which one was told, ascending; each happened in that frame or since the one before.
    pub frames: Vec<u64>,
}

/// A machine with all that was seen on it.
pub struct Bench<'c, 'p> {
    console: &'c mut Console<'p>,
    base: Profile,
    patch: String,
    saturated: Vec<String>,
}

impl<'c, 'p> Bench<'c, 'p> {
    /// Over a console; `base` is the profile whose hold each plan replaces by its own.
    pub fn new(console: &'c mut Console<'p>, base: Profile) -> Bench<'c, 'p> {
        Bench { console, base, patch: String::new(), saturated: Vec::new() }
    }

    /// The profile under every plan.
    pub fn base(&self) -> &Profile {
        &self.base
    }

    /// Name and SHA-256 of the patch that was loaded last.
    pub fn patch(&self) -> (&str, &str) {
        (&self.patch, self.console.patch_hash())
    }

    /// Converters and coefficients that saturated in any plan so far.
    pub fn saturated(&self) -> &[String] {
        &self.saturated
    }

    /// The console, for flights, which load `patch` themselves.
    pub fn console(&mut self, patch: &str) -> &mut Console<'p> {
        patch.clone_into(&mut self.patch);
        self.console
    }

    /// Loads any patch under any profile; gives its channels.
    pub fn load(
        &mut self,
        bundle: PatchBundle,
        params: Vec<(String, f64)>,
        profile: Profile,
    ) -> Result<&[Channel], LabError> {
        self.patch.clone_from(&bundle.root);
        self.console.load(bundle, params, profile)?;
        Ok(self.console.channels())
    }

    /// Operates what is loaded; gives what saturated.
    pub fn operate(
        &mut self,
        spec: &RunSpec,
        law: &mut dyn FnMut(&Samples, &mut Updates),
    ) -> Result<Saturated, LabError> {
        let mut all = Saturations::default();
        let mut frames = Vec::new();
        self.console.run(spec, &mut |samples: &Samples, updates: &mut Updates| {
            if all.note(samples) {
                frames.push(samples.frame);
            }
            if samples.run_state() != RunState::Ended {
                law(samples, updates);
            }
        })?;
        Ok(Saturated { channels: all.names(self.console.channels()), frames })
    }

    /// The linear model of what is loaded.
    pub fn linearise(
        &mut self,
        inputs: &[&str],
        outputs: &[&str],
    ) -> Result<LinearModel, ConsoleFault> {
        self.console.linearise(inputs, outputs)
    }

    /// Keeps what saturated for the end of the experiment, and reads nets.
    pub fn finish(&mut self, saturated: Saturated, nets: &[&str]) -> Result<Vec<f64>, LabError> {
        for name in saturated.channels {
            if !self.saturated.contains(&name) {
                self.saturated.push(name);
            }
        }
        if nets.is_empty() {
            return Ok(Vec::new());
        }
        let values = self.console.read(nets.iter().map(|n| (*n).to_owned()).collect())?;
        if values.len() != nets.len() {
            return Err(ConsoleFault::WrongReply { request: "a read-back" }.into());
        }
        Ok(values)
    }

    /// Runs case after case, with a bar where it takes long.
    pub fn each<C, R, E>(
        &mut self,
        cases: impl IntoIterator<Item = C>,
        mut run: impl FnMut(&mut Self, C) -> Result<R, E>,
    ) -> Result<Vec<R>, E> {
        let cases: Vec<C> = cases.into_iter().collect();
        let mut progress = Progress::new(cases.len() as u64, "cases");
        let mut rows = Vec::with_capacity(cases.len());
        for case in cases {
            rows.push(run(self, case)?);
            progress.at(rows.len() as u64);
        }
        progress.done();
        Ok(rows)
    }
}

impl Machine for Bench<'_, '_> {
    fn run(
        &mut self,
        plan: &RunPlan,
        law: &mut dyn FnMut(&Samples, &mut Updates),
    ) -> Result<Vec<f64>, LabError> {
        let mut profile = self.base.clone();
        profile.dac.hold = chosen(plan.hold.into());
        if let Some(bits) = plan.dac_bits {
            profile.dac.bits = chosen(bits);
        }
        let params = plan.params.iter().map(|(n, v)| ((*n).to_owned(), *v));
        self.load(shipped(plan.patch), params.collect(), profile)?;
        let saturated = self.operate(&plan.spec, law)?;
        self.finish(saturated, plan.read)
    }
}
