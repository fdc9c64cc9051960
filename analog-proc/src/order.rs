//! Net → ordered: an evaluation order in which every net is computed before it is read.
//!
//! A block that passes its inputs on within the instant (direct feedthrough)
//! comes after those it reads; a store comes first, since its output does not
//! depend on anything at that instant. A closed path without a store has no
//! such order: it is an algebraic loop, and is shown whole.

use crate::net::{Block, Netlist, Span};
use crate::patch::{Draft, Faults, Flaw, PatchFaults, Sources};
use engine::id::BlockId;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// A net without faults, with its evaluation order. Only compiling makes one.
#[derive(Clone, Debug)]
pub struct Ordered {
    /// The net.
    pub netlist: Netlist,
    /// Blocks in order of evaluation: stores first, then each block after those it reads.
    pub order: Vec<BlockId>,
    /// Files of the patch, for messages of later checks. Private, so that nothing else makes an `Ordered`.
    sources: Sources,
    root: String,
    notes: Vec<(BlockId, String)>,
}

impl Ordered {
    /// Files of the patch, for messages.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Name of the root file.
    pub fn root(&self) -> &str {
        &self.root
    }

    /// The `note` of a block.
    pub fn note(&self, block: BlockId) -> Option<&str> {
        let at = self.notes.binary_search_by_key(&block, |(id, _)| *id);
        at.ok().map(|at| self.notes[at].1.as_str())
    }
}

/// An edge of direct feedthrough into a block: from which block, and where it is written.
struct Edge {
    from: usize,
    span: Span,
}

/// Orders a net, or gives all faults, its loops among them.
pub(crate) fn order(draft: Draft, mut faults: Faults) -> Result<Ordered, PatchFaults> {
    let netlist = draft.netlist;
    let into: Vec<Vec<Edge>> = netlist
        .blocks
        .iter()
        .enumerate()
        .map(
            |(index, block)| {
                if draft.broken[index] { Vec::new() } else { feedthrough(block, &netlist) }
            },
        )
        .collect();
    let order = sort(&netlist, &into);
    if order.len() < netlist.blocks.len() {
        for component in components(&into) {
            report_loop(&component, &into, &netlist, &mut faults);
        }
    }
    let sources = faults.sources.clone();
    let root = faults.root().to_owned();
    faults.into_result()?;
    Ok(Ordered { netlist, order, sources, root, notes: draft.notes })
}

fn feedthrough(block: &Block, netlist: &Netlist) -> Vec<Edge> {
    if block.kind.is_store() {
        return Vec::new();
    }
    let inputs = block.inputs.iter().map(|input| (input.net, input.span));
    let sides = block.kind.component().sides().into_iter();
    inputs
        .chain(sides.map(|side| (side.net, block.span)))
        .map(|(net, span)| Edge { from: netlist.nets[net.index()].driver.index(), span })
        .collect()
}

/// Stores first, then whatever is ready, each time the one that stands first in the patch.
/// Shorter than the net if there are loops.
fn sort(netlist: &Netlist, into: &[Vec<Edge>]) -> Vec<BlockId> {
    let mut waits_for: Vec<usize> = into.iter().map(Vec::len).collect();
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); into.len()];
    for (reader, edges) in into.iter().enumerate() {
        for edge in edges {
            readers[edge.from].push(reader);
        }
    }
    let id = |index: usize| BlockId(u32::try_from(index).unwrap_or(u32::MAX));
    let mut order = Vec::with_capacity(into.len());
    let mut ready: BinaryHeap<Reverse<usize>> = BinaryHeap::new();
    let (stores, others): (Vec<usize>, Vec<usize>) =
        (0..into.len()).partition(|index| netlist.blocks[*index].kind.is_store());
    ready.extend(others.into_iter().filter(|i| waits_for[*i] == 0).map(Reverse));
    let mut release = |done: usize, ready: &mut BinaryHeap<Reverse<usize>>| {
        for &reader in &readers[done] {
            waits_for[reader] -= 1;
            if waits_for[reader] == 0 {
                ready.push(Reverse(reader));
            }
        }
    };
    for store in stores {
        order.push(id(store));
        release(store, &mut ready);
    }
    while let Some(Reverse(next)) = ready.pop() {
        order.push(id(next));
        release(next, &mut ready);
    }
    order
}

