//! The frame cycle: samples, transfers, and the integration between them.
//!
//! At `t_n + i·δ` ADC channel i is tracked and held; after the last, samples n
//! are published. Updates n take effect together at their instant of transfer:
//! in lock-step at `t_n + τ`, to which the array integrates while the digital
//! side computes; free-running when they arrive by the wall clock
//! ([`crate::session::free_run`]); in a replay when they did so then. Where a sample and a
//! transfer fall on one instant, the sample comes first.
//!
//! The array is only ever integrated to such an instant, and the instants are
//! integers, so that they alone determine the result: no schedule of the two
//! processes can change a lock-step run, and a replay repeats a free-running one
//! bit by bit. In HOLD the frames go on and problem time stands still.
//!
//! Where checkpoints are kept, the state is given away once the samples of a frame are taken and
//! before they are told: all updates have taken effect then, and none is on its way. A period that
//! goes on from it begins by telling those samples.
//!
//! With an aperture a > 0 the sample held at t is the mean over [t − a, t], by three-point Gauss
//! quadrature: exact for a signal of fifth degree in the aperture. What precedes the start of the
//! run, or the end of the scan before, counts as standing still.

use crate::session::{
    board::Board,
    channels::{ChannelState, Channels},
    free_run::FreeRun,
};
use bincode::config::standard;
use engine::{
    fault::RunFault,
    mode::Mode,
    simulation::{Pulse, Simulation},
};
use interface::{
    Tick,
    control::{AnalogState, Checkpoints, Clock, RunSpec},
    frame::{ModeCommand, RunState, Samples, Updates},
    link::{FramePort, LinkFault},
};
use serde::{Deserialize, Serialize};
use std::{collections::VecDeque, ops::ControlFlow};

/// Where a period stands once the samples of a frame are taken, which it has not told.
#[derive(Serialize, Deserialize)]
pub struct Stand {
    origin: Tick,
    clock: Tick,
    held: Tick,
    holding: bool,
    samples: Samples,
}

/// All that a period goes on from.
#[derive(Serialize, Deserialize)]
struct PeriodState {
    stand: Stand,
    channels: ChannelState,
    simulation: Vec<u8>,
}

impl Stand {
    /// Takes a state over into the board of the same patch; refused, the board is as it was.
    pub fn read(from: &AnalogState, board: &mut Board) -> Result<Stand, String> {
        let cannot =
            |reason: String| format!("the analog side cannot go on from its state: {reason}");
        let (state, _): (PeriodState, usize) =
            bincode::serde::decode_from_slice(&from.bytes, standard())
                .map_err(|e| cannot(e.to_string()))?;
        if state.stand.samples.frame != from.frame {
            return Err(cannot("it is that of another frame".to_owned()));
        }
        board.simulation.restore(&state.simulation).map_err(|fault| cannot(fault.to_string()))?;
        board.channels.restore(state.channels);
        Ok(state.stand)
    }
}

