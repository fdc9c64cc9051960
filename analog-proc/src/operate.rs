//! OPERATE: stepping, error control, events and stops.
//!
//! A step runs on frozen regions. When it is done its witnesses are looked at in
//! its middle, where a witness's parabola comes nearest to its surface, and at
//! its end; the earliest crossing is bracketed, first on the dense output, then
//! by steps of the method itself, on the half-open interval (t0, t*] down to the
//! last representable instant. The step then ends at t*, on the far side of the
//! surface, and everything settles there.
//!
//! It refuses to step over a corner, to answer with a step below the resolution
//! of time, and to go on while events repeat without progress.

use interface::Tick;

use crate::block::dac::Hold;
use crate::block::delay::POINTS;
use crate::block::source::Firing;
use crate::event::{Happenings, fatal};
use crate::fault::RunFault;
use crate::integrate::{Scheme, Step, System};
use crate::machine::{Frozen, Machine};
use crate::net::{BlockId, Integration, NetId, OverloadPolicy};
use crate::overload::LatchedOverload;
use crate::simulation::Statistics;

/// Factor below the step at which the error estimate would just be met.
const SAFETY: f64 = 0.9;
/// Least and greatest change of the step at once.
const SHRINK: f64 = 0.2;
const GROW: f64 = 10.0;
/// Weight of the former error in the controller (Hairer's choice for this method).
const BETA: f64 = 0.04;
/// First step of a patch without integrators, s.
const FIRST_STEP_S: f64 = 1e-3;
/// This many events within [`CHATTER_SPAN`] are chatter: a bouncing ball that loses a
/// fifth of its speed each time comes from one second to rounding in 160 bounces.
const CHATTER_EVENTS: u32 = 1000;
/// Relative progress of time under which events count as repeated.
const CHATTER_SPAN: f64 = 1e-9;
/// Instants closer to zero than this are resolved no finer than those at it, s.
const LEAST_TIME_S: f64 = 1e-9;
/// Probes of one bracketing: bisection alone needs 60, every fourth probe bisects.
const PROBES: usize = 250;

/// About two units in the last place of `t_s`, s.
fn resolution_s(t_s: f64) -> f64 {
    f64::EPSILON * t_s.abs().max(LEAST_TIME_S)
}

/// Hands nets to a sink at multiples of a period.
pub(crate) struct Recorder<'a> {
    every: Tick,
    next: i64,
    slots: Vec<u32>,
    values: Vec<f64>,
    sink: &'a mut dyn FnMut(f64, &[f64]),
}

impl<'a> Recorder<'a> {
    pub fn new(
        now_s: f64,
        every: Tick,
        slots: Vec<u32>,
        sink: &'a mut dyn FnMut(f64, &[f64]),
    ) -> Recorder<'a> {
        let every = Tick(every.0.max(1));
        let mut next = (now_s * 1e9) as i64 / every.0;
        while Tick(every.0.saturating_mul(next)).secs() <= now_s {
            next += 1;
        }
        let values = vec![0.0; slots.len()];
        Recorder {
            every,
            next,
            slots,
            values,
            sink,
        }
    }

    fn next_s(&self) -> f64 {
        Tick(self.every.0.saturating_mul(self.next)).secs()
    }

    fn record(&mut self, nets: &[f64]) {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            *value = nets[*slot as usize];
        }
        let t_s = self.next_s();
        (self.sink)(t_s, &self.values);
        self.next += 1;
    }
}