/// Strongly connected components that hold a cycle (Tarjan, without recursion).
fn components(into: &[Vec<Edge>]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let count = into.len();
    let (mut index, mut low) = (vec![UNSEEN; count], vec![0; count]);
    let mut on_stack = vec![false; count];
    let (mut stack, mut found, mut next) = (Vec::new(), Vec::new(), 0);
    for root in 0..count {
        if index[root] != UNSEEN {
            continue;
        }
        let mut path: Vec<(usize, usize)> = vec![(root, 0)];
        while let Some(&mut (node, ref mut edge)) = path.last_mut() {
            if *edge == 0 {
                index[node] = next;
                low[node] = next;
                next += 1;
                stack.push(node);
                on_stack[node] = true;
            }
            if let Some(to) = into[node].get(*edge).map(|e| e.from) {
                *edge += 1;
                if index[to] == UNSEEN {
                    path.push((to, 0));
                } else if on_stack[to] {
                    low[node] = low[node].min(index[to]);
                }
                continue;
            }
            path.pop();
            if let Some(&(parent, _)) = path.last() {
                low[parent] = low[parent].min(low[node]);
            }
            if low[node] == index[node] {
                let at = stack.iter().rposition(|n| *n == node).unwrap_or(0);
                let mut component = stack.split_off(at);
                component.iter().for_each(|n| on_stack[*n] = false);
                component.sort_unstable();
                let is_loop =
                    component.len() > 1 || into[node].iter().any(|edge| edge.from == node);
                if is_loop {
                    found.push(component);
                }
            }
        }
    }
    found.sort();
    found
}

/// The shortest cycle through the first block of a component, in the direction of the signal.
fn shortest_cycle(component: &[usize], into: &[Vec<Edge>]) -> Vec<usize> {
    let first = component[0];
    // Backwards over the edges: `reader[b]` is the block that reads b on the way to `first`.
    let mut reader = std::collections::HashMap::new();
    let mut queue = VecDeque::from([first]);
    while let Some(node) = queue.pop_front() {
        for edge in &into[node] {
            if edge.from == first {
                let mut cycle = vec![first];
                let mut at = node;
                while at != first {
                    cycle.push(at);
                    at = reader[&at];
                }
                return cycle;
            }
            if component.binary_search(&edge.from).is_ok() && !reader.contains_key(&edge.from) {
                reader.insert(edge.from, node);
                queue.push_back(edge.from);
            }
        }
    }
    vec![first]
}

fn report_loop(component: &[usize], into: &[Vec<Edge>], netlist: &Netlist, faults: &mut Faults) {
    /// A cycle longer than this is cut in the message.
    const SHOWN: usize = 30;
    let cycle = shortest_cycle(component, into);
    let name = |block: usize| netlist.blocks[block].name.as_str();
    let mut steps = Vec::new();
    let mut spans = Vec::new();
    for (place, &from) in cycle.iter().enumerate() {
        let to = cycle[(place + 1) % cycle.len()];
        let Some(edge) = into[to].iter().find(|edge| edge.from == from) else {
            continue;
        };
        spans.push(edge.span);
        let (line, _) = faults.sources.line_column(edge.span);
        let file = faults.sources.name(edge.span.file);
        let text = faults.sources.text(edge.span);
        steps.push(format!("  {} → {}   ({file}:{line}, {text})", name(from), name(to)));
    }
    let mut names: Vec<&str> = cycle.iter().take(SHOWN).map(|b| name(*b)).collect();
    if cycle.len() > SHOWN {
        names.push("…");
        let hidden = steps.len() - SHOWN;
        steps.truncate(SHOWN);
        steps.push(format!("  … and {hidden} more"));
    }
    names.push(name(cycle[0]));
    let chain = names.join(" → ");
    let is_logic = cycle.iter().all(|b| netlist.blocks[*b].kind.is_logic());
    let others = component.len() - cycle.len();
    let more = match others {
        0 => String::new(),
        n => format!("\n{n} more blocks lie on loops through these."),
    };
    let advice = if is_logic {
        "No gate can settle before the others. Put a `flip-flop` or a `one-shot` into the path."
    } else {
        "Every block here answers within the instant, so none can be computed first. Solve the equation by hand and patch its solution, or put the store that the real system has into the path (an `integrator`, or a `lag` with its true time constant)."
    };
    let help = format!("the whole loop:\n{}{more}\n{advice}", steps.join("\n"));
    let Some(&at) = spans.iter().min_by_key(|span| (span.file, span.start)) else {
        return;
    };
    let cycle = chain;
    let flaw = if is_logic { Flaw::LogicLoop { cycle } } else { Flaw::AlgebraicLoop { cycle } };
    faults.push_beside(at, flaw, help, &spans[..spans.len().min(SHOWN)]);
}
