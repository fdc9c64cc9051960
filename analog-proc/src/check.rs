//! Third stage: the typed net as a machine would see it.
//!
//! Checks what one block cannot know of itself: that logic is wired to logic
//! and analog to analog, that no two blocks claim a channel, that there is
//! anything at all, and that a machine profile has the blocks. Closed paths are
//! the business of [`crate::order`].

mod supply;

pub use supply::{against_profile, needs};

use crate::block::kind::linkage;
use crate::net::{Block, Span};
use crate::patch::{Draft, Faults, PatchFault};
use engine::id::NetId;
use miette::LabeledSpan;
use std::collections::HashMap;

/// Checks a draft; faults are added to those of the stages before.
pub(crate) fn check(draft: &Draft, faults: &mut Faults) {
    let netlist = &draft.netlist;
    if netlist.blocks.is_empty() && faults.is_empty() {
        faults.push(Span::default(), |src, at| PatchFault::NoBlocks {
            src,
            at,
            help: "add [blocks] with at least one line, such as x = { kind = \"integrator\", in = [\"-1 * x\"], ic = 1.0 }".into(),
        });
    }
    for (index, block) in netlist.blocks.iter().enumerate() {
        if !draft.broken[index] {
            wiring(block, draft, faults);
        }
    }
    channels(draft, faults);
}

/// Logic to logic, analog to analog.
fn wiring(block: &Block, draft: &Draft, faults: &mut Faults) {
    let wants_logic = block.kind.facts().takes_logic;
    for input in &block.inputs {
        expect(wants_logic, input.net, input.span, block, draft, faults);
        if wants_logic && input.coefficient != 1.0 {
            let net = draft.netlist.nets[input.net.index()].name.clone();
            faults.push(input.span, |src, at| PatchFault::LogicCoefficient {
                src,
                at,
                net,
                help: "logic is 0 or 1; invert it with a `not` block".into(),
            });
        }
    }
    for side in block.kind.component().sides() {
        expect(side.is_logic, side.net, block.span, block, draft, faults);
    }
}

fn expect(
    wants_logic: bool,
    net: NetId,
    at: Span,
    block: &Block,
    draft: &Draft,
    faults: &mut Faults,
) {
    let net = &draft.netlist.nets[net.index()];
    let driver = net.driver.index();
    // A broken driver is a stand-in; what it drives is not known.
    if draft.broken[driver] || draft.netlist.blocks[driver].kind.is_logic() == wants_logic {
        return;
    }
    let (name, owner) = (net.name.clone(), format!("`{}`", block.name));
    if wants_logic {
        faults.push(at, |src, at| PatchFault::AnalogForLogic {
            src,
            at,
            help: format!("a `comparator` makes logic of it: {{ kind = \"comparator\", in = [\"{name}\"], threshold = 0.5 }}"),
            net: name,
            owner,
        });
    } else {
        faults.push(at, |src, at| PatchFault::LogicForAnalog {
            src,
            at,
            help: format!("a `switch` makes an analog value of it: {{ kind = \"switch\", in = [\"one\", \"zero\"], control = \"{name}\" }}"),
            net: name,
            owner,
        });
    }
}

fn channels(draft: &Draft, faults: &mut Faults) {
    let mut taken: HashMap<(&str, u32), Span> = HashMap::new();
    for (block, broken) in draft.netlist.blocks.iter().zip(&draft.broken) {
        let Some(claim) = block.kind.component().claim().filter(|_| !broken) else {
            continue;
        };
        let (what, _) = linkage(claim.kind);
        for (number, _) in (claim.first..).zip(&claim.initial) {
            let Some(earlier) = taken.insert((what, number), block.span) else {
                continue;
            };
            let is_same_file = earlier.file == block.span.file && earlier != block.span;
            let start = earlier.start as usize;
            let length = (earlier.end - earlier.start) as usize;
            let first = is_same_file.then(|| LabeledSpan::new(None, start, length));
            faults.push(block.span, |src, at| PatchFault::ChannelTwice {
                src,
                at,
                what,
                number,
                first: first.into_iter().collect(),
                help: "give each block a channel of its own; in a sub-patch make it a parameter"
                    .into(),
            });
            break;
        }
    }
}
