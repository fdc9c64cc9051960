//! Runs the laboratory's plans on a machine, one after the other in one session.
//!
//! A [`RunPlan`] becomes a load, a profile and a run request; the law sees every frame but the last
//! one, whose updates would never take effect. Every run begins with a load: the patch's own
//! initial values stand in every DAC and coefficient, so that no run can see what another one left
//! there, and a sweep gives the same numbers in any order.

use super::{
    alpha::{AlphaRow, AlphaSetting},
    axes::{AxesRow, AxesSetting},
    converter_error::{
        CoefficientRow, CoefficientSetting, QuantisationSetting, SkewRow, SkewSetting, VarianceRow,
    },
    feedback::{CircleRow, CircleSetting, RootRow, RootSetting},
    function_generation::{Correlated, FunctionRow, FunctionSetting, Way},
    loop_study::{LoopCase, LoopRow, LoopStudy, Saturated},
    plan::{LabError, RunPlan},
    theory::hold::Hold,
};
use crate::{
    console::{Console, ConsoleFault},
    saturation::Saturations,
};
use desk::faults::FileFaults;
use interface::{
    Tick,
    control::{Clock, PatchBundle, RunSpec},
    frame::{RunState, Samples, Updates},
    hold::HoldKind,
    profile::{Profile, Provenance, Sourced},
};

