//! A machine in operation: state, time, stops and read-back.
//!
//! Problem time is kept in seconds within a run, but every stop lands exactly on
//! [`Tick::secs`]. What the digital side sets takes effect together at
//! [`Simulation::apply`]. Recording reads the dense output and never alters a
//! step. The engine that steps is in [`crate::operate`]. It is long, but one concept:
//! a thin driver whose methods all guard the same few fields (mode, what is not yet
//! applied, what ended the run), and most of it says what each promises.

use interface::Tick;
use std::ops::ControlFlow;

use crate::element::dac::DacPiece;
use crate::element::logic::Edge;
use crate::fault::RunFault;
use crate::machine::Machine;
use crate::mode::Mode;
pub use crate::operate::{Attendant, Pulse, Sink, SnapshotFault};
use crate::operate::{Engine, Heed, Recorder};
use crate::outlook;
use crate::overload::LatchedOverload;
use crate::remark::Remark;
pub use crate::statistics::Statistics;
use crate::{
    id::{BlockId, NetId},
    integration::{Integration, Method, OverloadPolicy},
};

/// Later than any stop.
const NEVER: Tick = Tick(i64::MAX);

/// How far a call came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// The stop asked for, or the tick nearest to where the run stopped.
    pub reached: Tick,
    /// The overload that stopped it, by the patch's policy.
    pub stopped_by: Option<LatchedOverload>,
}

/// A machine with its state; a clone goes on by itself.
#[derive(Clone, Debug)]
pub struct Simulation {
    engine: Engine,
    mode: Mode,
    dirty: bool,
    ended: Option<LatchedOverload>,
    fault: Option<RunFault>,
}

fn check(integration: &Integration) -> Result<(), RunFault> {
    let refuse = |setting, value| Err(RunFault::Setting { setting, value });
    let Integration { rtol, atol, step_s, max_step_s, .. } = *integration;
    if !(rtol >= 0.0 && rtol.is_finite()) {
        return refuse("rtol", rtol);
    }
    if !(atol >= 0.0 && atol.is_finite() && (atol > 0.0 || rtol > 0.0)) {
        return refuse("atol", atol);
    }
    let fixed = matches!(integration.method, Method::RungeKutta4 | Method::Euler);
    if fixed && !(1e-9..9e9).contains(&step_s) {
        return refuse("step", step_s);
    }
    if max_step_s <= 0.0 || max_step_s.is_nan() {
        return refuse("max-step", max_step_s);
    }
    Ok(())
}

impl Simulation {
    /// A program in its initial condition.
    pub fn new(machine: Machine, integration: Integration) -> Result<Simulation, RunFault> {
        check(&integration)?;
        let engine = Engine::new(machine, integration);
        let mut simulation = Simulation {
            engine,
            mode: Mode::InitialCondition,
            dirty: false,
            ended: None,
            fault: None,
        };
        simulation.reset()?;
        Ok(simulation)
    }

    /// Back to the initial condition at t = 0, regions and logic settled. What the
    /// digital side has set stays set, as constants.
    /// It refuses a net that is not finite, a zero divisor, a negative root and a logic race.
    pub fn reset(&mut self) -> Result<(), RunFault> {
        self.mode = Mode::InitialCondition;
        self.dirty = false;
        self.ended = None;
        self.fault = None;
        let result = self.engine.reset();
        self.keep(result)
    }

    /// Sets the initial condition of a block with a state, from the next reset on.
    /// A block without one ignores it.
    pub fn set_ic(&mut self, block: BlockId, value: f64) {
        let state = self.engine.machine.state_of_block.get(block.index());
        if let Some(Some(state)) = state {
            self.engine.ics[*state as usize] = value;
        }
    }

    /// The initial condition of a block with a state.
    pub fn ic(&self, block: BlockId) -> Option<f64> {
        let state = (*self.engine.machine.state_of_block.get(block.index())?)?;
        Some(self.engine.ics[state as usize])
    }

    /// Problem time, to the nearest tick.
    pub fn now(&self) -> Tick {
        Tick::from_secs(self.engine.t_s).unwrap_or(Tick(i64::MAX))
    }

    /// Problem time, s.
    pub fn now_s(&self) -> f64 {
        self.engine.t_s
    }

    /// The mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Operates until exactly `t`. In HOLD, or after an overload has ended the run,
    /// problem time stands still and the answer says so.
    /// A fault stands until the next reset.
    pub fn advance_to(&mut self, t: Tick) -> Result<Advance, RunFault> {
        self.advance_attended(t, &mut |_| ControlFlow::Continue(()))
    }

