//! From a study and a vehicle to the list of runs.
//!
//! Finds each point on the nominal flight, freezes it, applies every condition and
//! lists the runs of both loops with their settings. The plan is pure data: whoever
//! runs it (the hybrid machine or the reference) answers run by run in its order.
//! A run is left out where its condition cannot apply (no interval before the
//! first, no fin tips) or changes nothing.

use super::coefficients::{Disturbance, Offsets, Settings};
use super::control_loop::{ControlLoop, Offset, Test};
use super::higher_modes::of_a_loop;
use super::moment;
use super::places::{gyro_stations, locate_all};
use super::point::FrozenPoint;
use super::point::QUANTITIES;
use super::study_file::{Condition, GainSource, How, Study, StudyError};
use interface::Tick;
use vehicle::Vehicle;
use vehicle::gain_schedule::{GainSchedule, LoopGains};
use vehicle::slice::SlicePoint;
use vehicle::structure::Structure;

/// All runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Duration of a run, s.
    pub duration_s: f64,
    /// Sampling interval, whole milliseconds.
    pub sample: Tick,
    /// Step command of the pitch test, rad.
    pub step_rad: f64,
    /// Yaw offset of the yaw–roll test, rad.
    pub yaw_rad: f64,
    /// What the vehicle may take.
    pub limits: Limits,
    /// Bending modes in the pitch loop.
    pub modes: usize,
    /// The points in the study's order.
    pub points: Vec<PlannedPoint>,
    /// The conditions in the study's order.
    pub conditions: Vec<Condition>,
    /// Points left out, and why.
    pub left_out: Vec<String>,
    /// The vehicle as a beam.
    pub structure: Structure,
    /// The runs, those of the pitch loop first.
    pub cases: Vec<Case>,
}

/// What the vehicle's data allow, for claims that ask it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of |Qα|, Pa deg.
    pub q_alpha_padeg: f64,
    /// Of the path angle at burn-out, rad.
    pub path_angle_rad: f64,
}

/// A point found on the flight.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPoint {
    /// Name.
    pub name: String,
    /// Its slice of the flight.
    pub slice: SlicePoint,
}

/// What one run is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Index of the point.
    pub point: usize,
    /// Index of the condition.
    pub condition: usize,
    /// What is tested.
    pub test: Test,
    /// The point as the condition leaves it.
    pub frozen: FrozenPoint,
    /// Settings of the patch.
    pub settings: Settings,
}

impl Plan {
    /// Plans a study on a vehicle.
    pub fn new(study: &Study, vehicle: &Vehicle) -> Result<Plan, StudyError> {
        let slices = locate_all(&study.points, study.source(), vehicle)?;
        gyro_stations(study, vehicle)?;
        let named = |slice: SlicePoint| PlannedPoint { name: slice.name.clone(), slice };
        let mut plan = Plan {
            duration_s: study.duration_s,
            sample: Tick(i64::from(study.sample_ms) * 1_000_000),
            step_rad: study.pitch.step_deg.to_radians(),
            limits: Limits {
                q_alpha_padeg: vehicle.data().limits.q_alpha_padeg,
                path_angle_rad: vehicle.data().long_period_case.accept_dgam_deg.to_radians(),
            },
            yaw_rad: study.yaw_roll.yaw_deg.to_radians().abs(),
            modes: study.pitch.modes as usize,
            points: slices.into_iter().map(named).collect(),
            conditions: study.conditions.clone(),
            left_out: study.left_out.clone(),
            structure: Structure::new(vehicle),
            cases: Vec::new(),
        };
        plan.list_runs(study, vehicle);
        plan.cases.iter().try_for_each(|case| moment::beam(&plan, case).map(drop))?;
        Ok(plan)
    }

    /// Number of samples after the one at zero.
    pub fn samples(&self) -> usize {
        (self.duration_s / self.sample.secs()).round() as usize
    }

    /// The runs of one loop.
    pub fn of(&self, control_loop: ControlLoop) -> impl Iterator<Item = &Case> {
        self.cases.iter().filter(move |case| case.test.control_loop() == control_loop)
    }