/// Why an experiment gave no row.
#[derive(Debug, thiserror::Error)]
pub enum BenchFault {
    /// The machine or its link.
    #[error(transparent)]
    Console(#[from] ConsoleFault),
    /// The setting, the theory or the record.
    #[error(transparent)]
    Lab(#[from] LabError),
    /// The user's study.
    #[error(transparent)]
    Study(#[from] FileFaults),
    /// A shipped patch that is not built in.
    #[error("there is no shipped patch `{0}`; the laboratory's are {list}", list = shipped_names())]
    NoPatch(String),
}

/// Patch files of the laboratory with every file that they use, by path under `patch-files/`.
const SHIPPED: &[(&str, &str)] = &[
    (
        "lab/alpha-conventional.toml",
        include_str!("../../../patch-files/lab/alpha-conventional.toml"),
    ),
    ("lab/alpha-redundant.toml", include_str!("../../../patch-files/lab/alpha-redundant.toml")),
    ("lab/axes.toml", include_str!("../../../patch-files/lab/axes.toml")),
    ("lab/circle.toml", include_str!("../../../patch-files/lab/circle.toml")),
    ("lab/coefficient.toml", include_str!("../../../patch-files/lab/coefficient.toml")),
    (
        "lab/function-generation.toml",
        include_str!("../../../patch-files/lab/function-generation.toml"),
    ),
    ("lab/quantisation.toml", include_str!("../../../patch-files/lab/quantisation.toml")),
    ("lab/root.toml", include_str!("../../../patch-files/lab/root.toml")),
    ("lab/skew.toml", include_str!("../../../patch-files/lab/skew.toml")),
    ("redundant-integrator.toml", include_str!("../../../patch-files/redundant-integrator.toml")),
];

fn shipped_names() -> String {
    let names: Vec<&str> = SHIPPED.iter().map(|(name, _)| *name).collect();
    names.join(", ")
}

/// A shipped patch of the laboratory and what it uses.
///
/// # Errors
/// [`BenchFault::NoPatch`] for any other name.
pub fn shipped(root: &str) -> Result<PatchBundle, BenchFault> {
    let file = |name: &str| SHIPPED.iter().find(|(n, _)| *n == name);
    let Some((_, text)) = file(root) else {
        return Err(BenchFault::NoPatch(root.to_owned()));
    };
    let mut files = vec![(root.to_owned(), (*text).to_owned())];
    if text.contains("redundant-integrator.toml")
        && let Some((name, text)) = file("redundant-integrator.toml")
    {
        files.push(((*name).to_owned(), (*text).to_owned()));
    }
    Ok(PatchBundle { root: root.to_owned(), files })
}

/// A number set by an experiment, not by a machine's data sheet.
pub fn chosen<T>(value: T) -> Option<Sourced<T>> {
    Some(Sourced { value, status: Provenance::Assumed, source: "set by the experiment".to_owned() })
}

/// The wire's name of a hold.
pub fn hold_kind(hold: Hold) -> HoldKind {
    match hold {
        Hold::ZeroOrder => HoldKind::ZeroOrder,
        Hold::Extrapolating => HoldKind::Extrapolating,
        Hold::Interpolating => HoldKind::Interpolating,
    }
}

/// A machine on which plans are run.
pub struct Bench<'c, 'p> {
    console: &'c mut Console<'p>,
    base: Profile,
    saturated: Vec<String>,
}

impl<'c, 'p> Bench<'c, 'p> {
    /// Over a console; `base` is the profile whose hold each plan replaces by its own.
    pub fn new(console: &'c mut Console<'p>, base: Profile) -> Bench<'c, 'p> {
        Bench { console, base, saturated: Vec::new() }
    }

    /// Converters and coefficients that saturated in any run so far; a study tells its own with
    /// each case.
    pub fn saturated(&self) -> &[String] {
        &self.saturated
    }

    /// The console, to read what a run left on the analog side.
    pub fn console(&mut self) -> &mut Console<'p> {
        self.console
    }

    /// The profile under every plan.
    pub fn base(&self) -> &Profile {
        &self.base
    }

    /// The profile for a plan.
    pub fn profile(&self, hold: Hold) -> Profile {
        let mut profile = self.base.clone();
        profile.dac.hold = chosen(hold_kind(hold));
        profile
    }

    /// Runs a plan on its shipped patch with the base profile and the plan's hold.
    ///
    /// # Errors
    /// [`BenchFault`] from the machine.
    pub fn run(
        &mut self,
        plan: &RunPlan,
        law: impl FnMut(&Samples, &mut Updates),
    ) -> Result<(), BenchFault> {
        let bundle = shipped(plan.patch)?;
        let profile = self.profile(plan.hold);
        self.run_patch(bundle, profile, plan, law)
    }

    /// Runs a plan on any patch and profile.
    ///
    /// # Errors
    /// [`BenchFault`] from the machine.
    pub fn run_patch(
        &mut self,
        bundle: PatchBundle,
        profile: Profile,
        plan: &RunPlan,
        law: impl FnMut(&Samples, &mut Updates),
    ) -> Result<(), BenchFault> {
        let params = plan.params.iter().map(|(n, v)| ((*n).to_owned(), *v));
        self.console.load(bundle, params.collect(), profile)?;
        self.operate(plan.frame, plan.latency, plan.skew, plan.stop, law)
    }

    /// Operates what is loaded from its initial condition.
    ///
    /// # Errors
    /// [`BenchFault`] from the machine.
    pub fn operate(
        &mut self,
        frame: Tick,
        latency: Tick,
        skew: Tick,
        stop: Tick,
        law: impl FnMut(&Samples, &mut Updates),
    ) -> Result<(), BenchFault> {
        let (saturations, _) = self.operate_noting(frame, latency, skew, stop, law)?;
        for name in saturations.names(self.console.channels()) {
            if !self.saturated.contains(&name) {
                self.saturated.push(name);
            }
        }
        Ok(())
    }

    /// The same; what saturated in this run, and the frames in which it was told.
    fn operate_noting(
        &mut self,
        frame: Tick,
        latency: Tick,
        skew: Tick,
        stop: Tick,
        mut law: impl FnMut(&Samples, &mut Updates),
    ) -> Result<(Saturations, Vec<u64>), BenchFault> {
        let spec = RunSpec { frame, latency, skew, stop, from_ic: true, clock: Clock::LockStep };
        let mut saturations = Saturations::default();
        let mut frames = Vec::new();
        self.console.operate::<ConsoleFault>(&spec, |samples, updates| {
            if saturations.note(samples) {
                frames.push(samples.frame);
            }
            if samples.run_state() != RunState::Ended {
                law(samples, updates);
            }
            Ok(())
        })?;
        Ok((saturations, frames))
    }

    /// Circle test.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn circle(&mut self, setting: &CircleSetting) -> Result<CircleRow, BenchFault> {
        let mut law = setting.law();
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        Ok(setting.row(&law)?)
    }

    /// Root of a sampled second-order loop.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn root(&mut self, setting: &RootSetting) -> Result<RootRow, BenchFault> {
        let mut law = setting.law();
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        Ok(setting.row(&law)?)
    }

