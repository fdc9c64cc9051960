//! Placing: the order of the blocks in each column, and their heights on the page.
//!
//! Wires that pass a column hold a place in it (a passage), so that they do not
//! run through symbols. Order: barycentre sweeps, the ordering with the fewest
//! crossings kept. Heights: each item wants to be level with its neighbours;
//! the least-squares answer that keeps the distances is found by pooling.

use super::graph::{Graph, Role};
use super::symbol::{self, Size};
use crate::net::{Kind, Netlist};
use std::collections::{BTreeMap, HashMap};

/// Sweeps over all columns.
const SWEEPS: usize = 24;
/// Items above which crossings are no longer counted.
const MOST_COUNTED: usize = 1500;
/// Vertical distance between two wires that pass a column.
const PASSAGE: f64 = 12.0;
/// Clear distance between blocks.
const CLEARANCE: f64 = 20.0;

/// What stands at a place of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Item {
    Block(usize),
    /// A wire of a net that passes the column; `back` from right to left.
    Passage {
        net: usize,
        back: bool,
    },
}

/// One item with its place.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) item: Item,
    pub(super) layer: usize,
    pub(super) y: f64,
    above: f64,
    below: f64,
}

/// A wire between two items of neighbouring columns (or, fed back, of the same one).
struct Link {
    a: usize,
    b: usize,
    a_offset: f64,
    b_offset: f64,
    weight: f64,
}

/// All items placed.
pub(super) struct Layout {
    pub(super) items: Vec<Placed>,
    pub(super) index: HashMap<(usize, Item), usize>,
    pub(super) sizes: Vec<Size>,
    /// Height of each port above or below its block's middle.
    pub(super) port_offsets: Vec<Vec<f64>>,
}

pub(super) fn place(graph: &mut Graph, netlist: &Netlist) -> Layout {
    let sizes: Vec<Size> = netlist
        .blocks
        .iter()
        .zip(&graph.ports)
        .map(|(block, ports)| symbol::size(block, ports.len()))
        .collect();
    let mut items = Vec::new();
    let mut index = HashMap::new();
    let mut add = |item: Item, layer: usize, above: f64, below: f64| {
        index.entry((layer, item)).or_insert_with(|| {
            items.push(Placed {
                item,
                layer,
                y: 0.0,
                above,
                below,
            });
            items.len() - 1
        });
    };
    for (block, size) in sizes.iter().enumerate() {
        add(
            Item::Block(block),
            graph.layer[block],
            size.height / 2.0 + size.above,
            size.height / 2.0 + size.below,
        );
    }
    for (block, ports) in graph.ports.iter().enumerate() {
        for port in ports.iter().filter(|p| !p.is_tag) {
            let from = graph.layer[graph.driver[port.net].0];
            let to = graph.layer[block];
            let passed = if port.is_back {
                to..from + 1
            } else {
                from + 1..to
            };
            let (net, back) = (port.net, port.is_back);
            for layer in passed {
                add(
                    Item::Passage { net, back },
                    layer,
                    PASSAGE / 2.0,
                    PASSAGE / 2.0,
                );
            }
        }
    }
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); graph.layers];
    for (at, item) in items.iter().enumerate() {
        columns[item.layer].push(at);
    }
    let mut layout = Layout {
        items,
        index,
        port_offsets: port_offsets(graph, &sizes),
        sizes,
    };
    let links = links(graph, &layout);
    order(&mut columns, &layout, &links);
    sort_ports(graph, netlist, &columns, &layout);
    layout.port_offsets = port_offsets(graph, &layout.sizes);
    let links = self::links(graph, &layout);
    heights(&columns, &mut layout, &links);
    straighten(&columns, &mut layout, &links);
    layout
}

fn port_offsets(graph: &Graph, sizes: &[Size]) -> Vec<Vec<f64>> {
    graph
        .ports
        .iter()
        .zip(sizes)
        .map(|(ports, size)| {
            let pitch = symbol::PORT_PITCH.min(size.height / ports.len().max(1) as f64);
            let middle = (ports.len() as f64 - 1.0) / 2.0;
            (0..ports.len())
                .map(|i| (i as f64 - middle) * pitch)
                .collect()
        })
        .collect()
}

