//! Flies the modes one after another on one session.
//!
//! The stage patch is loaded once; every flight starts from initial conditions
//! (rep-op) and none restarts the partner. All flights have the same frames, so
//! that their peaks compare. A flight that diverges is recorded as lost and the
//! next one starts afresh; a fault of the link or of a file ends the study.

use super::results::{Acceptance, FlightWind, Flown, LongPeriodResults, ModeResult};
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
use interface::{Tick, control::PatchBundle, frame::Samples, profile::Profile};
use vehicle::{
    Vehicle,
    flight_mode::FlightScript,
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
    /// Whether the wind is also reversed.
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
        1 + self.modes.len() * (1 + self.envelope.len() + usize::from(self.reversed))
    }
}

/// Flies the whole plan; `progress` is told the number of flights done.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    plan: &LongPeriodPlan,
    mut progress: impl FnMut(usize),
) -> Result<LongPeriodResults, StudyFault> {
    let stage = Stage::load_patch(console, vehicle, &plan.profile, plan.patch.clone())?;
    let mut bench = Bench::new(vehicle, plan, stage)?;
    let mut done = 0;
    let mut fly = |script: &FlightScript, wind: FlightWind, misalignment: [f64; 2]| {
        let flown = bench.fly(console, vehicle, script, wind, misalignment);
        done += 1;
        progress(done);
        flown
    };

    let case = &vehicle.data().long_period_case;
    let design = [case.misalign_pitch, case.misalign_yaw];
    let (undisturbed, nominal_history) = fly(&FlightScript::sound(), FlightWind::Calm, [0.0, 0.0])?;
    let nominal = undisturbed.ended.map_err(StudyFault::NominalLost)?;
    let mut modes = Vec::with_capacity(plan.modes.len());
    for script in &plan.modes {
        let (flown, history) = fly(script, FlightWind::DesignCase, design)?;
        let mut mode = ModeResult::new(script, flown, history, &nominal);
        for &pitch in &plan.envelope {
            let (flown, _) = fly(script, FlightWind::DesignCase, [pitch, design[1]])?;
            mode.envelope.push(flown);
        }
        if plan.reversed {
            mode.reversed = Some(fly(script, FlightWind::Reversed, design)?.0);
        }
        modes.push(mode);
    }
    let data = vehicle.data();
    Ok(LongPeriodResults {
        accept: Acceptance::new(vehicle),
        nominal,
        nominal_history,
        modes,
        designed: data.gains.schedule(),
        reduced: data.gains_reduced.clone(),
        carried_kg: data.tvc.fluid_kg,
    })
}

/// The loaded machine and what all flights share.
pub struct Bench<'a> {
    plan: &'a LongPeriodPlan,
    stage: Stage,
    stop: Tick,
    latency: Tick,
    design_wind: Wind,
    reversed_wind: Wind,
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
        let fast = plan.slow.fast_period(plan.step).unwrap_or(plan.step);
        Ok(Bench {
            plan,
            stage,
            stop: Tick::from_secs(burn_time_s).ok_or(StudyFault::BurnTime(burn_time_s))?,
            latency: plan
                .latency
                .unwrap_or_else(|| plan.profile.latency_within(Sampled::COUNT, fast).0),
            design_wind: Wind::design_case(vehicle)?,
            reversed_wind: Wind::Synthetic(SyntheticWind::new(
                &data.wind,
                -data.long_period_case.wind_sign,
            )?),
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
