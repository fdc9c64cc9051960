//! The flat program of a patch: what is patched when the board is on the machine.
//!
//! An ordered net is lowered once into operations with `u32` indices into one
//! flat array of nets, whose first entries are the integrators' outputs. There
//! is no dispatch by pointer, no hashing and no allocation in a pass. The
//! program has two lists: `settle` evaluates every block and decides every
//! region (at events only); `fast` holds only what varies within a step, on
//! frozen regions, and is what the integration methods run.
//!
//! It refuses to hold any running state: that is [`Frozen`] (piecewise
//! constant) and the nets.

use crate::block::curve::Piece;
use crate::block::dac::Hold;
use crate::block::delay::DelayLine;
use crate::block::integrator::Control;
use crate::block::logic::Store;
use crate::block::piecewise::{Piecewise, UNSET};
use crate::block::source::{Noise, Timer, Waveform};
use crate::block::surface::Table;
use crate::fault::RunFault;
use crate::net::BlockId;
use crate::order::Ordered;

/// Index into the flat array of nets.
pub(crate) type Slot = u32;

/// One weighted net.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub slot: Slot,
    pub c: f64,
}

impl Term {
    #[inline(always)]
    pub fn of(self, nets: &[f64]) -> f64 {
        self.c * nets[self.slot as usize]
    }
}

