//! The flat program of a patch: what is patched when the board is on the machine.
//!
//! An ordered net is lowered once into operations with `u32` indices into one
//! flat array of nets, whose first entries are the integrators' outputs. The
//! program has two parts: `settle` evaluates every block and decides every
//! region, at events only; `kernel` holds what varies within a step, on frozen
//! regions, and first what the derivatives depend on, which is what the
//! integration methods run.
//!
//! It refuses to hold any running state: that is [`Frozen`] (piecewise
//! constant) and the nets.

use crate::element::curve::Piece;
use crate::element::dac::Hold;
use crate::element::delay::DelayLine;
use crate::element::integrator::Control;
use crate::element::logic::Store;
use crate::element::pace::Pace;
use crate::element::piecewise::{Piecewise, UNSET};
use crate::element::source::{Noise, Timer, Waveform};
use crate::element::surface::Table;
use crate::id::BlockId;
use crate::kernel::{Kernel, Step};
use crate::op::{Op, Slot, Term};

/// One step of settling an instant.
#[derive(Clone, Copy, Debug)]
pub enum Settle {
    /// Evaluate.
    Op(Op),
    /// Choose the region of an element from its inputs as they are now.
    Decide(u32),
}

/// The immutable program. Its fields are filled by who lowers a patch.
#[allow(missing_docs)]
#[derive(Clone, Debug)]
pub struct Machine {
    pub states: usize,
    pub slots: usize,
    /// Slot of each net of the netlist.
    pub slot_of_net: Vec<Slot>,
    /// State of each block, if it has one.
    pub state_of_block: Vec<Option<u32>>,
    pub block_of_slot: Vec<BlockId>,
    pub net_names: Vec<String>,
    pub block_names: Vec<String>,
    pub block_of_state: Vec<BlockId>,
    pub settle: Vec<Settle>,
    /// What the integration methods run.
    pub kernel: Kernel,
    /// Terms of the derivative of each state, as patched.
    pub rates: Vec<(u32, Vec<Term>)>,
    pub terms: Vec<Term>,
    pub ics: Vec<f64>,
    /// Scale of each state in the error norm, where its block states one (`max`).
    pub scales: Vec<Option<f64>>,
    /// Nets before anything is evaluated: constants, initial store outputs.
    pub initial_nets: Vec<f64>,
    pub elements: Vec<(BlockId, Piecewise)>,
    /// Elements whose inputs vary within a step.
    pub watched: Vec<u32>,
    /// The first side of each element, where it is watched.
    pub first_side: Vec<Option<u32>>,
    /// The element of each side of the watched.
    pub element_of_side: Vec<u32>,
    /// How often a step is halved at least before a side is judged.
    pub halvings: Vec<u8>,
    /// Whether none is.
    pub smooth: bool,
    /// Operations that those sides, the paces and the delay lines depend on.
    pub watch: Vec<Op>,
    /// What bounds the step by its own scale, and its block.
    pub paces: Vec<(Pace, BlockId)>,
    pub breakpoints: Vec<f64>,
    pub initial_pieces: Vec<Piece>,
    pub tables: Vec<Table>,
    pub controls: Vec<Control>,
    pub stores: Vec<Store>,
    pub track_ics: Vec<f64>,
    pub timers: Vec<(Slot, Timer)>,
    pub waves: Vec<Waveform>,
    pub noises: Vec<(f64, u64)>,
    pub lines: Vec<DelayLine>,
    pub dac_channels: Vec<(u32, f64)>,
    pub dcu_channels: Vec<(u32, f64)>,
    pub digital_functions: Vec<crate::element::curve::DigitalFunction>,
    pub senses: Vec<(u32, Slot)>,
    pub control_lines: Vec<(u32, Slot)>,
    /// Greatest step that any source or delay admits, s.
    pub step_cap_s: f64,
}

/// Everything that stands still within a step and changes only at events.
#[derive(Clone, Debug)]
pub(crate) struct Frozen {
    pub region: Vec<u32>,
    /// What each watched side must exceed to count at this settling.
    pub held: Vec<f64>,
    /// Present piece of each element.
    pub piece: Vec<Piece>,
    /// All pieces of all curves (digital functions rewrite theirs).
    pub pieces: Vec<Piece>,
    pub holds: Vec<Hold>,
    /// Folded operations and weights of the rows, coefficients included.
    pub steps: Vec<Step>,
    pub weights: Vec<f64>,
    /// Nets of converters that move within a step, and their holds.
    pub moving: Vec<(Slot, u32)>,
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
    /// Number of integrators, those inside lags, followers and backlashes included.
    pub fn states(&self) -> usize {
        self.states
    }

    /// Number of folded operations and sums in one derivative pass.
    pub fn operations(&self) -> usize {
        self.kernel.operations()
    }

    pub(crate) fn frozen(&self) -> Frozen {
        Frozen {
            region: vec![UNSET; self.elements.len()],
            held: vec![0.0; self.element_of_side.len()],
            piece: vec![Piece::default(); self.elements.len()],
            pieces: self.initial_pieces.clone(),
            holds: self.dac_channels.iter().map(|d| Hold::at(d.1)).collect(),
            steps: self.kernel.steps(),
            weights: self.kernel.weights(),
            moving: Vec::with_capacity(self.dac_channels.len()),
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
}
