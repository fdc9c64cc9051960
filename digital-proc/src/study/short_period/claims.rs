//! The paper's sentences about the short period, judged on the measured runs.
//!
//! The judge reads only the plan and the measured runs, so that it serves the hybrid
//! machine's answers and the reference's alike. Conditions are known by their names
//! in the study file ([`NORMAL`], [`FTC_GAIN_LOST`], [`TVC_SLOW`], [`TVC_FAST`]); a
//! study without one of them leaves its claims unjudged. A measure that a run does
//! not yield (a diverged attitude, say) fails a claim that bounds it from above.

mod pitch;
mod yaw_roll;

pub use pitch::{BENDING_MIDDLE, OSCILLATORY, OVERSHOOT_P1, RESIDUAL_P1};

use super::outcome::{Outcome, Run};
use desk::claim::{Claim, Verdict};

/// Name of the normal condition.
pub const NORMAL: &str = "normal";
/// Name of the extreme reduction of the FTC gain.
pub const FTC_GAIN_LOST: &str = "ftc-gain-lost";
/// Name of the TVC pole reduced to 1 rad/s.
pub const TVC_SLOW: &str = "tvc-slow";
/// Name of the TVC time constant reduced to 0.005 s.
pub const TVC_FAST: &str = "tvc-fast";

/// Judges P1 to P6 and Y1 to Y4.
pub fn judge(outcome: &Outcome) -> Vec<Claim> {
    vec![
        pitch::p1(outcome),
        pitch::p2(outcome),
        pitch::p3(outcome),
        pitch::p4(outcome),
        pitch::p5(outcome),
        pitch::p6(outcome),
        yaw_roll::y1(outcome),
        yaw_roll::y2(outcome),
        yaw_roll::y3(outcome),
        yaw_roll::y4(outcome),
    ]
}

/// The worst value of some runs with its point: greatest where the bound is an upper one.
struct Worst<'a> {
    upper: bool,
    found: Option<(f64, &'a str)>,
    missing: Option<&'a str>,
}

impl<'a> Worst<'a> {
    fn of<C: 'a, R: 'a, M: 'a>(
        upper: bool,
        runs: impl Iterator<Item = &'a Run<C, R, M>>,
        value: impl Fn(&Run<C, R, M>) -> Option<f64>,
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
                let kept = if self.upper { value <= bound } else { value >= bound };
                if kept { Verdict::Holds } else { Verdict::Fails }
            }
        }
    }

    fn percent(&self) -> String {
        self.text(|v| format!("{:.1} %", 100.0 * v))
    }

    fn seconds(&self) -> String {
        self.text(|v| format!("{v:.2} s"))
    }

    fn text(&self, show: impl Fn(f64) -> String) -> String {
        match (self.missing, self.found) {
            (Some(point), _) => format!("none at {point}"),
            (None, Some((value, point))) => format!("{} at {point}", show(value)),
            (None, None) => "no runs".to_owned(),
        }
    }
}

