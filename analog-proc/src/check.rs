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
use crate::patch::{Draft, Faults, Flaw};
use engine::id::NetId;
use std::collections::HashMap;

/// Checks a draft; faults are added to those of the stages before.
pub(crate) fn check(draft: &Draft, faults: &mut Faults) {
    let netlist = &draft.netlist;
    if netlist.blocks.is_empty() && faults.is_empty() {
        let help = "add [blocks] with at least one line, such as x = { kind = \"integrator\", in = [\"-1 * x\"], ic = 1.0 }";
        faults.push(Span::default(), Flaw::NoBlocks {}, help);
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
            let help = "logic is 0 or 1; invert it with a `not` block";
            faults.push(input.span, Flaw::LogicCoefficient { net }, help);
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
        let help = format!(
            "a `comparator` makes logic of it: {{ kind = \"comparator\", in = [\"{name}\"], threshold = 0.5 }}"
        );
        faults.push(at, Flaw::AnalogForLogic { net: name, owner }, help);
    } else {
        let help = format!(
            "a `switch` makes an analog value of it: {{ kind = \"switch\", in = [\"one\", \"zero\"], control = \"{name}\" }}"
        );
        faults.push(at, Flaw::LogicForAnalog { net: name, owner }, help);
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
            let help = "give each block a channel of its own; in a sub-patch make it a parameter";
            faults.push_beside(block.span, Flaw::ChannelTwice { what, number }, help, &[earlier]);
            break;
        }
    }
}