/// The running state.
#[derive(Debug)]
pub(crate) struct Engine {
    pub machine: Machine,
    pub frozen: Frozen,
    /// Initial conditions, as set for the next reset.
    pub ics: Vec<f64>,
    pub nets: Vec<f64>,
    /// A second set of nets, for looking between the ends of a step.
    pub probe: Vec<f64>,
    pub before: Vec<f64>,
    /// `y0` and `f0` are the state and its derivative at `t_s`.
    pub step: Step,
    pub scheme: Scheme,
    pub atol: Vec<f64>,
    pub integration: Integration,
    pub t_s: f64,
    /// Proposal of the controller, kept over truncated steps.
    pub next_step_s: f64,
    pub former_error: f64,
    pub margins: Vec<f64>,
    /// Margins at the lower end of the bracket: at the start of the step.
    pub margins_low: Vec<f64>,
    pub margins_high: Vec<f64>,
    pub happenings: Happenings,
    pub overloads: Vec<LatchedOverload>,
    pub chatter_from_s: f64,
    pub chatter: u32,
    pub statistics: Statistics,
}

impl Machine {
    pub(crate) fn driver_of(&self, net: NetId) -> Option<BlockId> {
        let slot = self.slot_of_net.get(net.index())?;
        self.block_of_slot.get(*slot as usize).copied()
    }
}

impl Engine {
    pub fn reset(&mut self) -> Result<(), RunFault> {
        let fresh = self.machine.frozen();
        let old = std::mem::replace(&mut self.frozen, fresh);
        // What the digital side holds outlives a reset.
        self.frozen.dcus = old.dcus;
        for (new, held) in self.frozen.holds.iter_mut().zip(&old.holds) {
            *new = Hold::at(held.at_time(self.t_s));
        }
        self.before.copy_from_slice(&self.nets);
        self.nets.copy_from_slice(&self.machine.initial_nets);
        for (_, slot) in &self.machine.control_lines {
            self.nets[*slot as usize] = self.before[*slot as usize];
        }
        self.load_functions();
        self.nets[..self.ics.len()].copy_from_slice(&self.ics);
        self.t_s = 0.0;
        self.statistics = Statistics::default();
        self.step.evaluations = 0;
        self.overloads.clear();
        self.happenings = Happenings::default();
        self.chatter = 0;
        self.chatter_from_s = 0.0;
        self.former_error = 1e-4;
        for (i, (_, timer)) in self.machine.timers.iter().enumerate() {
            self.frozen.timer_count[i] = timer.first();
            self.frozen.timer_s[i] = timer.instant_s(timer.first());
        }
        self.fire_timers();
        self.settle(true, Some(0))?;
        self.next_step_s = self.first_step_s();
        Ok(())
    }

    /// Settles what the digital side has set.
    pub fn apply(&mut self, initial: bool) -> Result<(), RunFault> {
        self.load_functions();
        self.settle(initial, Some(0))
    }

    fn load_functions(&mut self) {
        for function in &self.machine.digital_functions {
            function.load(&self.machine.breakpoints, &mut self.frozen);
        }
    }

    pub fn derivative_pass(&mut self) -> f64 {
        let n = self.step.y0.len();
        self.probe[..n].copy_from_slice(&self.step.y0);
        self.machine
            .derivatives(&self.frozen, self.t_s, &mut self.probe, &mut self.step.f1);
        self.step.f1.last().copied().unwrap_or(0.0)
    }

    /// Settles at the present instant and restarts the integration there. `generation`
    /// is given where delay lines must pass the event on.
    fn settle(&mut self, initial: bool, generation: Option<u8>) -> Result<(), RunFault> {
        let n = self.step.y0.len();
        let t_s = self.t_s;
        for line in &mut self.frozen.lines {
            if let Some(generation) = generation {
                line.event(t_s, generation);
            }
            // What is read at this instant belongs to what follows it.
            line.aim(t_s, line.delay_s * 1e-3);
        }
        let Engine {
            machine,
            frozen,
            nets,
            before,
            happenings,
            ics,
            ..
        } = self;
        machine.settle(frozen, ics, t_s, nets, before, initial, happenings)?;
        self.overloads.append(&mut self.happenings.overloads);
        self.step.y0.copy_from_slice(&self.nets[..n]);
        self.machine
            .derivatives(&self.frozen, t_s, &mut self.nets, &mut self.step.f0);
        self.step.evaluations += 1;
        self.probe.copy_from_slice(&self.nets);
        self.scheme.restart();
        self.check_finite()?;
        let mut margins = std::mem::take(&mut self.margins_low);
        self.witness(&self.nets, &mut margins);
        self.margins_low = margins;
        Ok(())
    }

