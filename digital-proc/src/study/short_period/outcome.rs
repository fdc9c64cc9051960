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
        let pitch = plan.pitch.iter().zip(answers.pitch).map(|(&case, response)| Run {
            measures: PitchMeasures::new(&plan, &case, &response),
            case,
            response,
        });
        let yaw_roll = plan.yaw_roll.iter().zip(answers.yaw_roll).map(|(&case, response)| Run {
            measures: YawRollMeasures::new(&case, &response),
            case,
            response,
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
        let index = self.plan.conditions.iter().position(|c| c.name == condition);
        let asked = move |c: &PitchCase| Some(c.condition) == index && c.disturbed == disturbed;
        self.pitch.iter().filter(move |r| asked(&r.case))
    }

    /// Yaw–roll runs under a condition, with the tips dedicated to roll or shared.
    pub fn yaw_roll_under(
        &self,
        condition: &str,
        dedicated: bool,
    ) -> impl Iterator<Item = &YawRollRun> {
        let index = self.plan.conditions.iter().position(|c| c.name == condition);
        let asked =
            move |c: &YawRollCase| Some(c.condition) == index && c.settings.dedicated == dedicated;
        self.yaw_roll.iter().filter(move |r| asked(&r.case))
    }

    /// Name of a point.
    pub fn point(&self, index: usize) -> &str {
        &self.plan.points[index].name
    }

    /// Remarks of the machine in words, run by run.
    pub fn remarks(&self) -> Vec<String> {
        let plan = &self.plan;
        self.remarks
            .iter()
            .map(|remark| {
                let name = match remark.control_loop {
                    ControlLoop::Pitch => plan.pitch_name(&plan.pitch[remark.run]),
                    ControlLoop::YawRoll => plan.yaw_roll_name(&plan.yaw_roll[remark.run]),
                };
                format!("{name}: {}", remark.what)
            })
            .collect()
    }
}

impl Plan {
    /// Name of a pitch run, unique within the plan.
    pub fn pitch_name(&self, case: &PitchCase) -> String {
        let test = if case.disturbed { "" } else { ".undisturbed" };
        format!("{}{test}", self.cell(case.point, case.condition))
    }

    /// Name of a yaw–roll run, unique within the plan.
    pub fn yaw_roll_name(&self, case: &YawRollCase) -> String {
        let tips = if case.settings.dedicated { ".dedicated" } else { "" };
        format!("{}{tips}", self.cell(case.point, case.condition))
    }

    fn cell(&self, point: usize, condition: usize) -> String {
        format!("{}.{}", self.points[point].name, self.conditions[condition].name)
    }
}
