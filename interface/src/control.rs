//! The slow control plane: patch upload, parameters, ICs, modes, read-back.
//!
//! One request, one reply, bincode on the wire. Nothing here crosses during a
//! frame; while a run operates only frames flow.

use crate::{Tick, frame::Updates, profile::Profile};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A patch with every file that it uses, so that the analog side needs no file system.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PatchBundle {
    /// Name of the root file, a key of `files`.
    pub root: String,
    /// Path (as written in `use`, relative to the root's folder) and text of each file.
    pub files: Vec<(String, String)>,
}

impl PatchBundle {
    /// SHA-256 of the root's name and every file by name, hexadecimal; each text is
    /// preceded by its length, so that no two bundles share their bytes. The order in
    /// which the files are listed does not matter.
    pub fn hash(&self) -> String {
        let mut sha = Sha256::new();
        let mut text = |text: &str| {
            sha.update((text.len() as u64).to_le_bytes());
            sha.update(text.as_bytes());
        };
        text(&self.root);
        let mut files: Vec<&(String, String)> = self.files.iter().collect();
        files.sort();
        for (path, contents) in files {
            text(path);
            text(contents);
        }
        sha.finalize().iter().map(|b| format!("{b:02x}")).collect()
    }
}

/// What one OPERATE period is to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunSpec {
    /// Frame period T.
    pub frame: Tick,
    /// Total latency τ from sample to transfer, `0 ≤ τ ≤ T`.
    pub latency: Tick,
    /// Multiplexer skew δ between neighbouring ADC channels.
    pub skew: Tick,
    /// Problem time at which the run ends; need not be a multiple of T.
    pub stop: Tick,
    /// Start from the ICs (true) or go on from the held state (false).
    pub from_ic: bool,
    /// Who says when updates take effect.
    pub clock: Clock,
}

/// The checkpoints of an OPERATE period in lock-step, at which both sides keep their states.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Checkpoints {
    /// Frames from one to the next; not zero.
    pub every: u64,
    /// The state that the period goes on from, in place of a start.
    pub from: Option<AnalogState>,
}

/// The analog side before the samples of a frame are told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnalogState {
    /// That frame.
    pub frame: u64,
    /// What the analog side alone can read.
    pub bytes: Vec<u8>,
}

impl Checkpoints {
    /// The frame that the period begins with.
    pub fn first(&self) -> u64 {
        self.from.as_ref().map_or(0, |state| state.frame)
    }

    /// Whether the states are kept before the samples of `frame`.
    pub fn due(&self, frame: u64) -> bool {
        frame > self.first() && frame.is_multiple_of(self.every)
    }
}

/// Who says when an update takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Clock {
    /// Lock-step: at `t_n + τ`, whatever the wall clock says.
    LockStep,
    /// Free-running: the analog side is paced by the wall clock and stamps each transfer.
    Wall {
        /// The processor that both sides share, where there is none to spare.
        processor: Option<u32>,
    },
    /// At the recorded ticks that the updates carry.
    Replay,
}

/// Runs of the loaded patch that the digital side only reads (iterative operation): each starts
/// from the machine as it stands with settings of its own, so that none knows of another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Sampling interval.
    pub every: Tick,
    /// ADC channels to be recorded.
    pub adc: Vec<u32>,
    /// What is run.
    pub cases: Vec<SweepCase>,
}

/// One run of a [`Sweep`], from its initial conditions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepCase {
    /// Initial conditions by integrator name.
    pub ics: Vec<(String, f64)>,
    /// DACs, DCUs and control lines.
    pub preset: Updates,
    /// Problem time at which it ends.
    pub stop: Tick,
}

/// What a run of a [`Sweep`] came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptRun {
    /// Samples at 0, `every`, … and the stop, the asked channels of one instant after another; of
    /// a faulted run those before the fault.
    pub samples: Vec<f64>,
    /// Whether a converter or coefficient unit was driven beyond its range.
    pub saturated: bool,
    /// Latched overloads in order of time.
    pub overloads: Vec<Overload>,
    /// When and why it stopped by itself, if it did.
    pub fault: Option<(Tick, String)>,
}

/// The loaded patch made linear about where it stands: ẋ = A x + B u, y = C x + D u, per second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinearModel {
    /// The block of each state.
    pub states: Vec<String>,
    /// States by states, a row a state, row after row.
    pub a: Vec<f64>,
    /// States by inputs.
    pub b: Vec<f64>,
    /// Outputs by states.
    pub c: Vec<f64>,
    /// Outputs by inputs.
    pub d: Vec<f64>,
}

