//! A study that has run: its plan, the machine's answers, and what they come to.
//!
//! Runs are named here once, for tables, traces and figures alike: point, condition
//! and, where it differs from the rule, the test (`undisturbed`, `dedicated`).

use super::agreement::{self, Agreement};
use super::claims;
use super::machine::{Answers, ControlLoop};
use super::measure::Results;
use super::plan::{PitchCase, Plan, YawRollCase};
use crate::study::claim::Claim;

/// A study that has run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// What was asked.
    pub plan: Plan,
    /// What the machine answered.
    pub answers: Answers,
    /// The measures.
    pub results: Results,
    /// The runs held against linear theory.
    pub agreement: Vec<Agreement>,
}

impl Outcome {
    /// Measures the answers.
    pub fn new(plan: Plan, answers: Answers) -> Outcome {
        Outcome {
            results: Results::new(&plan, &answers.pitch, &answers.yaw_roll),
            agreement: agreement::compare(&plan, &answers.pitch),
            plan,
            answers,
        }
    }

    /// Judges the paper's sentences.
    pub fn claims(&self) -> Vec<Claim> {
        claims::judge(&self.plan, &self.results)
    }

    /// Runs that disagree with linear theory.
    pub fn disagreements(&self) -> impl Iterator<Item = &Agreement> {
        self.agreement.iter().filter(|a| !a.agrees())
    }

    /// Number of a pitch run, by names.
    pub fn pitch_run(&self, point: usize, condition: &str, disturbed: bool) -> Option<usize> {
        self.plan.pitch.iter().position(|c| {
            c.point == point
                && self.plan.conditions[c.condition].name == condition
                && c.disturbed == disturbed
        })
    }

    /// Number of a yaw–roll run, by names.
    pub fn yaw_roll_run(&self, point: usize, condition: &str, dedicated: bool) -> Option<usize> {
        self.plan.yaw_roll.iter().position(|c| {
            c.point == point
                && self.plan.conditions[c.condition].name == condition
                && c.settings.dedicated == dedicated
        })
    }

    /// Remarks of the machine in words, run by run.
    pub fn remarks(&self) -> Vec<String> {
        let plan = &self.plan;
        self.answers
            .remarks
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