    fn list_runs(&mut self, study: &Study, vehicle: &Vehicle) {
        let (pitch, yaw) = (&study.pitch, &study.yaw_roll);
        let shaken = Disturbance { misalignment: pitch.misalignment, gust: pitch.gust, cant: 0.0 };
        let yaw_roll =
            Disturbance { misalignment: yaw.misalignment, gust: yaw.gust, cant: yaw.cant };
        let initial = |offset| {
            let (yaw_deg, roll_deg) = match offset {
                Offset::Both => (yaw.yaw_deg, yaw.roll_deg),
                Offset::LargeYaw => (yaw.large_yaw_deg, yaw.roll_deg),
                Offset::YawAlone => (yaw.yaw_deg, 0.0),
                Offset::RollAlone => (0.0, yaw.roll_deg),
            };
            Offsets {
                yaw_rad: yaw_deg.to_radians(),
                yaw_rate_radps: yaw.yaw_rate_dps.to_radians(),
                roll_rad: roll_deg.to_radians(),
                roll_rate_radps: yaw.roll_rate_dps.to_radians(),
            }
        };
        let (step_rad, mut cases) = (self.step_rad, Vec::new());
        for (condition, entry) in self.conditions.iter().enumerate() {
            for (point, PlannedPoint { name, slice }) in self.points.iter().enumerate() {
                if entry.points.as_ref().is_some_and(|names| !names.contains(name)) {
                    continue;
                }
                let Some(frozen) = entry.freeze(vehicle, slice) else {
                    continue;
                };
                let unchanged = FrozenPoint::new(vehicle, slice, &slice.settings.gains);
                let has_ftc = unchanged.ftc_gain != 0.0;
                if (entry.needs_ftc && !has_ftc) || (entry.is_a_change() && frozen == unchanged) {
                    continue;
                }
                let pitch = [
                    (Test::Disturbed, entry.pitch),
                    (Test::StepOnly, entry.pitch && entry.overshoot),
                ];
                // Without fin tips nothing controls roll: there is no loop to study.
                let yaw_roll_asked = entry.yaw_roll && has_ftc;
                let offsets = Offset::ALL.into_iter().flat_map(|offset| {
                    let asked = yaw_roll_asked && (offset == Offset::Both || entry.offsets);
                    [
                        (Test::Shared(offset), asked),
                        (Test::Dedicated(offset), asked && entry.dedicated),
                    ]
                });
                let gyro_x_m = entry.gyro.map_or(vehicle.data().bending.gyro_x_m, |(x_m, _)| x_m);
                for (test, _) in pitch.into_iter().chain(offsets).filter(|(_, asked)| *asked) {
                    let mut settings = match test {
                        Test::Disturbed => Settings::pitch(&frozen, &shaken, step_rad),
                        Test::StepOnly => Settings::pitch(&frozen, &Disturbance::NONE, step_rad),
                        Test::Shared(offset) => {
                            Settings::yaw_roll(&frozen, &yaw_roll, initial(offset), false)
                        }
                        Test::Dedicated(offset) => {
                            Settings::yaw_roll(&frozen, &yaw_roll, initial(offset), true)
                        }
                    };
                    if test.control_loop() == ControlLoop::Pitch {
                        settings.plane.higher = of_a_loop(vehicle, &frozen, gyro_x_m, self.modes);
                    }
                    cases.push(Case { point, condition, test, frozen, settings });
                }
            }
        }
        cases.sort_by_key(|case: &Case| case.test.control_loop());
        self.cases = cases;
    }
}

impl Condition {
    /// Its title, or its name where it has none.
    pub fn title(&self) -> &str {
        if self.title.is_empty() { &self.name } else { &self.title }
    }

    fn is_a_change(&self) -> bool {
        !self.changes.is_empty() || self.gains != GainSource::Scheduled || self.gyro.is_some()
    }

    /// The point as this condition leaves it; `None` where it cannot apply.
    pub fn freeze(&self, vehicle: &Vehicle, slice: &SlicePoint) -> Option<FrozenPoint> {
        let gains = self.gains.at(vehicle, slice.time_s)?;
        let mut frozen = FrozenPoint::new(vehicle, slice, &gains);
        if let Some((station_m, _)) = self.gyro {
            frozen.gyro_slope_pm = vehicle.gyro_slope_at_station(station_m)?;
        }
        for change in &self.changes {
            let value = match change.how {
                How::Times(factor) => change.quantity.get(&frozen) * factor,
                How::Set(value) => value,
            };
            change.quantity.set(&mut frozen, value);
        }
        QUANTITIES.iter().all(|q| q.range.contains(q.get(&frozen))).then_some(frozen)
    }
}

impl GainSource {
    /// Gains at a flight time; `None` if there is no such interval.
    pub fn at(self, vehicle: &Vehicle, time_s: f64) -> Option<LoopGains> {
        let designed = vehicle.designed_schedule();
        match self {
            GainSource::Scheduled => Some(designed.at(time_s)),
            GainSource::Reduced => Some(vehicle.reduced_schedule().at(time_s)),
            GainSource::StuckAt(stuck_s) => Some(designed.stuck_at(time_s, stuck_s)),
            GainSource::PreviousInterval => {
                let now = interval(designed, time_s);
                now.checked_sub(1).map(|i| designed.gains()[i])
            }
            GainSource::NextInterval => {
                let now = interval(designed, time_s);
                designed.gains().get(now + 1).copied()
            }
        }
    }
}