    fn check_finite(&self) -> Result<(), RunFault> {
        // Zero times a finite number is zero: the sum is defined only if all are finite.
        let nets: f64 = self.nets.iter().map(|x| x * 0.0).sum();
        let rates: f64 = self.step.f0.iter().map(|x| x * 0.0).sum();
        if nets + rates == 0.0 {
            return Ok(());
        }
        Err(self.not_finite(&self.nets, &self.step.f0))
    }

    fn not_finite(&self, nets: &[f64], rates: &[f64]) -> RunFault {
        let machine = &self.machine;
        let state = nets[..rates.len()].iter().position(|x| !x.is_finite());
        let later = nets.iter().position(|x| !x.is_finite());
        let rate = rates.iter().position(|x| !x.is_finite());
        let (what, slot) = match (state, later, rate) {
            (Some(slot), _, _) | (None, Some(slot), _) => ("output", slot),
            (None, None, Some(slot)) => ("derivative", slot),
            (None, None, None) => ("error estimate", self.step.worst),
        };
        let block = machine
            .block_of_slot
            .get(slot)
            .map_or_else(String::new, |b| machine.block_name(*b));
        let net = machine.slot_name(slot as u32);
        RunFault::NonFinite {
            t_s: self.t_s,
            block,
            net,
            what,
        }
    }

    fn fire_timers(&mut self) -> bool {
        let mut fired = false;
        for i in 0..self.machine.timers.len() {
            while self.frozen.timer_s[i] <= self.t_s {
                fired = true;
                let (slot, timer) = self.machine.timers[i];
                let n = self.frozen.timer_count[i];
                match timer.fire(n) {
                    Firing::Value(value) => self.nets[slot as usize] = value,
                    Firing::Started(wave) => self.frozen.started[wave as usize] = true,
                    Firing::Renew(noise) => {
                        self.nets[slot as usize] = self.frozen.noises[noise as usize].next();
                    }
                }
                self.frozen.timer_count[i] = n + 1;
                // However short a period, time goes on between two firings.
                let least_s = self.t_s + resolution_s(self.t_s);
                self.frozen.timer_s[i] = timer.instant_s(n + 1).max(least_s);
            }
        }
        fired
    }

    /// The next instant that is known beforehand, s.
    fn next_instant_s(&self) -> f64 {
        let timers = self
            .frozen
            .timer_s
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        self.frozen
            .lines
            .iter()
            .map(|line| line.next_s())
            .fold(timers, f64::min)
    }

    fn first_step_s(&mut self) -> f64 {
        let n = self.step.y0.len();
        let cap_s = self.cap_s();
        if n == 0 {
            return FIRST_STEP_S.min(cap_s);
        }
        let rtol = self.integration.rtol;
        let size = |v: &[f64], y: &[f64], atol: &[f64]| {
            let mut norm = 0.0_f64;
            for i in 0..n {
                norm = norm.max(v[i].abs() / (atol[i] + rtol * y[i].abs()));
            }
            norm
        };
        let (y0, f0) = (&self.step.y0, &self.step.f0);
        let (d0, d1) = (size(y0, y0, &self.atol), size(f0, y0, &self.atol));
        let mut h0 = if d0 < 1e-5 || d1 < 1e-5 {
            1e-6
        } else {
            0.01 * d0 / d1
        };
        h0 = h0.min(cap_s);
        for i in 0..n {
            self.probe[i] = y0[i] + h0 * f0[i];
        }
        let t_s = self.t_s + h0;
        self.machine
            .derivatives(&self.frozen, t_s, &mut self.probe, &mut self.step.f1);
        self.step.evaluations += 1;
        for i in 0..n {
            self.step.f1[i] = (self.step.f1[i] - self.step.f0[i]) / h0;
        }
        let d2 = size(&self.step.f1, &self.step.y0, &self.atol);
        let greatest = d1.max(d2);
        let h1 = if greatest <= 1e-15 {
            (h0 * 1e-3).max(1e-6)
        } else {
            (0.01 / greatest).powf(1.0 / self.scheme.exponent())
        };
        let h = (100.0 * h0).min(h1).min(cap_s);
        if h.is_finite() && h > 0.0 {
            h
        } else {
            1e-6_f64.min(cap_s)
        }
    }

