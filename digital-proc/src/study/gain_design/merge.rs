//! Fewer switchings by long-period trials.
//!
//! Greedy: of all pairs of neighbouring intervals, the merger whose flights load
//! the vehicle least is kept, as long as they stay within the load limit, less a
//! reserve, and within the accepted burn-out. An interval without fin tips never
//! joins one with them: their switching-in is an event of the flight, not of the
//! schedule. Merged gains are the means weighted by duration.

use super::schedule;
use crate::{
    flight::Stage,
    linkage::console::Console,
    study::{
        fault::StudyFault,
        long_period::{
            results::{Acceptance, Departure},
            run::{Answer, Bench, LongPeriodPlan},
        },
    },
};
use vehicle::{
    ScheduleData, Vehicle,
    flight_mode::FlightScript,
    flight_summary::FlightSummary,
    gain_schedule::{DeadZoneLaw, LoopGains},
    reference::FlightCase,
};

/// Reserve kept below the load limit, fraction of it.
const LOAD_RESERVE: f64 = 0.10;
/// Misalignments in pitch at which a trial is flown beside the design case's, × 3σ.
const TRIAL_MISALIGNMENTS: [f64; 2] = [-1.0, 1.0];

/// A schedule and what its flights came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The schedule.
    pub schedule: ScheduleData,
    /// Largest Qα over the misalignments, Pa deg; infinite when a flight was lost.
    pub max_q_alpha_padeg: f64,
    /// Departure at burn-out, its largest part over what is accepted.
    pub severity: f64,
    /// Whether both are accepted.
    pub accepted: bool,
}

/// What merging came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Merging {
    /// The start and every accepted merger, one interval fewer each.
    pub levels: Vec<Trial>,
    /// Trial flights flown.
    pub flights: usize,
}

/// The schedule with intervals `i` and `i + 1` merged.
fn merged(data: &ScheduleData, i: usize, end_s: f64, tip_travel_deg: f64) -> ScheduleData {
    let t = &data.switch_time_s;
    let ends = [t[i], t[i + 1], t.get(i + 2).copied().unwrap_or(end_s)];
    let weight = (ends[1] - ends[0]) / (ends[2] - ends[0]);
    // Dead zones are closed anew below.
    let of = |i| LoopGains::of(data, i, DeadZoneLaw::Scheduled);
    let (a, b) = (of(i), of(i + 1));
    let mean = |a: f64, b: f64| weight * a + (1.0 - weight) * b;
    let mut joined = a;
    joined.ftc_gain = mean(a.ftc_gain, b.ftc_gain);
    joined.ftc_lead_s = mean(a.ftc_lead_s, b.ftc_lead_s);
    joined.tvc_gain_nprad = mean(a.tvc_gain_nprad, b.tvc_gain_nprad);
    joined.tvc_lead_s = mean(a.tvc_lead_s, b.tvc_lead_s);
    let mut out = schedule::empty();
    for (k, &switch_s) in t.iter().enumerate() {
        if k == i {
            schedule::push(&mut out, switch_s, &joined);
        } else if k != i + 1 {
            schedule::push(&mut out, switch_s, &of(k));
        }
    }
    schedule::close(&mut out, tip_travel_deg);
    out
}

/// Pairs that may be merged: both with tips or both without.
fn pairs(data: &ScheduleData) -> impl Iterator<Item = usize> {
    let with_tips: Vec<bool> = data.ftc_gain.iter().map(|g| *g > 0.0).collect();
    (1..with_tips.len()).filter(move |&i| with_tips[i - 1] == with_tips[i]).map(|i| i - 1)
}