fn links(graph: &Graph, layout: &Layout) -> Vec<Link> {
    let mut links: HashMap<(usize, usize, i64), Link> = HashMap::new();
    let find = |layer: usize, item: Item| layout.index.get(&(layer, item)).copied();
    let mut add =
        |a: Option<usize>, b: Option<usize>, a_offset: f64, b_offset: f64, weight: f64| {
            if let (Some(a), Some(b)) = (a, b) {
                links.insert(
                    (a, b, (b_offset * 10.0) as i64),
                    Link {
                        a,
                        b,
                        a_offset,
                        b_offset,
                        weight,
                    },
                );
            }
        };
    for (block, ports) in graph.ports.iter().enumerate() {
        let to = graph.layer[block];
        let here = find(to, Item::Block(block));
        for (port, offset) in ports.iter().zip(&layout.port_offsets[block]) {
            if port.is_tag {
                continue;
            }
            let (driver, output) = graph.driver[port.net];
            let from = graph.layer[driver];
            let out_offset = layout.sizes[driver].outputs[output.min(1)];
            let (net, back) = (port.net, port.is_back);
            let passage = Item::Passage { net, back };
            let mut before = (find(from, Item::Block(driver)), out_offset);
            if back {
                // Down to the passage beside the driver, left, and up again: a loose connection.
                for layer in (to..=from).rev() {
                    let weight = if layer == from { 0.2 } else { 2.0 };
                    let next = find(layer, passage);
                    add(before.0, next, before.1, 0.0, weight);
                    before = (next, 0.0);
                }
                add(before.0, here, 0.0, *offset, 0.2);
            } else {
                for layer in from + 1..to {
                    let next = find(layer, passage);
                    add(before.0, next, before.1, 0.0, 2.0);
                    before = (next, 0.0);
                }
                add(before.0, here, before.1, *offset, 1.0);
            }
        }
    }
    let mut list: Vec<Link> = links.into_values().collect();
    // From a map: put into an order that does not vary between runs.
    list.sort_by(|p, q| {
        (p.a, p.b)
            .cmp(&(q.a, q.b))
            .then(p.b_offset.total_cmp(&q.b_offset))
    });
    list
}

fn order(columns: &mut [Vec<usize>], layout: &Layout, links: &[Link]) {
    let count = layout.items.len();
    let mut neighbours: Vec<Vec<(usize, f64)>> = vec![Vec::new(); count];
    for link in links {
        neighbours[link.a].push((link.b, link.weight));
        neighbours[link.b].push((link.a, link.weight));
    }
    let mut position = vec![0.0; count];
    let set = |columns: &[Vec<usize>], position: &mut Vec<f64>| {
        for column in columns {
            // Centred, so that short and long columns compare.
            let middle = (column.len() as f64 - 1.0) / 2.0;
            for (at, item) in column.iter().enumerate() {
                position[*item] = at as f64 - middle;
            }
        }
    };
    set(columns, &mut position);
    let is_counted = count <= MOST_COUNTED;
    let mut best = (crossings(links, layout, &position), columns.to_vec());
    let sweeps = if is_counted { SWEEPS } else { 4 };
    for sweep in 0..sweeps {
        let forward = sweep % 2 == 0;
        let layers: Vec<usize> = if forward {
            (0..columns.len()).collect()
        } else {
            (0..columns.len()).rev().collect()
        };
        for layer in layers {
            let wanted: HashMap<usize, f64> = columns[layer]
                .iter()
                .map(|&item| {
                    let mut sum = (0.0, 0.0);
                    for &(other, weight) in &neighbours[item] {
                        let other_layer = layout.items[other].layer;
                        let is_fixed = if forward {
                            other_layer <= layer
                        } else {
                            other_layer >= layer
                        };
                        if is_fixed {
                            sum = (sum.0 + weight * position[other], sum.1 + weight);
                        }
                    }
                    let value = if sum.1 > 0.0 {
                        sum.0 / sum.1
                    } else {
                        position[item]
                    };
                    (item, value)
                })
                .collect();
            columns[layer].sort_by(|a, b| wanted[a].total_cmp(&wanted[b]));
            set(&columns[layer..=layer], &mut position);
        }
        if is_counted {
            let found = crossings(links, layout, &position);
            if found < best.0 {
                best = (found, columns.to_vec());
            }
        }
    }
    if is_counted {
        columns.clone_from_slice(&best.1);
    }
}

