//! Whether the eigenvalues agree with the responses where the loop stays linear.
//!
//! A channel's range is read from the response itself: the tips are linear while
//! they stay inside their travel and rate, the thrust vector is closed while its
//! error stays inside the dead zone and linear, without a dead zone, below its force
//! limit. A run that is linear throughout is held against the matrix exponential
//! ([`super::linear::step_response`]); one that becomes linear later shows the decay
//! of its bending coordinate beside the eigenvalue. Only undisturbed pitch runs are
//! compared, the linear response to a step from rest being exact there.
//!
//! A machine's components and converters are not exact. What their errors may do to a response is
//! bounded to first order from the profile's figures: each input's coefficient lies evenly within
//! the component error and each coefficient within half a step of its unit, independently of the
//! others, so that three standard deviations of the whole are allowed, and half a step of a sample.

use super::coefficients::Settings;
use super::control_loop::{Response, Test};
use super::inexact::Inexact;
use super::linear::{
    ChannelGains, Root, driven_matrix, driven_response, matrix_roots, plane_roots, step_response,
};
use super::metrics::{Oscillation, Window, envelope, oscillation};
use super::plan::{Case, Plan};
use nalgebra::DMatrix;

/// Largest accepted difference from the matrix exponential, as a fraction of the step
/// in attitude and of its greatest value in bending. The patch integrates to 1e-7 of
/// each state; a thousandfold of that leaves room for the gain from state to state.
const STEP_WITHIN: f64 = 1e-4;
/// Largest accepted relative error of a measured bending frequency: half a sample in a
/// window of some twenty cycles of twelve samples.
const FREQUENCY_WITHIN: f64 = 5e-3;
/// Largest accepted relative error of a measured damping. A peak found by a parabola
/// through three of twelve samples a cycle is good to about 1 %, and the envelope falls
/// to a tenth in the window; ten peaks leave a few per cent, doubled.
const DAMPING_WITHIN: f64 = 0.10;
/// Window in which the decay of a run that is not linear throughout is measured, s.
const DECAY: Window = Window { from_s: 4.0, to_s: 9.0 };
/// Part of the rate limit above which a tip is taken to have met it between samples.
const RATE_MET: f64 = 0.8;

/// Inputs on the longest way from one state to another, each with a coefficient of its own: from η
/// by pick-up, attitude error, channel error, dead zone, gain, limiter and slope to the thrust vector.
const INPUTS_ON_THE_WAY: f64 = 8.0;
/// Standard deviations that are allowed.
const DEVIATIONS: f64 = 3.0;
/// Steps of its converter that the bending coordinate must still have at the end of a decay that is
/// measured: with fewer, rounding makes peaks of its own.
const LEAST_STEPS: f64 = 20.0;

/// One run held against linear theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Range in which its channels stay.
    pub gains: ChannelGains,
    /// What was compared.
    pub compared: Compared,
    /// Differences that are accepted: of attitude and bending of a response, of frequency and
    /// damping (relative) of a decay.
    pub within: [f64; 2],
}

/// A comparison with linear theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Compared {
    /// The whole response with the matrix exponential.
    Response {
        /// Greatest difference in θ over the step.
        attitude: f64,
        /// Greatest difference in η over its greatest value.
        bending: f64,
    },
    /// The decay of the bending coordinate with its eigenvalue.
    Decay {
        /// As measured.
        measured: Oscillation,
        /// The eigenvalue.
        root: Root,
    },
}

impl Agreement {
    /// Whether they agree.
    pub fn agrees(&self) -> bool {
        let found = match self.compared {
            Compared::Response { attitude, bending } => [attitude, bending],
            Compared::Decay { measured, root } => {
                let off = |found: f64, expected: f64| (found / expected - 1.0).abs();
                [
                    off(measured.frequency_radps, root.frequency_radps()),
                    off(measured.damping, root.damping()),
                ]
            }
        };
        found.iter().zip(self.within).all(|(found, within)| *found <= within)
    }
}

