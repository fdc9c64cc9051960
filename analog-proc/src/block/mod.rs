//! Lowering: each kind of block becomes operations, elements and stores of the machine.
//!
//! What a kind becomes stands with the kind ([`kind`]); this file walks the evaluation
//! order and holds the builder that all of them use. A compound block (lag, follower,
//! backlash) becomes the wiring that a programmer would patch for it.

pub mod kind;

use self::kind::Storage;
use engine::element::curve::{Curve, Piece, band};
use engine::element::pace::{self, Pace};
use engine::element::piecewise::Piecewise;

use crate::net::{Block, Input, Level};
use crate::order::Ordered;
use engine::id::BlockId;
use engine::kernel::{Kernel, fold};
use engine::machine::{Machine, Settle};
use engine::op::{Op, Slot, Term, behind, degrees, powers};
use engine::overload::OVERLOAD_FACTOR;
use engine::{fault::RunFault, simulation::Simulation};

/// The machine under construction.
pub(crate) struct Lowering {
    m: Machine,
    /// Whether a slot varies within a step.
    varying: Vec<bool>,
    /// Operations whose result varies within a step.
    fast: Vec<Op>,
    /// Nets that the sides of each watched element read.
    watched: Vec<Vec<Slot>>,
    /// The block of each varying operation.
    block_of_fast: Vec<BlockId>,
    /// Terms of each derivative.
    rates: Vec<(u32, Vec<Term>)>,
    /// Angles whose sine is in a net, their cosine in the net after it.
    angles: Vec<(Slot, f64, Slot)>,
    block: BlockId,
}

/// The degree up to which a side is judged from the ends of a step: a quartic's error is known
/// from the change of its third derivative, and the peaks of a product of four sines are still
/// seen from the ends of a step of an eighth of a turn.
const JUDGED_AT_ENDS: u32 = 4;

/// How often a step is halved before a side of this degree is judged: so that there are as
/// many pieces as it may have extremes.
fn halvings(degree: u32) -> u8 {
    if degree <= JUDGED_AT_ENDS { 0 } else { (u32::BITS - (degree - 1).leading_zeros()) as u8 }
}

impl Ordered {
    /// The machine that it is, in the initial condition.
    ///
    /// # Errors
    /// Settings out of range, and whatever [`Simulation::reset`] finds.
    pub fn simulation(&self) -> Result<Simulation, RunFault> {
        Simulation::new(lower(self), self.netlist.integration)
    }
}

