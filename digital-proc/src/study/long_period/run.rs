//! Flies the modes side by side, each machine on a processor of its own, or one after another on
//! a session that somebody else serves.
//!
//! The stage patch is loaded once; every flight starts from initial conditions
//! (rep-op) and none restarts the partner. All flights have the same frames, so
//! that their peaks compare. A flight that diverges is recorded as lost and the
//! next one starts afresh; a fault of the link or of a file ends the study.

use super::results::{Acceptance, FlightWind, Flown, LongPeriodResults, ModeResult, STRONG};
use crate::{
    flight::{
        AlphaPath, FlightFault, FlightPlan, FrameResult, Stage, Timing, channels::Sampled,
        stage_patch,
    },
    linkage::{
        console::{Console, ConsoleFault},
        executive::Rate,
    },
    study::fault::StudyFault,
};
use interface::{
    Tick,
    control::PatchBundle,
    frame::Samples,
    processor,
    profile::Profile,
    side_by_side::{Jobs, side_by_side},
};
use vehicle::{
    Vehicle,
    flight_mode::{FlightScript, Schedule},
    flight_summary::FlightSample,
    reference::FlightCase,
    wind::{SyntheticWind, Wind},
};

/// Misalignments of the shipped envelope, fractions of 3σ, flown beside the
/// design case's own: both ends, the middle and half-way. The load of a mode with
/// its tips at work is nearly linear between them; that of the injection alone is
/// not, since it settles at one edge of the dead zone or the other.
pub const ENVELOPE: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// What is flown, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct LongPeriodPlan {
    /// The modes.
    pub modes: Vec<FlightScript>,
    /// Misalignments in pitch flown beside the design case's, fractions of 3σ.
    pub envelope: Vec<f64>,
    /// Whether the wind is also reversed, and strong.
    pub reversed: bool,
    /// Trajectory step.
    pub step: Tick,
    /// Fast frames in it.
    pub slow: Rate,
    /// Latency; the profile's, at most one fast frame, if none is given.
    pub latency: Option<Tick>,
    /// How α reaches the rotational equations.
    pub alpha: AlphaPath,
    /// The machine.
    pub profile: Profile,
    /// The stage patch.
    pub patch: PatchBundle,
}

impl LongPeriodPlan {
    /// The shipped study of `modes`: 0.1 s steps of five fast frames, the
    /// envelope [`ENVELOPE`], both winds.
    pub fn new(modes: Vec<FlightScript>, profile: Profile) -> LongPeriodPlan {
        LongPeriodPlan {
            modes,
            envelope: ENVELOPE.to_vec(),
            reversed: true,
            step: Tick(100_000_000),
            slow: Rate::every(5).unwrap_or(Rate::FAST),
            latency: None,
            alpha: AlphaPath::Redundant,
            profile,
            patch: stage_patch(),
        }
    }

    /// Number of flights.
    pub fn flights(&self) -> usize {
        let of_a_mode = 1 + self.envelope.len() + 2 * usize::from(self.reversed);
        1 + self.scripts().count() * of_a_mode
    }

    /// What is flown: the modes, and after them the sound vehicle where none of them is that.
    fn scripts(&self) -> impl Iterator<Item = FlightScript> {
        let without = self.modes.iter().all(|mode| !is_sound(mode));
        self.modes.iter().cloned().chain(without.then(FlightScript::sound))
    }
}

/// Whether nothing fails and the schedule is the designed one.
fn is_sound(script: &FlightScript) -> bool {
    script.actions.is_empty() && script.schedule == Schedule::Designed
}

/// Flies the whole plan; `progress` is told the number of flights done.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    progress: impl FnMut(usize),
) -> Result<LongPeriodResults, StudyFault> {
    let case = &vehicle.data().long_period_case;
    let design = [case.misalign_pitch, case.misalign_yaw];
    let sound = FlightScript::sound();
    let mut flights: Vec<Flight<'_>> = vec![(&sound, FlightWind::Calm, [0.0, 0.0])];
    let scripts: Vec<FlightScript> = plan.scripts().collect();
    for script in &scripts {
        flights.push((script, FlightWind::DesignCase, design));
        let envelope = plan.envelope.iter();
        flights.extend(envelope.map(|&pitch| (script, FlightWind::DesignCase, [pitch, design[1]])));
        if plan.reversed {
            flights.push((script, FlightWind::Reversed, design));
            flights.push((script, FlightWind::Strong, design));
        }
    }
    let mut flown = fly_all(console, vehicle, plan, &flights, progress)?.into_iter();
    let mut next = || flown.next().ok_or(StudyFault::LostFlight);
    let (undisturbed, nominal_history) = next()?;
    let nominal = undisturbed.ended.map_err(StudyFault::NominalLost)?;
    let mut modes = Vec::with_capacity(scripts.len());
    for script in &scripts {
        let (flown, history) = next()?;
        let mut mode = ModeResult::new(script, flown, history);
        for _ in &plan.envelope {
            mode.envelope.push(next()?.0);
        }
        if plan.reversed {
            mode.reversed = Some(next()?.0);
            mode.strong = Some(next()?.0);
        }
        modes.push(mode);
    }
    let sound = scripts.iter().zip(&modes).find(|(script, _)| is_sound(script));
    let sound = sound.map_or_else(Vec::new, |(_, mode)| mode.all_flights().cloned().collect());
    modes.truncate(plan.modes.len());
    let data = vehicle.data();
    Ok(LongPeriodResults {
        accept: Acceptance::new(vehicle),
        nominal,
        nominal_history,
        sound,
        modes,
        designed: data.gains.schedule(),
        reduced: data.gains_reduced.clone(),
        carried_kg: data.tvc.fluid_kg,
    })
}