/// One memoryless operation; `o` is the net it drives, other letters are nets it reads.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Op {
    Sum1 {
        o: Slot,
        a: Slot,
        ca: f64,
    },
    Sum2 {
        o: Slot,
        a: Slot,
        b: Slot,
        ca: f64,
        cb: f64,
    },
    Sum3 {
        o: Slot,
        a: Slot,
        b: Slot,
        d: Slot,
        ca: f64,
        cb: f64,
        cd: f64,
    },
    SumN {
        o: Slot,
        start: u32,
        len: u32,
    },
    /// `c·a·b`.
    Product {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `c·a/b`.
    Quotient {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `√max(c·a, 0)`: the argument's sign is a guarded surface.
    Root {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Sine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Cosine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Rotate {
        x: Slot,
        y: Slot,
        start: u32,
    },
    Arctangent {
        o: Slot,
        e: u32,
        y: Term,
        x: Term,
    },
    /// The present piece of curve `e`.
    Curve {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    /// The constant of element `e` (comparator, relay).
    Constant {
        o: Slot,
        e: u32,
    },
    DeadZone {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        w: Slot,
    },
    Limit {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        low: Slot,
        high: Slot,
    },
    /// The present extreme of the terms from `start`.
    Extreme {
        o: Slot,
        e: u32,
        start: u32,
    },
    Surface {
        o: Slot,
        e: u32,
        table: u32,
        x: Term,
        y: Term,
    },
    Friction {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    Dac {
        o: Slot,
        hold: u32,
    },
    Mdac {
        o: Slot,
        hold: u32,
        a: Slot,
        c: f64,
    },
    Dcu {
        o: Slot,
        dcu: u32,
        a: Slot,
        c: f64,
    },
    Switch {
        o: Slot,
        control: Slot,
        a: Term,
        b: Term,
    },
    Track {
        o: Slot,
        control: Slot,
        a: Slot,
        c: f64,
        store: u32,
    },
    Delay {
        o: Slot,
        line: u32,
    },
    Wave {
        o: Slot,
        wave: u32,
    },
    Time {
        o: Slot,
    },
    And {
        o: Slot,
        start: u32,
        len: u32,
    },
    Or {
        o: Slot,
        start: u32,
        len: u32,
    },
    Not {
        o: Slot,
        a: Slot,
    },
}

/// One step of settling an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Settle {
    /// Evaluate.
    Op(Op),
    /// Choose the region of an element from its inputs as they are now.
    Decide(u32),
}

/// Derivative of one integrator from one, two, three or many terms.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    pub one: Vec<(u32, Term)>,
    pub two: Vec<(u32, Term, Term)>,
    pub three: Vec<(u32, Term, Term, Term)>,
    pub many: Vec<(u32, u32, u32)>,
}

/// The immutable program.
#[derive(Clone, Debug)]
pub struct Machine {
    pub(crate) states: usize,
    pub(crate) slots: usize,
    /// Slot of each net of the netlist.
    pub(crate) slot_of_net: Vec<Slot>,
    /// State of each block, if it has one.
    pub(crate) state_of_block: Vec<Option<u32>>,
    pub(crate) block_of_slot: Vec<BlockId>,
    pub(crate) net_names: Vec<String>,
    pub(crate) block_names: Vec<String>,
    pub(crate) block_of_state: Vec<BlockId>,
    pub(crate) settle: Vec<Settle>,
    pub(crate) fast: Vec<Op>,
    pub(crate) rates: Rates,
    pub(crate) terms: Vec<Term>,
    pub(crate) ics: Vec<f64>,
    /// Scale of each state in the error norm (its `max`, or one).
    pub(crate) scales: Vec<f64>,
    /// Nets before anything is evaluated: constants, initial store outputs.
    pub(crate) initial_nets: Vec<f64>,
    pub(crate) elements: Vec<(BlockId, Piecewise)>,
    /// Elements whose inputs vary within a step.
    pub(crate) watched: Vec<u32>,
    pub(crate) breakpoints: Vec<f64>,
    pub(crate) initial_pieces: Vec<Piece>,
    pub(crate) tables: Vec<Table>,
    pub(crate) controls: Vec<Control>,
    pub(crate) stores: Vec<Store>,
    pub(crate) track_ics: Vec<f64>,
    pub(crate) timers: Vec<(Slot, Timer)>,
    pub(crate) waves: Vec<Waveform>,
    pub(crate) noises: Vec<(f64, u64)>,
    pub(crate) lines: Vec<DelayLine>,
    pub(crate) dac_channels: Vec<(u32, f64)>,
    pub(crate) dcu_channels: Vec<(u32, f64)>,
    pub(crate) digital_functions: Vec<crate::block::curve::DigitalFunction>,
    pub(crate) senses: Vec<(u32, Slot)>,
    pub(crate) control_lines: Vec<(u32, Slot)>,
    /// Greatest step that any source or delay admits, s.
    pub(crate) step_cap_s: f64,
}

/// Everything that stands still within a step and changes only at events.
#[derive(Clone, Debug)]
pub(crate) struct Frozen {
    pub region: Vec<u32>,
    /// Present piece of each element.
    pub piece: Vec<Piece>,
    /// All pieces of all curves (digital functions rewrite theirs).
    pub pieces: Vec<Piece>,
    pub holds: Vec<Hold>,
    pub dcus: Vec<f64>,
    pub tracked: Vec<f64>,
    pub tracking: Vec<bool>,
    pub started: Vec<bool>,
    pub running: Vec<bool>,
    /// Input of each store at the last settling, for edges.
    pub previous: Vec<f64>,
    /// Next instant of each timer, s.
    pub timer_s: Vec<f64>,
    pub timer_count: Vec<u64>,
    pub noises: Vec<Noise>,
    pub lines: Vec<DelayLine>,
}

impl Machine {
    /// Lowers an ordered net.
    ///
    /// # Errors
    /// [`RunFault::Malformed`] for a block with missing inputs or an empty table,
    /// which the checker refuses with a better message.
    pub fn new(ordered: &Ordered) -> Result<Machine, RunFault> {
        crate::block::lower(ordered)
    }

    /// Number of integrators, those inside lags, followers and backlashes included.
    #[must_use]
    pub fn states(&self) -> usize {
        self.states
    }

    /// Number of operations in one derivative pass, derivatives included.
    #[must_use]
    pub fn operations(&self) -> usize {
        self.fast.len() + self.states
    }

    pub(crate) fn frozen(&self) -> Frozen {
        Frozen {
            region: vec![UNSET; self.elements.len()],
            piece: vec![Piece::default(); self.elements.len()],
            pieces: self.initial_pieces.clone(),
            holds: self.dac_channels.iter().map(|d| Hold::at(d.1)).collect(),
            dcus: self.dcu_channels.iter().map(|d| d.1).collect(),
            tracked: self.track_ics.clone(),
            tracking: vec![false; self.track_ics.len()],
            started: vec![false; self.waves.len()],
            running: vec![true; self.controls.len()],
            previous: vec![0.0; self.stores.len() + self.controls.len()],
            timer_s: vec![f64::INFINITY; self.timers.len()],
            timer_count: vec![0; self.timers.len()],
            noises: self.noises.iter().map(|n| Noise::new(n.0, n.1)).collect(),
            lines: self.lines.clone(),
        }
    }

    pub(crate) fn block_name(&self, block: BlockId) -> String {
        self.block_names[block.index()].clone()
    }

    /// Derivatives `d` of the states at `t_s`, with the states already in `nets[..states]`;
    /// brings every varying net up to date.
    #[inline]
    pub(crate) fn derivatives(&self, f: &Frozen, t_s: f64, nets: &mut [f64], d: &mut [f64]) {
        self.run(&self.fast, f, t_s, nets);
        for &(s, a) in &self.rates.one {
            d[s as usize] = a.of(nets);
        }
        for &(s, a, b) in &self.rates.two {
            d[s as usize] = a.of(nets) + b.of(nets);
        }
        for &(s, a, b, c) in &self.rates.three {
            d[s as usize] = a.of(nets) + b.of(nets) + c.of(nets);
        }
        for &(s, start, len) in &self.rates.many {
            d[s as usize] = self.sum(start, len, nets);
        }
        for (control, &running) in self.controls.iter().zip(&f.running) {
            if !running {
                d[control.state as usize] = 0.0;
            }
        }
    }

    /// The varying nets at `t_s`, without derivatives.
    pub(crate) fn outputs(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        self.run(&self.fast, f, t_s, nets);
    }

    #[inline(always)]
    fn sum(&self, start: u32, len: u32, nets: &[f64]) -> f64 {
        let terms = &self.terms[start as usize..(start + len) as usize];
        terms.iter().map(|term| term.of(nets)).sum()
    }

    #[inline]
    fn run(&self, ops: &[Op], f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for op in ops {
            self.evaluate(op, f, t_s, nets);
        }
    }

    /// Evaluates one operation.
    #[inline(always)]
    pub(crate) fn evaluate(&self, op: &Op, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        match *op {
            Op::Sum1 { o, a, ca } => net!(o) = ca * net!(a),
            Op::Sum2 { o, a, b, ca, cb } => net!(o) = ca * net!(a) + cb * net!(b),
            Op::Sum3 {
                o,
                a,
                b,
                d,
                ca,
                cb,
                cd,
            } => {
                net!(o) = ca * net!(a) + cb * net!(b) + cd * net!(d);
            }
            Op::SumN { o, start, len } => net!(o) = self.sum(start, len, nets),
            Op::Product { o, a, b, c } => net!(o) = c * net!(a) * net!(b),
            Op::Quotient { o, a, b, c } => net!(o) = c * net!(a) / net!(b),
            Op::Root { o, a, c } => net!(o) = root(c * net!(a)),
            Op::Sine { o, a, c } => net!(o) = (c * net!(a)).sin(),
            Op::Cosine { o, a, c } => net!(o) = (c * net!(a)).cos(),
            Op::Rotate { x, y, start } => {
                let i = start as usize;
                let (u, v) = (self.terms[i].of(nets), self.terms[i + 1].of(nets));
                let (sin, cos) = self.terms[i + 2].of(nets).sin_cos();
                net!(x) = u * cos - v * sin;
                net!(y) = u * sin + v * cos;
            }
            Op::Arctangent { o, e, y, x } => {
                let (y, x) = (y.of(nets), x.of(nets));
                net!(o) = crate::block::function::arctangent(y, x, f.region[e as usize]);
            }
            Op::Curve { o, e, a, c } => net!(o) = f.piece[e as usize].at(c * net!(a)),
            Op::Constant { o, e } => net!(o) = f.piece[e as usize].y0,
            Op::DeadZone { o, e, a, c, w } => {
                net!(o) = match f.region[e as usize] {
                    0 => c * net!(a) + net!(w),
                    1 => 0.0,
                    _ => c * net!(a) - net!(w),
                };
            }
            Op::Limit {
                o,
                e,
                a,
                c,
                low,
                high,
            } => {
                net!(o) = match f.region[e as usize] {
                    0 => net!(low),
                    1 => c * net!(a),
                    _ => net!(high),
                };
            }
            Op::Extreme { o, e, start } => {
                net!(o) = self.terms[(start + f.region[e as usize]) as usize].of(nets);
            }
            Op::Surface { o, e, table, x, y } => {
                let (x, y) = (x.of(nets), y.of(nets));
                net!(o) = self.tables[table as usize].at(f.region[e as usize], x, y);
            }
            Op::Friction { o, e, a, c } => {
                net!(o) = if f.region[e as usize] == crate::block::friction::STUCK {
                    -c * net!(a)
                } else {
                    f.piece[e as usize].y0
                };
            }
            Op::Dac { o, hold } => net!(o) = f.holds[hold as usize].at_time(t_s),
            Op::Mdac { o, hold, a, c } => {
                net!(o) = f.holds[hold as usize].at_time(t_s) * c * net!(a);
            }
            Op::Dcu { o, dcu, a, c } => net!(o) = f.dcus[dcu as usize] * c * net!(a),
            Op::Switch { o, control, a, b } => {
                net!(o) = if net!(control) != 0.0 {
                    a.of(nets)
                } else {
                    b.of(nets)
                };
            }
            Op::Track {
                o,
                control,
                a,
                c,
                store,
            } => {
                net!(o) = if net!(control) != 0.0 {
                    c * net!(a)
                } else {
                    f.tracked[store as usize]
                };
            }
            Op::Delay { o, line } => net!(o) = f.lines[line as usize].read(t_s),
            Op::Wave { o, wave } => {
                let w = &self.waves[wave as usize];
                net!(o) = w.at(t_s, f.started[wave as usize]);
            }
            Op::Time { o } => net!(o) = t_s,
            Op::And { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = f64::from(terms.iter().all(|term| net!(term.slot) != 0.0));
            }
            Op::Or { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = f64::from(terms.iter().any(|term| net!(term.slot) != 0.0));
            }
            Op::Not { o, a } => net!(o) = f64::from(net!(a) == 0.0),
        }
    }
}

/// Square root of the positive part, NaN kept.
#[inline(always)]
fn root(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x.sqrt() }
}
