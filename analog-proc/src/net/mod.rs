//! The typed net: what a patch means, after names are resolved and before it is checked.
//!
//! Blocks and nets are indices; names and spans are kept only for messages and
//! read-back. One block drives one net of the same name (a resolver drives two).
//! All numbers are in problem units; parameters are already put in.

pub use crate::block::kind::{Kind, Wave};
use desk::faults::suggestion;
pub use desk::reader::Span;
use engine::{
    id::{BlockId, NetId},
    integration::Integration,
};

/// A level that is fixed in the patch or follows a net.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// A number.
    Fixed(f64),
    /// The present value of a net.
    Net(NetId),
}

/// One weighted input: `coefficient · net`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// The net that is read.
    pub net: NetId,
    /// Its coefficient.
    pub coefficient: f64,
    /// Where it stands in the patch.
    pub span: Span,
}

/// One block.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Full name, with the prefixes of its sub-patches.
    pub name: String,
    /// Where it stands in the patch.
    pub span: Span,
    /// What it does.
    pub kind: Kind,
    /// Weighted inputs, in order.
    pub inputs: Vec<Input>,
    /// Nets it drives (one; two for a resolver).
    pub outputs: Vec<NetId>,
    /// Scale factor `max`, problem units at full scale.
    pub max: Option<f64>,
}

/// One net.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// Name.
    pub name: String,
    /// The block that drives it.
    pub driver: BlockId,
}

/// Values that the static check compares with.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// The net.
    pub net: NetId,
    /// Output at IC.
    pub output: Option<f64>,
    /// Derivative at IC (integrators).
    pub derivative: Option<f64>,
    /// Absolute tolerance, problem units.
    pub tolerance: f64,
}

/// A whole patch, names resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Netlist {
    /// Title of the root file.
    pub title: String,
    /// Blocks in patch order.
    pub blocks: Vec<Block>,
    /// Nets.
    pub nets: Vec<Net>,
    /// Integration settings.
    pub integration: Integration,
    /// Static-check expectations.
    pub expected: Vec<Expected>,
    /// Parameters after overriding, by name (root file only).
    pub params: Vec<(String, f64)>,
}

impl Netlist {
    /// The net of that name, or what to write instead.
    pub fn net(&self, name: &str) -> Result<NetId, String> {
        let place = self.nets.iter().position(|net| net.name == name);
        place.map(|i| NetId(i as u32)).ok_or_else(|| {
            let help = suggestion(name, self.nets.iter().map(|net| net.name.as_str()));
            format!("the patch has no net `{name}`; {help}")
        })
    }
}
