//! OPERATE: stepping, error control, events and stops.
//!
//! A step runs on frozen regions, and no longer than its functions show in its ends
//! what they do between them ([`crate::element::pace`]). When it is done the sides of
//! all regions are searched; the earliest crossing is located on the half-open
//! interval (t0, t*] down to the last representable instant. The step then ends at
//! t*, on the far side of the surface, and everything settles there.
//!
//! It refuses to step over a corner, to answer with a step below the resolution
//! of time, and to go on while events repeat without progress.

mod crossing;
mod fixed;
mod guard;
mod heed;
mod instants;
mod paces;
mod past;
mod recorder;
mod search;
mod size;
mod snapshot;
mod stepping;
mod watch;

pub(crate) use heed::Heed;
pub use heed::{Attendant, Pulse};
pub use recorder::Sink;
pub(crate) use recorder::{Cut, Recorder};
pub use snapshot::SnapshotFault;

use crate::element::dac::Hold;
use crate::event::Happenings;
use crate::fault::RunFault;
use crate::integrate::{Scheme, Step};
use crate::integration::{Integration, OverloadPolicy};
use crate::machine::{Frozen, Machine};
use crate::overload::LatchedOverload;
use crate::remark::Remark;
use crate::signal::{Doubted, Rated};
use crate::statistics::Statistics;
use fixed::FixedSteps;
use guard::Switched;
use instants::resolution_s;
use paces::Paces;
use watch::Node;

/// The running state.
#[derive(Clone, Debug)]
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
    /// Absolute tolerance of each state, and the greatest magnitude that it has had.
    pub atol: Vec<f64>,
    pub largest: Vec<f64>,
    /// Whether a state has come back from its greatest magnitude.
    turned: Vec<bool>,
    /// The error of each state that shorter steps do not lessen: rounding.
    grain: Vec<f64>,
    /// The greatest magnitude of a net while some state only grew.
    greatest: f64,
    pub integration: Integration,
    pub t_s: f64,
    /// Proposal of the controller, kept over truncated steps.
    pub next_step_s: f64,
    pub former_error: f64,
    /// What the surfaces read, with its rates: at the start of the step, and where one
    /// looks.
    pub rated_start: Vec<Rated>,
    pub rated: Vec<Rated>,
    pub doubted: Vec<Doubted>,
    /// The ends of the step and the places looked at between them.
    nodes: Vec<Node>,
    /// Error of the cubic of each side, by depth of halving.
    errors: Vec<Vec<f64>>,
    /// A sixth of the third derivative of each side, times the step cubed; and that of the
    /// step before, where it can be compared (`followed`).
    thirds: Vec<f64>,
    former_thirds: Vec<f64>,
    former_cube: f64,
    followed: bool,
    former_region: Vec<u32>,
    /// Sides that are not clear of their surfaces at once.
    active: Vec<u32>,
    doubts: Vec<Doubted>,
    probes: u32,
    cuts: u32,
    margins: Vec<Rated>,
    margins_low: Vec<Rated>,
    margins_high: Vec<Rated>,
    paces: Paces,
    fixed_steps: FixedSteps,
    past: Vec<Rated>,
    /// What the polynomials of the delay lines miss of their inputs over a part of a step.
    missed: Vec<f64>,
    pub happenings: Happenings,
    pub overloads: Vec<LatchedOverload>,
    pub chatter_from_s: f64,
    pub chatter: u32,
    /// How the switchings of each element follow one another.
    switched: Vec<Switched>,
    pub statistics: Statistics,
}