    fn cap_s(&self) -> f64 {
        self.machine.step_cap_s.min(self.integration.max_step_s)
    }

    /// Operates until `stop_s`, or until an overload stops it.
    pub fn operate(
        &mut self,
        stop_s: f64,
        mut recorder: Option<&mut Recorder<'_>>,
    ) -> Result<Option<LatchedOverload>, RunFault> {
        while self.t_s < stop_s {
            let known = self.overloads.len();
            let mut target_s = stop_s.min(self.next_instant_s());
            if !self.scheme.adaptive() {
                target_s = target_s.min(self.grid_s());
            }
            if target_s - self.t_s <= resolution_s(self.t_s) {
                self.t_s = self.t_s.max(target_s);
            } else {
                self.advance_once(target_s, recorder.as_deref_mut())?;
            }
            if self.next_instant_s() <= self.t_s {
                let mut generation = None;
                for line in &mut self.frozen.lines {
                    generation = match (generation, line.take_due(self.t_s)) {
                        (Some(a), Some(b)) => Some(u8::min(a, b)),
                        (a, b) => a.or(b),
                    };
                }
                if self.fire_timers() {
                    generation = Some(0);
                }
                self.statistics.events += 1;
                self.settle(false, generation)?;
            }
            if let Some(recorder) = recorder.as_deref_mut() {
                while recorder.next_s() <= self.t_s {
                    recorder.record(&self.nets);
                }
            }
            if self.overloads.len() > known && self.integration.overload != OverloadPolicy::Continue
            {
                return Ok(self.overloads.get(known).copied());
            }
        }
        Ok(None)
    }

    /// The next point of the fixed grid, a multiple of the step in whole ticks, s.
    fn grid_s(&self) -> f64 {
        let step = Tick::from_secs(self.integration.step_s).map_or(1, |t| t.0.max(1));
        let mut n = (self.t_s * 1e9 / step as f64) as i64;
        loop {
            let next_s = Tick(step.saturating_mul(n)).secs();
            if next_s > self.t_s + resolution_s(self.t_s) || n == i64::MAX {
                return next_s;
            }
            n += 1;
        }
    }

    fn attempt(&mut self, h_s: f64) -> f64 {
        for line in &mut self.frozen.lines {
            line.aim(self.t_s, h_s);
        }
        let Engine {
            machine,
            frozen,
            atol,
            integration,
            step,
            nets,
            scheme,
            ..
        } = self;
        step.t0_s = self.t_s;
        let system = System {
            machine,
            frozen,
            atol,
            rtol: integration.rtol,
        };
        scheme.attempt(system, step, h_s, nets)
    }

