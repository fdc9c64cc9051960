//! Lowering: each kind of block becomes operations, elements and stores of the machine.
//!
//! What a kind becomes stands with the kind ([`kind`]); this file walks the evaluation
//! order. A compound block (lag, follower, backlash) becomes the wiring that a programmer would
//! patch for it.

pub mod kind;
mod lowering;

use self::kind::Storage;
use self::lowering::Lowering;
use crate::order::Ordered;
use engine::element::pace::{self, Pace};
use engine::id::BlockId;
use engine::kernel::{Kernel, fold};
use engine::machine::Machine;
use engine::op::{Op, behind, degrees, powers};
use engine::{fault::RunFault, simulation::Simulation};

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
            rates: Vec::new(),
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
    m.rates = rates;
    m
}
