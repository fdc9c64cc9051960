//! The measures of a run, ready to be judged and tabulated.

use super::coefficients::{Plane, Settings};
use super::control_loop::{Offset, Response, Test};
use super::linear::{ChannelGains, PlaneRoots, plane_roots};
use super::metrics::{
    Window, detrended_peak_to_peak, envelope, first_beyond_s, longest_run_s, overshoot, settling_s,
    time_beyond_s,
};
use super::plan::{Case, Plan};

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
/// Band of yaw settling, as a fraction of the large yaw offset: 0.2° of 2.5°.
pub const LARGE_YAW_BAND: f64 = 0.08;
/// The same of the other one: 0.08° of 0.5°. Twice as wide in proportion, since misalignment and
/// gust, which do not shrink with the offset, rule the last of the approach.
pub const YAW_BAND: f64 = 0.16;
/// Band of roll settling, deg.
pub const ROLL_BAND_DEG: f64 = 0.5;
/// Yaw's share of the tips below which they count as given to roll (criterion Y1).
const YAW_SHARE: f64 = 0.1;
/// Thrust-vector force that counts as begun and as called in, as fractions of its maximum (Y2).
const BEGUN: f64 = 0.02;
const CALLED_IN: f64 = 0.2;
/// Roll error that counts as fallen, as a fraction of its initial value (Y3).
const ROLL_FALLEN: f64 = 0.25;

/// What is measured of one run. `None` where the run does not allow the measure, or its loop
/// has no such thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Roots of the plane with both channels linear.
    pub roots: PlaneRoots,
    /// Bending envelope in the three windows, m.
    pub bending_m: [Option<f64>; 3],
    /// Time from which the attitude (θ or ψ) stays within its band about its final value, s.
    pub settling_s: Option<f64>,
    /// Overshoot of θ as a fraction of the step; of a run without disturbances.
    pub overshoot: Option<f64>,
    /// Greatest θ over the step command.
    pub peak: Option<f64>,
    /// Mean error θ − θ_c of the last second, rad.
    pub standing_error_rad: Option<f64>,
    /// Residual oscillation of θ from 5 to 10 s as a fraction of the step.
    pub residual: Option<f64>,
    /// Time for which the tips are saturated in pitch, s.
    pub tip_saturation_s: Option<f64>,
    /// Time for which the thrust vector is saturated in pitch, s.
    pub tvc_saturation_s: Option<f64>,
    /// Greatest |α| in pitch, rad.
    pub greatest_incidence_rad: Option<f64>,
    /// Tip authority over the static load of misalignment, gust and step: the
    /// thrust vector is needed where it is below 1 and a margin.
    pub tip_authority: f64,
    /// Longest time with both tips saturated in opposite senses while yaw has less
    /// than a tenth of them, s.
    pub tips_given_to_roll_s: Option<f64>,
    /// First time at which the tips, less what roll has of them, fall short of what their own gain
    /// asks for the yaw offset, s: δ_max − ½|δ_2 − δ_4| < K_F |ψ_0|.
    pub tips_short_s: Option<f64>,
    /// First time at which the thrust vector gives a fiftieth of its force in yaw, s.
    pub tvc_begins_s: Option<f64>,
    /// First time at which the thrust vector gives a fifth of its force in yaw, s.
    pub tvc_called_s: Option<f64>,
    /// Greatest thrust-vector force in yaw, N.
    pub tvc_peak_n: Option<f64>,
    /// When the roll error first falls to a quarter of its initial value, s.
    pub roll_fallen_s: Option<f64>,
    /// Mean share of the tips in yaw until roll first lets them off their limits, fraction of the
    /// travel limit.
    pub yaw_share_before: Option<f64>,
    /// Greatest share of the tips in yaw after that, fraction of the travel limit.
    pub yaw_share_after: Option<f64>,
    /// Roll settling about its final value, s.
    pub roll_settling_s: Option<f64>,
    /// Final yaw and roll, rad.
    pub final_rad: Option<[f64; 2]>,
}

