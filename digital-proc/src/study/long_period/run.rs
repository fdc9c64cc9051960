//! Flies the modes side by side, each machine on a processor of its own, or one after another on
//! a session that somebody else serves.
//!
//! The stage patch is loaded once; every flight starts from initial conditions
//! (rep-op) and none restarts the partner. All flights have the same frames, so
//! that their peaks compare. A flight that diverges is recorded as lost and the
//! next one starts afresh; a fault of the link or of a file ends the study.

use super::results::{Acceptance, FlightWind, Flown, LongPeriodResults, ModeResult};
use crate::{
    flight::{
        AlphaPath, FlightFault, FlightPlan, FrameResult, Options, Stage, Timing, channels::Sampled,
        stage_patch,
    },
    linkage::{
        console::{Console, ConsoleFault},
        executive::Rate,
    },
    study::{
        bending_moment::{BendingMoments, flight::FlightMoments},
        fault::StudyFault,
    },
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
    flight_summary::{FlightSample, FlightSummary},
    reference::{FlightCase, RollDrift},
    structure::{Structure, StructureError},
    wind::Wind,
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
    let mut flights = vec![(FlightScript::sound(), FlightWind::Calm, [0.0, 0.0])];
    let scripts: Vec<FlightScript> = plan.scripts().collect();
    for script in &scripts {
        let mut add = |wind, misalignment| flights.push((script.clone(), wind, misalignment));
        add(FlightWind::DesignCase, design);
        for &pitch in &plan.envelope {
            add(FlightWind::DesignCase, [pitch, design[1]]);
        }
        if plan.reversed {
            add(FlightWind::Reversed, design);
            add(FlightWind::Strong, design);
        }
    }
    let case = |(script, wind, misalignment): &(FlightScript, FlightWind, [f64; 2])| {
        Ok(FlightCase {
            script: script.clone(),
            failure_start_s: 0.0,
            wind: wind.of(vehicle)?,
            pitch_misalignment: misalignment[0],
            yaw_misalignment: misalignment[1],
            roll_drift: RollDrift::NONE,
        })
    };
    let cases = flights.iter().map(case).collect::<Result<Vec<_>, StudyFault>>()?;
    let answers = fly_all(console, vehicle, plan, (&cases, true), progress)?;
    let mut flown = flights.into_iter().zip(answers).map(|(flight, answer)| {
        let ((_, wind, misalignment), Answer { ended, history, moments }) = (flight, answer);
        (Flown { wind, misalignment, ended, moments }, history)
    });
    let mut next = || flown.next().ok_or(StudyFault::LostFlight);
    let (undisturbed, nominal_history) = next()?;
    let nominal = undisturbed.ended.clone().map_err(StudyFault::NominalLost)?;
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
        undisturbed,
        nominal,
        nominal_history,
        sound,
        modes,
        designed: data.gains.schedule(),
        reduced: data.gains_reduced.clone(),
        range_safety: data.range_safety.clone(),
    })
}

/// One flight.
#[derive(Clone, Debug)]
pub struct Answer {
    /// What it came to, or why it was lost.
    pub ended: Result<FlightSummary, String>,
    /// Its samples, one a trajectory step, where they are kept.
    pub history: Vec<FlightSample>,
    /// Its bending moments, of a flight that is kept and shown.
    pub moments: Option<Result<BendingMoments<2>, StructureError>>,
}

/// Whether a flight's bending moments are shown: the undisturbed ones and the design cases.
fn is_shown(vehicle: &Vehicle, case: &FlightCase) -> Result<bool, StudyFault> {
    let design = FlightCase::design(vehicle, &case.script)?;
    Ok(case.wind == Wind::Calm || *case == design)
}