/// Lowers an ordered net.
fn lower(ordered: &Ordered) -> Machine {
    let netlist = &ordered.netlist;
    let mut states = 0_u32;
    let mut slot_of_net = vec![u32::MAX; netlist.nets.len()];
    let mut state_of_block = vec![None; netlist.blocks.len()];
    let mut block_of_state = Vec::new();
    let mut scales = Vec::new();
    for (i, block) in netlist.blocks.iter().enumerate() {
        if block.kind.facts().storage == Storage::State
            && let Some(net) = block.outputs.first()
        {
            slot_of_net[net.index()] = states;
            state_of_block[i] = Some(states);
            block_of_state.push(BlockId(i as u32));
            scales.push(block.max.filter(|m| *m > 0.0));
            states += 1;
        }
    }
    let mut slots = states;
    for slot in &mut slot_of_net {
        if *slot == u32::MAX {
            *slot = slots;
            slots += 1;
        }
    }
    let mut block_of_slot = vec![BlockId(0); slots as usize];
    for (net, slot) in netlist.nets.iter().zip(&slot_of_net) {
        block_of_slot[*slot as usize] = net.driver;
    }
    let mut varying = vec![false; slots as usize];
    varying[..states as usize].fill(true);
    let mut lowering = Lowering {
        m: Machine {
            states: states as usize,
            slots: slots as usize,
            slot_of_net,
            state_of_block,
            block_of_slot,
            net_names: netlist.nets.iter().map(|n| n.name.clone()).collect(),
            block_names: netlist.blocks.iter().map(|b| b.name.clone()).collect(),
            block_of_state,
            settle: Vec::new(),
            kernel: Kernel::default(),
            terms: Vec::new(),
            ics: vec![0.0; states as usize],
            scales,
            initial_nets: vec![0.0; slots as usize],
            elements: Vec::new(),
            watched: Vec::new(),
            first_side: Vec::new(),
            element_of_side: Vec::new(),
            halvings: Vec::new(),
            smooth: true,
            watch: Vec::new(),
            paces: Vec::new(),
            breakpoints: Vec::new(),
            initial_pieces: Vec::new(),
            tables: Vec::new(),
            controls: Vec::new(),
            stores: Vec::new(),
            track_ics: Vec::new(),
            timers: Vec::new(),
            waves: Vec::new(),
            noises: Vec::new(),
            lines: Vec::new(),
            dac_channels: Vec::new(),
            dcu_channels: Vec::new(),
            digital_functions: Vec::new(),
            senses: Vec::new(),
            control_lines: Vec::new(),
            step_cap_s: f64::INFINITY,
        },
        varying,
        fast: Vec::new(),
        watched: Vec::new(),
        block_of_fast: Vec::new(),
        rates: Vec::new(),
        angles: Vec::new(),
        block: BlockId(0),
    };
    let blocks = ordered.order.iter().map(|id| (*id, &netlist.blocks[id.index()]));
    for (id, block) in blocks.clone() {
        lowering.block = id;
        let o = lowering.slot(block.outputs[0]);
        if block.kind.facts().storage != Storage::State {
            block.kind.component().lower(&mut lowering, block, o);
        }
        lowering.overload(o, block.max);
    }
    // Stores read nets that come later in the order: their inputs are wired last.
    for (id, block) in blocks {
        lowering.block = id;
        let o = lowering.slot(block.outputs[0]);
        block.kind.component().lower_inputs(&mut lowering, block, o);
    }
    let Lowering { mut m, rates, fast, watched: read_by, block_of_fast, .. } = lowering;
    let mut seen = read_by.concat();
    seen.extend(m.lines.iter().map(|line| line.input.slot));
    let mut needed = seen.clone();
    needed.extend(rates.iter().flat_map(|rate| rate.1.iter().map(|t| t.slot)));
    let live = behind(&fast, &m.terms, &needed, m.slots);
    let degree = degrees(&fast, &m.terms, m.slots);
    let powers = powers(&fast, &m.terms, &degree);
    for ((op, block), live) in fast.iter().zip(&block_of_fast).zip(live) {
        if let (true, Some(pace)) = (live, Pace::of(op, &powers)) {
            pace.reads(|slot| seen.push(slot));
            m.paces.push((pace, *block));
        }
        if let (true, Op::Wave { o, wave }) = (live, op) {
            let turn = pace::turn(powers[*o as usize]);
            let cap_s = m.waves[*wave as usize].time_to_turn_s(turn);
            m.step_cap_s = m.step_cap_s.min(cap_s);
        }
    }
    let watch = behind(&fast, &m.terms, &seen, m.slots);
    let watched = fast.iter().zip(watch);
    m.watch = watched.filter_map(|(op, seen)| seen.then_some(*op)).collect();
    m.first_side = vec![None; m.elements.len()];
    for (e, reads) in m.watched.iter().zip(&read_by) {
        let sides = m.elements[*e as usize].1.side_count();
        m.first_side[*e as usize] = Some(m.element_of_side.len() as u32);
        m.element_of_side.extend(std::iter::repeat_n(*e, sides));
        let greatest = reads.iter().map(|slot| degree[*slot as usize]).max();
        let halvings = halvings(greatest.unwrap_or(1));
        m.halvings.extend(std::iter::repeat_n(halvings, sides));
    }
    m.smooth = m.halvings.iter().all(|n| *n == 0);
    m.kernel = fold(&fast, &m.terms, &rates, m.slots);
    m
}

fn scaled(terms: Vec<Term>, factor: f64) -> Vec<Term> {
    terms.into_iter().map(|t| Term { slot: t.slot, c: factor * t.c }).collect()
}

impl Lowering {
    fn term(&self, input: &Input) -> Term {
        Term { slot: self.slot(input.net), c: input.coefficient }
    }

    fn slot(&self, net: engine::id::NetId) -> Slot {
        self.m.slot_of_net[net.index()]
    }

    fn terms(&self, inputs: &[Input]) -> Vec<Term> {
        inputs.iter().map(|i| self.term(i)).collect()
    }

    fn hidden(&mut self) -> Slot {
        let slot = self.m.slots as Slot;
        self.m.slots += 1;
        self.m.initial_nets.push(0.0);
        self.m.block_of_slot.push(self.block);
        self.varying.push(false);
        slot
    }

    fn level(&mut self, level: Level) -> Slot {
        match level {
            Level::Fixed(value) => {
                let slot = self.hidden();
                self.m.initial_nets[slot as usize] = value;
                slot
            }
            Level::Net(net) => self.slot(net),
        }
    }

    fn vary(&self, slots: &[Slot]) -> bool {
        slots.iter().any(|s| self.varying[*s as usize])
    }

