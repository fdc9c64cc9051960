//! The patch as a layered graph: which block stands in which column.
//!
//! Signals run from left to right; the paths that close a loop are fed back,
//! and since every loop holds a store, they can always be broken at a store's
//! input. Chains of integrators (`x = ∫v`) are kept in one piece if they can be.

use crate::net::{Block, Netlist};
use crate::order::Ordered;

/// Above this many blocks the search for the best place to break loops would take
/// too long, and every input of a store is fed back.
const MOST_SEARCHED: usize = 1500;
/// From this many blocks on, long wires are drawn as named tags at their ends.
const TAGS_FROM: usize = 30;
/// Columns that a wire may cross in a patch with tags.
const LONGEST_WIRE: usize = 2;

/// What a port is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// A summed or numbered input.
    Input,
    /// A net that a field names: mode control, level.
    Side(&'static str),
}

/// One port of a block and the net that it reads.
#[derive(Clone, Debug)]
pub(super) struct Port {
    pub(super) net: usize,
    pub(super) coefficient: f64,
    pub(super) role: Role,
    pub(super) is_logic: bool,
    /// Drawn as a named tag, not as a wire.
    pub(super) is_tag: bool,
    /// The wire runs from right to left.
    pub(super) is_back: bool,
}

/// Blocks in columns, with their ports.
#[derive(Debug)]
pub(super) struct Graph {
    /// Ports of each block.
    pub(super) ports: Vec<Vec<Port>>,
    /// Column of each block.
    pub(super) layer: Vec<usize>,
    /// Driver of each net, and which of its outputs it is.
    pub(super) driver: Vec<(usize, usize)>,
    pub(super) layers: usize,
}

pub(super) fn build(ordered: &Ordered) -> Graph {
    let netlist = &ordered.netlist;
    let driver: Vec<(usize, usize)> = netlist
        .nets
        .iter()
        .enumerate()
        .map(|(index, net)| {
            let block = &netlist.blocks[net.driver.index()];
            let output = block.outputs.iter().position(|o| o.index() == index);
            (net.driver.index(), output.unwrap_or(0))
        })
        .collect();
    let mut ports: Vec<Vec<Port>> = netlist.blocks.iter().map(|b| ports(b, netlist)).collect();
    mark_feedback(netlist, ordered, &driver, &mut ports);
    let layer = layers(ordered, &driver, &ports);
    let layers = layer.iter().max().map_or(0, |last| last + 1);
    for (block, list) in ports.iter_mut().enumerate() {
        for port in list {
            let from = layer[driver[port.net].0];
            port.is_back = from >= layer[block];
            let span = from.abs_diff(layer[block]);
            port.is_tag = netlist.blocks.len() >= TAGS_FROM && span > LONGEST_WIRE;
        }
    }
    Graph { ports, layer, driver, layers }
}

fn ports(block: &Block, netlist: &Netlist) -> Vec<Port> {
    let port = |net: usize, coefficient: f64, role: Role| Port {
        net,
        coefficient,
        role,
        is_logic: netlist.blocks[netlist.nets[net].driver.index()].kind.is_logic(),
        is_tag: false,
        is_back: false,
    };
    let mut list: Vec<Port> =
        block.inputs.iter().map(|i| port(i.net.index(), i.coefficient, Role::Input)).collect();
    list.extend(
        block
            .kind
            .component()
            .sides()
            .into_iter()
            .map(|side| port(side.net.index(), side.coefficient, Role::Side(side.mark))),
    );
    list
}

/// Keeps as many wires forward as a greedy search can, the important ones first.
fn mark_feedback(
    netlist: &Netlist,
    ordered: &Ordered,
    driver: &[(usize, usize)],
    ports: &mut [Vec<Port>],
) {
    let count = ports.len();
    let mut forward: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut soft = Vec::new();
    for (to, list) in ports.iter_mut().enumerate() {
        let is_store = netlist.blocks[to].kind.is_store();
        let inputs = list.iter().filter(|p| p.role == Role::Input).count();
        for (index, port) in list.iter_mut().enumerate() {
            let from = driver[port.net].0;
            if !is_store {
                forward[from].push(to);
                continue;
            }
            port.is_back = true;
            let is_side = port.role != Role::Input;
            let is_chain = inputs == 1 && port.coefficient > 0.0 && !is_side;
            let rank = (is_side, !is_chain, from > to);
            if from != to {
                soft.push((rank, to, index, from));
            }
        }
    }
    soft.sort_unstable();
    if ordered.netlist.blocks.len() > MOST_SEARCHED {
        return;
    }
    for (_, to, index, from) in soft {
        if !reaches(&forward, to, from) {
            forward[from].push(to);
            ports[to][index].is_back = false;
        }
    }
}

fn reaches(forward: &[Vec<usize>], from: usize, to: usize) -> bool {
    let mut seen = vec![false; forward.len()];
    let mut waiting = vec![from];
    while let Some(node) = waiting.pop() {
        if node == to {
            return true;
        }
        if !std::mem::replace(&mut seen[node], true) {
            waiting.extend(&forward[node]);
        }
    }
    false
}

/// Longest path from the left; sources then move next to their first reader.
fn layers(ordered: &Ordered, driver: &[(usize, usize)], ports: &[Vec<Port>]) -> Vec<usize> {
    let count = ports.len();
    let mut readers: Vec<Vec<usize>> = vec![Vec::new(); count];
    let mut waits = vec![0usize; count];
    for (to, list) in ports.iter().enumerate() {
        for port in list.iter().filter(|p| !p.is_back) {
            readers[driver[port.net].0].push(to);
            waits[to] += 1;
        }
    }
    let mut layer = vec![0usize; count];
    let mut ready: Vec<usize> =
        ordered.order.iter().map(|b| b.index()).filter(|b| waits[*b] == 0).collect();
    while let Some(node) = ready.pop() {
        for &to in &readers[node] {
            layer[to] = layer[to].max(layer[node] + 1);
            waits[to] -= 1;
            if waits[to] == 0 {
                ready.push(to);
            }
        }
    }
    for node in 0..count {
        let has_forward_input = ports[node].iter().any(|p| !p.is_back);
        let nearest = readers[node].iter().map(|to| layer[*to]).min();
        if let Some(nearest) = nearest.filter(|n| !has_forward_input && *n > 0) {
            // A store that is only fed back may move too: its feedback gets shorter.
            layer[node] = layer[node].max(nearest - 1);
        }
    }
    layer
}
