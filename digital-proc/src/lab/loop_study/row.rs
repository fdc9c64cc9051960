//! What a run of a loop study did: the least damped oscillatory mode of its record, or the
//! strongest one of a record that came through a converter.
//!
//! The record must be a decay of one linear loop. The pencil gives modes of anything, so a
//! damping is told only where those modes describe the record, and a reason where they do not.

use super::{
    super::{
        bench::Saturated,
        identify,
        modal_fit::ModalFit,
        theory::{C64, Refusal, damping_ratio, equivalent_root},
    },
    LoopCase, LoopStudy,
    poles::Poles,
    remark::{Remark, STEPS_HIGH, WORST_FIT},
    swing::Swing,
};
use nalgebra::ComplexField;

/// What a converter adds to that, steps (rms): its rounding is 1/√12 = 0.29 of a step, and comes
/// back through the loop.
const STEPS_LEFT: f64 = 0.5;
/// The most that may be left with converters. An integral in the law sums what is rounded: one
/// through 8 bits left 0.017 to 0.029 and had 20 % less damping than the linear loop, while
/// records that left less than this told it to 2 %.
const WORST_FIT_OF_ALL: f64 = 1e-2;
/// A mode is the record's own where its rms is this many times what the fit leaves: among what is
/// left a dozen modes can always be found, each about as strong as that.
const ABOVE_THE_REST: f64 = 10.0;
/// Damping ratio, beside the fit, below which a swing that goes on is no decay: ten digits of the
/// integration less those that a record of 320 frames costs.
const NO_DECAY: f64 = 1e-6;

/// One row of the answer.
#[derive(Clone, Debug)]
pub struct LoopRow {
    /// With the bits that the converters had.
    pub case: LoopCase,
    /// The oscillatory mode found, rad/s: the least damped, or through a converter the strongest.
    /// None where there is none, or where the record is no decay of one linear loop.
    pub root: Option<C64>,
    /// Greatest magnitude in the last tenth of the record over that in the first tenth; none where
    /// the first tenth is zero.
    pub last_over_first: Option<f64>,
    /// What the modes of the record's first two thirds leave of all of it, rms over rms; none
    /// where no mode was sought.
    pub fit: Option<f64>,
    /// What the loop does by its exact poles, where it has them.
    pub poles: Option<Poles>,
    /// Why a value is missing, and what else happened.
    pub remarks: Vec<Remark>,
}

/// A mode as it is told.
struct Told {
    root: C64,
    rms: f64,
    fit: f64,
}

impl Told {
    /// The swing of a mode that neither dies nor grows.
    fn swing(&self) -> Swing {
        Swing {
            amplitude: std::f64::consts::SQRT_2 * self.rms,
            period_s: std::f64::consts::TAU / self.root.im,
        }
    }
}

impl LoopStudy {
    /// What a run of `case` did in the study's window, from the last saturation on.
    ///
    /// A record that cannot be judged leaves the modal columns empty, with a remark.
    pub fn row(
        &self,
        case: &LoopCase,
        record: &[f64],
        saturated: &Saturated,
    ) -> Result<LoopRow, Refusal> {
        identify::check(record, identify::SHORTEST)?;
        let frames = |t: interface::Tick| (t.0 / case.frame.0) as usize;
        let first = frames(interface::Tick(self.from.0 + case.frame.0 - 1)).min(record.len());
        let end = (frames(self.until) + 1).min(record.len()).max(first);
        identify::check(&record[first..end], identify::SHORTEST)?;

        let mut remarks = Vec::new();
        let mut start = first;
        let before_the_end = saturated.frames.partition_point(|n| (*n as usize) < end);
        if let Some(last) = saturated.frames[..before_the_end].last() {
            remarks.push(Remark::Saturated {
                channels: saturated.channels.clone(),
                until_s: *last as f64 * case.frame.secs(),
            });
            start = start.max(*last as usize + 1);
        }
        let window = &record[start..end];
        let told = if window.len() < identify::SHORTEST {
            Err(Remark::TooShort { frames: window.len() })
        } else {
            mode(window, case.frame.secs())?
        };
        let mut swing = Swing::of(&record[first..end], case.frame.secs());
        let (told, fit) = match told {
            Ok(told) => {
                let zeta = damping_ratio(told.root).abs();
                if zeta <= NO_DECAY {
                    swing = swing.or(Some(told.swing()));
                }
                let decays = swing.is_none() || zeta > told.fit.max(NO_DECAY);
                (decays.then_some(told.root), Some(told.fit))
            }
            Err(remark) => {
                let fit = remark.fit();
                remarks.push(remark);
                (None, fit)
            }
        };
        if let Some(swing) = swing {
            remarks.push(Remark::Swings(swing));
        }
        let judged = &record[first..end];
        let tenth = (judged.len() / 10).max(1);
        let before = peak(&judged[..tenth]);
        Ok(LoopRow {
            case: *case,
            root: told,
            last_over_first: (before > 0.0)
                .then(|| peak(&judged[judged.len() - tenth..]) / before)
                .filter(|ratio| ratio.is_finite()),
            fit,
            poles: None,
            remarks,
        })
    }
}

impl LoopRow {
    /// The exact root that belongs to the measured one.
    pub fn exact(&self) -> Option<C64> {
        self.poles.as_ref()?.oscillation(self.root)
    }
}