/// Merges intervals of `start` until no further merger is accepted; `progress`
/// is told the intervals left and the flights flown.
pub fn merge(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    start: &ScheduleData,
    mut progress: impl FnMut(&Trial, usize),
) -> Result<Merging, StudyFault> {
    let stage = Stage::load(console, vehicle, &plan.profile)?;
    let mut trials =
        Trials { bench: Bench::new(vehicle, plan, stage)?, vehicle, nominal: None, flights: 0 };
    let burn_s = vehicle.data().mass.burn_time_s;
    let travel_deg = vehicle.data().ftc.delta_max_deg;
    let first = trials.fly(console, start)?;
    progress(&first, trials.flights);
    let mut levels = vec![first];
    while let Some(present) = levels.last() {
        let mut best: Option<Trial> = None;
        for i in pairs(&present.schedule) {
            let trial = trials.fly(console, &merged(&present.schedule, i, burn_s, travel_deg))?;
            let better =
                best.as_ref().is_none_or(|b| trial.max_q_alpha_padeg < b.max_q_alpha_padeg);
            if trial.accepted && better {
                best = Some(trial);
            }
        }
        let Some(best) = best else { break };
        progress(&best, trials.flights);
        levels.push(best);
    }
    Ok(Merging { levels, flights: trials.flights })
}

struct Trials<'v> {
    bench: Bench<'v>,
    vehicle: &'v Vehicle,
    nominal: Option<FlightSummary>,
    flights: usize,
}

impl Trials<'_> {
    fn fly(&mut self, console: &mut Console<'_>, data: &ScheduleData) -> Result<Trial, StudyFault> {
        let candidate = schedule::with_designed(self.vehicle, data)?;
        let case = &self.vehicle.data().long_period_case;
        let nominal = match self.nominal {
            Some(nominal) => nominal,
            None => {
                self.flights += 1;
                let undisturbed = FlightCase::undisturbed();
                let Answer { ended, .. } =
                    self.bench.fly(console, self.vehicle, &undisturbed, false)?;
                *self.nominal.insert(ended.map_err(StudyFault::NominalLost)?)
            }
        };
        let accept = Acceptance::new(self.vehicle);
        let mut load: f64 = 0.0;
        let mut severity = f64::INFINITY;
        let misalignments = std::iter::once(case.misalign_pitch).chain(TRIAL_MISALIGNMENTS);
        for (k, pitch) in misalignments.enumerate() {
            self.flights += 1;
            let mut flight = FlightCase::design(&candidate, &FlightScript::sound())?;
            flight.pitch_misalignment = pitch;
            let Answer { ended, .. } = self.bench.fly(console, &candidate, &flight, false)?;
            load = load.max(ended.as_ref().map_or(f64::INFINITY, |f| f.max_q_alpha.value));
            if let (0, Ok(flight)) = (k, &ended) {
                severity = Departure::new(flight, &nominal).severity(&accept);
            }
        }
        Ok(Trial {
            schedule: data.clone(),
            max_q_alpha_padeg: load,
            severity,
            accepted: load <= (1.0 - LOAD_RESERVE) * accept.q_alpha_padeg && severity <= 1.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_keeps_the_tips_apart_and_weights_by_duration() {
        let vehicle = Vehicle::shipped().unwrap();
        let data = vehicle.data().gains.schedule();
        let can: Vec<usize> = pairs(&data).collect();
        // Intervals 0 and 1 have no tips, 2 to 7 have.
        assert_eq!(can, [0, 2, 3, 4, 5, 6]);
        let out = merged(&data, 2, 49.0, 10.0);
        assert_eq!(out.switch_time_s, [0.0, 10.0, 17.0, 25.0, 34.0, 40.0, 45.0]);
        // (3·9.5 + 5·7.8)/8 = 8.4375, to 0.1; its dead zone 10/8.4 to 0.01.
        assert_eq!(out.ftc_gain[2], 8.4);
        assert_eq!(out.dead_zone_deg[2], 1.19);
        let last = merged(&data, 6, 49.0, 10.0);
        // (5·11.5 + 4·16)/9 = 13.5.
        assert_eq!(last.ftc_gain[6], 13.5);
        assert_eq!(last.switch_time_s.len(), 7);
    }
}
