//! The paper's whole case study (§4) in one session: short period, long period, and
//! sensitivities to dispersed parameters.
//!
//! The plans are data, so that a caller (the command, or a test that spoils
//! something on purpose) decides what runs; judging is the studies' own.

use super::gain_design::{bench::PitchBench, design::DesignFault};
use super::long_period::{
    self,
    results::LongPeriodResults,
    run::{LongPeriodPlan, StudyFault},
};
use super::sensitivity::{
    dispersion_file::Dispersions,
    run::{PointSensitivity, loops, run as disperse},
};
use super::short_period::{
    self,
    claims::NORMAL,
    machine::{self, Patches},
    outcome::Outcome,
    plan::Plan,
};
use crate::console::{Console, ConsoleFault};
use desk::claim::Claim;
use serde_json::{Value, json};
use vehicle::Vehicle;

/// What is run.
#[derive(Clone, Debug, PartialEq)]
pub struct CasePlan {
    /// The short-period runs.
    pub short: Plan,
    /// Their patches.
    pub patches: Patches,
    /// The flights; their profile is that of the whole session.
    pub long: LongPeriodPlan,
    /// Dispersions of the pitch loop, if they are asked for; no claim needs them.
    pub dispersions: Option<Dispersions>,
}

impl CasePlan {
    /// Number of runs and flights.
    pub fn runs(&self) -> usize {
        self.short.pitch.len()
            + self.short.yaw_roll.len()
            + self.long.flights()
            + self.dispersions.as_ref().map_or(0, loops)
    }
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResults {
    /// Short period.
    pub short: Outcome,
    /// Long period.
    pub long: LongPeriodResults,
    /// Sensitivities, point by point.
    pub sensitivity: Vec<PointSensitivity>,
}

/// Why the case study could not be completed.
#[derive(Debug, thiserror::Error)]
pub enum CaseFault {
    /// The short or long period.
    #[error(transparent)]
    Study(#[from] StudyFault),
    /// The sensitivities.
    #[error(transparent)]
    Sensitivity(#[from] DesignFault),
}

impl From<ConsoleFault> for CaseFault {
    fn from(fault: ConsoleFault) -> CaseFault {
        CaseFault::Study(fault.into())
    }
}

/// Runs everything on one session; `progress` is told the number of runs done.
///
/// # Errors
/// [`CaseFault`]: the machine, its link, or a nominal flight that is lost.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &CasePlan,
    mut progress: impl FnMut(usize),
) -> Result<CaseResults, CaseFault> {
    let profile = &plan.long.profile;
    let answers = machine::run(console, &plan.short, &plan.patches, profile, &mut progress)?;
    let done = plan.short.pitch.len() + plan.short.yaw_roll.len();
    let long = long_period::run::run(console, vehicle, &plan.long, |flights| {
        progress(done + flights);
    })?;
    let done = done + plan.long.flights();
    let sensitivity = match &plan.dispersions {
        Some(dispersions) => {
            let bench = PitchBench::load(console, profile)?;
            disperse(console, &bench, vehicle, dispersions, |loops| {
                progress(done + loops);
            })?
        }
        None => Vec::new(),
    };
    Ok(CaseResults { short: Outcome::new(plan.short.clone(), answers), long, sensitivity })
}

impl CaseResults {
    /// Every claim, in the paper's order.
    pub fn claims(&self) -> Vec<Claim> {
        let mut claims = short_period::claims::judge(&self.short);
        claims.extend(long_period::claims::judge(&self.long));
        // The paper: the reduced schedule "has to be reevaluated again by reverting to the
        // short period analysis". What that finds belongs beside its claim.
        let found = claims.iter().find(|c| c.id == "P1").and_then(|c| c.remark.clone());
        if let Some(claim) = claims.iter_mut().find(|c| c.id == "L3")
            && let Some(found) = found
        {
            claim.remark = Some(format!(
                "in part: re-evaluated with the short-period models against P1, {found}"
            ));
        }
        claims
    }

    /// Whether every claim holds, and every linear run agrees with its eigenvalues.
    pub fn holds(&self) -> bool {
        self.claims().iter().all(Claim::holds) && self.short.disagreements().next().is_none()
    }

    /// Everything that was measured, for machines: a function of the plan alone, without
    /// any time of day. Time histories are in the traces.
    pub fn summary(&self) -> Value {
        let plan = &self.short.plan;
        let pitch: Vec<Value> = self
            .short
            .pitch
            .iter()
            .map(|r| json!({"run": r.name, "measures": r.measures}))
            .collect();
        let yaw_roll: Vec<Value> = self
            .short
            .yaw_roll
            .iter()
            .map(|r| json!({"run": r.name, "measures": r.measures}))
            .collect();
        let flights: Vec<Value> = self
            .long
            .modes
            .iter()
            .map(|mode| {
                json!({
                    "mode": mode.name,
                    "departure": mode.departure,
                    "flights": mode.flights().collect::<Vec<_>>(),
                })
            })
            .collect();
        json!({
            "claims": self.claims(),
            "holds": self.holds(),
            "short_period": {
                "points": plan.points.iter()
                    .map(|p| json!({"name": p.name, "time_s": p.slice.time_s}))
                    .collect::<Vec<_>>(),
                "pitch": pitch,
                "yaw_roll": yaw_roll,
                "linear_runs": self.short.agreement.len(),
                "linear_runs_that_disagree": self.short.disagreements().count(),
                "remarks": self.short.remarks(),
            },
            "long_period": {
                "undisturbed": self.long.nominal,
                "modes": flights,
                "worst_fuel": self.long.worst_fuel(),
            },
            "sensitivity": self.sensitivity,
        })
    }

    /// Points at which a condition was run in pitch with disturbances, with the residual.
    fn residuals<'a>(&'a self, condition: &'a str) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.short
            .pitch_under(condition, true)
            .map(|r| (r.case.point, r.measures.residual.unwrap_or(f64::INFINITY)))
    }

    /// The point at which all of some conditions ring most (the least of them counts),
    /// among those that also have a normal run.
    pub fn most_telling_point(&self, conditions: &[&str]) -> Option<usize> {
        let least = |point: usize| {
            conditions
                .iter()
                .map(|c| self.residuals(c).find(|(p, _)| *p == point).map(|(_, r)| r))
                .try_fold(f64::INFINITY, |least, r| Some(least.min(r?)))
        };
        self.residuals(NORMAL)
            .filter_map(|(point, _)| Some((point, least(point)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(point, _)| point)
    }
}