    /// One accepted step towards `target_s`, ended early by an event.
    fn advance_once(
        &mut self,
        target_s: f64,
        recorder: Option<&mut Recorder<'_>>,
    ) -> Result<(), RunFault> {
        let room_s = target_s - self.t_s;
        let adaptive = self.scheme.adaptive();
        let proposal_s = self.next_step_s.min(self.cap_s());
        let mut h_s = if adaptive {
            proposal_s.min(room_s)
        } else {
            room_s.min(self.machine.step_cap_s)
        };
        if adaptive && proposal_s <= resolution_s(self.t_s) {
            return Err(self.underflow(1.0, proposal_s));
        }
        let mut end_s = self.end_of(h_s, target_s, room_s);
        let mut rejected = false;
        loop {
            // The step as time resolves it; the wish goes on shrinking below that.
            let step_s = end_s - self.t_s;
            let error = self.attempt(step_s);
            if !adaptive {
                break;
            }
            if error <= 1.0 {
                self.propose(error, step_s, proposal_s, rejected);
                break;
            }
            h_s = h_s.min(step_s);
            self.statistics.rejected += 1;
            let shrink = if error.is_finite() {
                (SAFETY * error.powf(-1.0 / self.scheme.exponent())).clamp(SHRINK, SAFETY)
            } else {
                0.1
            };
            rejected = true;
            h_s *= shrink;
            self.next_step_s = h_s;
            if h_s <= resolution_s(self.t_s) {
                return Err(self.underflow(error, h_s));
            }
            end_s = self.end_of(h_s, target_s, room_s);
        }
        let crossed = if self.machine.watched.is_empty() {
            None
        } else {
            self.find_crossing(end_s)?
        };
        let end_s = crossed.map_or(end_s, |c| c.0);
        self.finish(end_s, recorder)?;
        if let Some((_, Some(element))) = crossed {
            self.statistics.events += 1;
            self.count_chatter(element)?;
            self.settle(false, Some(0))?;
        }
        Ok(())
    }

    /// End of a step of about `h_s`, without leaving a sliver before the target.
    fn end_of(&self, h_s: f64, target_s: f64, room_s: f64) -> f64 {
        if h_s >= room_s * (1.0 - 1e-9) {
            target_s
        } else if h_s > 0.55 * room_s {
            self.t_s + 0.5 * room_s
        } else {
            self.t_s + h_s
        }
    }

    fn propose(&mut self, error: f64, h_s: f64, proposal_s: f64, rejected: bool) {
        let order = self.scheme.exponent();
        let error = error.max(1e-10);
        let former = self.former_error;
        let factor = SAFETY * error.powf(-(1.0 / order - 0.75 * BETA)) * former.powf(BETA);
        let mut next_s = h_s * factor.clamp(SHRINK, GROW);
        if rejected {
            next_s = next_s.min(h_s);
        } else if h_s < proposal_s * (1.0 - 1e-9) {
            // Truncated at a stop: the proposal stands, unless the step shows it too long.
            next_s = next_s.max(proposal_s);
        }
        if h_s >= proposal_s * (1.0 - 1e-9) || rejected {
            self.former_error = error.max(1e-4);
        }
        self.next_step_s = next_s.min(self.cap_s());
    }

    fn underflow(&self, error: f64, step_s: f64) -> RunFault {
        if error.is_finite() {
            let state = self.step.worst;
            let block = self.machine.block_of_state.get(state);
            let block = block.map_or_else(String::new, |b| self.machine.block_name(*b));
            RunFault::StepUnderflow {
                t_s: self.t_s,
                step_s,
                block,
            }
        } else {
            self.not_finite(&self.nets, &self.step.f1)
        }
    }

    /// Accepts the step that ends at `end_s` with what `nets` now hold.
    fn finish(&mut self, end_s: f64, recorder: Option<&mut Recorder<'_>>) -> Result<(), RunFault> {
        self.statistics.steps += 1;
        let (t0_s, h_s) = (self.t_s, self.step.h_s);
        if let Some(recorder) = recorder {
            while recorder.next_s() < end_s {
                self.look((recorder.next_s() - t0_s) / h_s);
                recorder.record(&self.probe);
            }
        }
        if !self.frozen.lines.is_empty() {
            self.store_delays();
        }
        self.step.advance();
        self.t_s = end_s;
        self.check_finite()
    }

    fn store_delays(&mut self) {
        let mut samples = vec![[0.0; POINTS]; self.frozen.lines.len()];
        for point in 0..POINTS {
            let theta = point as f64 / (POINTS - 1) as f64;
            if point + 1 < POINTS {
                self.look(theta);
            } else {
                self.probe.copy_from_slice(&self.nets);
            }
            for (sample, line) in samples.iter_mut().zip(&self.frozen.lines) {
                sample[point] = line.input.of(&self.probe);
            }
        }
        let (t0_s, h_s) = (self.t_s, self.step.h_s);
        for (sample, line) in samples.iter().zip(&mut self.frozen.lines) {
            line.store(t0_s, h_s, *sample);
        }
    }