/// Crossings between columns, and how far fed-back wires run from their blocks.
fn crossings(links: &[Link], layout: &Layout, position: &[f64]) -> f64 {
    if layout.items.len() > MOST_COUNTED {
        return 0.0;
    }
    let mut between: HashMap<usize, Vec<(f64, f64)>> = HashMap::new();
    let mut cost = 0.0;
    for link in links {
        let (mut a, mut b) = (link.a, link.b);
        let (la, lb) = (layout.items[a].layer, layout.items[b].layer);
        if la == lb {
            cost += 0.3 * (position[a] - position[b]).abs();
            continue;
        }
        if la > lb {
            std::mem::swap(&mut a, &mut b);
        }
        between
            .entry(la.min(lb))
            .or_default()
            .push((position[a], position[b]));
    }
    for edges in between.values() {
        for (i, p) in edges.iter().enumerate() {
            for q in &edges[i + 1..] {
                if (p.0 - q.0) * (p.1 - q.1) < 0.0 {
                    cost += 1.0;
                }
            }
        }
    }
    cost
}

/// Inputs of a sum may come in any order: the one in which their wires arrive.
fn sort_ports(graph: &mut Graph, netlist: &Netlist, columns: &[Vec<usize>], layout: &Layout) {
    let mut position = vec![0.0; layout.items.len()];
    for column in columns {
        let middle = (column.len() as f64 - 1.0) / 2.0;
        for (at, item) in column.iter().enumerate() {
            position[*item] = at as f64 - middle;
        }
    }
    for block in 0..graph.ports.len() {
        if !inputs_commute(&netlist.blocks[block].kind) {
            continue;
        }
        let layer = graph.layer[block];
        let here = layout.index[&(layer, Item::Block(block))];
        let key = |port: &super::graph::Port| -> f64 {
            if port.is_tag {
                return 0.0;
            }
            let (net, back) = (port.net, port.is_back);
            let passage = Item::Passage { net, back };
            if back {
                let at = layout.index.get(&(layer, passage));
                // Above or below the block, beyond all wires from the left.
                return at.map_or(0.0, |at| 1e3 * (position[*at] - position[here]).signum());
            }
            let before = layer.saturating_sub(1);
            let source = layout.index.get(&(before, passage)).or_else(|| {
                layout
                    .index
                    .get(&(before, Item::Block(graph.driver[net].0)))
            });
            source.map_or(0.0, |at| position[*at])
        };
        let keys: Vec<f64> = graph.ports[block].iter().map(key).collect();
        let mut indices: Vec<usize> = (0..keys.len()).collect();
        let is_side = |i: usize| graph.ports[block][i].role != Role::Input;
        indices.sort_by(|&a, &b| {
            is_side(a)
                .cmp(&is_side(b))
                .then(keys[a].total_cmp(&keys[b]))
        });
        graph.ports[block] = indices
            .into_iter()
            .map(|i| graph.ports[block][i].clone())
            .collect();
    }
}

fn inputs_commute(kind: &Kind) -> bool {
    !matches!(
        kind,
        Kind::Divider
            | Kind::Resolver
            | Kind::Arctangent
            | Kind::Function2d { .. }
            | Kind::DryFriction { .. }
            | Kind::Switch { .. }
            | Kind::FlipFlop { .. }
            | Kind::Counter { .. }
    )
}

