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
/// Name of the gains of the interval to come.
pub const GAINS_EARLY: &str = "gains-early";

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
        control_loop::ControlLoop,
        plan::Plan,
        reference,
        study_file::{SHIPPED_TEXT, Study},
    };
    use vehicle::Vehicle;

    const VEHICLE: &str = include_str!("../../../data/vehicle.toml");

    fn changed(text: &str, changes: &[(&str, &str)]) -> String {
        changes.iter().fold(text.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        })
    }

    /// Claims about the shipped study and vehicle with some texts of theirs changed, with only
    /// some conditions and loops to save time; on the second formulation.
    fn judged(
        conditions: &[&str],
        loops: &[ControlLoop],
        study: &[(&str, &str)],
        vehicle: &[(&str, &str)],
    ) -> Vec<Claim> {
        let mut study = Study::from_toml("study", &changed(SHIPPED_TEXT, study)).unwrap();
        study.conditions.retain(|c| conditions.contains(&c.name.as_str()));
        let vehicle = Vehicle::from_toml("vehicle", &changed(VEHICLE, vehicle)).unwrap();
        let mut plan = Plan::new(&study, &vehicle).unwrap();
        plan.cases.retain(|case| loops.contains(&case.test.control_loop()));
        // 1 ms: gyro and the fastest actuator take 100 and 200 rad/s · 1 ms.
        judge(&reference::answer(&plan, 1e-3))
    }

    fn verdict(claims: &[Claim], id: &str) -> Verdict {
        claims.iter().find(|c| c.id == id).unwrap().verdict
    }

    #[test]
    fn the_verdicts_on_the_second_formulation() {
        let conditions = [NORMAL, FTC_GAIN_LOST, TVC_SLOW, TVC_FAST, "gains-early"];
        let claims = judged(&conditions, &ControlLoop::ALL, &[], &[]);
        for (id, expected) in [
            // The load of the disturbed test at max Q.
            ("P1", Verdict::InPart),
            ("P2", Verdict::Holds),
            ("P3", Verdict::Holds),
            // `gains-early` at 10 s.
            ("P4", Verdict::InPart),
            ("P5", Verdict::Holds),
            ("P6", Verdict::Holds),
            // Where the attitude swings, so does the mode.
            ("P7", Verdict::InPart),
            ("Y1", Verdict::Holds),
            ("Y2", Verdict::Holds),
            ("Y3", Verdict::Holds),
            // Roll from the large yaw offset at 47 s.
            ("Y4", Verdict::InPart),
        ] {
            assert_eq!(verdict(&claims, id), expected, "{claims:#?}");
        }
        assert_eq!(claims.len(), 11);
        // The literal reading of the slow actuator is told beside the other, with its θ.
        let p3 = claims.iter().find(|c| c.id == "P3").unwrap();
        assert!(p3.remark.as_ref().unwrap().contains("read literally"), "{p3:?}");
    }

    /// Figures of an independent formulation, the least and the greatest over the points, each to
    /// half a unit of its last digit or to what a sampling interval (20 ms) leaves of an instant.
    #[test]
    fn the_yaw_and_roll_loops_are_those_of_the_independent_formulation() {
        let study = Study::shipped().unwrap();
        let mut plan = Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap();
        plan.cases.retain(|case| {
            case.test.control_loop() == ControlLoop::YawRoll
                && plan.conditions[case.condition].name == NORMAL
        });
        let results = reference::answer(&plan, 1e-3);
        let range = |test, of: &dyn Fn(&Run) -> f64| {
            let values: Vec<f64> = results.under(NORMAL, test).map(of).collect();
            assert_eq!(values.len(), 9);
            values
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)))
        };
        let held = |what: &str, found: (f64, f64), low: f64, high: f64, within: f64| {
            let near = (found.0 - low).abs() <= within && (found.1 - high).abs() <= within;
            assert!(near, "{what}: {found:?} for {low} to {high}");
        };
        use super::super::control_loop::{
            Offset::{Both, LargeYaw, YawAlone},
            Test::{Dedicated, Shared},
        };
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let peak_n = |r: &Run| number(r.measures.tvc_peak_n);
        let of_limit = |r: &Run| peak_n(r) / r.case.settings.plane.tvc_limit;
        let of_offset =
            |r: &Run| peak_n(r) / (r.case.settings.plane.tvc_gain * 0.5_f64.to_radians());
        held(
            "tips short",
            range(Shared(Both), &|r| number(r.measures.tips_short_s)),
            0.02,
            0.07,
            5e-3,
        );
        held(
            "begins",
            range(Shared(Both), &|r| number(r.measures.tvc_begins_s)),
            0.075,
            0.10,
            5e-3,
        );
        held("peak over K_T ψ_0", range(Shared(Both), &of_offset), 0.78, 1.09, 5e-3);
        held("peak over F_max", range(Shared(Both), &of_limit), 0.09, 0.22, 5e-3);
        held("the same, large", range(Shared(LargeYaw), &of_limit), 0.39, 0.88, 5e-3);
        assert_eq!(range(Shared(YawAlone), &peak_n), (0.0, 0.0));
        let travel_deg = 10.0;
        let before = range(Shared(Both), &|r| travel_deg * number(r.measures.yaw_share_before));
        assert!(before.1 <= 0.01, "{before:?}");
        let after = range(Shared(Both), &|r| travel_deg * number(r.measures.yaw_share_after));
        // Its greatest value is that between the samples too.
        held("share after, deg", after, 2.8, 6.2, 6e-2);
        held(
            "settling",
            range(Dedicated(Both), &|r| number(r.measures.settling_s)),
            0.75,
            1.08,
            2e-2,
        );
    }

    /// A change of the study or the vehicle for each claim, with which it does not hold.
    #[test]
    fn every_claim_can_fail() {
        type Texts = &'static [(&'static str, &'static str)];
        type Case = (&'static str, &'static [&'static str], Texts, Texts, &'static [&'static str]);
        let cases: [Case; 13] = [
            (
                "hardly any rate feedback of the tips",
                &[NORMAL],
                &[],
                &[("0.84,  0.82,  0.74,  0.68,  0.70,  0.75]", "0.1, 0.1, 0.1, 0.1, 0.1, 0.1]")],
                &["P1"],
            ),
            (
                "the gain is not lost",
                &[FTC_GAIN_LOST],
                &[("\"ftc-gain\", times = 0.05", "\"ftc-gain\", times = 0.9")],
                &[],
                &["P2"],
            ),
            (
                "the actuator is not slow",
                &[TVC_SLOW],
                &[("\"tvc-time-constant\", set = 1.0", "\"tvc-time-constant\", set = 0.12")],
                &[],
                &["P3"],
            ),
            (
                "a third condition that rings",
                &["tips-weak", FTC_GAIN_LOST, TVC_SLOW],
                &[("\"tip-force-slope\", times = 0.7", "\"ftc-lead\", times = 0.1")],
                &[],
                &["P4"],
            ),
            (
                "a mode without damping of its own, moved by all that moves",
                &[NORMAL, FTC_GAIN_LOST],
                &[],
                &[("zeta   = 0.010", "zeta   = 0.0")],
                &["P5", "P6"],
            ),
            (
                "a mode that grows under the slow actuator",
                &[TVC_SLOW],
                &[(
                    "set = 1.0 }]",
                    "set = 1.0 }, { quantity = \"bending-damping\", set = -0.02 }]",
                )],
                &[],
                &["P7"],
            ),
            (
                "a small roll offset",
                &[NORMAL],
                &[("roll-deg = 20.0", "roll-deg = 1.0")],
                &[],
                &["Y1"],
            ),
            (
                "a yaw offset without roll",
                &[NORMAL],
                &[("roll-deg = 20.0", "roll-deg = 0.0")],
                &[],
                &["Y1", "Y2", "Y3"],
            ),
            (
                "a dead zone that knows nothing of the tips",
                &[NORMAL],
                &[],
                &[("dead_zone = \"remaining\"", "dead_zone = \"scheduled\"")],
                &["Y2"],
            ),
            (
                "a yaw offset beyond the tips' authority calls the thrust vector by itself",
                &[NORMAL],
                &[("\nyaw-deg = 0.5", "\nyaw-deg = 2.5")],
                &[],
                &["Y2"],
            ),
            (
                "a yaw error that asks hardly anything of the tips",
                &[NORMAL],
                &[
                    ("large-yaw-deg = 2.5", "large-yaw-deg = 0.05"),
                    ("\nyaw-deg = 0.5", "\nyaw-deg = 0.01"),
                    ("gust = 0.5\ncant", "gust = 0.0\ncant"),
                    ("misalignment = 0.4", "misalignment = 0.0"),
                ],
                &[],
                &["Y3"],
            ),
            (
                "a dedicated channel without its lead",
                &[NORMAL],
                &[],
                &[("decoupled_yaw_TT = 0.55", "decoupled_yaw_TT = 0.0")],
                &["Y4"],
            ),
            (
                "no thrust vector in yaw",
                &[NORMAL],
                &[],
                &[("decoupled_yaw_KT = 0.9 ", "decoupled_yaw_KT = 0.0 ")],
                &["Y4"],
            ),
        ];
        for (what, conditions, study, vehicle, ids) in cases {
            let of = |id: &&str| match id.starts_with('P') {
                true => ControlLoop::Pitch,
                false => ControlLoop::YawRoll,
            };
            let loops: Vec<_> = ids.iter().map(of).collect();
            let claims = judged(conditions, &loops, study, vehicle);
            for id in ids {
                assert_eq!(verdict(&claims, id), Verdict::Fails, "{what}: {claims:#?}");
            }
        }
    }

    #[test]
    fn a_study_without_the_runs_leaves_claims_unjudged() {
        let claims = judged(&[], &ControlLoop::ALL, &[], &[]);
        assert!(claims.iter().all(|c| c.verdict == Verdict::NotJudged));
    }
}
