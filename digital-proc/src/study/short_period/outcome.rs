//! A study that has run: its plan, the machine's answers, and what they come to.
//!
//! Runs are named here once, for tables, traces and figures alike: point, condition
//! and, where it differs from the rule, the test (`undisturbed`, `dedicated`).

use super::agreement::{self, Agreement};
use super::machine::{Answers, ControlLoop, Remark};
use super::measure::{PitchMeasures, YawRollMeasures};
use super::plan::{PitchCase, Plan, YawRollCase};
use super::response::{PitchResponse, YawRollResponse};

/// One run: what was asked, what the machine answered, and what that measures.
#[derive(Clone, Debug, PartialEq)]
pub struct Run<C, R, M> {
    /// Unique within the study.
    pub name: String,
    /// Name of its point.
    pub point: String,
    /// Name of its condition.
    pub condition: String,
    /// What was asked.
    pub case: C,
    /// The answer.
    pub response: R,
    /// Its measures.
    pub measures: M,
}

/// A run of the pitch loop.
pub type PitchRun = Run<PitchCase, PitchResponse, PitchMeasures>;
/// A run of the yaw and roll loops.
pub type YawRollRun = Run<YawRollCase, YawRollResponse, YawRollMeasures>;

/// A study that has run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// What was asked.
    pub plan: Plan,
    /// Pitch runs in the plan's order.
    pub pitch: Vec<PitchRun>,
    /// Yaw–roll runs in the plan's order.
    pub yaw_roll: Vec<YawRollRun>,
    /// The runs held against linear theory.
    pub agreement: Vec<Agreement>,
    /// SHA-256 of each patch that ran, by its name.
    pub patches: Vec<(String, String)>,
    remarks: Vec<Remark>,
}

impl Outcome {
    /// Measures the answers, which stand in the plan's order.
    pub fn new(plan: Plan, answers: Answers) -> Outcome {
        let agreement = agreement::compare(&plan, &answers.pitch);
        let named = |point: usize, condition: usize, test: &str| {
            let (point, condition) = (&plan.points[point].name, &plan.conditions[condition].name);
            (format!("{point}.{condition}{test}"), point.clone(), condition.clone())
        };
        let pitch = plan.pitch.iter().zip(answers.pitch).map(|(&case, response)| {
            let test = if case.disturbed { "" } else { ".undisturbed" };
            let (name, point, condition) = named(case.point, case.condition, test);
            let measures = PitchMeasures::new(&plan, &case, &response);
            Run { name, point, condition, case, response, measures }
        });
        let yaw_roll = plan.yaw_roll.iter().zip(answers.yaw_roll).map(|(&case, response)| {
            let test = if case.settings.dedicated { ".dedicated" } else { "" };
            let (name, point, condition) = named(case.point, case.condition, test);
            let measures = YawRollMeasures::new(&case, &response);
            Run { name, point, condition, case, response, measures }
        });
        Outcome {
            pitch: pitch.collect(),
            yaw_roll: yaw_roll.collect(),
            agreement,
            patches: answers.patches,
            remarks: answers.remarks,
            plan,
        }
    }

    /// Runs that disagree with linear theory.
    pub fn disagreements(&self) -> impl Iterator<Item = &Agreement> {
        self.agreement.iter().filter(|a| !a.agrees())
    }

    /// Pitch runs under a condition, with disturbances or without.
    pub fn pitch_under(&self, condition: &str, disturbed: bool) -> impl Iterator<Item = &PitchRun> {
        self.pitch.iter().filter(move |r| r.condition == condition && r.case.disturbed == disturbed)
    }

    /// Yaw–roll runs under a condition, with the tips dedicated to roll or shared.
    pub fn yaw_roll_under(
        &self,
        condition: &str,
        dedicated: bool,
    ) -> impl Iterator<Item = &YawRollRun> {
        self.yaw_roll
            .iter()
            .filter(move |r| r.condition == condition && r.case.settings.dedicated == dedicated)
    }

    /// Remarks of the machine in words, run by run.
    pub fn remarks(&self) -> Vec<String> {
        self.remarks
            .iter()
            .map(|remark| {
                let name = match remark.control_loop {
                    ControlLoop::Pitch => &self.pitch[remark.run].name,
                    ControlLoop::YawRoll => &self.yaw_roll[remark.run].name,
                };
                format!("{name}: {}", remark.what)
            })
            .collect()
    }
}