/// Runs the frames of one OPERATE period; returns what stopped it early, if it was a fault.
/// `time_scale` is the wall time that a unit of problem time takes when free-running.
pub fn run(
    spec: &RunSpec,
    time_scale: f64,
    (checkpoints, mut resumed): (Option<&Checkpoints>, Option<Stand>),
    Board { simulation, channels }: &mut Board,
    port: &mut dyn FramePort,
) -> Result<Option<RunFault>, LinkFault> {
    let origin = simulation.now();
    if resumed.is_none() {
        channels.set_all(simulation);
    }
    let mut cycle = Cycle {
        simulation,
        channels,
        port,
        origin,
        clock: Tick::ZERO,
        held: Tick::ZERO,
        holding: false,
        timing: Timing::LockStep { pending: None },
        checkpoints,
        queue: VecDeque::new(),
        over: None,
        looks: VecDeque::new(),
        means: Vec::new(),
    };
    cycle.settle();
    match spec.clock {
        Clock::LockStep => {}
        Clock::Replay => cycle.timing = Timing::Replay,
        // The wall clock starts when everything is ready.
        Clock::Wall { processor } => {
            cycle.timing = Timing::Wall(FreeRun::start(time_scale, processor));
        }
    }
    let channels_in_scan = cycle.channels.adc_count();
    let first = match &resumed {
        None => 0,
        Some(Stand { origin, clock, held, holding, samples }) => {
            (cycle.origin, cycle.clock) = (*origin, *clock);
            (cycle.held, cycle.holding) = (*held, *holding);
            samples.frame
        }
    };
    cycle.open_aperture(spec, first);
    for frame in first.. {
        let at = start_of(spec, frame);
        if let Some(Stand { samples, .. }) = resumed.take() {
            cycle.tell(spec, samples)?;
            continue;
        }
        let last = at == spec.stop;
        let mut samples = Samples::new(frame, at, RunState::Operate);
        for index in 0..channels_in_scan.max(1) {
            let instant = if last { at } else { at + spec.skew * index as i64 };
            cycle.gather(instant)?;
            cycle.transfer_before(instant);
            cycle.advance(instant);
            if index < channels_in_scan {
                cycle.hold(index, &mut samples);
            }
        }
        if last && cycle.over.is_none() {
            cycle.over = Some(Over::Ended);
        }
        if let Some(over) = cycle.over.take() {
            return cycle.finish(samples, over);
        }
        cycle.stamp(&mut samples);
        // A transfer at the very instant of the last sample comes after it: the
        // sample is taken, and told once the updates before it have come.
        let just_after = cycle.clock + Tick(1);
        cycle.await_due(just_after)?;
        cycle.transfer_before(just_after);
        if let Some(over) = cycle.over.take() {
            return cycle.finish(samples, over);
        }
        if cycle.keeps(frame) {
            let state =
                cycle.state(samples).map_err(|detail| LinkFault::Protocol { frame, detail })?;
            cycle.port.give_state(frame, state)?;
        }
        cycle.tell(spec, samples)?;
    }
    unreachable!("frames are counted in u64")
}

/// `t_n`, or the stop if that comes first. Overflow would take 292 years of problem time: such a
/// frame lies beyond any stop.
fn start_of(spec: &RunSpec, frame: u64) -> Tick {
    spec.frame.checked_mul(frame).map_or(spec.stop, |t| t.min(spec.stop))
}

/// Three-point Gauss–Legendre on [0, 1]: distance from the end (½ ± √0.15 and ½) and weight.
const GAUSS: [(f64, f64); 3] = [
    (0.887_298_334_620_741_7, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.112_701_665_379_258_3, 5.0 / 18.0),
];

/// A look at a channel within the aperture of its next sample.
struct Look {
    at: Tick,
    index: usize,
    weight: f64,
}

/// Why no further frame follows.
enum Over {
    Ended,
    Faulted(RunFault),
    /// While it integrated, the digital side went or this process was interrupted.
    Alone(LinkFault),
}

/// Who says when updates take effect.
enum Timing {
    /// The frame: at `t_n + τ`. Frame whose updates are still to be taken, and that instant.
    LockStep { pending: Option<(u64, Tick)> },
    /// The updates themselves.
    Replay,
    /// The wall clock.
    Wall(FreeRun),
}

/// Updates that have come, and when they take effect.
struct Due {
    at: Tick,
    updates: Updates,
}

struct Cycle<'a> {
    simulation: &'a mut Simulation,
    channels: &'a mut Channels,
    port: &'a mut dyn FramePort,
    /// Problem time of the array when this period started.
    origin: Tick,
    /// Run time reached, counted from the start of this period, HOLD included.
    clock: Tick,
    /// Time spent in HOLD so far.
    held: Tick,
    holding: bool,
    timing: Timing,
    checkpoints: Option<&'a Checkpoints>,
    /// Updates that have not taken effect yet, in order of time.
    queue: VecDeque<Due>,
    over: Option<Over>,
    /// Looks still to be taken for the coming samples, in order of time; none without an aperture.
    looks: VecDeque<Look>,
    /// Means of the coming samples so far, by place in the scan.
    means: Vec<f64>,
}