/// Flies side by side where more machines can be started, or else one after another; each has the
/// bits of a flight alone. Histories are kept if `history` is set.
pub fn fly_all(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    (cases, history): (&[FlightCase], bool),
    mut progress: impl FnMut(usize),
) -> Result<Vec<Answer>, StudyFault> {
    // Here too, so that the console knows the patch.
    let stage = Stage::load_patch(console, vehicle, &plan.profile, plan.patch.clone())?;
    let Some(fellow) = console.fellow() else {
        let mut bench = Bench::new(vehicle, plan, stage)?;
        let mut answers = Vec::with_capacity(cases.len());
        for case in cases {
            answers.push(bench.fly(console, vehicle, case, history)?);
            progress(answers.len());
        }
        return Ok(answers);
    };
    let mut answers: Vec<Option<Answer>> = vec![None; cases.len()];
    let worker = |jobs: Jobs<'_, Result<Answer, StudyFault>>| {
        let _kept = fellow.is_pair().then(|| processor::share(jobs.worker));
        let work = || {
            let mut machine = fellow.start(jobs.given_up())?;
            let mut console = Console::new(&mut machine);
            let patch = plan.patch.clone();
            let stage = Stage::load_patch(&mut console, vehicle, &plan.profile, patch)?;
            let mut bench = Bench::new(vehicle, plan, stage)?;
            while let Some(i) = jobs.next() {
                jobs.done(i, bench.fly(&mut console, vehicle, &cases[i], history));
            }
            Ok(console.bye()?)
        };
        if let (Err(fault), Some(i)) = (work(), jobs.next()) {
            jobs.done(i, Err(fault));
        }
    };
    let mut done = 0;
    side_by_side(cases.len(), worker, |answer| {
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
}

impl<'a> Bench<'a> {
    /// Of a loaded stage.
    pub fn new(
        vehicle: &Vehicle,
        plan: &'a LongPeriodPlan,
        stage: Stage,
    ) -> Result<Bench<'a>, StudyFault> {
        let burn_time_s = vehicle.data().mass.burn_time_s;
        let fast = plan.slow.fast_period(plan.step).unwrap_or(plan.step);
        Ok(Bench {
            plan,
            stage,
            stop: Tick::from_secs(burn_time_s).ok_or(StudyFault::BurnTime(burn_time_s))?,
            latency: plan
                .latency
                .unwrap_or_else(|| plan.profile.latency_within(Sampled::COUNT, fast).0),
        })
    }

    /// One flight to burn-out, and its history if that is wanted. `vehicle` is the one that was
    /// loaded, or a variant of it with the same burn time.
    ///
    /// # Errors
    /// [`StudyFault`]: the machine; a flight that diverges is lost, not an error.
    pub fn fly(
        &mut self,
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        case: &FlightCase,
        keep: bool,
    ) -> Result<Answer, StudyFault> {
        let plan = FlightPlan {
            case: case.clone(),
            step: self.plan.step,
            slow: self.plan.slow,
            latency: self.latency,
            skew: self.plan.profile.skew(),
            stop: self.stop,
            alpha: self.plan.alpha,
            options: Options::NONE,
            profile: self.plan.profile.clone(),
        };
        let shown = keep && is_shown(vehicle, case)?;
        let structure = shown.then(|| Structure::new(vehicle));
        let misalignment = [case.pitch_misalignment, case.yaw_misalignment];
        let mut moments = structure.as_ref().map(|s| FlightMoments::new(s, misalignment));
        let mut history = Vec::new();
        let slow = self.plan.slow;
        let flown = self.stage.fly(
            console,
            vehicle,
            &plan,
            Timing::LockStep,
            &mut |frame: &Samples, result: &FrameResult| {
                if keep && slow.due(frame.frame) {
                    history.push(result.sample);
                }
                if let Some(moments) = &mut moments {
                    moments.observe(result);
                }
            },
        );
        let moments = moments.map(FlightMoments::finish);
        let ended = match flown {
            Ok(summary) => Ok(summary),
            Err(
                fault @ (FlightFault::Trajectory(_)
                | FlightFault::Console(ConsoleFault::RunFault { .. })),
            ) => Err(fault.to_string()),
            Err(fault) => return Err(fault.into()),
        };
        Ok(Answer { ended, history, moments })
    }
}