    /// As [`Simulation::advance_to`], asking `attendant` every few thousand derivative
    /// passes whether to go on; when and what it answers alters nothing else.
    pub fn advance_attended(
        &mut self,
        t: Tick,
        attendant: &mut Attendant<'_>,
    ) -> Result<Advance, RunFault> {
        self.advance((t, NEVER), None, attendant)
    }

    /// As [`Simulation::advance_to`], handing the nets to `sink` at each multiple of
    /// `every` after now and up to `t`, from the dense output. At an event the value
    /// after it is handed out.
    pub fn advance_recording(
        &mut self,
        t: Tick,
        every: Tick,
        nets: &[NetId],
        mut sink: impl FnMut(f64, &[f64]),
    ) -> Result<Advance, RunFault> {
        let mut sink = |t_s: f64, values: &[f64]| {
            sink(t_s, values);
            ControlFlow::Continue(())
        };
        self.advance_recording_attended(t, every, nets, &mut sink, &mut |_| {
            ControlFlow::Continue(())
        })
    }

    /// Both: a sink that may have had enough, and an attendant.
    pub fn advance_recording_attended(
        &mut self,
        t: Tick,
        every: Tick,
        nets: &[NetId],
        sink: &mut Sink<'_>,
        attendant: &mut Attendant<'_>,
    ) -> Result<Advance, RunFault> {
        self.advance_by_legs((t, NEVER), every, nets, sink, attendant)
    }

    /// As [`Simulation::advance_recording_attended`] until `t`, but it comes back at the first
    /// step's end that is not before `rest`, without a stop there: who calls again goes on as if
    /// nothing had been.
    pub fn advance_by_legs(
        &mut self,
        (t, rest): (Tick, Tick),
        every: Tick,
        nets: &[NetId],
        sink: &mut Sink<'_>,
        attendant: &mut Attendant<'_>,
    ) -> Result<Advance, RunFault> {
        let slots: Vec<u32> =
            nets.iter().map(|n| self.engine.machine.slot_of_net[n.index()]).collect();
        let mut recorder = Recorder::new(self.engine.t_s, every, slots, sink);
        self.advance((t, rest), Some(&mut recorder), attendant)
    }

