//! Placing: the order of the blocks in each column.
//!
//! Wires that pass a column hold a place in it (a passage), so that they do not
//! run through symbols. The order is found by barycentre sweeps; the one with the
//! fewest crossings is kept.

use super::graph::{Graph, Port, Role};
use super::layout::{Item, Layout, Link, PASSAGE, Placed, sweep};
use super::level;
use super::symbol::{self, Size};
use crate::net::Netlist;
use std::collections::HashMap;

/// Sweeps over all columns.
const SWEEPS: usize = 24;
/// Items above which crossings are no longer counted.
const MOST_COUNTED: usize = 1500;
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
            items.push(Placed { item, layer, y: 0.0, above, below });
            items.len() - 1
        });
    };
    for (block, size) in sizes.iter().enumerate() {
        let (above, below) = size.extent();
        add(Item::Block(block), graph.layer[block], above, below);
    }
    for (block, ports) in graph.ports.iter().enumerate() {
        for port in ports.iter().filter(|p| !p.is_tag) {
            let from = graph.layer[graph.driver[port.net].0];
            let to = graph.layer[block];
            let passed = if port.is_back { to..from + 1 } else { from + 1..to };
            let (net, back) = (port.net, port.is_back);
            for layer in passed {
                add(Item::Passage { net, back }, layer, PASSAGE / 2.0, PASSAGE / 2.0);
            }
        }
    }
    let mut columns: Vec<Vec<usize>> = vec![Vec::new(); graph.layers];
    for (at, item) in items.iter().enumerate() {
        columns[item.layer].push(at);
    }
    let mut layout = Layout { items, index, port_offsets: port_offsets(graph, &sizes), sizes };
    let links = links(graph, &layout);
    order(&mut columns, &layout, &links);
    sort_ports(graph, netlist, &columns, &layout);
    layout.port_offsets = port_offsets(graph, &layout.sizes);
    let links = self::links(graph, &layout);
    level::heights(&columns, &mut layout, &links);
    level::straighten(&columns, &mut layout, &links);
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
            (0..ports.len()).map(|i| (i as f64 - middle) * pitch).collect()
        })
        .collect()
}

fn links(graph: &Graph, layout: &Layout) -> Vec<Link> {
    let mut links: HashMap<(usize, usize, i64), Link> = HashMap::new();
    let find = |layer: usize, item: Item| layout.index.get(&(layer, item)).copied();
    // From an item to another, each with the height of the wire there.
    let mut add = |from: (Option<usize>, f64), to: (Option<usize>, f64), weight: f64| {
        if let ((Some(a), a_offset), (Some(b), b_offset)) = (from, to) {
            let link = Link { a, b, a_offset, b_offset, weight };
            links.insert((a, b, (b_offset * 10.0) as i64), link);
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
            let mut before = (find(from, Item::Block(driver)), out_offset);
            // Fed back, it goes down to the passage beside the driver, left, and up again: a loose
            // connection at both ends.
            let passed: Vec<usize> =
                if back { (to..=from).rev().collect() } else { (from + 1..to).collect() };
            for layer in passed {
                let next = (find(layer, Item::Passage { net, back }), 0.0);
                add(before, next, if back && layer == from { 0.2 } else { 2.0 });
                before = next;
            }
            add(before, (here, *offset), if back { 0.2 } else { 1.0 });
        }
    }
    let mut list: Vec<Link> = links.into_values().collect();
    // From a map: put into an order that does not vary between runs.
    list.sort_by(|p, q| (p.a, p.b).cmp(&(q.a, q.b)).then(p.b_offset.total_cmp(&q.b_offset)));
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
    locate(columns, &mut position);
    let is_counted = count <= MOST_COUNTED;
    let mut best = (crossings(links, layout, &position), columns.to_vec());
    let sweeps = if is_counted { SWEEPS } else { 4 };
    for round in 0..sweeps {
        let forward = round % 2 == 0;
        for layer in sweep(columns.len(), forward) {
            let wanted: HashMap<usize, f64> = columns[layer]
                .iter()
                .map(|&item| {
                    let mut sum = (0.0, 0.0);
                    for &(other, weight) in &neighbours[item] {
                        let other_layer = layout.items[other].layer;
                        let is_fixed =
                            if forward { other_layer <= layer } else { other_layer >= layer };
                        if is_fixed {
                            sum = (sum.0 + weight * position[other], sum.1 + weight);
                        }
                    }
                    let value = if sum.1 > 0.0 { sum.0 / sum.1 } else { position[item] };
                    (item, value)
                })
                .collect();
            columns[layer].sort_by(|a, b| wanted[a].total_cmp(&wanted[b]));
            locate(&columns[layer..=layer], &mut position);
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

/// Places of items in their columns, centred, so that short and long columns compare.
fn locate(columns: &[Vec<usize>], position: &mut [f64]) {
    for column in columns {
        let middle = (column.len() as f64 - 1.0) / 2.0;
        for (at, item) in column.iter().enumerate() {
            position[*item] = at as f64 - middle;
        }
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
        between.entry(la.min(lb)).or_default().push((position[a], position[b]));
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
    locate(columns, &mut position);
    for block in 0..graph.ports.len() {
        if !netlist.blocks[block].kind.facts().inputs.roles.is_empty() {
            continue;
        }
        let layer = graph.layer[block];
        let here = layout.index[&(layer, Item::Block(block))];
        let key = |port: &Port| -> f64 {
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
            let source = layout
                .index
                .get(&(before, passage))
                .or_else(|| layout.index.get(&(before, Item::Block(graph.driver[net].0))));
            source.map_or(0.0, |at| position[*at])
        };
        let keys: Vec<f64> = graph.ports[block].iter().map(key).collect();
        let mut indices: Vec<usize> = (0..keys.len()).collect();
        let is_side = |i: usize| graph.ports[block][i].role != Role::Input;
        indices.sort_by(|&a, &b| is_side(a).cmp(&is_side(b)).then(keys[a].total_cmp(&keys[b])));
        graph.ports[block] = indices.into_iter().map(|i| graph.ports[block][i].clone()).collect();
    }
}