/// Script, wind and misalignments of a flight.
type Flight<'a> = (&'a FlightScript, FlightWind, [f64; 2]);
/// What it came to, and its history.
type Answer = (Flown, Vec<FlightSample>);

/// Flies side by side where more machines can be started, or else one after another; each has the
/// bits of a flight alone.
fn fly_all(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    flights: &[Flight<'_>],
    mut progress: impl FnMut(usize),
) -> Result<Vec<Answer>, StudyFault> {
    // Here too, so that the console knows the patch.
    let stage = Stage::load_patch(console, vehicle, &plan.profile, plan.patch.clone())?;
    let Some(fellow) = console.fellow() else {
        let mut bench = Bench::new(vehicle, plan, stage)?;
        let mut answers = Vec::with_capacity(flights.len());
        for (script, wind, misalignment) in flights {
            answers.push(bench.fly(console, vehicle, script, *wind, *misalignment)?);
            progress(answers.len());
        }
        return Ok(answers);
    };
    let mut answers: Vec<Option<Answer>> = vec![None; flights.len()];
    let worker = |jobs: Jobs<'_, Result<Answer, StudyFault>>| {
        let _kept = fellow.is_pair().then(|| processor::share(jobs.worker));
        let work = || {
            let mut machine = fellow.start(jobs.given_up())?;
            let mut console = Console::new(&mut machine);
            let patch = plan.patch.clone();
            let stage = Stage::load_patch(&mut console, vehicle, &plan.profile, patch)?;
            let mut bench = Bench::new(vehicle, plan, stage)?;
            while let Some(i) = jobs.next() {
                let (script, wind, misalignment) = flights[i];
                jobs.done(i, bench.fly(&mut console, vehicle, script, wind, misalignment));
            }
            Ok(console.bye()?)
        };
        if let (Err(fault), Some(i)) = (work(), jobs.next()) {
            jobs.done(i, Err(fault));
        }
    };
    let mut done = 0;
    side_by_side(flights.len(), worker, |answer| {
        if let Some((i, answer)) = answer {
            answers[i] = Some(answer?);
            done += 1;
            progress(done);
        }
        Ok::<_, StudyFault>(console.attend()?)
    })?;
    answers.into_iter().collect::<Option<_>>().ok_or(StudyFault::LostFlight)
}

/// The loaded machine and what all flights share.
pub struct Bench<'a> {
    plan: &'a LongPeriodPlan,
    stage: Stage,
    stop: Tick,
    latency: Tick,
    design_wind: Wind,
    reversed_wind: Wind,
    strong_wind: Wind,
}

impl<'a> Bench<'a> {
    /// Of a loaded stage.
    pub fn new(
        vehicle: &Vehicle,
        plan: &'a LongPeriodPlan,
        stage: Stage,
    ) -> Result<Bench<'a>, StudyFault> {
        let data = vehicle.data();
        let burn_time_s = data.mass.burn_time_s;
        let scaled = |factor: f64| {
            let sign = factor * data.long_period_case.wind_sign;
            SyntheticWind::new(&data.wind, sign).map(Wind::Synthetic)
        };
        let fast = plan.slow.fast_period(plan.step).unwrap_or(plan.step);
        Ok(Bench {
            plan,
            stage,
            stop: Tick::from_secs(burn_time_s).ok_or(StudyFault::BurnTime(burn_time_s))?,
            latency: plan
                .latency
                .unwrap_or_else(|| plan.profile.latency_within(Sampled::COUNT, fast).0),
            design_wind: Wind::design_case(vehicle)?,
            reversed_wind: scaled(-1.0)?,
            strong_wind: scaled(STRONG)?,
        })
    }

    /// One flight to burn-out and its history. `vehicle` is the one that was
    /// loaded, or a variant of it with the same wind and burn time.
    ///
    /// # Errors
    /// [`StudyFault`]: the machine; a flight that diverges is lost, not an error.
    pub fn fly(
        &mut self,
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        script: &FlightScript,
        wind: FlightWind,
        misalignment: [f64; 2],
    ) -> Result<(Flown, Vec<FlightSample>), StudyFault> {
        let plan = FlightPlan {
            case: FlightCase {
                script: script.clone(),
                failure_start_s: 0.0,
                wind: match wind {
                    FlightWind::Calm => Wind::Calm,
                    FlightWind::DesignCase => self.design_wind.clone(),
                    FlightWind::Reversed => self.reversed_wind.clone(),
                    FlightWind::Strong => self.strong_wind.clone(),
                },
                pitch_misalignment: misalignment[0],
                yaw_misalignment: misalignment[1],
            },
            step: self.plan.step,
            slow: self.plan.slow,
            latency: self.latency,
            skew: self.plan.profile.skew(),
            stop: self.stop,
            alpha: self.plan.alpha,
            profile: self.plan.profile.clone(),
        };
        let mut history = Vec::new();
        let slow = self.plan.slow;
        let flown = self.stage.fly(
            console,
            vehicle,
            &plan,
            Timing::LockStep,
            &mut |frame: &Samples, result: &FrameResult| {
                if slow.due(frame.frame) {
                    history.push(result.sample);
                }
            },
        );
        let ended = match flown {
            Ok(summary) => Ok(summary),
            Err(
                fault @ (FlightFault::Trajectory(_)
                | FlightFault::Console(ConsoleFault::RunFault { .. })),
            ) => Err(fault.to_string()),
            Err(fault) => return Err(fault.into()),
        };
        let flown = Flown { wind, misalignment, ended };
        Ok((flown, history))
    }
}