fn heights(columns: &[Vec<usize>], layout: &mut Layout, links: &[Link]) {
    let mut of: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); layout.items.len()];
    for link in links {
        let shift = link.a_offset - link.b_offset;
        of[link.b].push((link.a, shift, link.weight));
        of[link.a].push((link.b, -shift, link.weight));
    }
    for column in columns {
        let mut y = 0.0;
        for &item in column {
            y += layout.items[item].above;
            layout.items[item].y = y;
            y += layout.items[item].below + CLEARANCE;
        }
        let shift = y / 2.0;
        column.iter().for_each(|i| layout.items[*i].y -= shift);
    }
    for sweep in 0..40 {
        let layers: Vec<usize> = if sweep % 2 == 0 {
            (0..columns.len()).collect()
        } else {
            (0..columns.len()).rev().collect()
        };
        for layer in layers {
            let column = &columns[layer];
            let wanted: Vec<(f64, f64)> = column
                .iter()
                .map(|&item| {
                    let mut sum = (0.0, 0.0);
                    for &(other, shift, weight) in &of[item] {
                        let is_block = matches!(layout.items[other].item, Item::Block(_));
                        let is_passage = matches!(layout.items[item].item, Item::Passage { .. });
                        // Straight wires first where a wire passes to a wire.
                        let weight = if is_passage && !is_block {
                            3.0 * weight
                        } else {
                            weight
                        };
                        sum = (
                            sum.0 + weight * (layout.items[other].y + shift),
                            sum.1 + weight,
                        );
                    }
                    if sum.1 > 0.0 {
                        (sum.0 / sum.1, sum.1)
                    } else {
                        (layout.items[item].y, 0.05)
                    }
                })
                .collect();
            let gaps: Vec<f64> = column
                .windows(2)
                .map(|pair| distance(&layout.items[pair[0]], &layout.items[pair[1]]))
                .collect();
            for (item, y) in column.iter().zip(pool(&wanted, &gaps)) {
                layout.items[*item].y = y;
            }
        }
    }
}

/// Least distance between the middles of two items of a column, `a` above `b`.
fn distance(a: &Placed, b: &Placed) -> f64 {
    let is_wire = |p: &Placed| matches!(p.item, Item::Passage { .. });
    let clear = match (is_wire(a), is_wire(b)) {
        (true, true) => 0.0,
        (false, false) => CLEARANCE,
        _ => 6.0,
    };
    a.below + b.above + clear
}

/// Takes the last small steps out of wires: first whole passages are levelled,
/// then an item moves to where most of its wires run straight, if its neighbours
/// in the column leave it the room.
fn straighten(columns: &[Vec<usize>], layout: &mut Layout, links: &[Link]) {
    /// Farther than this an item is not moved for the sake of a straight wire.
    const REACH: f64 = 40.0;
    /// Heights closer than this are the same.
    const LEVEL: f64 = 0.05;
    let mut of: Vec<Vec<(usize, f64)>> = vec![Vec::new(); layout.items.len()];
    for link in links {
        let shift = link.a_offset - link.b_offset;
        if layout.items[link.a].layer != layout.items[link.b].layer {
            of[link.b].push((link.a, shift));
            of[link.a].push((link.b, -shift));
        }
    }
    for sweep in 0..8 {
        let is_forward = sweep % 2 == 0;
        level_passages(columns, layout);
        let mut layers: Vec<usize> = (0..columns.len()).collect();
        if !is_forward {
            layers.reverse();
        }
        for column in layers.into_iter().map(|layer| &columns[layer]) {
            for (at, &item) in column.iter().enumerate() {
                let (low, high) = room(column, at, layout);
                let here = &layout.items[item];
                let wanted: Vec<(f64, bool)> = of[item]
                    .iter()
                    .map(|(other, shift)| {
                        let other = &layout.items[*other];
                        (other.y + shift, other.layer < here.layer)
                    })
                    .collect();
                let straight = |y: f64| wanted.iter().filter(|w| (w.0 - y).abs() < LEVEL).count();
                let mut best = (straight(here.y), here.y);
                for &(candidate, is_left) in &wanted {
                    let fits = candidate >= low && candidate <= high;
                    let count = straight(candidate);
                    // Ties move too, after the side that has just been placed, so that a chain lines up.
                    let is_better = count > best.0 || (count == best.0 && is_forward == is_left);
                    if fits && (candidate - here.y).abs() < REACH && is_better {
                        best = (count, candidate);
                    }
                }
                layout.items[item].y = best.1;
            }
        }
    }
    level_passages(columns, layout);
}

/// Heights between which an item of a column may move.
fn room(column: &[usize], at: usize, layout: &Layout) -> (f64, f64) {
    let here = &layout.items[column[at]];
    let low = at.checked_sub(1).map_or(f64::NEG_INFINITY, |before| {
        let other = &layout.items[column[before]];
        other.y + distance(other, here)
    });
    let high = column.get(at + 1).map_or(f64::INFINITY, |after| {
        let other = &layout.items[*after];
        other.y - distance(here, other)
    });
    (low, high)
}

