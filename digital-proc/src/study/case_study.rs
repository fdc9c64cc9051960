//! The paper's whole case study (§4) in one session: short period, long period, tankage, the
//! catalogue of failures, and sensitivities to dispersed parameters. It runs the studies after one
//! another and composes what they came to; judging and drawing are their own.

use super::{
    catalogue::{self, Catalogue, CataloguePlan},
    fault::StudyFault,
    long_period::{
        self,
        results::LongPeriodResults,
        run::{LongPeriodPlan, run as fly},
    },
    profile_cost,
    sensitivity::{
        self,
        dispersion_file::Dispersions,
        run::{PointSensitivity, loops, run as disperse},
    },
    short_period::{
        self,
        claims::{NORMAL, reduced_against_p1},
        control_loop::ControlLoop,
        machine::{self, Bench, Patches},
        plan::Plan,
        results::Results,
    },
    tankage::{self, Tankage},
};
use crate::{linkage::console::Console, report::block_diagram};
use desk::{
    claim::{Claim, Verdict},
    outcome::{Figure, Outcome},
};
use interface::profile::Profile;
use vehicle::Vehicle;

/// What is run.
#[derive(Clone, Debug, PartialEq)]
pub struct CasePlan {
    /// The short-period runs.
    pub short: Plan,
    /// The flights; their profile is that of the whole session.
    pub long: LongPeriodPlan,
    /// The catalogue, and the tankage with it, if they are asked for: most of all flights, and no
    /// claim needs them.
    pub catalogue: Option<CataloguePlan>,
    /// Dispersions of the pitch loop, if they are asked for; no claim needs them.
    pub dispersions: Option<Dispersions>,
}

impl CasePlan {
    /// Number of runs and flights.
    pub fn runs(&self) -> usize {
        let ideal = self.on_ideal().map_or(0, |(short, long)| short.cases.len() + long.flights());
        self.short.cases.len() + self.flights() + sensitivity_runs(self) + ideal
    }

    fn flights(&self) -> usize {
        let tankage = tankage::flights(self.long.modes.len());
        let catalogue = self.catalogue.as_ref().map_or(0, |plan| plan.flights() + tankage);
        self.long.flights() + catalogue
    }

    /// What is run on the ideal machine too, unless this is it: the normal condition and the modes'
    /// design cases, so that the machine's own share is seen.
    fn on_ideal(&self) -> Option<(Plan, LongPeriodPlan)> {
        let ideal = Profile::ideal();
        if self.long.profile == ideal {
            return None;
        }
        let mut short = self.short.clone();
        short.cases.retain(|case| self.short.conditions[case.condition].name == NORMAL);
        let long = LongPeriodPlan {
            envelope: Vec::new(),
            reversed: false,
            profile: ideal,
            ..self.long.clone()
        };
        Some((short, long))
    }
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResults {
    /// Short period.
    pub short: Results,
    /// Long period.
    pub long: LongPeriodResults,
    /// Tankage and the catalogue of failures.
    pub catalogue: Option<(Tankage, Catalogue)>,
    /// Sensitivities, point by point.
    pub sensitivity: Vec<PointSensitivity>,
    /// What of them was run on the ideal machine too, unless this is it.
    pub ideal: Option<(Results, LongPeriodResults)>,
    /// SHA-256 of each patch that ran, by its name.
    pub patches: Vec<(String, String)>,
}

/// Runs everything on one session; `progress` is told the number of runs done.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &CasePlan,
    mut progress: impl FnMut(usize),
) -> Result<CaseResults, StudyFault> {
    let profile = &plan.long.profile;
    let short = machine::run(
        console,
        &plan.short,
        &Patches::with_modes(plan.short.modes),
        profile,
        &mut progress,
    )?;
    let done = short.runs.len();
    let long = fly(console, vehicle, &plan.long, |flights| progress(done + flights))?;
    let stage = (plan.long.patch.root.clone(), console.patch_hash().to_owned());
    let patches = short.patches.iter().cloned().chain([stage]).collect();
    let done = done + plan.long.flights();
    let catalogue = match &plan.catalogue {
        Some(wanted) => {
            let flights = |flights| progress(done + flights);
            let tankage = tankage::run(console, vehicle, &plan.long, flights)?;
            let done = done + tankage::flights(plan.long.modes.len());
            let flights = |flights| progress(done + flights);
            Some((tankage, catalogue::run(console, vehicle, &plan.long, wanted, flights)?))
        }
        None => None,
    };
    let done = plan.short.cases.len() + plan.flights();
    let sensitivity = match &plan.dispersions {
        Some(dispersions) => {
            let bench = Bench::pitch(console, profile)?;
            disperse(console, &bench, vehicle, dispersions, |loops| progress(done + loops))?
        }
        None => Vec::new(),
    };
    let done = done + sensitivity_runs(plan);
    let ideal = match plan.on_ideal() {
        Some((cases, flights)) => {
            let patches = Patches::with_modes(plan.short.modes);
            let runs = machine::run(console, &cases, &patches, &flights.profile, |runs| {
                progress(done + runs);
            })?;
            let done = done + runs.runs.len();
            let flown = fly(console, vehicle, &flights, |flights| progress(done + flights))?;
            Some((runs, flown))
        }
        None => None,
    };
    Ok(CaseResults { short, long, catalogue, sensitivity, ideal, patches })
}

