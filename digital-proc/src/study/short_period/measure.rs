//! The measures of each run of the plan, ready to be judged and tabulated.

use super::coefficients::Plane;
use super::linear::{ChannelGains, PlaneRoots, plane_roots};
use super::metrics::{
    Window, detrended_peak_to_peak, envelope, first_beyond_s, longest_run_s, overshoot, settling_s,
    time_beyond_s,
};
use super::plan::{PitchCase, Plan, YawRollCase};
use super::response::{PitchResponse, YawRollResponse};

/// Window of the residual oscillation, s.
pub const RESIDUAL: Window = Window { from_s: 5.0, to_s: 10.0 };
/// Windows of the bending envelope, s: just after the step, and twice later.
pub const ENVELOPES: [Window; 3] = [
    Window { from_s: 0.05, to_s: 2.0 },
    Window { from_s: 5.0, to_s: 6.5 },
    Window { from_s: 8.0, to_s: 9.5 },
];
/// Part of a limit from which an actuator counts as saturated.
pub const SATURATED: f64 = 0.95;
/// Band of pitch settling, as a fraction of the step.
pub const PITCH_BAND: f64 = 0.05;
/// Band of yaw settling, deg.
pub const YAW_BAND_DEG: f64 = 0.2;
/// Band of roll settling, deg.
pub const ROLL_BAND_DEG: f64 = 0.5;
/// Yaw's share of the tips below which they count as given to roll (criterion Y1).
pub const YAW_SHARE: f64 = 0.1;
/// Thrust-vector force that counts as called in, as a fraction of its maximum (Y2).
pub const CALLED_IN: f64 = 0.2;
/// Roll error that counts as fallen, as a fraction of its initial value (Y3).
pub const ROLL_FALLEN: f64 = 0.25;

/// What is measured of one pitch run. `None` where a run does not allow the measure.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PitchMeasures {
    /// Overshoot as a fraction of the step (only of undisturbed runs).
    pub overshoot: Option<f64>,
    /// Time from which θ stays within 5 % of the step about its final value, s.
    pub settling_s: Option<f64>,
    /// Residual oscillation 5–10 s as a fraction of the step.
    pub residual: Option<f64>,
    /// Bending envelope in the three windows, m.
    pub bending_m: [Option<f64>; 3],
    /// Time for which the tips are saturated, s.
    pub tip_saturation_s: f64,
    /// Time for which the thrust vector is saturated, s.
    pub tvc_saturation_s: f64,
    /// Greatest |α|, rad.
    pub greatest_incidence_rad: f64,
    /// Tip authority over the static load of misalignment, gust and step: the
    /// thrust vector is needed where it is below 1 and a margin.
    pub tip_authority: f64,
    /// Roots with both channels linear.
    #[serde(skip)]
    pub roots_both: PlaneRoots,
    /// Roots with the tips alone, inside the dead zone.
    #[serde(skip)]
    pub roots_ftc: PlaneRoots,
    /// Roots with the thrust vector alone, the dead zone ignored.
    #[serde(skip)]
    pub roots_tvc: PlaneRoots,
}

impl PitchMeasures {
    /// Measures a run.
    pub fn new(plan: &Plan, case: &PitchCase, response: &PitchResponse) -> PitchMeasures {
        let sample_s = response.sample_s;
        let theta = response.theta_rad();
        let step = plan.step_rad;
        let plane = &case.settings.plane;
        let period_s = std::f64::consts::TAU / case.frozen.bending_frequency_radps;
        PitchMeasures {
            overshoot: if case.disturbed { None } else { overshoot(theta, step) },
            settling_s: theta
                .last()
                .and_then(|&end| settling_s(theta, sample_s, end, PITCH_BAND * step.abs())),
            residual: detrended_peak_to_peak(theta, sample_s, RESIDUAL).map(|r| r / step.abs()),
            bending_m: ENVELOPES.map(|w| envelope(response.eta_m(), sample_s, period_s, w)),
            tip_saturation_s: if plane.ftc_gain == 0.0 {
                0.0
            } else {
                time_beyond_s(response.tip_rad(), sample_s, SATURATED * plane.tip_travel)
            },
            tvc_saturation_s: time_beyond_s(
                response.tvc_force_n(),
                sample_s,
                SATURATED * plane.tvc_limit,
            ),
            greatest_incidence_rad: response
                .alpha_rad()
                .iter()
                .fold(0.0, |greatest, a| a.abs().max(greatest)),
            tip_authority: tip_authority(plane, &case.settings.command_rad),
            roots_both: plane_roots(plane, ChannelGains::BOTH),
            roots_ftc: plane_roots(plane, ChannelGains::FTC_ONLY),
            roots_tvc: plane_roots(plane, ChannelGains::TVC_ONLY),
        }
    }