impl Cycle<'_> {
    /// Integrates to run time `to`, stopping where an aperture looks and where an interpolating
    /// hold arrives; a look comes first.
    fn advance(&mut self, to: Tick) {
        while self.over.is_none() {
            let look = self.looks.front().map(|l| l.at).filter(|at| *at <= to);
            let arrival = self.channels.next_arrival(self.clock).filter(|at| *at <= to);
            match (look, arrival) {
                (Some(at), arrival) if arrival.is_none_or(|a| at <= a) => {
                    self.integrate(at);
                    if let Some(Look { index, weight, .. }) = self.looks.pop_front() {
                        self.means[index] += weight * self.channels.seen(index, self.simulation);
                    }
                }
                (_, Some(at)) => {
                    self.integrate(at);
                    self.channels.arrive(at, self.simulation);
                    self.settle();
                }
                _ => break,
            }
        }
        self.integrate(to);
    }

    /// Plans the looks for the samples of `frame`.
    fn open_aperture(&mut self, spec: &RunSpec, frame: u64) {
        let aperture = self.channels.aperture();
        if aperture <= Tick::ZERO {
            return;
        }
        let at = start_of(spec, frame);
        let skew = if at == spec.stop { Tick::ZERO } else { spec.skew };
        let scan = self.channels.adc_count();
        self.means.clear();
        self.means.resize(scan, 0.0);
        let mut looks: Vec<Look> = (0..scan)
            .flat_map(|index| {
                let held = at + skew * index as i64;
                GAUSS.map(|(before, weight)| Look {
                    at: held - Tick((before * aperture.0 as f64).round() as i64),
                    index,
                    weight,
                })
            })
            .collect();
        for look in &mut looks {
            look.at = look.at.max(self.clock);
        }
        looks.sort_by_key(|l| l.at);
        self.looks = looks.into();
    }

    /// Holds the `index`-th channel now and converts it.
    fn hold(&mut self, index: usize, samples: &mut Samples) {
        let held = if self.channels.aperture() > Tick::ZERO && self.over.is_none() {
            self.means[index]
        } else {
            self.channels.seen(index, self.simulation)
        };
        self.channels.sample(index, held, samples);
    }

    /// Lets what was set take effect.
    fn settle(&mut self) {
        if self.over.is_none()
            && let Err(fault) = self.simulation.apply()
        {
            self.over = Some(Over::Faulted(fault));
        }
    }

    /// Integrates to run time `to`; in HOLD only the clock moves.
    fn integrate(&mut self, to: Tick) {
        if self.over.is_some() || to <= self.clock {
            return;
        }
        if self.holding {
            self.held = self.held + (to - self.clock);
            self.clock = to;
            return;
        }
        let mut alone = None;
        let port = &mut *self.port;
        let mut attend = |_: &Pulse| match port.attend() {
            Ok(()) => ControlFlow::Continue(()),
            Err(fault) => {
                alone = Some(fault);
                ControlFlow::Break(())
            }
        };
        let stop = self.origin + to - self.held;
        let advance = self.simulation.advance_attended(stop, &mut attend);
        if let Some(fault) = alone {
            self.over = Some(Over::Alone(fault));
            return;
        }
        match advance {
            Ok(advance) if advance.stopped_by.is_none() => {}
            Ok(advance) if self.simulation.mode() == Mode::Hold => {
                // The overload policy: problem time stands where the overload was located.
                self.holding = true;
                self.held = self.held + (stop - advance.reached);
            }
            Ok(_) => self.over = Some(Over::Ended),
            Err(fault) => self.over = Some(Over::Faulted(fault)),
        }
        self.clock = to;
    }

    /// Takes in the updates that take effect before the next sample, at `instant`.
    fn gather(&mut self, instant: Tick) -> Result<(), LinkFault> {
        self.await_due(instant)?;
        let Timing::Wall(free) = &mut self.timing else {
            return Ok(());
        };
        while let Some((at, updates)) = free.next_updates(self.port, instant)? {
            self.queue.push_back(Due { at: at.max(self.clock), updates });
        }
        Ok(())
    }

    /// In lock-step: waits for the pending updates, if they are due before `instant`.
    fn await_due(&mut self, instant: Tick) -> Result<(), LinkFault> {
        let Timing::LockStep { pending } = &mut self.timing else {
            return Ok(());
        };
        let Some((frame, due)) = pending.take_if(|(_, due)| *due < instant) else {
            return Ok(());
        };
        self.advance(due);
        let updates = self.port.await_updates(frame)?;
        self.enqueue(due, updates);
        Ok(())
    }

    /// Puts updates into the queue, never before what was integrated or queued already.
    fn enqueue(&mut self, at: Tick, updates: Updates) {
        let earliest = self.queue.back().map_or(self.clock, |last| last.at);
        self.queue.push_back(Due { at: at.max(earliest), updates });
    }

    /// Lets the queued updates that are due before `instant` take effect, each at its own.
    fn transfer_before(&mut self, instant: Tick) {
        while self.queue.front().is_some_and(|due| due.at < instant)
            && let Some(due) = self.queue.pop_front()
        {
            self.advance(due.at);
            if self.over.is_some() {
                return;
            }
            self.channels.transfer(&due.updates, due.at, self.simulation);
            self.settle();
            if self.over.is_some() {
                return;
            }
            match due.updates.mode_command() {
                ModeCommand::Continue => {}
                ModeCommand::Hold => self.holding = true,
                ModeCommand::Operate => self.holding = false,
                ModeCommand::End => self.over = Some(Over::Ended),
            }
        }
    }

    /// Whether a checkpoint is due before the samples of `frame`.
    fn keeps(&self, frame: u64) -> bool {
        self.checkpoints.is_some_and(|checkpoints| checkpoints.due(frame))
    }

    /// All that the period goes on from, before `samples` are told.
    fn state(&self, samples: Samples) -> Result<Vec<u8>, String> {
        let Cycle { origin, clock, held, holding, .. } = *self;
        let state = PeriodState {
            stand: Stand { origin, clock, held, holding, samples },
            channels: self.channels.state(),
            simulation: self.simulation.snapshot().map_err(|fault| fault.to_string())?,
        };
        bincode::serde::encode_to_vec(state, standard()).map_err(|e| e.to_string())
    }

    /// Tells the samples of a frame, and goes on to where its updates are due.
    fn tell(&mut self, spec: &RunSpec, samples: Samples) -> Result<(), LinkFault> {
        let (frame, due) = (samples.frame, samples.tick + spec.latency);
        self.publish(samples)?;
        self.open_aperture(spec, frame + 1);
        match &mut self.timing {
            Timing::LockStep { pending } => {
                *pending = Some((frame, due));
                // Look-ahead: the array integrates while the digital side computes.
                self.advance(due.min(spec.stop));
            }
            Timing::Replay => {
                let updates = self.port.await_updates(frame)?;
                self.enqueue(updates.effective, updates);
            }
            Timing::Wall(_) => {}
        }
        Ok(())
    }

    /// Sends samples; on the wall clock not before their instant, and with their lateness.
    fn publish(&mut self, mut samples: Samples) -> Result<(), LinkFault> {
        if let Timing::Wall(free) = &mut self.timing {
            while let Some(updates) = free.await_instant(self.port, self.clock)? {
                self.queue.push_back(Due { at: self.clock, updates });
            }
            samples.late = free.published(samples.frame, self.clock);
        }
        self.port.send_samples(&samples)
    }

    /// Fills in what is read at the end of a scan: logic, edges, overloads, state.
    fn stamp(&mut self, samples: &mut Samples) {
        if self.holding {
            samples.state = RunState::Hold as u32;
        }
        let shift = self.held - self.origin;
        self.channels.stamp(self.simulation, shift, samples);
    }

    /// Tells the digital side that the run is over.
    fn finish(mut self, mut samples: Samples, over: Over) -> Result<Option<RunFault>, LinkFault> {
        let (state, fault) = match over {
            Over::Ended => (RunState::Ended, None),
            Over::Faulted(fault) => (RunState::Faulted, Some(fault)),
            Over::Alone(fault) => return Err(fault),
        };
        if let Timing::LockStep { pending } = &mut self.timing
            && let Some((frame, _)) = pending.take()
        {
            self.port.await_updates(frame)?;
        }
        self.stamp(&mut samples);
        samples.tick = self.clock;
        samples.state = state as u32;
        if self.keeps(samples.frame) {
            // Nothing to go on from: the period ends here.
            self.port.give_state(samples.frame, Vec::new())?;
        }
        self.publish(samples)?;
        Ok(fault)
    }
}