impl Engine {
    /// Before the first reset.
    pub fn new(machine: Machine, integration: Integration) -> Engine {
        let (states, slots) = (machine.states, machine.slots);
        let sides = machine.element_of_side.len();
        let node = |theta: f64| Node {
            theta,
            sides: vec![Rated::default(); sides],
            noise: vec![0.0; sides],
            doubted: false,
        };
        let zeros = || vec![0.0; sides];
        Engine {
            frozen: machine.frozen(),
            ics: machine.ics.clone(),
            nets: machine.initial_nets.clone(),
            probe: machine.initial_nets.clone(),
            before: vec![0.0; slots],
            step: Step::new(states),
            scheme: Scheme::new(integration.method, states),
            atol: vec![0.0; states],
            largest: vec![0.0; states],
            turned: vec![false; states],
            grain: vec![0.0; states],
            greatest: 0.0,
            integration,
            t_s: 0.0,
            next_step_s: 0.0,
            former_error: 1e-4,
            rated_start: vec![Rated::default(); slots],
            rated: vec![Rated::default(); slots],
            doubted: vec![Doubted::default(); slots],
            nodes: vec![node(0.0), node(1.0)],
            errors: vec![zeros()],
            thirds: zeros(),
            former_thirds: zeros(),
            former_cube: 1.0,
            followed: false,
            former_region: vec![0; machine.elements.len()],
            active: Vec::with_capacity(sides),
            doubts: vec![Doubted::default(); sides],
            probes: 0,
            cuts: 0,
            margins: vec![Rated::default(); sides],
            margins_low: vec![Rated::default(); sides],
            margins_high: vec![Rated::default(); sides],
            paces: Paces::new(&machine),
            fixed_steps: FixedSteps::new(states),
            past: Vec::new(),
            missed: Vec::new(),
            happenings: Happenings::default(),
            overloads: Vec::new(),
            chatter_from_s: 0.0,
            chatter: 0,
            switched: vec![Switched::default(); machine.elements.len()],
            statistics: Statistics::default(),
            machine,
        }
    }

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
        self.cuts = 0;
        for node in &mut self.nodes {
            // Of another run: nothing has been left yet.
            node.sides.fill(Rated::default());
            node.noise.fill(0.0);
        }
        self.overloads.clear();
        self.happenings = Happenings::default();
        self.chatter = 0;
        self.chatter_from_s = 0.0;
        self.switched.fill(Switched::default());
        self.former_error = 1e-4;
        self.paces.reset();
        self.fixed_steps.reset();
        self.forget_sizes();
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
        let followed = self.followed;
        self.former_region.copy_from_slice(&self.frozen.region);
        self.settle(initial, Some(0))?;
        // Where no region was left, the sides are what they were, and their third derivatives
        // before tell how much these vary.
        self.followed = followed && self.former_region == self.frozen.region;
        Ok(())
    }

    fn load_functions(&mut self) {
        for function in &self.machine.digital_functions {
            let Frozen { dcus, pieces, .. } = &mut self.frozen;
            function.load(&self.machine.breakpoints, dcus, pieces);
        }
        self.machine.load(&mut self.frozen);
    }

    pub fn derivative_pass(&mut self) -> f64 {
        let n = self.step.y0.len();
        self.probe[..n].copy_from_slice(&self.step.y0);
        self.machine.derivatives(&self.frozen, self.t_s, &mut self.probe, &mut self.step.f1);
        self.step.f1.last().copied().unwrap_or(0.0)
    }

    pub fn pulse(&self) -> Pulse {
        Pulse {
            t_s: self.t_s,
            statistics: Statistics { evaluations: self.step.evaluations, ..self.statistics },
            step_rate: self.scheme.step_rate(&self.step, &self.atol, self.integration.rtol),
        }
    }

    fn cut_short(&self, cut: Cut) -> RunFault {
        match cut {
            Cut::Sink => RunFault::Halted { t_s: self.t_s },
            Cut::NonFinite(slot, t_s) => {
                let block = self.machine.block_of_slot.get(slot as usize);
                RunFault::NonFinite {
                    t_s,
                    block: block.map_or_else(String::new, |b| self.machine.block_name(*b)),
                    net: self.machine.slot_name(slot),
                    what: "the value recorded",
                }
            }
        }
    }

    /// Settles at the present instant and restarts the integration there. `generation`
    /// is given where delay lines must pass the event on.
    fn settle(&mut self, initial: bool, generation: Option<u8>) -> Result<(), RunFault> {
        let n = self.step.y0.len();
        let t_s = self.t_s;
        for line in &mut self.frozen.lines {
            if generation.is_some() {
                line.part();
            }
            // What is read at this instant belongs to what follows it.
            line.aim(t_s, line.delay_s * 1e-3);
        }
        let before = self.inputs_of_lines();
        self.hold_what_leaves();
        self.settle_nets(initial)?;
        self.step.y0.copy_from_slice(&self.nets[..n]);
        self.size_up(true);
        self.forget_directions();
        // Again for each vector at zero: its direction may hang on that of another, and logic and
        // corners on it.
        for _ in 0..=self.machine.paces.len() + self.machine.elements.len() {
            self.machine.derivatives(&self.frozen, t_s, &mut self.nets, &mut self.step.f0);
            self.step.evaluations += 1;
            self.watch_start();
            if self.leave_corners() {
                continue;
            }
            if !self.turn_vectors() {
                break;
            }
            self.settle_nets(initial)?;
            self.step.y0.copy_from_slice(&self.nets[..n]);
        }
        self.count_switchings()?;
        self.probe.copy_from_slice(&self.nets);
        self.scheme.restart();
        self.fixed_steps.part();
        self.check_finite()?;
        if let Some(generation) = generation {
            for (line, before) in self.frozen.lines.iter_mut().zip(before) {
                let after = line.input.of(&self.rated_start);
                line.event(t_s, generation, before, after);
            }
        }
        Ok(())
    }

    /// Brings nets, regions and stores to rest at the present instant.
    fn settle_nets(&mut self, initial: bool) -> Result<(), RunFault> {
        let Engine { machine, frozen, nets, before, happenings, ics, t_s, .. } = self;
        machine.settle(frozen, ics, *t_s, nets, before, initial, happenings)?;
        self.statistics.edges_lost += self.happenings.drop_oldest_edges();
        self.overloads.append(&mut self.happenings.overloads);
        Ok(())
    }

    /// What is to be said of the run so far.
    pub fn remarks(&self) -> Vec<Remark> {
        let machine = &self.machine;
        let unresolved = self.unresolved().map(|state| Remark::Unresolved {
            block: machine.block_name(machine.block_of_state[state]),
            largest: self.largest[state],
            atol: self.atol[state],
        });
        let faded = self.faded().map(|state| Remark::Faded {
            block: machine.block_name(machine.block_of_state[state]),
            value: self.step.y0[state],
            atol: self.atol[state],
        });
        let coarse = self.fixed_steps.poorest(&self.largest).map(|(state, error)| Remark::Coarse {
            block: machine.block_name(machine.block_of_state[state]),
            error,
            largest: self.largest[state],
        });
        unresolved.chain(faded).chain(coarse).collect()
    }

    /// What the delay lines are given, as the nets were watched last.
    fn inputs_of_lines(&self) -> Vec<Rated> {
        let lines = self.frozen.lines.iter();
        lines.map(|line| line.input.of(&self.rated_start)).collect()
    }

    /// Asks the attendant, where it is time to.
    fn heed(&self, heed: &mut Heed<'_>) -> Result<(), RunFault> {
        if heed.is_due(self.step.evaluations) && heed.ask(&self.pulse()).is_break() {
            return Err(RunFault::Halted { t_s: self.t_s });
        }
        Ok(())
    }

    /// Operates until `stop_s`, or until an overload or the attendant stops it; it comes back at
    /// the first step's end that is not before `rest_s`, with nothing altered by that.
    pub fn operate(
        &mut self,
        stop_s: f64,
        rest_s: f64,
        mut recorder: Option<&mut Recorder<'_>>,
        heed: &mut Heed<'_>,
    ) -> Result<Option<LatchedOverload>, RunFault> {
        while self.t_s < stop_s && self.t_s < rest_s {
            self.heed(heed)?;
            let known = self.overloads.len();
            let mut target_s = stop_s.min(self.next_instant_s());
            if !self.scheme.adaptive() {
                target_s = target_s.min(self.grid_s());
            }
            if target_s - self.t_s <= resolution_s(self.t_s) {
                self.t_s = self.t_s.max(target_s);
            } else {
                self.advance_once(target_s, recorder.as_deref_mut(), heed)?;
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
                if let Some(cut) = recorder.cut() {
                    return Err(self.cut_short(cut));
                }
            }
            if self.overloads.len() > known && self.integration.overload != OverloadPolicy::Continue
            {
                return Ok(self.overloads.get(known).copied());
            }
        }
        Ok(None)
    }
}