    /// Bending envelope of window 1 or 2 over that just after the step.
    pub fn bending_ratio(&self, window: usize) -> Option<f64> {
        let first = self.bending_m[0].filter(|e| *e > 0.0)?;
        Some((*self.bending_m.get(window)?)? / first)
    }
}

/// Greatest tip moment over the static moment of misalignment, gust and step attitude;
/// 0 without tips.
pub fn tip_authority(plane: &Plane, command_rad: &f64) -> f64 {
    if plane.ftc_gain == 0.0 {
        return 0.0;
    }
    let tips = plane.ftc_moment * plane.tip_force * plane.tip_travel;
    let load = plane.misalignment + plane.aero_moment * (plane.gust + command_rad);
    if load == 0.0 { f64::INFINITY } else { tips / load.abs() }
}

/// What is measured of one yaw–roll run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct YawRollMeasures {
    /// Longest time with both tips saturated in opposite senses while yaw has less
    /// than a tenth of them, s.
    pub tips_given_to_roll_s: f64,
    /// First time at which the thrust vector gives a fifth of its force, s.
    pub tvc_called_s: Option<f64>,
    /// When the roll error first falls to a quarter of its initial value, s.
    pub roll_fallen_s: Option<f64>,
    /// Greatest share of the tips in yaw after that, fraction of the travel limit.
    pub yaw_share_after: Option<f64>,
    /// Yaw settling about its final value, band 0.2°, s.
    pub yaw_settling_s: Option<f64>,
    /// Roll settling about its final value, band 0.5°, s.
    pub roll_settling_s: Option<f64>,
    /// Final yaw, rad.
    pub final_yaw_rad: f64,
    /// Final roll, rad.
    pub final_roll_rad: f64,
    /// Bending envelope in the three windows, m.
    pub bending_m: [Option<f64>; 3],
    /// Roots of the yaw plane with both channels linear.
    #[serde(skip)]
    pub roots_both: PlaneRoots,
}

impl YawRollMeasures {
    /// Measures a run.
    pub fn new(case: &YawRollCase, response: &YawRollResponse) -> YawRollMeasures {
        let sample_s = response.sample_s;
        let (yaw, roll) = (response.yaw_rad(), response.roll_rad());
        let (tip2, tip4) = (response.tip2_rad(), response.tip4_rad());
        let travel = case.settings.plane.tip_travel;
        let yaw_share = |i: usize| ((tip2[i] + tip4[i]) / 2.0).abs() / travel;
        let given_to_roll = |i: usize| {
            tip2[i] * tip4[i] < 0.0
                && tip2[i].abs().min(tip4[i].abs()) >= SATURATED * travel
                && yaw_share(i) < YAW_SHARE
        };
        let fallen_below = ROLL_FALLEN * case.settings.initial.roll_rad.abs();
        let fallen = roll.iter().position(|phi| phi.abs() <= fallen_below);
        let period_s = std::f64::consts::TAU / case.frozen.bending_frequency_radps;
        let settled = |column: &[f64], band_deg: f64| {
            column.last().and_then(|&end| settling_s(column, sample_s, end, band_deg.to_radians()))
        };
        let last = |column: &[f64]| column.last().copied().unwrap_or(f64::NAN);
        YawRollMeasures {
            tips_given_to_roll_s: longest_run_s(response.len(), sample_s, given_to_roll),
            tvc_called_s: first_beyond_s(
                response.tvc_force_n(),
                sample_s,
                CALLED_IN * case.settings.plane.tvc_limit,
            ),
            roll_fallen_s: fallen.map(|i| response.time_s(i)),
            yaw_share_after: fallen.map(|from| {
                (from..response.len()).map(yaw_share).fold(0.0, |greatest, s| s.max(greatest))
            }),
            yaw_settling_s: settled(yaw, YAW_BAND_DEG),
            roll_settling_s: settled(roll, ROLL_BAND_DEG),
            final_yaw_rad: last(yaw),
            final_roll_rad: last(roll),
            bending_m: ENVELOPES.map(|w| envelope(response.eta_m(), sample_s, period_s, w)),
            roots_both: plane_roots(&case.settings.plane, ChannelGains::BOTH),
        }
    }
}
