//! Y1 to Y4: the yaw and roll loops sharing the tips.
//!
//! The paper tells causes: roll takes the tips, *which* calls in the thrust vector, and lets go of
//! them, *upon which* they serve yaw. So the claims are asked of runs with their cause and of runs
//! without it: a yaw offset within the tips' own authority, with the roll offset and alone.

use super::super::control_loop::{
    Offset::{self, Both, LargeYaw, RollAlone, YawAlone},
    Test::{Dedicated, Shared},
};
use super::super::measure::{LARGE_YAW_BAND, ROLL_BAND_DEG, YAW_BAND};
use super::super::results::{Results, Run};
use super::{FIGURE_5, NORMAL, Worst, YAW_ROLL};
use desk::claim::{Claim, Verdict};

const ALLOCATED_TO_ROLL: &str = "It may be observed that the fin tips get first allocated to the roll channel and saturate calling in the TVC for the yaw axis.";
const EFFECTIVE_IN_YAW: &str = "Fin tips become effective in yaw after the roll error is reduced.";
const DEDICATED: &str = "Since the pitch and yaw axes requirements are different, such a strategy may eliminate yaw-roll interaction and achieve better response times for yaw and roll by meeting their individual performance requirements.";

/// Time for which both tips stand at their limits for roll: three time constants of a tip (0.05 s),
/// so that it is no passing peak.
const GIVEN_TO_ROLL_S: f64 = 0.15;
/// Part of what the open thrust vector would give for the yaw offset, K_T ψ_0, that calls it in: at
/// the peak the vehicle has turned by less than half, and the lag of 0.1 s takes the rest.
const PEAK: f64 = 0.6;
/// By when it gives a fifth of its force for the large offset: the tips need 0.17 s to saturate,
/// the thrust vector two or three time constants of 0.1 s.
const CALLED_WITHIN_S: f64 = 0.6;
/// Share of the tips from which they serve yaw, and mean up to which they do not, both as fractions
/// of their travel: 2° and 0.1°.
const SHARE_AFTER: f64 = 0.20;
const SHARE_BEFORE: f64 = 0.01;
/// Part of the interaction with shared tips up to which it is eliminated.
const ELIMINATED: f64 = 0.01;

fn shared(results: &Results, offset: Offset) -> impl Iterator<Item = &Run> + Clone {
    results.under(NORMAL, Shared(offset))
}

/// Runs of both yaw offsets.
fn both_offsets(results: &Results) -> impl Iterator<Item = &Run> + Clone {
    shared(results, Both).chain(shared(results, LargeYaw))
}

/// The run of another test at the point of this one.
fn beside<'a>(results: &'a Results, run: &Run, offset: Offset, dedicated: bool) -> Option<&'a Run> {
    let test = if dedicated { Dedicated(offset) } else { Shared(offset) };
    results.at(run.case.point, NORMAL, test)
}

pub(super) fn y1(results: &Results) -> Claim {
    let given = |r: &Run| r.measures.tips_given_to_roll_s;
    let held = Worst::least(both_offsets(results), given);
    let without = Worst::greatest(shared(results, YawAlone), given);
    Claim {
        id: "Y1".into(),
        evidence: FIGURE_5,
        sentence: ALLOCATED_TO_ROLL.into(),
        criterion: format!(
            "from either yaw offset with the roll offset both tips ≥ 95 % of their limit in opposite senses for at least {GIVEN_TO_ROLL_S} s while yaw's share is under 10 %; never without the roll offset"
        ),
        falsified_by:
            "a point where roll does not saturate both tips, or where they do so without it".into(),
        measured: format!("least {}, without roll {}", held.seconds(), without.seconds()),
        verdict: held.against(GIVEN_TO_ROLL_S).and(without.against(0.0)),
        remark: None,
    }
}

pub(super) fn y2(results: &Results) -> Claim {
    // Not before the tips fall short of the yaw offset.
    let after = |r: &Run| Some(r.measures.tvc_begins_s? - r.measures.tips_short_s?);
    let follows = Worst::least(shared(results, Both), after);
    let of_offset = |r: &Run| {
        let plane = &r.case.settings.plane;
        let roll = r.case.settings.roll?;
        Some(r.measures.tvc_peak_n? / (plane.tvc_gain * roll.initial.yaw_rad.abs()))
    };
    let peak = Worst::least(shared(results, Both), of_offset);
    let without = Worst::greatest(shared(results, YawAlone), |r| r.measures.tvc_peak_n);
    let large = Worst::greatest(shared(results, LargeYaw), |r| r.measures.tvc_called_s);
    let begins = Worst::greatest(shared(results, Both), |r| r.measures.tvc_begins_s);
    let short = Worst::greatest(shared(results, Both), |r| r.measures.tips_short_s);
    Claim {
        id: "Y2".into(),
        evidence: FIGURE_5,
        sentence: ALLOCATED_TO_ROLL.into(),
        criterion: format!(
            "the yaw offset within the tips' authority calls the thrust vector only where roll has the tips: with the roll offset it passes 2 % of its force after the tips fall short of the yaw offset and reaches {PEAK} of its gain times that offset; without it no force at all; the large offset calls 20 % of its maximum within {CALLED_WITHIN_S} s"
        ),
        falsified_by: "a point where the thrust vector acts in yaw without the roll offset or before the tips fall short, or hardly acts with it".into(),
        measured: format!(
            "tips short at the latest after {}, thrust vector begun after {} and least {} later, its peak least {} of K_T ψ_0; without roll at most {}; large offset at the latest {}",
            short.fine_seconds(),
            begins.fine_seconds(),
            follows.fine_seconds(),
            peak.text(|v| format!("{v:.2}")),
            without.text(|v| format!("{v} N")),
            large.seconds()
        ),
        verdict: follows
            .against(0.0)
            .and(peak.against(PEAK))
            .and(without.against(0.0))
            .and(large.against(CALLED_WITHIN_S)),
        remark: None,
    }
}