    /// Brings `probe` to the instant `theta` of the step.
    fn look(&mut self, theta: f64) {
        self.step.dense(theta, &mut self.probe);
        let t_s = self.step.t0_s + theta * self.step.h_s;
        self.machine.outputs(&self.frozen, t_s, &mut self.probe);
        self.step.evaluations += 1;
    }

    fn witness(&self, nets: &[f64], margins: &mut [f64]) {
        for (margin, e) in margins.iter_mut().zip(&self.machine.watched) {
            let e = *e as usize;
            let element = &self.machine.elements[e].1;
            *margin = element.margin(self.frozen.region[e], &self.machine, nets);
        }
    }

    /// Margins at `t_s`, into `margins`; true where a surface is crossed.
    fn crossed_at(&mut self, t_s: f64, by_steps: bool) -> bool {
        if by_steps {
            self.attempt(t_s - self.t_s);
        } else {
            self.look((t_s - self.step.t0_s) / self.step.h_s);
        }
        let mut margins = std::mem::take(&mut self.margins);
        self.witness(
            if by_steps { &self.nets } else { &self.probe },
            &mut margins,
        );
        self.margins = margins;
        self.margins.iter().any(|g| *g > 0.0)
    }

    /// The end of the step as events have it: `None` where nothing is crossed; else
    /// the end, and the element that is left there (none, if the step is merely cut).
    fn find_crossing(&mut self, end_s: f64) -> Result<Option<(f64, Option<u32>)>, RunFault> {
        let start_s = self.t_s;
        let h_s = end_s - start_s;
        let mut at_end = std::mem::take(&mut self.margins_high);
        self.witness(&self.nets, &mut at_end);
        self.margins_high = at_end;
        let crossed_at_end = self.margins_high.iter().any(|g| *g > 0.0);
        let middle_s = start_s + 0.5 * h_s;
        let mut high_s = end_s;
        let mut by_dense = false;
        if h_s > 4.0 * resolution_s(end_s) {
            if self.crossed_at(middle_s, false) {
                high_s = middle_s;
                by_dense = true;
            } else if let Some(theta) = self.nearest_approach() {
                let t_s = start_s + theta * h_s;
                if self.crossed_at(t_s, false) {
                    high_s = t_s;
                    by_dense = true;
                }
            }
        }
        if !crossed_at_end && !by_dense {
            std::mem::swap(&mut self.margins_low, &mut self.margins_high);
            return Ok(None);
        }
        let start_margins = self.margins_low.clone();
        if by_dense {
            std::mem::swap(&mut self.margins, &mut self.margins_high);
        }
        let (_, guess_s) = self.narrow(start_s, high_s, 1e-6 * h_s, false);
        self.margins_low.copy_from_slice(&start_margins);
        if !self.crossed_at(high_s, true) {
            // The dense output saw what the method does not confirm: the step is cut
            // there and goes on from its true value.
            self.witness_low();
            return Ok(Some((high_s, None)));
        }
        std::mem::swap(&mut self.margins, &mut self.margins_high);
        let mut low_s = start_s;
        let mut last_s = high_s;
        if guess_s > low_s && guess_s < high_s {
            last_s = guess_s;
            if self.crossed_at(guess_s, true) {
                high_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
            } else {
                low_s = guess_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
            }
        }
        let (probed_s, located_s) = self.narrow(low_s, high_s, resolution_s(high_s), true);
        if let Some(probed_s) = probed_s {
            last_s = probed_s;
        }
        if last_s != located_s {
            self.crossed_at(located_s, true);
        }
        let crossed = self.margins_high.iter().position(|g| *g > 0.0);
        let element = crossed.map(|i| self.machine.watched[i]);
        if let Some(e) = element {
            let (block, piecewise) = self.machine.elements[e as usize];
            if let Some(fault) = piecewise.fatal() {
                return Err(fatal(&self.machine, block, fault, located_s));
            }
        }
        Ok(Some((located_s, element)))
    }