fn both(a: Verdict, b: Verdict) -> Verdict {
    match (a, b) {
        (Verdict::Fails, _) | (_, Verdict::Fails) => Verdict::Fails,
        (Verdict::Holds, Verdict::Holds) => Verdict::Holds,
        _ => Verdict::NotJudged,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::plan::{Plan, YawRollCase};
    use crate::study::short_period::reference;
    use crate::study::short_period::study_file::Study;
    use vehicle::{Vehicle, VehicleData};

    fn judged(plan: &Plan) -> Vec<Claim> {
        // 1 ms: gyro and the fastest actuator take 100 and 200 rad/s · 1 ms.
        judge(&Outcome::new(plan.clone(), reference::answer(plan, 1e-3)))
    }

    /// The shipped study with only some conditions, to save time.
    fn plan(conditions: &[&str], change: impl Fn(&mut VehicleData)) -> Plan {
        let mut data = Vehicle::shipped().unwrap().data().clone();
        change(&mut data);
        let vehicle = Vehicle::from_data(data).unwrap();
        let mut study = Study::shipped().unwrap();
        study.conditions.retain(|c| conditions.contains(&c.name.as_str()));
        Plan::new(&study, &vehicle).unwrap()
    }

    fn failing(claims: &[Claim]) -> Vec<String> {
        claims.iter().filter(|c| c.verdict == Verdict::Fails).map(|c| c.id.to_string()).collect()
    }

    const JUDGED: [&str; 4] = [NORMAL, FTC_GAIN_LOST, TVC_SLOW, TVC_FAST];

    #[test]
    fn every_claim_holds_on_the_second_formulation() {
        let claims = judged(&plan(&JUDGED, |_| {}));
        assert_eq!(claims.len(), 10);
        for claim in &claims {
            assert!(claim.holds(), "{claim:?}");
        }
    }

    /// With the thrust vector always at work its poor lead spoils the normal step, and
    /// dedicated allocation loses its advantage. (The gain failure still rings, since
    /// its loop is lightly damped with and without the dead zone.)
    #[test]
    fn without_the_dead_zone_normal_mode_and_allocation_fail() {
        let mut plan = plan(&[NORMAL], |_| {});
        for case in &mut plan.pitch {
            case.settings.plane.dead_zone = 0.0;
        }
        for case in &mut plan.yaw_roll {
            case.settings.plane.dead_zone = 0.0;
        }
        assert_eq!(failing(&judged(&plan)), ["P1", "Y4"]);
    }

    #[test]
    fn a_flipped_sign_of_the_damping_spoils_the_normal_mode() {
        let mut leads = plan(&[NORMAL], |_| {});
        for case in &mut leads.pitch {
            case.settings.plane.tvc_lead *= -1.0;
            case.settings.plane.ftc_lead *= -1.0;
        }
        assert!(failing(&judged(&leads)).iter().any(|id| id == "P1"));
        let mut structure = plan(&[NORMAL], |_| {});
        for case in &mut structure.pitch {
            case.settings.plane.bending_drag *= -1.0;
        }
        assert!(failing(&judged(&structure)).iter().any(|id| id == "P5"));
    }

    #[test]
    fn an_undamped_mode_fails_the_gain_failure_claim_too() {
        let mut plan = plan(&[FTC_GAIN_LOST], |_| {});
        for case in &mut plan.pitch {
            case.settings.plane.bending_drag = 0.0;
        }
        assert!(failing(&judged(&plan)).iter().any(|id| id == "P6"));
    }

    #[test]
    fn a_healthy_actuator_does_not_pass_for_a_failed_one() {
        let mut plan = plan(&[TVC_SLOW, TVC_FAST], |_| {});
        for case in &mut plan.pitch {
            case.settings.plane.tvc_bandwidth = 10.0;
        }
        assert_eq!(failing(&judged(&plan)), ["P3", "P4"]);
    }

    #[test]
    fn other_sharing_of_the_tips_fails_the_sharing_claims() {
        let base = plan(&[NORMAL], |_| {});
        let with = |change: &dyn Fn(&mut YawRollCase)| {
            let mut plan = base.clone();
            plan.pitch.clear();
            plan.yaw_roll.iter_mut().for_each(change);
            failing(&judged(&plan))
        };
        // A small roll error does not saturate the tips.
        assert!(with(&|c| c.settings.initial.roll_rad /= 20.0).iter().any(|id| id == "Y1"));
        // No thrust vector: never called, and yaw never settles.
        assert!(with(&|c| c.settings.plane.tvc_gain = 0.0).iter().any(|id| id == "Y2"));
        // Tips that never serve yaw.
        assert!(with(&|c| c.settings.plane.ftc_gain = 0.0).iter().any(|id| id == "Y3"));
        // A dedicated channel without its lead settles later than the shared one.
        assert!(
            with(&|c| {
                if c.settings.dedicated {
                    c.settings.plane.tvc_lead = 0.0;
                }
            })
            .iter()
            .any(|id| id == "Y4")
        );
    }

    #[test]
    fn a_study_without_the_runs_leaves_claims_unjudged() {
        let claims = judged(&plan(&[], |_| {}));
        assert!(claims.iter().all(|c| c.verdict == Verdict::NotJudged));
    }
}