    /// α loop, conventional or redundant; also its record of angles at the slow samples, rad.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn alpha(&mut self, setting: &AlphaSetting) -> Result<(AlphaRow, Vec<f64>), BenchFault> {
        let mut law = setting.law()?;
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        Ok((setting.row(&law)?, law.record().to_vec()))
    }

    /// Function generation, the three ways of one run.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn function(&mut self, setting: &FunctionSetting) -> Result<Vec<FunctionRow>, BenchFault> {
        let mut law = setting.law()?;
        self.run(&setting.plan()?, |s, up| {
            law.step(s.frame, &s.adc, s.sense, up);
        })?;
        let exact = self.correlated("exact")?;
        [(Way::AllDigital, "all_digital"), (Way::Hybrid, "hybrid"), (Way::LocalCell, "local")]
            .into_iter()
            .map(|(way, name)| Ok(setting.row(way, self.correlated(name)?, exact)?))
            .collect()
    }

    fn correlated(&mut self, name: &str) -> Result<Correlated, BenchFault> {
        let nets = ["sine", "cosine", "square"].map(|what| format!("{name}_{what}"));
        let values = self.console.read(nets.into())?;
        let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        Ok(Correlated { sine: at(0), cosine: at(1), square: at(2) })
    }

    /// Three systems of axes from the samples of one run.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn axes(&mut self, setting: &AxesSetting) -> Result<Vec<AxesRow>, BenchFault> {
        let mut law = setting.law();
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        Ok(setting.rows(&law)?)
    }

    /// Quantisation noise.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn quantisation(
        &mut self,
        setting: &QuantisationSetting,
    ) -> Result<Vec<VarianceRow>, BenchFault> {
        let plan = setting.plan()?;
        let mut profile = self.profile(plan.hold);
        profile.dac.bits = chosen(setting.bits);
        let mut law = setting.law()?;
        self.run_patch(shipped(plan.patch)?, profile, &plan, |s, up| {
            law.step(s.frame, &s.adc, up);
        })?;
        Ok(setting.rows(&law))
    }

    /// Resolver pair read with a multiplexer's skew.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn skew(&mut self, setting: &SkewSetting) -> Result<SkewRow, BenchFault> {
        let mut law = setting.law();
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        Ok(setting.row(&law))
    }

    /// Staircase of a digital coefficient.
    ///
    /// # Errors
    /// [`BenchFault`] from setting, machine or record.
    pub fn coefficient(
        &mut self,
        setting: &CoefficientSetting,
    ) -> Result<CoefficientRow, BenchFault> {
        let mut law = setting.law();
        self.run(&setting.plan()?, |s, up| law.step(s.frame, &s.adc, up))?;
        let nets = ["error_sum", "square_sum"].map(str::to_owned);
        let values = self.console.read(nets.into())?;
        let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        Ok(setting.row(at(0), at(1)))
    }

    /// One case of a user's study on the user's patch.
    ///
    /// # Errors
    /// [`BenchFault`] from study, machine or record.
    pub fn study_case(
        &mut self,
        study: &LoopStudy,
        bundle: &PatchBundle,
        case: &LoopCase,
    ) -> Result<LoopRow, BenchFault> {
        let mut profile = self.base.clone();
        if let Some(bits) = case.bits {
            profile.adc.bits = chosen(bits);
            profile.dac.bits = chosen(bits);
        }
        let bits = profile.adc.bits.as_ref().map(|b| b.value);
        self.console.load(bundle.clone(), study.params.clone(), profile)?;
        let mut law = study.law(self.console.channels())?;
        let (saturations, frames) =
            self.operate_noting(case.frame, case.latency, Tick::ZERO, study.stop, |s, up| {
                law.step(s.frame, &s.adc, up);
            })?;
        let saturated = Saturated { channels: saturations.names(self.console.channels()), frames };
        let mut row = study.row(case, &law, &saturated)?;
        row.bits = bits;
        Ok(row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_patches_bring_what_they_use() {
        let bundle = shipped("lab/alpha-redundant.toml").unwrap();
        let names: Vec<&str> = bundle.files.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(names, ["lab/alpha-redundant.toml", "redundant-integrator.toml"]);
        assert_eq!(shipped("lab/circle.toml").unwrap().files.len(), 1);
        assert!(shipped("lab/none.toml").is_err());
    }
}
