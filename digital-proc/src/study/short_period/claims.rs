//! The paper's sentences about the short period, judged on the measured runs.
//!
//! The judge reads only the measured runs, so that it serves the hybrid
//! machine's answers and the reference's alike. Conditions are known by their names
//! in the study file ([`NORMAL`], [`FTC_GAIN_LOST`], [`TVC_SLOW`], [`TVC_FAST`]); a
//! study without one of them leaves its claims unjudged, and one without `offsets` those that ask
//! for a cause. A measure that a run does
//! not yield (a diverged attitude, say) fails a claim that bounds it from above.

mod pitch;
mod yaw_roll;

pub use pitch::{BENDING_MIDDLE, OSCILLATORY, OVERSHOOT_P1, RESIDUAL_P1, reduced_against_p1};

use super::results::{Results, Run};
use desk::claim::{Claim, Evidence, Verdict};

/// Name of the normal condition.
pub const NORMAL: &str = "normal";
/// Name of the extreme reduction of the FTC gain.
pub const FTC_GAIN_LOST: &str = "ftc-gain-lost";
/// Name of the TVC pole reduced to 1 rad/s.
pub const TVC_SLOW: &str = "tvc-slow";
/// Name of the TVC time constant reduced to 0.005 s.
pub const TVC_FAST: &str = "tvc-fast";

// Where the case study's report shows them.
pub(super) const FIGURE_4: Evidence = Evidence::at("figure-4");
pub(super) const FIGURE_5: Evidence = Evidence::at("figure-5");
pub(super) const BENDING_GROWTH: Evidence = Evidence::at("bending-growth");
pub(super) const YAW_ROLL: Evidence = Evidence::at("yaw_roll");
pub(super) const OVERSHOOTS: Evidence = Evidence::at("matrix-overshoot");
pub(super) const RESIDUALS: Evidence = Evidence::at("matrix-residual");
pub(super) const BENDING: Evidence = Evidence::at("matrix-bending");

/// Judges P1 to P7 and Y1 to Y4.
pub fn judge(results: &Results) -> Vec<Claim> {
    use {pitch::*, yaw_roll::*};
    [p1, p2, p3, p4, p5, p6, p7, y1, y2, y3, y4].map(|claim| claim(results)).into()
}

/// The worst value of some runs with its point: greatest where the bound is an upper one.
struct Worst<'a> {
    upper: bool,
    found: Option<(f64, &'a str)>,
    missing: Option<&'a str>,
}