pub(super) fn y3(results: &Results) -> Claim {
    let before = Worst::greatest(shared(results, Both), |r| r.measures.yaw_share_before);
    let after = Worst::least(both_offsets(results), |r| r.measures.yaw_share_after);
    Claim {
        id: "Y3".into(),
        evidence: FIGURE_5,
        sentence: EFFECTIVE_IN_YAW.into(),
        criterion: format!(
            "until roll lets the tips off their limits their mean share in yaw is at most {:.0} % of their limit; after roll has fallen to a quarter they pass {:.0} %",
            100.0 * SHARE_BEFORE,
            100.0 * SHARE_AFTER
        ),
        falsified_by: "a point where the tips serve yaw before, or never do".into(),
        measured: format!(
            "before at most {}, after at least {}",
            before.percent(),
            after.percent()
        ),
        verdict: before.against(SHARE_BEFORE).and(after.against(SHARE_AFTER)),
        remark: None,
    }
}

/// Gain in settling time by dedicated tips: shared minus dedicated.
fn gain(results: &Results, offset: Offset, of: impl Fn(&Run) -> Option<f64>) -> Worst<'_> {
    let dedicated = results.under(NORMAL, Dedicated(offset));
    let dedicated = dedicated.filter(|r| beside(results, r, offset, false).is_some());
    Worst::least(dedicated, |run| match [of(beside(results, run, offset, false)?), of(run)] {
        [Some(shared), Some(dedicated)] => Some(shared - dedicated),
        [None, Some(_)] => Some(f64::INFINITY),
        [_, None] => None,
    })
}

/// Greatest change of an angle in deg by the other axis' offset, beside the same run without it.
fn interaction<'a>(
    results: &'a Results,
    dedicated: bool,
    adc: &'static str,
    alone: Offset,
) -> Worst<'a> {
    let test = if dedicated { Dedicated(Both) } else { Shared(Both) };
    Worst::greatest(results.under(NORMAL, test), |run| {
        let alone = beside(results, run, alone, dedicated)?;
        let pairs = run.response.of(adc).iter().zip(alone.response.of(adc));
        Some(pairs.fold(0.0_f64, |d, (a, b)| d.max((a - b).abs())).to_degrees())
    })
}

pub(super) fn y4(results: &Results) -> Claim {
    let sample_s = results.plan.sample.secs();
    let [yaw, roll] = [|r: &Run| r.measures.settling_s, |r: &Run| r.measures.roll_settling_s];
    let yaw = [Both, LargeYaw].map(|offset| gain(results, offset, yaw));
    let roll = [Both, LargeYaw].map(|offset| gain(results, offset, roll));
    let of_yaw = [false, true].map(|d| interaction(results, d, "yaw_attitude", YawAlone));
    let of_roll = [false, true].map(|d| interaction(results, d, "roll_attitude", RollAlone));
    let eliminated = |[shared, dedicated]: &[Worst<'_>; 2]| {
        dedicated.against(shared.found.map_or(0.0, |(most, _)| ELIMINATED * most))
    };
    // A difference below the sampling interval is none.
    let roll_verdict = roll.each_ref().map(|gain| gain.against(-sample_s));
    let degrees = |worst: &Worst<'_>| worst.text(|v| format!("{v:.2}°"));
    let slower = roll_verdict.contains(&Verdict::Fails);
    Claim {
        id: "Y4".into(),
        evidence: YAW_ROLL,
        sentence: DEDICATED.into(),
        criterion: format!(
            "with dedicated tips, at every point and from either yaw offset: yaw settles no later (to {:.0} % of the offset, {:.0} % of the large one, about its final value), what roll does to yaw and yaw to roll is at most {:.0} % of what it is with shared tips; in part unless roll (to {ROLL_BAND_DEG}°) settles no later than by a sampling interval of {:.0} ms",
            100.0 * YAW_BAND,
            100.0 * LARGE_YAW_BAND,
            100.0 * ELIMINATED,
            1e3 * sample_s
        ),
        falsified_by: "a point where yaw settles later with dedicated tips, or either axis still feels the other".into(),
        measured: format!(
            "yaw: least gain {}, large offset {}; roll: {}, large offset {}; roll moves yaw by up to {}, dedicated {}, yaw moves roll by {}, dedicated {}",
            yaw[0].seconds(),
            yaw[1].seconds(),
            roll[0].fine_seconds(),
            roll[1].fine_seconds(),
            degrees(&of_yaw[0]),
            degrees(&of_yaw[1]),
            degrees(&of_roll[0]),
            degrees(&of_roll[1])
        ),
        verdict: yaw[0]
            .against(0.0)
            .and(yaw[1].against(0.0))
            .and(eliminated(&of_yaw))
            .and(eliminated(&of_roll))
            .in_part_unless(!slower),
        remark: slower.then(|| {
            let late = roll.iter().filter_map(|r| r.found).filter(|(g, _)| *g < -sample_s);
            let late: Vec<String> = late.map(|(g, at)| format!("{at} ({:.2} s later)", -g)).collect();
            format!(
                "not for roll from the large yaw offset at {}, where that offset takes shared tips off roll earlier",
                late.join(", ")
            )
        }),
    }
}
