//! Y1 to Y4: the yaw and roll loops sharing the tips.

use super::super::control_loop::Test::{Dedicated, Shared};
use super::super::measure::{ROLL_BAND_DEG, YAW_BAND_DEG};
use super::super::results::{Results, Run};
use super::{FIGURE_5, NORMAL, Worst};
use desk::claim::Claim;

const ALLOCATED_TO_ROLL: &str = "It may be observed that the fin tips get first allocated to the roll channel and saturate calling in the TVC for the yaw axis.";
const DEDICATED: &str = "Since the pitch and yaw axes requirements are different, such a strategy may eliminate yaw-roll interaction and achieve better response times for yaw and roll by meeting their individual performance requirements.";

const GIVEN_TO_ROLL_S: f64 = 0.15;
const CALLED_WITHIN_S: f64 = 0.6;
const SHARE_AFTER: f64 = 0.20;

pub(super) fn y1(results: &Results) -> Claim {
    let held = Worst::least(results.under(NORMAL, Shared), |r| r.measures.tips_given_to_roll_s);
    Claim {
        id: "Y1".into(),
        evidence: FIGURE_5,
        sentence: ALLOCATED_TO_ROLL.into(),
        criterion: format!(
            "both tips ≥ 95 % of their limit in opposite senses for at least {GIVEN_TO_ROLL_S} s while yaw's share is under 10 %"
        ),
        falsified_by: "a point where roll does not saturate both tips so long".into(),
        measured: format!("least {}", held.seconds()),
        verdict: held.against(GIVEN_TO_ROLL_S),
        remark: None,
    }
}

pub(super) fn y2(results: &Results) -> Claim {
    let called = Worst::greatest(results.under(NORMAL, Shared), |r| r.measures.tvc_called_s);
    Claim {
        id: "Y2".into(),
        evidence: FIGURE_5,
        sentence: ALLOCATED_TO_ROLL.into(),
        criterion: format!(
            "thrust-vector yaw force above 20 % of its maximum within {CALLED_WITHIN_S} s"
        ),
        falsified_by: "a point where the thrust vector comes later or not at all".into(),
        measured: format!("latest {}", called.seconds()),
        verdict: called.against(CALLED_WITHIN_S),
        remark: None,
    }
}

pub(super) fn y3(results: &Results) -> Claim {
    let share = Worst::least(results.under(NORMAL, Shared), |r| r.measures.yaw_share_after);
    Claim {
        id: "Y3".into(),
        evidence: FIGURE_5,
        sentence: "Fin tips become effective in yaw after the roll error is reduced.".into(),
        criterion: format!(
            "after roll has fallen to a quarter, tips above {:.0} % of their limit in yaw",
            100.0 * SHARE_AFTER
        ),
        falsified_by: "a point where the tips never serve yaw".into(),
        measured: format!("least {}", share.percent()),
        verdict: share.against(SHARE_AFTER),
        remark: None,
    }
}

pub(super) fn y4(results: &Results) -> Claim {
    let shared = |r: &Run| results.under(NORMAL, Shared).find(|shared| shared.point == r.point);
    let both = results.under(NORMAL, Dedicated).filter(|r| shared(r).is_some());
    // Gain in settling time: shared minus dedicated, at each point with both runs.
    let gain = Worst::least(both, |dedicated| {
        match [shared(dedicated)?, dedicated].map(|r| r.measures.settling_s) {
            [Some(shared), Some(dedicated)] => Some(shared - dedicated),
            [None, Some(_)] => Some(f64::INFINITY),
            [_, None] => None,
        }
    });
    let roll = Worst::greatest(results.under(NORMAL, Dedicated), |r| r.measures.roll_settling_s);
    Claim {
        id: "Y4".into(),
        evidence: FIGURE_5,
        sentence: DEDICATED.into(),
        criterion: format!(
            "with dedicated allocation yaw settles (to {YAW_BAND_DEG}° of its final value) no later, \
             at every point"
        ),
        falsified_by: "a point where yaw settles later with dedicated tips".into(),
        measured: format!("least gain {}", gain.seconds()),
        verdict: gain.against(0.0),
        remark: roll.found.map(|_| {
            format!("roll then settles to {ROLL_BAND_DEG}° at the latest in {}", roll.seconds())
        }),
    }
}