impl Measures {
    /// Measures a run.
    pub fn new(plan: &Plan, case: &Case, response: &Response) -> Measures {
        let sample_s = response.sample_s;
        let attitude = response.attitude_rad();
        let Settings { plane, command_rad, roll } = &case.settings;
        let period_s = std::f64::consts::TAU / case.frozen.bending_frequency_radps;
        let settled =
            |column: &[f64], band: f64| settling_s(column, sample_s, *column.last()?, band);
        let none = Measures {
            roots: plane_roots(plane, ChannelGains::BOTH),
            bending_m: ENVELOPES.map(|w| envelope(response.eta_m(), sample_s, period_s, w)),
            settling_s: None,
            overshoot: None,
            peak: None,
            standing_error_rad: None,
            residual: None,
            tip_saturation_s: None,
            tvc_saturation_s: None,
            greatest_incidence_rad: None,
            tip_authority: tip_authority(plane, *command_rad),
            tips_given_to_roll_s: None,
            tips_short_s: None,
            tvc_begins_s: None,
            tvc_called_s: None,
            tvc_peak_n: None,
            roll_fallen_s: None,
            yaw_share_before: None,
            yaw_share_after: None,
            roll_settling_s: None,
            final_rad: None,
        };
        let Some(loop_of_roll) = roll else {
            let step = plan.step_rad;
            let beyond = |adc, limit| time_beyond_s(response.of(adc), sample_s, SATURATED * limit);
            let greatest = |column: &[f64]| column.iter().fold(0.0_f64, |g, v| v.abs().max(g));
            let last_second = attitude.len().saturating_sub((1.0 / sample_s).round() as usize);
            let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
            return Measures {
                peak: Some(attitude.iter().fold(0.0_f64, |g, v| (v / step).max(g))),
                standing_error_rad: Some(mean(&attitude[last_second..]) - step),
                overshoot: overshoot(attitude, step).filter(|_| case.test == Test::StepOnly),
                settling_s: settled(attitude, PITCH_BAND * step.abs()),
                residual: detrended_peak_to_peak(attitude, sample_s, RESIDUAL)
                    .map(|r| r / step.abs()),
                tip_saturation_s: Some(if plane.ftc_gain == 0.0 {
                    0.0
                } else {
                    beyond("tip_deflection", plane.tip_travel)
                }),
                tvc_saturation_s: Some(beyond("tvc_force", plane.tvc_limit)),
                greatest_incidence_rad: Some(greatest(response.of("angle_of_attack"))),
                ..none
            };
        };
        let roll = response.of("roll_attitude");
        let (tip2, tip4) = (response.of("tip2_deflection"), response.of("tip4_deflection"));
        let travel = plane.tip_travel;
        let yaw_share = |i: usize| ((tip2[i] + tip4[i]) / 2.0).abs() / travel;
        let given_to_roll = |i: usize| {
            tip2[i] * tip4[i] < 0.0
                && tip2[i].abs().min(tip4[i].abs()) >= SATURATED * travel
                && yaw_share(i) < YAW_SHARE
        };
        let fallen_below = ROLL_FALLEN * loop_of_roll.initial.roll_rad.abs();
        let fallen = roll.iter().position(|phi| phi.abs() <= fallen_below);
        let in_roll: Vec<f64> =
            tip2.iter().zip(tip4).map(|(two, four)| (two - four) / 2.0).collect();
        let offset_rad = loop_of_roll.initial.yaw_rad.abs();
        let tvc = response.of("tvc_yaw_force");
        let beyond = |fraction| first_beyond_s(tvc, sample_s, fraction * plane.tvc_limit);
        let yaw_band = match case.test {
            Test::Dedicated(Offset::LargeYaw) | Test::Shared(Offset::LargeYaw) => LARGE_YAW_BAND,
            _ => YAW_BAND,
        };
        // A run without a yaw offset settles to the band of its fellows.
        let yaw_band_rad = yaw_band * if offset_rad == 0.0 { plan.yaw_rad } else { offset_rad };
        let let_off =
            (0..response.len()).skip_while(|&i| !given_to_roll(i)).find(|&i| !given_to_roll(i));
        let last = |column: &[f64]| column.last().copied().unwrap_or(f64::NAN);
        Measures {
            tips_given_to_roll_s: Some(longest_run_s(response.len(), sample_s, given_to_roll)),
            tips_short_s: first_beyond_s(
                &in_roll,
                sample_s,
                (travel - plane.ftc_gain * offset_rad).max(0.0),
            )
            .filter(|_| offset_rad > 0.0),
            tvc_begins_s: beyond(BEGUN),
            tvc_called_s: beyond(CALLED_IN),
            tvc_peak_n: Some(tvc.iter().fold(0.0_f64, |g, v| v.abs().max(g))),
            roll_fallen_s: fallen.map(|i| i as f64 * sample_s),
            yaw_share_before: let_off
                .map(|until| (0..until).map(yaw_share).sum::<f64>() / until as f64),
            yaw_share_after: fallen
                .map(|from| (from..response.len()).map(yaw_share).fold(0.0_f64, f64::max)),
            settling_s: settled(attitude, yaw_band_rad),
            roll_settling_s: settled(roll, ROLL_BAND_DEG.to_radians()),
            final_rad: Some([last(attitude), last(roll)]),
            ..none
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
fn tip_authority(plane: &Plane, command_rad: f64) -> f64 {
    if plane.ftc_gain == 0.0 {
        return 0.0;
    }
    let tips = plane.ftc_moment * plane.tip_force * plane.tip_travel;
    let load = plane.misalignment + plane.aero_moment * (plane.gust + command_rad);
    if load == 0.0 { f64::INFINITY } else { tips / load.abs() }
}