    fn push(&mut self, op: Op, outputs: &[Slot], varying: bool) {
        for o in outputs {
            self.varying[*o as usize] |= varying;
        }
        self.m.settle.push(Settle::Op(op));
        if varying {
            self.fast.push(op);
            self.block_of_fast.push(self.block);
        }
    }

    fn store_terms(&mut self, terms: &[Term]) -> (u32, u32) {
        let start = self.m.terms.len() as u32;
        self.m.terms.extend_from_slice(terms);
        (start, terms.len() as u32)
    }

    /// `o = Σ terms`.
    fn sum_into(&mut self, o: Slot, terms: &[Term]) {
        let slots: Vec<Slot> = terms.iter().map(|t| t.slot).collect();
        let varying = self.vary(&slots);
        let op = match *terms {
            [a] => Op::Sum1 { o, a: a.slot, ca: a.c },
            [a, b] => Op::Sum2 { o, a: a.slot, b: b.slot, ca: a.c, cb: b.c },
            [a, b, d] => Op::Sum3 { o, a: a.slot, b: b.slot, d: d.slot, ca: a.c, cb: b.c, cd: d.c },
            _ => {
                let (start, len) = self.store_terms(terms);
                Op::SumN { o, start, len }
            }
        };
        self.push(op, &[o], varying);
    }

    /// One term that carries `Σ inputs`, through a hidden net where there are several.
    fn sum(&mut self, inputs: &[Input]) -> Term {
        if let [one] = inputs {
            return self.term(one);
        }
        let slot = self.hidden();
        self.sum_into(slot, &self.terms(inputs));
        Term { slot, c: 1.0 }
    }

    /// `o = factor · Σ`.
    fn weighted(&mut self, o: Slot, block: &Block, factor: f64) {
        self.sum_into(o, &scaled(self.terms(&block.inputs), factor));
    }

    /// `o` by an operation on `Σ` alone.
    fn through(&mut self, o: Slot, block: &Block, op: impl FnOnce(Term) -> Op) {
        let u = self.sum(&block.inputs);
        let varying = self.vary(&[u.slot]);
        self.push(op(u), &[o], varying);
    }

    /// The inputs of a kind that takes so many.
    fn exactly<const N: usize>(&self, inputs: &[Input]) -> [Term; N] {
        std::array::from_fn(|i| self.term(&inputs[i]))
    }

    /// Adds an element and its decision; `reads` are the nets of its sides.
    fn element(&mut self, element: Piecewise, reads: &[Slot]) -> u32 {
        let e = self.m.elements.len() as u32;
        self.m.elements.push((self.block, element));
        self.m.settle.push(Settle::Decide(e));
        if self.vary(reads) {
            self.m.watched.push(e);
            self.watched.push(reads.to_vec());
        }
        e
    }

    /// `o = curve(u)`.
    fn curve_into(&mut self, o: Slot, u: Term, corners: &[f64], pieces: &[Piece]) -> Curve {
        let curve = Curve {
            u,
            start: self.m.breakpoints.len() as u32,
            len: corners.len() as u32,
            pieces: self.m.initial_pieces.len() as u32,
            band: band(corners),
        };
        self.m.breakpoints.extend_from_slice(corners);
        self.m.initial_pieces.extend_from_slice(pieces);
        let e = self.element(Piecewise::Curve(curve), &[u.slot]);
        let varying = self.vary(&[u.slot]);
        self.push(Op::Curve { o, e, a: u.slot, c: u.c }, &[o], varying);
        curve
    }

    /// The sine of an angle as a term, its cosine in the net after that; resolvers share them.
    fn sine_of(&mut self, angle: Term) -> Term {
        let c = angle.c.abs();
        let known = self.angles.iter().find(|a| (a.0, a.1) == (angle.slot, c));
        let slot = match known {
            Some(known) => known.2,
            None => {
                let (o, a) = (self.hidden(), angle.slot);
                let cosine = self.hidden();
                let varying = self.vary(&[a]);
                self.push(Op::SinCos { o, a, c }, &[o, cosine], varying);
                self.angles.push((a, c, o));
                o
            }
        };
        Term { slot, c: if angle.c < 0.0 { -1.0 } else { 1.0 } }
    }

    fn overload(&mut self, o: Slot, max: Option<f64>) {
        if let Some(max) = max {
            let level = OVERLOAD_FACTOR * max.abs();
            self.element(Piecewise::Overload { net: o, level }, &[o]);
        }
    }

    fn rate(&mut self, state: u32, terms: &[Term]) {
        self.rates.push((state, terms.to_vec()));
    }
}