/// Index of the interval in force.
fn interval(schedule: &GainSchedule, time_s: f64) -> usize {
    let begun = schedule.switch_time_s().partition_point(|&t| t <= time_s);
    begun.max(1) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::study_file::SHIPPED_TEXT;
    use desk::faults::FileFaults;

    fn plan(text: &str) -> Result<Plan, StudyError> {
        Plan::new(&Study::from_toml("user.toml", text)?, &Vehicle::shipped().unwrap())
    }

    #[test]
    fn events_are_found_on_the_flight() {
        let plan = plan(SHIPPED_TEXT).unwrap();
        let at = |name: &str| {
            let point = plan.points.iter().find(|p| p.name == name).unwrap();
            (point.slice.time_s, &point.slice.airframe)
        };
        for (name, time_s) in [
            ("vertical-rise", 2.0),
            ("pitch-initiation", 4.0),
            ("max-pitch-rate", 7.5),
            ("ftc-switch-in", 17.0),
            ("gain-25", 25.0),
            ("burn-out", 47.0),
        ] {
            assert_eq!(at(name).0, time_s, "{name}");
        }
        // Within one refined interval: 1 ms of flight is 3e-5 of Mach number here.
        let mach = at("transonic").1.mach;
        assert!((1.05..1.0501).contains(&mach), "{mach}");
        // The data set's neighbouring points are at 30 and 35 s.
        assert!((31.0..34.0).contains(&at("max-q").0));
        let peak = at("max-q").1.dynamic_pressure_pa;
        assert!(plan.points.iter().all(|p| p.slice.airframe.dynamic_pressure_pa <= peak));
        let in_tables = |p: &SlicePoint| p.airframe.edges.is_empty() && p.bending.edges.is_empty();
        assert!(plan.points.iter().all(|p| in_tables(&p.slice)));
    }

    #[test]
    fn runs_that_cannot_differ_are_left_out() {
        let plan = plan(SHIPPED_TEXT).unwrap();
        let runs = |condition: &str| -> Vec<&str> {
            let index = plan.conditions.iter().position(|c| c.name == condition).unwrap();
            plan.cases
                .iter()
                .filter(|c| c.condition == index && c.test == Test::Disturbed)
                .map(|c| plan.points[c.point].name.as_str())
                .collect()
        };
        assert_eq!(runs("normal").len(), plan.points.len());
        assert!(!runs("ftc-gain-lost").contains(&"vertical-rise"));
        // Before its first switching the sequencer has nothing to keep; at 17.5 s it is not
        // yet stuck, so that the condition begins at 20 s.
        assert_eq!(runs("gains-not-switched")[0], "gain-10");
        assert_eq!(runs("sequencer-stuck")[0], "gain-20");
        assert!(!runs("gains-early").contains(&"burn-out"));
        // No fin tips, no roll control.
        assert!(plan.of(ControlLoop::YawRoll).all(|c| c.frozen.time_s >= 17.0));
    }

    #[test]
    fn places_that_the_flight_lacks_are_reported_with_their_lines() {
        let text = "[run]\nduration-s = 1.0\nsample-ms = 10\n\
            [pitch]\nstep-deg = 2.0\nmisalignment = 1.0\ngust = 1.0\n\
            [yaw-roll]\nyaw-deg = 1.0\nlarge-yaw-deg = 2.0\nyaw-rate-dps = 0.0\nroll-deg = 1.0\nroll-rate-dps = 0.0\n\
            misalignment = 0.0\ngust = 0.0\ncant = 0.0\n\
            [[point]]\nname = \"a\"\nat = { mach = 9.0 }\n\
            [[point]]\nname = \"b\"\nat = { gain-switch = 8 }\n\
            [[point]]\nname = \"c\"\nat = { time-s = 60.0 }\n";
        let Err(StudyError::File(FileFaults(faults))) = plan(text) else {
            panic!("accepted");
        };
        let lines: Vec<_> = faults.iter().map(|f| f.place.unwrap().0).collect();
        assert_eq!(lines, [19, 22, 25]);
        assert!(faults[0].to_string().contains("does not reach Mach 9"));
        assert!(faults[1].to_string().contains("switches 7 times"));
        assert!(faults[2].to_string().contains("burn-out at 49"));
    }
}
