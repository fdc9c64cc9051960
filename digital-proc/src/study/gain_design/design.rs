//! Gains of each sequencer interval, improved run by run on the pitch loop.
//!
//! The switch times are given (those of the vehicle's schedule); yaw shares the
//! pitch gains. Each interval starts from gains that place the poles of the rigid
//! vehicle, and is then judged at both its ends, where its frozen coefficients are
//! farthest apart. Gains whose linearised loop is unstable, or drives the bending
//! mode, are not put on the machine.

use super::{
    criteria::{LoopQuality, least_bending_damping, measure},
    schedule,
    search::{Bounds, Effort, Found, coordinate_search},
};
use crate::{
    linkage::console::Console,
    study::{
        fault::StudyFault,
        short_period::{
            coefficients::{Disturbance, Plane},
            linear::{ChannelGains, plane_roots},
            machine::Bench,
            point::FrozenPoint,
            study_file::StudyError,
        },
    },
};
use vehicle::{
    ScheduleData, Vehicle,
    gain_schedule::{DeadZoneLaw, LoopGains},
    slice::{self, SlicePoint},
};

/// Last and first instants at which the loop is judged, s before burn-out and
/// after lift-off: outside, thrust or dynamic pressure tells nothing of a loop.
const END_MARGIN_S: f64 = 2.0;
/// Natural frequency and damping ratio of the rigid vehicle's starting poles.
const START_RADPS: f64 = 2.0;
const START_DAMPING: f64 = 0.7;
/// Starting rate gain of the injection beside working tips, s: low, since its
/// lead drives the bending mode.
const START_TVC_LEAD_S: f64 = 0.2;
/// Growth of the slow drift root that is tolerated, 1/s.
const DRIFT_GROWTH: f64 = 0.2;
/// Cost from which a loop was refused without a run.
const REFUSED: f64 = 1e3;

/// Search effort for one interval.
pub const EFFORT: Effort = Effort { first_factor: 1.25, last_factor: 1.02, evaluations: 26 };

/// Bounds of K_F, T_F (s), K_T (N/rad), T_T (s).
const FTC_GAIN: Bounds = Bounds { low: 2.0, high: 25.0 };
const FTC_LEAD_S: Bounds = Bounds { low: 0.2, high: 1.5 };
const TVC_GAIN: Bounds = Bounds { low: 1e3 * DEGREES, high: 1e4 * DEGREES };
const TVC_LEAD_S: Bounds = Bounds { low: 0.05, high: 1.5 };
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// One interval's design.
#[derive(Clone, Debug, PartialEq)]
pub struct IntervalDesign {
    /// Where it is judged, s.
    pub judged_s: [f64; 2],
    /// Cost of the starting gains.
    pub first_cost: f64,
    /// Cost of the designed gains.
    pub cost: f64,
    /// Evaluations of the cost.
    pub evaluations: usize,
    /// Quality of the designed gains at both places.
    pub quality: Vec<LoopQuality>,
}

/// A designed schedule.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// The schedule.
    pub schedule: ScheduleData,
    /// How each interval came out.
    pub intervals: Vec<IntervalDesign>,
    /// Runs on the machine.
    pub runs: usize,
}

/// Designs the gains of every interval of the vehicle's own switch times; `progress` is told
/// each interval's number, of how many, and how it came out.
pub fn design(
    console: &mut Console<'_>,
    bench: &Bench,
    vehicle: &Vehicle,
    effort: Effort,
    mut progress: impl FnMut(usize, usize, &IntervalDesign),
) -> Result<Design, StudyFault> {
    let switches = vehicle.designed_schedule().switch_time_s().to_vec();
    let last_s = vehicle.data().mass.burn_time_s - END_MARGIN_S;
    let ends: Vec<[f64; 2]> = switches
        .iter()
        .enumerate()
        .map(|(i, &from)| {
            let to = switches.get(i + 1).copied().unwrap_or(last_s).min(last_s);
            [from.max(END_MARGIN_S).min(to), to]
        })
        .collect();
    let wanted: Vec<(&str, f64)> = ends.iter().flatten().map(|&t| ("", t)).collect();
    let slices = slice::points(vehicle, &wanted).map_err(StudyError::from)?;
    let tip_travel_deg = vehicle.data().ftc.delta_max_deg;
    let law = DeadZoneLaw::new(vehicle.data());
    let mut found = Design {
        schedule: schedule::empty(),
        intervals: Vec::with_capacity(switches.len()),
        runs: 0,
    };
    for (i, judged_s) in ends.iter().enumerate() {
        let mut judge = Judge {
            console,
            bench,
            vehicle,
            slices: [&slices[2 * i], &slices[2 * i + 1]],
            runs: 0,
        };
        let with_tips = switches[i] >= vehicle.data().ftc.on_time_s;
        let (gains, first_cost, evaluations) = judge.interval(with_tips, effort)?;
        schedule::push(&mut found.schedule, switches[i], &gains);
        schedule::close(&mut found.schedule, tip_travel_deg);
        let quality = judge.quality(&LoopGains::of(&found.schedule, i, law))?;
        found.runs += judge.runs;
        let cost = worse(&quality);
        let interval =
            IntervalDesign { judged_s: *judged_s, first_cost, cost, evaluations, quality };
        progress(i + 1, switches.len(), &interval);
        found.intervals.push(interval);
    }
    Ok(found)
}