impl Agreement {
    /// Compares a run, if it is an undisturbed one of pitch that is linear, throughout or late.
    pub(super) fn of(
        plan: &Plan,
        case: &Case,
        response: &Response,
        inexact: &Inexact,
    ) -> Option<Agreement> {
        let whole = response.len() == plan.samples() + 1 && response.is_finite();
        if case.test != Test::StepOnly || !whole {
            return None;
        }
        let settings = &case.settings;
        let always = Window { from_s: 0.0, to_s: plan.duration_s };
        if let Some(gains) = linear_range(settings, response, always) {
            let compared = against_exponential(settings, response, gains);
            let within = response_within(settings, response, gains, inexact);
            return Some(Agreement { gains, compared, within });
        }
        let gains = linear_range(settings, response, DECAY)?;
        let root = plane_roots(&settings.plane, gains).bending?;
        let period_s = std::f64::consts::TAU / root.frequency_radps();
        let measured = oscillation(response.eta_m(), response.sample_s, period_s, DECAY)?;
        let end = Window { from_s: DECAY.to_s - 2.0 * period_s, to_s: DECAY.to_s };
        let left_m = envelope(response.eta_m(), response.sample_s, period_s, end)?;
        let half_step_m = inexact.half_step("bending");
        if left_m < 2.0 * LEAST_STEPS * half_step_m {
            return None;
        }
        let mut within = decay_within(settings, gains, root, inexact);
        // A peak off by half a step at either end of the window, and a crossing likewise.
        let rounding = 2.0 * half_step_m / left_m / (DECAY.to_s - DECAY.from_s);
        within[0] += rounding / root.frequency_radps();
        within[1] += rounding / root.real.abs();
        Some(Agreement { gains, compared: Compared::Decay { measured, root }, within })
    }
}

/// The linear loops that the machine's errors make of one, one error at a time, each of one standard
/// deviation: a √3rd of a bound within which it lies evenly.
fn neighbours(settings: &Settings, gains: ChannelGains, inexact: &Inexact) -> Vec<DMatrix<f64>> {
    let nominal = driven_matrix(&settings.plane, gains);
    let mut all = Vec::new();
    if inexact.component_error > 0.0 {
        for i in (0..nominal.len()).filter(|&i| nominal[i] != 0.0) {
            let mut off = nominal.clone();
            off[i] *= 1.0 + (INPUTS_ON_THE_WAY / 3.0).sqrt() * inexact.component_error;
            all.push(off);
        }
    }
    for n in 0..settings.plane.clone().each().len() {
        let mut plane = settings.plane;
        let (blocks, value) = plane.each().swap_remove(n);
        let half_step = blocks.iter().map(|b| inexact.half_step(b)).fold(0.0, f64::max);
        if half_step > 0.0 && *value != 0.0 {
            *value += half_step / 3.0_f64.sqrt();
            all.push(driven_matrix(&plane, gains));
        }
    }
    // The force of the tips is held by another block in each patch.
    let mut plane = settings.plane;
    plane.tip_force += inexact.half_step("fin_force") / 3.0_f64.sqrt();
    if plane != settings.plane {
        all.push(driven_matrix(&plane, gains));
    }
    all
}

/// Accepted differences of a response.
fn response_within(
    settings: &Settings,
    response: &Response,
    gains: ChannelGains,
    inexact: &Inexact,
) -> [f64; 2] {
    let (step, sample_s) = (settings.command_rad, response.sample_s);
    let of = |driven: &DMatrix<f64>| {
        driven_response(driven, step, sample_s, response.len().saturating_sub(1))
    };
    let exact = of(&driven_matrix(&settings.plane, gains));
    let greatest = exact.iter().fold(0.0_f64, |g, row| g.max(row[1].abs()));
    let mut squares = [0.0; 2];
    for neighbour in neighbours(settings, gains, inexact) {
        let found = of(&neighbour);
        for (i, scale) in [step.abs(), greatest].into_iter().enumerate() {
            let pairs = found.iter().zip(&exact);
            let off = pairs.fold(0.0_f64, |d, (a, b)| d.max((a[i] - b[i]).abs())) / scale;
            squares[i] += off * off;
        }
    }
    let mut within = squares.map(|sum| STEP_WITHIN + DEVIATIONS * sum.sqrt());
    // Rounding of the samples; η is the fourth channel of the multiplexer, θ the first.
    const ETA_CHANNEL: f64 = 3.0;
    within[0] += inexact.half_step("pitch_attitude") / step.abs();
    within[1] += inexact.half_step("bending") / greatest
        + ETA_CHANNEL * inexact.skew_s * settings.plane.bending_spring.sqrt();
    within
}