    fn witness_low(&mut self) {
        let mut margins = std::mem::take(&mut self.margins_low);
        self.witness(&self.nets, &mut margins);
        self.margins_low = margins;
    }

    /// Where the parabola of a witness through start, middle and end rises above its
    /// surface, if one does: the place of a graze. The middle is in `margins`.
    fn nearest_approach(&self) -> Option<f64> {
        let mut best: Option<(f64, f64)> = None;
        for ((low, middle), high) in self
            .margins_low
            .iter()
            .zip(&self.margins)
            .zip(&self.margins_high)
        {
            let bend = 2.0 * (low - 2.0 * middle + high);
            if bend >= 0.0 || bend.is_nan() {
                continue;
            }
            let slope = 4.0 * middle - 3.0 * low - high;
            let theta = -slope / (2.0 * bend);
            let peak = low + 0.5 * slope * theta;
            if theta > 0.0 && theta < 1.0 && peak > 0.0 && best.is_none_or(|b| theta < b.1) {
                best = Some((peak, theta));
            }
        }
        best.map(|b| b.1)
    }

    /// Narrows a bracket whose lower end is not crossed (`margins_low`) and whose upper
    /// end is (`margins_high`) to `width_s`: the Illinois form of false position on the
    /// earliest witness, with a bisection every fourth time. Returns the last instant
    /// probed and the upper end.
    fn narrow(
        &mut self,
        mut low_s: f64,
        mut high_s: f64,
        width_s: f64,
        by_steps: bool,
    ) -> (Option<f64>, f64) {
        let (mut weight_low, mut weight_high, mut side) = (1.0, 1.0, 0);
        let mut probed = None;
        for probe in 0..PROBES {
            if high_s - low_s <= width_s {
                break;
            }
            let mut t_s = 0.5 * (low_s + high_s);
            if probe % 4 != 3 {
                let mut earliest_s = high_s;
                for (low, high) in self.margins_low.iter().zip(&self.margins_high) {
                    if *high > 0.0 {
                        let (low, high) = (weight_low * low.min(0.0), weight_high * high);
                        let root_s = low_s + (high_s - low_s) * (low / (low - high));
                        if root_s < earliest_s {
                            earliest_s = root_s;
                        }
                    }
                }
                t_s = earliest_s.clamp(low_s + 0.5 * width_s, high_s - 0.5 * width_s);
            }
            if !(t_s > low_s && t_s < high_s) {
                break;
            }
            probed = Some(t_s);
            if self.crossed_at(t_s, by_steps) {
                high_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_high);
                weight_high = 1.0;
                weight_low = if side == 1 { 0.5 * weight_low } else { 1.0 };
                side = 1;
            } else {
                low_s = t_s;
                std::mem::swap(&mut self.margins, &mut self.margins_low);
                weight_low = 1.0;
                weight_high = if side == -1 { 0.5 * weight_high } else { 1.0 };
                side = -1;
            }
        }
        (probed, high_s)
    }

    fn count_chatter(&mut self, element: u32) -> Result<(), RunFault> {
        let span_s = CHATTER_SPAN * self.t_s.abs().max(LEAST_TIME_S);
        if self.t_s - self.chatter_from_s > span_s {
            self.chatter_from_s = self.t_s;
            self.chatter = 0;
        }
        self.chatter += 1;
        if self.chatter < CHATTER_EVENTS {
            return Ok(());
        }
        let block = self
            .machine
            .block_name(self.machine.elements[element as usize].0);
        Err(RunFault::Chatter {
            t_s: self.t_s,
            block,
            events: self.chatter,
        })
    }
}
