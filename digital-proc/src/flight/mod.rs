//! The long-period flight on the hybrid machine.
//!
//! Loads the stage's control system on the analog side, flies the trajectory on
//! this one, and tells an observer of every frame. It writes no files.

pub(crate) mod channels;
mod law;
mod options;
pub(crate) mod pacing;
pub(crate) mod plan_record;
mod timing;
pub(crate) mod trace;

pub use channels::AttitudeSample;
pub use law::FrameResult;
pub(crate) use options::replace_block;
pub use options::{AxesName, FunctionGeneration, Options};
pub use timing::{Timing, TransferLog};

use crate::{
    linkage::{
        console::{Console, ConsoleFault},
        executive::Rate,
    },
    study::bending_moment::flight::Found,
};
use channels::StageChannels;
use desk::run_dir::RunDirError;
use interface::{
    Tick,
    control::{AnalogState, Checkpoints, Clock, PatchBundle, RunSpec},
    frame::{ModeCommand, Samples, Updates},
    link::Law,
    processor::Kept,
    profile::Profile,
};
use law::{FlightLaw, LawState};
use serde::{Deserialize, Serialize};
use vehicle::{
    Vehicle,
    flight_summary::{FlightMonitor, FlightSummary},
    reference::FlightCase,
    trajectory::FlightError,
};

/// How the angle of attack reaches the rotational equations.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub enum AlphaPath {
    /// Redundant analog integrator, corrected at the trajectory's rate
    Redundant,
    /// From the flight-path angle held over a trajectory step
    Held,
}

/// How a flight is run.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightPlan {
    /// What is flown.
    pub case: FlightCase,
    /// Trajectory step (the slow frame).
    pub step: Tick,
    /// Fast frames in one step.
    pub slow: Rate,
    /// Total latency τ, at most one fast frame.
    pub latency: Tick,
    /// Multiplexer skew δ between ADC channels.
    pub skew: Tick,
    /// Where the flight ends.
    pub stop: Tick,
    /// How α reaches the rotational equations.
    pub alpha: AlphaPath,
    /// What else is shared out in another way than shipped.
    pub options: Options,
    /// The machine.
    pub profile: Profile,
}

/// Why a flight could not be flown to its end.
#[derive(Debug, thiserror::Error)]
pub enum FlightFault {
    /// The machine or its link.
    #[error(transparent)]
    Console(#[from] ConsoleFault),
    /// The trajectory.
    #[error("the trajectory cannot be continued: {0}")]
    Trajectory(#[from] FlightError),
    /// The plan's periods.
    #[error(
        "the trajectory step {step} is no multiple of {fast_frames} whole nanoseconds; choose another --frame or --fast"
    )]
    Periods {
        /// Trajectory step.
        step: Tick,
        /// Fast frames in it.
        fast_frames: u64,
    },
    /// The observer could not write its trace.
    #[error(transparent)]
    Trace(#[from] RunDirError),
    /// Nothing was flown.
    #[error("the flight had no frame")]
    NoFrame,
}

/// A flight's state before the samples of a frame, both sides of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FlightState {
    analog: AnalogState,
    law: LawState,
    monitor: FlightMonitor,
    /// The bending moments up to there, where they are looked at.
    pub moments: Option<Found>,
}

/// How a flight keeps its state, and what it goes on from.
#[derive(Clone, Debug, Default)]
pub struct Keeping {
    /// Fast frames from one checkpoint to the next; none are kept without.
    pub every: Option<u64>,
    /// Where it goes on, in place of lift-off.
    pub from: Option<FlightState>,
}

/// The stage patch and its sub-patches, as shipped.
pub fn stage_patch() -> PatchBundle {
    let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    PatchBundle {
        root: "long-period.toml".to_owned(),
        files: vec![
            file("long-period.toml", include_str!("../../../patch-files/long-period.toml")),
            file("stage-gyro.toml", include_str!("../../../patch-files/stage-gyro.toml")),
            file("fin-tip.toml", include_str!("../../../patch-files/fin-tip.toml")),
        ],
    }
}