fn sensitivity_runs(plan: &CasePlan) -> usize {
    plan.dispersions.as_ref().map_or(0, loops)
}

impl CaseResults {
    /// Everything together. The case study fails where a claim does not hold or is not judged.
    pub fn outcome(&self, plan: &CasePlan) -> Outcome {
        let of = |control_loop| plan.short.of(control_loop).count();
        let mut out = Outcome::new(
            "First-stage control system: the case study rerun",
            format!(
                "Section 4 of the paper on the hybrid machine: {} pitch runs and {} yaw–roll runs at {} trajectory points, and {} flights to burn-out, all in one session. Each claim quotes the paper's whole sentence, says what was asked of the runs and what would falsify it, what was measured, and, where it holds only in part, where not and why; the sections below show what was run and what came out.",
                of(ControlLoop::Pitch),
                of(ControlLoop::YawRoll),
                plan.short.points.len(),
                plan.flights()
            ),
        );
        out.section("Partition").figure(Figure::new(
            "partition",
            "Who computes what in the long-period flights: control dynamics in the analog processor, trajectory dynamics in the digital one. In the short-period runs the whole loop is patched; the digital side sets coefficients, initial conditions, disturbances and modes, and reads the answers.",
            block_diagram(),
        ));
        short_period::paper::fill(&self.short, &mut out);
        long_period::outcome::fill(&self.long, plan.long.step, &mut out);
        if let Some((tankage, catalogue)) = &self.catalogue {
            tankage.fill(&mut out);
            catalogue.fill(&mut out);
        }
        if let Some(dispersions) = &plan.dispersions {
            sensitivity::outcome::fill(&self.sensitivity, dispersions, &mut out);
        }
        if let Some((short, long)) = &self.ideal {
            out.section("What the machine costs")
                .aside(format!(
                    "The same study on the ideal machine, beside the profile `{}`: {} What its components, converters and latency do to each measure of the normal condition and of the modes' design cases is shown where it is most.",
                    plan.long.profile.name, plan.long.profile.note
                ))
                .table(
                    "profile_cost",
                    "Measures on this machine and on the ideal one, each at the run or mode where they differ most.",
                    profile_cost::table((&self.short, &self.long), (short, long)),
                );
        }
        out.claims_on_terminal();
        re_evaluated(&mut out.claims, reduced_against_p1(&self.short));
        let not_judged = out.claims.iter().filter(|c| c.verdict == Verdict::NotJudged);
        let not_judged: Vec<&str> = not_judged.map(|c| &*c.id).collect();
        if !not_judged.is_empty() {
            out.refused.push(format!("not judged: {}", not_judged.join(", ")));
        }
        out
    }
}

/// The paper: the reduced schedule "has to be reevaluated again by reverting to the short period
/// analysis". What that finds belongs beside its claim.
fn re_evaluated(claims: &mut [Claim], found: Option<(bool, String)>) {
    let claim = claims.iter_mut().find(|c| c.id == "L3");
    if let (Some(claim), Some((meets, found))) = (claim, found) {
        if meets && claim.verdict == Verdict::InPart {
            claim.verdict = Verdict::Holds;
        }
        claim.remark = Some(format!("re-evaluated with the short-period models, {found}"));
    }
}