/// Brings the passages of a wire through neighbouring columns to one height, from the outside inwards.
fn level_passages(columns: &[Vec<usize>], layout: &mut Layout) {
    let mut place = vec![0; layout.items.len()];
    for column in columns {
        for (at, item) in column.iter().enumerate() {
            place[*item] = at;
        }
    }
    let mut wires: BTreeMap<(usize, bool), Vec<usize>> = BTreeMap::new();
    for (at, item) in layout.items.iter().enumerate() {
        if let Item::Passage { net, back } = item.item {
            wires.entry((net, back)).or_default().push(at);
        }
    }
    let mean = |wire: &[usize], layout: &Layout| {
        wire.iter().map(|i| layout.items[*i].y).sum::<f64>() / wire.len() as f64
    };
    let mut wires: Vec<Vec<usize>> = wires.into_values().filter(|w| w.len() > 1).collect();
    wires.sort_by(|a, b| mean(b, layout).abs().total_cmp(&mean(a, layout).abs()));
    for wire in wires {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for item in &wire {
            let column = &columns[layout.items[*item].layer];
            let (l, h) = room(column, place[*item], layout);
            (low, high) = (low.max(l), high.min(h));
        }
        if low <= high {
            let y = mean(&wire, layout).clamp(low, high);
            wire.iter().for_each(|item| layout.items[*item].y = y);
        } else {
            push_out(&wire, columns, &place, (low, high), layout);
        }
    }
}

/// Levels a wire that has no room by pushing the wires beyond it outwards, where only wires are.
fn push_out(
    wire: &[usize],
    columns: &[Vec<usize>],
    place: &[usize],
    (low, high): (f64, f64),
    layout: &mut Layout,
) {
    let is_below = wire.iter().map(|i| layout.items[*i].y).sum::<f64>() > 0.0;
    let beyond = |item: usize| -> Vec<usize> {
        let column = &columns[layout.items[item].layer];
        let at = place[item];
        if is_below {
            column[at + 1..].to_vec()
        } else {
            column[..at].iter().rev().copied().collect()
        }
    };
    let outer: Vec<Vec<usize>> = wire.iter().map(|item| beyond(*item)).collect();
    let is_wire = |item: &usize| matches!(layout.items[*item].item, Item::Passage { .. });
    if !outer.iter().flatten().all(is_wire) {
        return;
    }
    let y = if is_below { low } else { high };
    for (item, outer) in wire.iter().zip(outer) {
        layout.items[*item].y = y;
        let mut limit = y;
        for other in outer {
            let wanted = layout.items[other].y;
            let moved = if is_below {
                wanted.max(limit + PASSAGE)
            } else {
                wanted.min(limit - PASSAGE)
            };
            layout.items[other].y = moved;
            limit = moved;
        }
    }
}

/// Least squares of `weight · (y − wanted)²` with `y[i+1] − y[i] ≥ gaps[i]` (pool adjacent violators).
fn pool(wanted: &[(f64, f64)], gaps: &[f64]) -> Vec<f64> {
    // With u[i] = y[i] − Σ gaps before i the constraint is that u does not decrease.
    let mut before = 0.0;
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (i, (value, weight)) in wanted.iter().enumerate() {
        if i > 0 {
            before += gaps[i - 1];
        }
        let mut next = (value - before, *weight, 1);
        while let Some(&last) = pools.last().filter(|last| last.0 > next.0) {
            pools.pop();
            let weight = last.1 + next.1;
            let mean = (last.0 * last.1 + next.0 * next.1) / weight;
            next = (mean, weight, last.2 + next.2);
        }
        pools.push(next);
    }
    let mut out = Vec::with_capacity(wanted.len());
    let mut before = 0.0;
    for (mean, _, count) in pools {
        for _ in 0..count {
            if !out.is_empty() {
                before += gaps[out.len() - 1];
            }
            out.push(mean + before);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::pool;

    #[test]
    fn pooling_keeps_distances_and_the_mean() {
        let y = pool(&[(0.0, 1.0), (0.0, 1.0), (100.0, 1.0)], &[10.0, 10.0]);
        // Two that want the same place share it evenly; the third is free. Exact in binary.
        assert_eq!(y, [-5.0, 5.0, 100.0]);
    }
}