impl<'a> Worst<'a> {
    /// Against an upper bound the greatest, against a lower one the least.
    fn greatest(
        runs: impl Iterator<Item = &'a Run>,
        value: impl Fn(&Run) -> Option<f64>,
    ) -> Worst<'a> {
        Worst::of(true, runs, value)
    }

    fn least(
        runs: impl Iterator<Item = &'a Run>,
        value: impl Fn(&Run) -> Option<f64>,
    ) -> Worst<'a> {
        Worst::of(false, runs, value)
    }

    fn of(
        upper: bool,
        runs: impl Iterator<Item = &'a Run>,
        value: impl Fn(&Run) -> Option<f64>,
    ) -> Worst<'a> {
        let mut worst = Worst { upper, found: None, missing: None };
        for run in runs {
            let point = run.point.as_str();
            match value(run).filter(|v| !v.is_nan()) {
                None => worst.missing = Some(point),
                Some(value) => {
                    let worse =
                        worst.found.is_none_or(|(w, _)| if upper { value > w } else { value < w });
                    if worse {
                        worst.found = Some((value, point));
                    }
                }
            }
        }
        worst
    }

    /// Verdict against a bound, which itself is allowed.
    fn against(&self, bound: f64) -> Verdict {
        match (self.found, self.missing) {
            (None, None) => Verdict::NotJudged,
            (_, Some(_)) => Verdict::Fails,
            (Some((value, _)), None) => {
                Verdict::of(if self.upper { value <= bound } else { value >= bound })
            }
        }
    }

    fn percent(&self) -> String {
        self.text(|v| format!("{:.1} %", 100.0 * v))
    }

    fn seconds(&self) -> String {
        self.text(|v| format!("{v:.2} s"))
    }

    /// To the millisecond.
    fn fine_seconds(&self) -> String {
        self.text(|v| format!("{v:.3} s"))
    }

    fn text(&self, show: impl Fn(f64) -> String) -> String {
        match (self.missing, self.found) {
            (Some(point), _) => format!("none at {point}"),
            (None, Some((value, point))) => format!("{} at {point}", show(value)),
            (None, None) => "no runs".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::{
        coefficients::Settings, plan::Plan, reference, study_file::Study,
    };
    use vehicle::Vehicle;

    fn judged(plan: &Plan) -> Vec<Claim> {
        // 1 ms: gyro and the fastest actuator take 100 and 200 rad/s · 1 ms.
        judge(&reference::answer(plan, 1e-3))
    }

    /// The shipped study with only some conditions, to save time.
    fn plan(conditions: &[&str]) -> Plan {
        let mut study = Study::shipped().unwrap();
        study.conditions.retain(|c| conditions.contains(&c.name.as_str()));
        Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap()
    }

    fn failing(claims: &[Claim]) -> Vec<String> {
        claims.iter().filter(|c| c.verdict == Verdict::Fails).map(|c| c.id.to_string()).collect()
    }

    const JUDGED: [&str; 4] = [NORMAL, FTC_GAIN_LOST, TVC_SLOW, TVC_FAST];

    #[test]
    fn every_claim_holds_on_the_second_formulation() {
        let claims = judged(&plan(&JUDGED));
        assert_eq!(claims.len(), 10);
        for claim in &claims {
            assert!(claim.holds(), "{claim:?}");
        }
    }

    /// What is spoilt fails its claims. With the thrust vector always at work its poor lead
    /// spoils the normal step, and dedicated allocation loses its advantage. (The gain failure
    /// still rings, since its loop is lightly damped with and without the dead zone.)
    #[test]
    fn a_spoilt_loop_fails_the_matching_claims() {
        type Spoil = fn(&mut Settings);
        let pitch: [(&[&str], Spoil, &[&str]); 5] = [
            (&[NORMAL], |s| s.plane.dead_zone = 0.0, &["P1", "Y4"]),
            (
                &[NORMAL],
                |s| (s.plane.tvc_lead, s.plane.ftc_lead) = (-s.plane.tvc_lead, -s.plane.ftc_lead),
                &["P1"],
            ),
            (&[NORMAL], |s| s.plane.bending_drag *= -1.0, &["P5"]),
            (&[FTC_GAIN_LOST], |s| s.plane.bending_drag = 0.0, &["P6"]),
            (&[TVC_SLOW, TVC_FAST], |s| s.plane.tvc_bandwidth = 10.0, &["P3", "P4"]),
        ];
        fn roll(s: &mut Settings) -> &mut super::super::coefficients::Roll {
            s.roll.as_mut().unwrap()
        }
        let yaw_roll: [(Spoil, &str); 4] = [
            // A small roll error does not saturate the tips.
            (|s| roll(s).initial.roll_rad /= 20.0, "Y1"),
            // No thrust vector: never called, and yaw never settles.
            (|s| s.plane.tvc_gain = 0.0, "Y2"),
            // Tips that never serve yaw.
            (|s| s.plane.ftc_gain = 0.0, "Y3"),
            // A dedicated channel without its lead settles later than the shared one.
            (
                |s| {
                    if roll(s).dedicated {
                        s.plane.tvc_lead = 0.0
                    }
                },
                "Y4",
            ),
        ];
        let fails = |mut plan: Plan, spoil: Spoil, expected: &[&str]| {
            plan.cases.iter_mut().for_each(|case| spoil(&mut case.settings));
            let failing = failing(&judged(&plan));
            assert!(expected.iter().all(|id| failing.iter().any(|f| f == id)), "{failing:?}");
            failing.len()
        };
        for (conditions, spoil, expected) in pitch {
            let failing = fails(plan(conditions), spoil, expected);
            assert!(expected.len() < 2 || failing == 2, "{expected:?}");
        }
        for (spoil, expected) in yaw_roll {
            let mut plan = plan(&[NORMAL]);
            plan.cases.retain(|c| c.settings.roll.is_some());
            fails(plan, spoil, &[expected]);
        }
    }

    #[test]
    fn a_study_without_the_runs_leaves_claims_unjudged() {
        let claims = judged(&plan(&[]));
        assert!(claims.iter().all(|c| c.verdict == Verdict::NotJudged));
    }
}
