//! A study that has run: a row a run, with what was asked, what was answered and what that
//! measures. Runs are named here once, for tables, traces and figures alike: point, condition
//! and, where it differs from the rule, the test (`undisturbed`, `dedicated`).

use super::agreement::Agreement;
use super::control_loop::{ControlLoop, Response, Test};
use super::inexact::Inexact;
use super::measure::Measures;
use super::moment;
use super::plan::{Case, Plan};
use crate::study::bending_moment::outcome::GreatestMoment;
use interface::Tick;

/// What may happen in a run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Occurrence {
    /// The machine stopped it; its samples end there.
    #[error("stopped at {time}: {fault}")]
    Stopped {
        /// Problem time of the last frame.
        time: Tick,
        /// The analog side's account.
        fault: String,
    },
    /// A converter or coefficient unit was driven beyond its range.
    #[error("a converter was saturated")]
    Saturated,
    /// Blocks were overloaded: their names, in order of time.
    #[error("overloaded: {}", .0.join(", "))]
    Overloaded(Vec<String>),
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Unique within its loop.
    pub name: String,
    /// Name of its point.
    pub point: String,
    /// Name of its condition.
    pub condition: String,
    /// What was asked.
    pub case: Case,
    /// The answer.
    pub response: Response,
    /// What happened beside.
    pub seen: Vec<Occurrence>,
    /// The measures of the answer.
    pub measures: Measures,
    /// Greatest bending moment; none of an answer that is no number.
    pub moment: Option<GreatestMoment>,
    /// The answer held against linear theory, where that is possible.
    pub linear: Option<Agreement>,
}

impl Run {
    /// Measures an answer.
    pub fn new(
        plan: &Plan,
        case: &Case,
        response: Response,
        seen: Vec<Occurrence>,
        inexact: &Inexact,
    ) -> Run {
        let point = plan.points[case.point].name.clone();
        let condition = plan.conditions[case.condition].name.clone();
        Run {
            name: format!("{point}.{condition}{}", case.test.suffix()),
            point,
            condition,
            case: *case,
            measures: Measures::new(plan, case, &response),
            moment: moment::greatest(plan, case, &response),
            linear: Agreement::of(plan, case, &response, inexact),
            response,
            seen,
        }
    }

    /// Its loop.
    pub fn control_loop(&self) -> ControlLoop {
        self.case.test.control_loop()
    }
}

/// A study that has run.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// What was asked.
    pub plan: Plan,
    /// The runs in the plan's order.
    pub runs: Vec<Run>,
    /// SHA-256 of each patch that ran, by its name.
    pub patches: Vec<(String, String)>,
}

impl Results {
    /// Runs of a test under a condition.
    pub fn under(&self, condition: &str, test: Test) -> impl Iterator<Item = &Run> + Clone {
        self.runs.iter().filter(move |r| r.case.test == test && r.condition == condition)
    }

    /// The run of a test under a condition at a point.
    pub(super) fn at(&self, point: usize, condition: &str, test: Test) -> Option<&Run> {
        self.under(condition, test).find(|r| r.case.point == point)
    }

    /// Runs of one loop.
    pub(super) fn of(&self, control_loop: ControlLoop) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |r| r.control_loop() == control_loop)
    }

    /// How many runs were held against linear theory, and how many disagree with it.
    pub fn linear(&self) -> (usize, usize) {
        let all = || self.runs.iter().filter_map(|r| r.linear);
        (all().count(), all().filter(|a| !a.agrees()).count())
    }

    /// What happened in the runs, in words, run by run.
    pub(super) fn remarks(&self) -> Vec<String> {
        let of = |run: &Run| -> Vec<String> {
            run.seen.iter().map(|what| format!("{}: {what}", run.name)).collect()
        };
        self.runs.iter().flat_map(of).collect()
    }
}