/// Accepted relative differences of frequency and damping.
fn decay_within(
    settings: &Settings,
    gains: ChannelGains,
    root: Root,
    inexact: &Inexact,
) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for neighbour in neighbours(settings, gains, inexact) {
        let states = neighbour.nrows();
        let matrix = neighbour.columns(0, states).into_owned();
        if let Some(off) = matrix_roots(&settings.plane, matrix).bending {
            let parts = [
                off.frequency_radps() / root.frequency_radps() - 1.0,
                off.damping() / root.damping() - 1.0,
            ];
            for (sum, part) in squares.iter_mut().zip(parts) {
                *sum += part * part;
            }
        }
    }
    let [frequency, damping] = squares.map(|sum| DEVIATIONS * sum.sqrt());
    [FREQUENCY_WITHIN + frequency, DAMPING_WITHIN + damping]
}

fn against_exponential(settings: &Settings, response: &Response, gains: ChannelGains) -> Compared {
    let step = settings.command_rad;
    let samples = response.len().saturating_sub(1);
    let exact = step_response(&settings.plane, gains, step, response.sample_s, samples);
    let greatest = exact.iter().fold(0.0_f64, |g, row| g.max(row[1].abs()));
    let difference = |found: &[f64], column: usize, scale: f64| {
        let pairs = found.iter().zip(&exact);
        pairs.fold(0.0_f64, |d, (x, row)| d.max((x - row[column]).abs())) / scale.abs()
    };
    Compared::Response {
        attitude: difference(response.attitude_rad(), 0, step),
        bending: difference(response.eta_m(), 1, greatest),
    }
}

/// Gains of the channels if both keep to one linear range in the window.
fn linear_range(settings: &Settings, response: &Response, window: Window) -> Option<ChannelGains> {
    let plane = &settings.plane;
    let range = window.indices(response.sample_s, response.len());
    let greatest =
        |column: &[f64]| column[range.clone()].iter().fold(0.0_f64, |g, v| g.max(v.abs()));
    let tips = response.of("tip_deflection");
    let rate =
        tips[range.clone()].windows(2).fold(0.0_f64, |g, pair| g.max((pair[1] - pair[0]).abs()))
            / response.sample_s;
    let ftc = if plane.ftc_gain == 0.0 {
        0.0
    } else if greatest(tips) < plane.tip_travel && rate < RATE_MET * plane.tip_rate {
        1.0
    } else {
        return None;
    };
    let error = greatest(response.of("tvc_channel_error"));
    let tvc = if error <= plane.dead_zone && plane.dead_zone > 0.0 {
        0.0
    } else if plane.dead_zone == 0.0 && plane.tvc_gain * error < plane.tvc_limit {
        1.0
    } else {
        return None;
    };
    Some(ChannelGains { ftc, tvc })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::{claims::NORMAL, reference, study_file::Study};
    use vehicle::Vehicle;

    /// Undisturbed runs of the normal mode at their points, as the reference answers them when
    /// it is spoilt.
    fn compared(spoil: impl Fn(&mut Settings)) -> Vec<Agreement> {
        let mut study = Study::shipped().unwrap();
        study.conditions.retain(|c| c.name == NORMAL);
        let plan = Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap();
        let of = |case: &Case| {
            let mut settings = case.settings;
            spoil(&mut settings);
            {
                let response = reference::run(&settings, &reference::grid(&plan, 1e-3));
                Agreement::of(&plan, case, &response, &Inexact::default())
            }
        };
        plan.cases.iter().filter(|c| c.test == Test::StepOnly).filter_map(of).collect()
    }

    #[test]
    fn the_normal_mode_agrees_with_its_eigenvalues_where_it_is_linear_and_another_does_not() {
        let sound = compared(|_| {});
        let whole = sound.iter().filter(|a| matches!(a.compared, Compared::Response { .. }));
        // Before the tips are switched in nothing but the force limit is not linear.
        assert!((1..sound.len()).contains(&whole.count()), "{sound:?}");
        assert!(sound.iter().all(Agreement::agrees), "{sound:?}");
        let wrong = compared(|settings| settings.plane.bending_drag *= 1.5);
        assert!(!wrong.is_empty() && wrong.iter().all(|a| !a.agrees()), "{wrong:?}");
    }
}