/// The vehicle's numbers that the stage patch takes as parameters.
fn parameters(vehicle: &Vehicle) -> Vec<(String, f64)> {
    let data = vehicle.data();
    [
        ("delta_max", data.ftc.delta_max_deg.to_radians()),
        ("rate_max", data.ftc.rate_max_dps.to_radians()),
        ("inv_tau_f", 1.0 / data.ftc.time_constant_s),
        ("tau_t", data.tvc.time_constant_s),
        ("force_max", data.tvc.force_max_n),
        ("wn", data.gyro.natural_frequency_radps),
        ("zeta", data.gyro.damping_ratio),
        ("filter_tau", 1.0 / data.bending.filter_corner_radps),
        ("theta_0", data.pitch_programme.theta0_deg.to_radians()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

/// The stage patch on the machine, with a vehicle's numbers set: many flights
/// follow one another on it without a restart (rep-op).
pub struct Stage {
    channels: StageChannels,
    parameters: Vec<(String, f64)>,
}

impl Stage {
    /// Loads the shipped stage patch.
    pub fn load(
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        profile: &Profile,
    ) -> Result<Stage, FlightFault> {
        Stage::load_patch(console, vehicle, profile, stage_patch())
    }

    /// Loads a stage patch of the caller's, with the channels of the shipped one.
    pub fn load_patch(
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        profile: &Profile,
        patch: PatchBundle,
    ) -> Result<Stage, FlightFault> {
        let parameters = parameters(vehicle);
        console.load(patch, parameters.clone(), profile.clone())?;
        Ok(Stage { channels: StageChannels::resolve(console)?, parameters })
    }

    /// Flies `plan` (its profile was settled at loading) from initial conditions. Where `vehicle`
    /// differs from the one loaded in what the patch takes as parameters, they are set first.
    pub fn fly(
        &mut self,
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        plan: &FlightPlan,
        timing: Timing<'_>,
        observer: &mut impl Observer,
    ) -> Result<FlightSummary, FlightFault> {
        self.fly_kept(console, vehicle, plan, (timing, Keeping::default()), observer)
    }

    /// As [`Stage::fly`], with checkpoints given to the observer, or from one.
    pub fn fly_kept(
        &mut self,
        console: &mut Console<'_>,
        vehicle: &Vehicle,
        plan: &FlightPlan,
        (timing, keeping): (Timing<'_>, Keeping),
        observer: &mut impl Observer,
    ) -> Result<FlightSummary, FlightFault> {
        let parameters = parameters(vehicle);
        if parameters != self.parameters {
            console.set_params(parameters.clone())?;
            self.parameters = parameters;
        }
        let frame = plan.slow.fast_period(plan.step).ok_or(FlightFault::Periods {
            step: plan.step,
            fast_frames: plan.slow.fast_frames(),
        })?;
        let channels = self.channels.clone();
        let options = (plan.options, plan.options.channels(console)?);
        let ways = (plan.alpha, options);
        let mut law = FlightLaw::new(vehicle, &plan.case, channels, ways, (plan.slow, plan.step));
        let mut monitor = FlightMonitor::new(vehicle);
        let from_ic = keeping.from.is_none();
        let from = match keeping.from {
            None => {
                let incidence = law.initial_incidence_rad();
                let roll_rad = plan.case.roll_drift.initial_rad;
                let mut ics = vec![("alpha_int", incidence), ("phi", roll_rad)];
                if plan.options.beta == AlphaPath::Redundant {
                    ics.push(("alpha_y", law.initial_yaw_incidence_rad()));
                }
                let ics = ics.into_iter().map(|(name, value)| (name.to_owned(), value));
                console.set_ics(ics.collect())?;
                preset(console, law.clone(), incidence, vehicle)?;
                None
            }
            Some(state) => {
                law.resume(state.law);
                monitor = state.monitor;
                Some(state.analog)
            }
        };
        let checkpoints = keeping.every.map(|every| Checkpoints { every, from });

        let spec = RunSpec {
            frame,
            latency: plan.latency,
            skew: plan.skew,
            stop: plan.stop,
            from_ic,
            clock: timing.clock(),
        };
        let _kept = match spec.clock {
            Clock::Wall { processor } => processor.and_then(Kept::on),
            Clock::LockStep | Clock::Replay => None,
        };
        let mut flying = Flying { law, timing, monitor, observer, result: None, lost: None };
        console.run_kept(&spec, checkpoints.as_ref(), &mut flying)?;
        match flying.lost {
            Some(fault) => Err(fault),
            None => flying.monitor.finish().ok_or(FlightFault::NoFrame),
        }
    }
}

/// Who looks on at a flight, frame by frame; a closure hears of every frame flown.
pub trait Observer {
    /// Adds to updates n, or changes them, after the flight's own tasks.
    fn task(&mut self, _samples: &Samples, _result: &FrameResult, _updates: &mut Updates) {}

    /// Every frame that came, also those in which the flight was lost already.
    fn told(&mut self, _samples: &Samples) -> Result<(), RunDirError> {
        Ok(())
    }

    /// The flight's state, at a checkpoint.
    fn keep(&mut self, _state: FlightState) -> Result<(), RunDirError> {
        Ok(())
    }

    /// A frame flown.
    fn flown(&mut self, samples: &Samples, result: &FrameResult) -> Result<(), RunDirError>;
}

impl<F: FnMut(&Samples, &FrameResult)> Observer for F {
    fn flown(&mut self, samples: &Samples, result: &FrameResult) -> Result<(), RunDirError> {
        self(samples, result);
        Ok(())
    }
}

/// A flight under way.
struct Flying<'a, O> {
    law: FlightLaw<'a>,
    timing: Timing<'a>,
    monitor: FlightMonitor,
    observer: &'a mut O,
    result: Option<FrameResult>,
    lost: Option<FlightFault>,
}

impl<O: Observer> Law for Flying<'_, O> {
    fn frame(&mut self, samples: &Samples, updates: &mut Updates) {
        if let Some(effective) = self.timing.effective(samples.frame) {
            updates.effective = effective;
        }
        if self.lost.is_none() {
            match self.law.frame(samples, updates) {
                Ok(result) => {
                    self.observer.task(samples, &result, updates);
                    self.result = Some(result);
                    return;
                }
                Err(fault) => self.lost = Some(fault),
            }
        }
        updates.mode = ModeCommand::End as u32;
        updates.effective = samples.tick;
    }

    fn after(&mut self, samples: &Samples) {
        let result = self.result.take();
        let kept = self.observer.told(samples).and_then(|()| match result {
            Some(result) => {
                self.monitor.observe(&result.sample, result.edges);
                self.observer.flown(samples, &result)
            }
            None => Ok(()),
        });
        if let Err(fault) = kept {
            self.lost.get_or_insert(fault.into());
        }
    }

    fn checkpoint(&mut self, frame: u64, analog: Vec<u8>) {
        if self.lost.is_some() {
            return;
        }
        let analog = AnalogState { frame, bytes: analog };
        let (law, monitor) = (self.law.kept(), self.monitor.clone());
        if let Err(fault) = self.observer.keep(FlightState { analog, law, monitor, moments: None })
        {
            self.lost = Some(fault.into());
        }
    }
}

/// Sets before OPERATE what the first updates will set again, so that with a
/// latency the first instants do not run on zero coefficients.
fn preset(
    console: &mut Console<'_>,
    mut law: FlightLaw<'_>,
    incidence_rad: f64,
    vehicle: &Vehicle,
) -> Result<(), FlightFault> {
    let mut samples = Samples::new(0, Tick::ZERO, interface::frame::RunState::Operate);
    let adc = law.channels().adc.clone();
    samples.adc[adc.adc_theta] = vehicle.data().pitch_programme.theta0_deg.to_radians();
    samples.adc[adc.adc_alpha] = incidence_rad;
    let mut updates = Updates::new(0, Tick::ZERO);
    law.frame(&samples, &mut updates)?;
    Ok(console.preset(&updates)?)
}