/// Role of a converter, coefficient or line in the loaded patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ChannelKind {
    /// Sampled analog net.
    Adc,
    /// Signal set by the digital side (DAC or MDAC).
    Dac,
    /// Coefficient set by the digital side.
    Dcu,
    /// Logic, analog to digital.
    Sense,
    /// Logic, digital to analog.
    Control,
    /// Comparator edge with its located time.
    Interrupt,
}

/// One channel of the loaded patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    pub kind: ChannelKind,
    /// Block name in the patch, by which the digital side finds it.
    pub name: String,
    /// Channel or line number.
    pub number: u32,
    /// Full scale in problem units (the block's `max`), if stated.
    pub full_scale: Option<f64>,
}

/// A request of the digital side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "a few requests a session; a box would burden every caller"
)]
pub enum Request {
    /// First request of a session: both sides compare these.
    Hello {
        /// Protocol version.
        version: u32,
        /// Hash of the frame layouts.
        layout_hash: u64,
    },
    /// Compiles and loads a patch; the machine goes to IC.
    Load {
        /// The patch and its sub-patches.
        bundle: PatchBundle,
        /// Values for `[params]` entries, overriding the patch's own.
        params: Vec<(String, f64)>,
        /// The machine profile.
        profile: Profile,
    },
    /// Pot-set: new values for `[params]` entries; the machine goes to IC.
    SetParams(Vec<(String, f64)>),
    /// New initial conditions by integrator name; the machine goes to IC.
    SetIcs(Vec<(String, f64)>),
    /// Sets DACs, DCUs and control lines while not operating.
    Preset(Updates),
    /// Values of nets now (in IC or HOLD).
    Read(Vec<String>),
    /// Outputs and derivatives at IC against the values expected in the patch.
    StaticCheck,
    /// Starts a run; frames follow until `Ended` or `Faulted`.
    Operate(RunSpec),
    /// The same with checkpoints, or from one.
    OperateKept(RunSpec, Checkpoints),
    /// The state of the analog side, in a frame in which a checkpoint is due.
    Checkpoint,
    /// Many runs without a frame crossing; afterwards the machine stands as before.
    Sweep(Sweep),
    /// The linear model about the present state, by names of nets; an input stands for whatever
    /// drives its net.
    Linearise {
        /// Inputs u.
        inputs: Vec<String>,
        /// Outputs y.
        outputs: Vec<String>,
    },
    /// Text of the fault that ended the last run, and latched overloads.
    Diagnose,
    /// Ends the session.
    Bye,
}

/// One overloaded block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overload {
    /// Block name.
    pub block: String,
    /// Located time of the first excess, s.
    pub time_s: f64,
    /// Value at that time, problem units.
    pub value: f64,
}

/// One line of a static check.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticCheckLine {
    /// Block name.
    pub block: String,
    /// `output` or `derivative`.
    pub what: String,
    /// Expected value, problem units.
    pub expected: f64,
    /// Computed value, problem units.
    pub found: f64,
    /// Whether they agree within the patch's tolerance.
    pub agrees: bool,
}

/// The analog side's answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// Handshake accepted, with the analog side's own values.
    Hello {
        /// Protocol version.
        version: u32,
        /// Hash of the frame layouts.
        layout_hash: u64,
    },
    /// The patch is loaded.
    Loaded {
        /// SHA-256 of the bundle, hexadecimal.
        patch_hash: String,
        /// Every channel of the patch.
        channels: Vec<Channel>,
    },
    Done,
    /// Net values in the order asked.
    Values(Vec<f64>),
    /// Static check result.
    StaticCheck(Vec<StaticCheckLine>),
    /// The runs of a sweep, in the order of its cases.
    Swept(Vec<SweptRun>),
    /// The linear model.
    Linear(LinearModel),
    /// The state of the analog side; empty where the run ends in this frame.
    Checkpoint(Vec<u8>),
    /// What ended the last run, and overloads.
    Diagnosis {
        /// Fault text, if the last run faulted.
        fault: Option<String>,
        /// Latched overloads in order of time.
        overloads: Vec<Overload>,
    },
    /// The request was refused; the text is ready to be shown (may be several lines).
    Refused(String),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bundle_is_named_by_its_texts_not_by_their_order() {
        let bundle = |root: &str, files: &[(&str, &str)]| PatchBundle {
            root: root.to_owned(),
            files: files
                .iter()
                .map(|(name, text)| ((*name).to_owned(), (*text).to_owned()))
                .collect(),
        };
        let reference = bundle("a", &[("a", "x"), ("b", "y")]).hash();
        assert_eq!(reference.len(), 64);
        assert_eq!(reference, bundle("a", &[("b", "y"), ("a", "x")]).hash());
        assert_ne!(reference, bundle("a", &[("a", "y"), ("b", "x")]).hash());
        assert_ne!(bundle("a", &[("a", "x")]).hash(), bundle("a", &[("ax", "")]).hash());
    }
}