/// The worse cost of the two ends.
fn worse(quality: &[LoopQuality]) -> f64 {
    quality.iter().map(LoopQuality::cost).fold(0.0, f64::max)
}

/// Tries gains at both ends of one interval.
struct Judge<'j, 'c, 'p> {
    console: &'j mut Console<'p>,
    bench: &'c Bench,
    vehicle: &'c Vehicle,
    slices: [&'c SlicePoint; 2],
    runs: usize,
}

impl Judge<'_, '_, '_> {
    /// Searches the gains; with them the first cost and the evaluations used.
    fn interval(
        &mut self,
        with_tips: bool,
        effort: Effort,
    ) -> Result<(LoopGains, f64, usize), StudyFault> {
        let start = self.start(with_tips);
        let travel_rad = self.vehicle.data().ftc.delta_max_deg.to_radians();
        fn told<const N: usize>(gains: LoopGains, found: &Found<N>) -> (LoopGains, f64, usize) {
            (gains, found.first_cost, found.evaluations)
        }
        if with_tips {
            let gains = |p: &[f64; 4]| LoopGains {
                ftc_gain: p[0],
                ftc_lead_s: p[1],
                tvc_gain_nprad: p[2],
                tvc_lead_s: p[3],
                dead_zone_rad: travel_rad / p[0],
                // Of the pitch tips, which are designed here, roll takes nothing.
                dead_zone_yield: 0.0,
            };
            let from = [start.ftc_gain, start.ftc_lead_s, start.tvc_gain_nprad, start.tvc_lead_s];
            let bounds = [FTC_GAIN, FTC_LEAD_S, TVC_GAIN, TVC_LEAD_S];
            let found = coordinate_search(from, &bounds, effort, |p| self.cost(&gains(p)))?;
            Ok(told(gains(&found.parameters), &found))
        } else {
            let gains = |p: &[f64; 2]| LoopGains {
                ftc_gain: 0.0,
                ftc_lead_s: 0.0,
                tvc_gain_nprad: p[0],
                tvc_lead_s: p[1],
                dead_zone_rad: 0.0,
                dead_zone_yield: 0.0,
            };
            let from = [start.tvc_gain_nprad, start.tvc_lead_s];
            let bounds = [TVC_GAIN, TVC_LEAD_S];
            let found = coordinate_search(from, &bounds, effort, |p| self.cost(&gains(p)))?;
            Ok(told(gains(&found.parameters), &found))
        }
    }

    /// Pole placement on the rigid vehicle in the middle of the interval:
    /// θ̈ = μ_α θ − K μ (θ + T θ̇), so that K μ − μ_α = ω² and K μ T = 2ζω.
    fn start(&self, with_tips: bool) -> LoopGains {
        let none = LoopGains {
            ftc_gain: 1.0,
            ftc_lead_s: 0.0,
            tvc_gain_nprad: 1.0,
            tvc_lead_s: 0.0,
            dead_zone_rad: 0.0,
            dead_zone_yield: 0.0,
        };
        let mean = |of: fn(&Plane) -> f64| {
            let planes = self
                .slices
                .map(|s| Plane::new(&FrozenPoint::new(self.vehicle, s, &none), &Disturbance::NONE));
            0.5 * (of(&planes[0]) + of(&planes[1]))
        };
        let stiffness = START_RADPS * START_RADPS + mean(|p| p.aero_moment).max(0.0);
        let lead_s = 2.0 * START_DAMPING * START_RADPS / stiffness;
        let tvc_gain_nprad = stiffness / mean(|p| p.tvc_moment);
        if !with_tips {
            return LoopGains { ftc_gain: 0.0, tvc_gain_nprad, tvc_lead_s: lead_s, ..none };
        }
        LoopGains {
            ftc_gain: stiffness / mean(|p| p.ftc_moment * p.tip_force),
            ftc_lead_s: lead_s,
            tvc_gain_nprad,
            tvc_lead_s: START_TVC_LEAD_S,
            ..none
        }
    }

    /// The worse cost of the two ends.
    fn cost(&mut self, gains: &LoopGains) -> Result<f64, StudyFault> {
        let mut refused = 0.0;
        for slice in self.slices {
            let frozen = FrozenPoint::new(self.vehicle, slice, gains);
            let plane = Plane::new(&frozen, &Disturbance::NONE);
            let growth = plane_roots(&plane, ChannelGains::BOTH)
                .rightmost
                .map_or(0.0, |r| r.real - DRIFT_GROWTH);
            refused += growth.max(0.0) + (-least_bending_damping(&plane)).max(0.0);
        }
        if refused > 0.0 {
            return Ok(REFUSED * (1.0 + refused));
        }
        Ok(worse(&self.quality(gains)?))
    }

    fn quality(&mut self, gains: &LoopGains) -> Result<Vec<LoopQuality>, StudyFault> {
        self.runs += 2 * self.slices.len();
        let frozen = self.slices.map(|slice| FrozenPoint::new(self.vehicle, slice, gains));
        measure(self.console, self.bench, &frozen, |_| {})
    }
}
