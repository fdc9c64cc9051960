//! Which of the merged schedules is accepted, what speaks against the others, and the schedules
//! as sections of a vehicle file, under what they are and nothing better.

use super::{
    evaluate::{PointQuality, accepted},
    merge::Trial,
    schedule::as_toml,
};
use crate::study::short_period::claims::{OVERSHOOT_P1, RESIDUAL_P1};

/// A schedule of the merging with its quality at the trajectory points.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The schedule and its flights.
    pub trial: Trial,
    /// Its points.
    pub points: Vec<PointQuality>,
}

impl Level {
    /// Switchings of the schedule.
    pub(super) fn switchings(&self) -> usize {
        self.trial.schedule.switch_time_s.len().saturating_sub(1)
    }
}

/// The schedule of the fewest switchings that both the flights and the short-period model accept.
pub(super) fn fewest_accepted(levels: &[Level]) -> Option<&Trial> {
    let mut levels = levels.iter().rev();
    levels.find(|l| l.trial.accepted && accepted(&l.points)).map(|l| &l.trial)
}

/// The schedule of the fewest switchings that the flights accept.
fn fewest_flown(levels: &[Level]) -> Option<&Trial> {
    levels.iter().rev().map(|l| &l.trial).find(|trial| trial.accepted)
}

/// What speaks against one schedule; empty where it is accepted.
fn objections(Level { trial, points }: &Level) -> Vec<String> {
    let flights = (!trial.accepted).then(|| {
        format!(
            "flights: {:.1} kPa deg, departure at burn-out {:.2} of what is accepted",
            trial.max_q_alpha_padeg / 1e3,
            trial.severity
        )
    });
    let points = points.iter().flat_map(PointQuality::failures);
    flights.into_iter().chain(points).collect()
}

/// That no schedule is accepted, with everything that speaks against each; a line a schedule.
pub(super) fn none_accepted(levels: &[Level]) -> String {
    let mut text = format!(
        "no schedule is accepted by flights and by the short-period model (overshoot at most {} %, residual at most {} %)",
        100.0 * OVERSHOOT_P1,
        100.0 * RESIDUAL_P1
    );
    for level in levels {
        text += &format!("\n{} switchings: {}", level.switchings(), objections(level).join("; "));
    }
    text
}

/// The designed schedule as `[gains]`; it is the first level.
pub(super) fn designed_section(levels: &[Level]) -> String {
    levels.first().map_or_else(String::new, |first| {
        let against = objections(first);
        let comment = if against.is_empty() {
            "designed here; K_phi, T_phi, decoupled_yaw_* stay as they are".to_owned()
        } else {
            format!("designed here, NOT accepted: {}", against.join("; "))
        };
        as_toml("gains", &comment, &first.trial.schedule)
    })
}

/// The accepted schedule of the fewest switchings as `[gains_reduced]`, and, as a comment, the one
/// that the flights alone accept. Where none is accepted that is said in its place.
pub(super) fn reduced_sections(levels: &[Level]) -> String {
    let both = fewest_accepted(levels).map_or_else(
        || commented(&format!("[gains_reduced]: {}", none_accepted(levels))),
        |trial| {
            let what = "fewest switchings accepted by flights and by the short-period model";
            as_toml("gains_reduced", what, &trial.schedule)
        },
    );
    let flown = fewest_flown(levels).map_or_else(
        || "# no schedule is accepted by flights alone\n".to_owned(),
        |trial| {
            let what = "fewest switchings accepted by flights alone";
            commented(&as_toml("gains_reduced", what, &trial.schedule))
        },
    );
    format!("{both}\n{flown}")
}

fn commented(text: &str) -> String {
    text.lines().map(|line| format!("# {line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::gain_design::criteria::{LoopQuality, tests::kept};
    use vehicle::Vehicle;

    fn trial(switchings: usize, accepted: bool) -> Trial {
        let mut schedule = Vehicle::shipped().unwrap().data().gains_reduced.clone();
        schedule.switch_time_s = (0..=switchings).map(|n| n as f64).collect();
        Trial { schedule, max_q_alpha_padeg: 298_100.0, severity: 0.5, accepted }
    }

    fn point(overshoot: Option<f64>, residual: f64) -> PointQuality {
        PointQuality {
            point: "max-q".to_owned(),
            time_s: 32.5,
            quality: LoopQuality { overshoot, residual: Some(residual), ..kept() },
        }
    }

    #[test]
    fn a_rejected_schedule_is_never_the_accepted_one() {
        let trials = [trial(3, true), trial(2, true), trial(1, true), trial(0, false)];
        let good = vec![point(Some(0.2), 0.01)];
        let bad = vec![point(Some(0.312), 0.01)];
        let diverged = vec![point(None, 0.2)];
        let levels = |of: [&Vec<PointQuality>; 4]| -> Vec<Level> {
            let all = trials.iter().cloned().zip(of);
            all.map(|(trial, points)| Level { trial, points: points.clone() }).collect()
        };
        // The last is good at its points, but not in flight.
        let some = levels([&good, &good, &bad, &good]);
        assert_eq!(fewest_accepted(&some).unwrap().schedule.switch_time_s.len(), 3);
        assert_eq!(fewest_flown(&some).unwrap().schedule.switch_time_s.len(), 2);
        let read = |levels: &[Level]| -> toml::Table {
            let text = designed_section(levels) + &reduced_sections(levels);
            toml::from_str(&text).unwrap()
        };
        let times = read(&some)["gains_reduced"]["t_sw"].as_array().unwrap().len();
        assert_eq!(times, 3);
        assert!(!designed_section(&some).contains("NOT accepted"));
        let none = levels([&bad, &diverged, &bad, &good]);
        assert!(fewest_accepted(&none).is_none());
        assert!(!read(&none).contains_key("gains_reduced"));
        assert!(designed_section(&none).contains("NOT accepted: overshoot 31.2 %"));
        let text = reduced_sections(&none);
        assert!(text.contains("# [gains_reduced]: no schedule is accepted"), "{text}");
        for part in [
            "3 switchings: overshoot 31.2 % at max-q (32.5 s)",
            "no overshoot, it diverges, at max-q (32.5 s); residual 20.0 % at max-q",
            "0 switchings: flights: 298.1 kPa deg",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