/// The mode of a record, or why none is told. Faults are those of a record that is none.
fn mode(record: &[f64], period_s: f64) -> Result<Result<Told, Remark>, Refusal> {
    let step = converter_step(record);
    let judged = match above_the_steps(record, step) {
        Some(judged) => judged,
        None => return Ok(Err(Remark::TooCoarse)),
    };
    // Quantisation stands above the noise-free floor.
    let floor = (2.0 * step / peak(judged)).max(1e-9);
    let sought = |part: &[f64]| match identify::factors(part, floor) {
        Ok(z) => Ok(z),
        Err(Refusal::NoOscillation) => Ok(Vec::new()),
        Err(e) => Err(e),
    };
    let z = sought(judged)?;
    // Modes of the first two thirds, judged on all: what is no sum of modes can be matched where
    // they were sought, and fails beyond.
    let used = judged.len().min(identify::LONGEST);
    let part = (2 * used / 3).max(identify::SHORTEST);
    let (Some(all), Some(beyond)) =
        (ModalFit::new(judged, &z), ModalFit::new(judged, &sought(&judged[..part])?))
    else {
        return Ok(Err(Remark::NoModes));
    };
    let fit = beyond.residual;
    let rms = (all.record_energy / all.samples as f64).sqrt();
    if fit > (WORST_FIT + STEPS_LEFT * step / rms).min(WORST_FIT_OF_ALL) {
        return Ok(Err(Remark::NotOneDecay { fit }));
    }
    let least_energy = (ABOVE_THE_REST * fit).powi(2) * all.record_energy;
    let oscillating = (0..z.len())
        .map(|k| (equivalent_root(z[k], period_s), all.energy[k]))
        .filter(|(s, energy)| oscillates(*s, period_s) && *energy > least_energy);
    let found = if step > 0.0 {
        // Noise has modes of its own, some of them undamped: the record's is the strongest.
        oscillating.max_by(|a, b| a.1.total_cmp(&b.1))
    } else {
        oscillating.max_by(|a, b| a.0.re.total_cmp(&b.0.re))
    };
    Ok(match found {
        Some((root, energy)) => {
            // A mode and its conjugate.
            let rms = 2.0 * (energy / (2.0 * all.samples as f64)).sqrt();
            Ok(Told { root, rms, fit })
        }
        None => Err(Remark::NoOscillation { fit }),
    })
}

/// Whether a root swings, and is no alternation from frame to frame.
pub(super) fn oscillates(s: C64, period_s: f64) -> bool {
    s.im > 0.0 && s.im < 0.999 * (std::f64::consts::PI / period_s)
}

fn peak(part: &[f64]) -> f64 {
    part.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
}

/// Share of a record's peak below which two samples differ by rounding, not by a converter step.
const ROUNDING: f64 = 1e-9;

/// The step of the converter through which a record came: what all its values are multiples of;
/// zero where they are not multiples of one step.
fn converter_step(record: &[f64]) -> f64 {
    let peak = peak(record);
    let mut sorted = record.to_vec();
    sorted.sort_by(f64::total_cmp);
    let step = sorted
        .windows(2)
        .map(|w| w[1] - w[0])
        .filter(|d| *d > ROUNDING * peak)
        .fold(f64::INFINITY, f64::min);
    let whole = |v: &f64| {
        let steps = v / step;
        (steps - steps.round()).abs() < 1e-3
    };
    if step.is_finite() && record.iter().all(whole) { step } else { 0.0 }
}

/// The record up to its last sample that stands well above the steps about where it comes to rest;
/// all of it where there are no steps, none where too little stands above them.
fn above_the_steps(record: &[f64], step: f64) -> Option<&[f64]> {
    if step == 0.0 {
        return Some(record);
    }
    let end = &record[record.len() - (record.len() / 10).max(1)..];
    let mean = end.iter().sum::<f64>() / end.len() as f64;
    let rest = (mean / step).round() * step;
    let last = record.iter().rposition(|v| (v - rest).abs() >= STEPS_HIGH * step)?;
    (last + 1 >= identify::SHORTEST).then(|| &record[..=last])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_of_a_converter_is_found_and_a_smooth_record_has_none() {
        let smooth: Vec<f64> =
            (0..200).map(|n| (-0.02 * n as f64).exp() * (0.3 * n as f64).cos()).collect();
        assert_eq!(converter_step(&smooth), 0.0);
        let step = 4.0 / 4096.0;
        let coarse: Vec<f64> = smooth.iter().map(|v| (v / step).round() * step).collect();
        assert!((converter_step(&coarse) - step).abs() < 1e-12);
        let judged = above_the_steps(&coarse, step).unwrap().len();
        // e^(-0.02 n) = 10 steps = 0.0098 at n = 231: all of it; with ten times the step, n = 116.
        assert!(judged > 190);
        let step = 10.0 * step;
        let coarser: Vec<f64> = smooth.iter().map(|v| (v / step).round() * step).collect();
        let judged = above_the_steps(&coarser, converter_step(&coarser)).unwrap().len();
        assert!((100..=120).contains(&judged), "{judged}");
        assert_eq!(converter_step(&[0.0; 20]), 0.0);
    }
}