    fn advance(
        &mut self,
        (t, rest): (Tick, Tick),
        recorder: Option<&mut Recorder<'_>>,
        attendant: &mut Attendant<'_>,
    ) -> Result<Advance, RunFault> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        if self.dirty {
            self.apply()?;
        }
        if self.mode == Mode::Hold || self.ended.is_some() {
            return Ok(Advance { reached: self.now(), stopped_by: self.ended });
        }
        self.mode = Mode::Operate;
        let passes = self.engine.step.evaluations;
        let mut heed = Heed::new(self.engine.machine.states, passes, attendant);
        let result = self.engine.operate(t.secs(), rest.secs(), recorder, &mut heed);
        let stopped_by = self.keep(result)?;
        if stopped_by.is_some() {
            match self.engine.integration.overload {
                OverloadPolicy::Stop => self.ended = stopped_by,
                OverloadPolicy::Hold => self.mode = Mode::Hold,
                OverloadPolicy::Continue => {}
            }
        }
        let is_short = stopped_by.is_some() || self.engine.t_s < t.secs();
        let reached = if is_short { self.now() } else { t };
        Ok(Advance { reached, stopped_by })
    }

    /// The whole state as bytes, apart from program and settings.
    pub fn snapshot(&self) -> Result<Vec<u8>, SnapshotFault> {
        if self.fault.is_some() {
            return Err(SnapshotFault::Faulted);
        }
        let mut bytes = self.engine.snapshot()?;
        let rest = (self.mode, self.dirty, self.ended);
        bincode::serde::encode_into_std_write(rest, &mut bytes, bincode::config::standard())
            .map_err(|e| SnapshotFault::Damaged(e.to_string()))?;
        Ok(bytes)
    }

    /// Takes over the state of a simulation of the same program and settings; what follows has the
    /// bits that it would have had there. Where the bytes are refused all stays as it is.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SnapshotFault> {
        let mut engine = self.engine.clone();
        let rest = engine.restore(bytes)?;
        let damaged = |e: String| SnapshotFault::Damaged(e);
        let ((mode, dirty, ended), used) =
            bincode::serde::decode_from_slice(rest, bincode::config::standard())
                .map_err(|e| damaged(e.to_string()))?;
        if used != rest.len() {
            return Err(damaged("it is longer than a state".to_owned()));
        }
        *self = Simulation { engine, mode, dirty, ended, fault: None };
        Ok(())
    }

    fn keep<T>(&mut self, result: Result<T, RunFault>) -> Result<T, RunFault> {
        if let Err(fault) = &result {
            self.fault = Some(fault.clone());
        }
        result
    }

    /// Present value of a net.
    pub fn net(&self, net: NetId) -> f64 {
        let slot = self.engine.machine.slot_of_net.get(net.index());
        slot.map_or(f64::NAN, |s| self.engine.nets[*s as usize])
    }

    /// Present derivative of a block with a state, per second.
    pub fn derivative(&self, block: BlockId) -> Option<f64> {
        let state = (*self.engine.machine.state_of_block.get(block.index())?)?;
        Some(self.engine.step.f0[state as usize])
    }

    /// Loads a DAC channel; in force from [`Simulation::apply`] on.
    pub fn set_dac(&mut self, channel: u32, piece: DacPiece) {
        let channels = &self.engine.machine.dac_channels;
        for (hold, (number, _)) in self.engine.frozen.holds.iter_mut().zip(channels) {
            let new = hold.transfer(piece);
            if *number == channel && *hold != new {
                *hold = new;
                self.dirty = true;
            }
        }
    }

    /// Sets a coefficient; in force from [`Simulation::apply`] on.
    pub fn set_dcu(&mut self, channel: u32, c: f64) {
        let channels = &self.engine.machine.dcu_channels;
        for (held, (number, _)) in self.engine.frozen.dcus.iter_mut().zip(channels) {
            if *number == channel && *held != c {
                *held = c;
                self.dirty = true;
            }
        }
    }

    /// Sets a control line; in force from [`Simulation::apply`] on.
    pub fn set_control(&mut self, line: u32, on: bool) {
        for (number, slot) in &self.engine.machine.control_lines {
            let net = &mut self.engine.nets[*slot as usize];
            if *number == line && (*net != 0.0) != on {
                *net = f64::from(on);
                self.dirty = true;
            }
        }
    }

    /// Puts in force what has been set since the last call, all at once. Without a
    /// change the integration goes on undisturbed.
    pub fn apply(&mut self) -> Result<(), RunFault> {
        if !self.dirty {
            return Ok(());
        }
        self.dirty = false;
        let initial = self.mode == Mode::InitialCondition;
        let result = self.engine.apply(initial);
        self.keep(result)
    }

    /// HOLD or OPERATE.
    pub fn hold(&mut self, on: bool) {
        self.mode = match (on, self.engine.t_s > 0.0) {
            (true, _) => Mode::Hold,
            (false, true) => Mode::Operate,
            (false, false) => Mode::InitialCondition,
        };
    }

    /// Moves the interrupt edges since the last call to the end of `out`, in order of time.
    /// Of more than 65 536 the oldest are dropped, and counted in the statistics.
    pub fn take_edges(&mut self, out: &mut Vec<Edge>) {
        out.append(&mut self.engine.happenings.edges);
    }

    /// Present level of a sense line; false where none is patched.
    pub fn sense(&self, line: u32) -> bool {
        let senses = &self.engine.machine.senses;
        senses
            .iter()
            .any(|(number, slot)| *number == line && self.engine.nets[*slot as usize] != 0.0)
    }

    /// Overloads latched since the last reset, in order of time.
    pub fn overloads(&self) -> &[LatchedOverload] {
        &self.engine.overloads
    }

    /// What the patch's settings make of a run from the present state.
    pub fn outlook(&self) -> Vec<outlook::Warning> {
        let Integration { method, step_s, .. } = self.engine.integration;
        outlook::warnings(&self.rates_by_states(), method, step_s)
    }

    /// What the reader of the results should know, since the last reset.
    pub fn remarks(&self) -> Vec<Remark> {
        self.engine.remarks()
    }

    /// Counts since the last reset.
    pub fn statistics(&self) -> Statistics {
        self.engine.pulse().statistics
    }

    pub(crate) fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The program.
    pub fn machine(&self) -> &Machine {
        &self.engine.machine
    }

    /// One derivative pass at the present state; returns the last derivative, so that
    /// a benchmark can use it.
    pub fn derivative_pass(&mut self) -> f64 {
        self.engine.derivative_pass()
    }
}
