//! The drawing itself: title, frames, wires, symbols and the texts at their ports.
//!
//! Everything is given its place first; then it is only turned into SVG, in an order
//! in which later things lie over earlier ones.

use super::columns::{self, BORDER, Columns, port_texts, text_width};
use super::graph::{self, Graph, Role};
use super::layout::{Item, Layout, Placed};
use super::pen::{circle, path, rect, round, text};
use super::place;
use super::route::{self, Routes};
use super::symbol;
use crate::net::{Kind, Netlist};
use crate::order::Ordered;
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeMap;

/// Room for the title.
const HEAD: f64 = 56.0;

const STYLE: &str = include_str!("sheet.css");

/// A patch that is placed and routed, on its page.
pub(super) struct Sheet<'a> {
    ordered: &'a Ordered,
    netlist: &'a Netlist,
    graph: Graph,
    layout: Layout,
    routes: Routes,
    columns: Columns,
    /// Shift that brings the highest item below the title.
    top: f64,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(ordered: &'a Ordered) -> Sheet<'a> {
        let netlist = &ordered.netlist;
        let mut graph = graph::build(ordered);
        let layout = place::place(&mut graph, netlist);
        let routes = route::route(&graph, &layout);
        let columns = columns::columns(&graph, netlist, &layout, &routes);
        let highest = layout.items.iter().map(|item| item.y - extent(item.item, &layout).0);
        let highest = highest.fold(f64::INFINITY, f64::min);
        let top = HEAD + BORDER - if highest.is_finite() { highest } else { 0.0 };
        Sheet { ordered, netlist, graph, layout, routes, columns, top }
    }

    /// The whole drawing.
    pub(super) fn document(&self) -> Markup {
        let bottom = |item: &Placed| item.y + self.top + extent(item.item, &self.layout).1;
        let height = self.layout.items.iter().map(bottom).fold(HEAD, f64::max) + BORDER;
        let title = &self.netlist.title;
        let width = f64::max(self.columns.total, 2.0 * BORDER + 1.9 * text_width(title));
        let count = self.netlist.blocks.len();
        let integrators =
            self.netlist.blocks.iter().filter(|b| matches!(b.kind, Kind::Integrator(_))).count();
        let subtitle = format!(
            "{count} block{}, {integrators} integrator{}",
            plural(count),
            plural(integrators)
        );
        let (width, height) = (round(width), round(height));
        let symbol = |(block, content)| {
            let (x, y) = self.middle(block);
            let id = engine::id::BlockId(u32::try_from(block).unwrap_or(u32::MAX));
            symbol::draw(content, self.ordered.note(id), self.layout.sizes[block], x, y)
        };
        html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height) role="img" {
                title { (title) }
                style { (PreEscaped(STYLE)) }
                rect class="paper" width="100%" height="100%" {}
                (text(BORDER, 36.0, "title", title))
                (text(BORDER, 54.0, "subtitle", &subtitle))
                g { @for frame in self.frames() { (frame) } }
                g { @for wire in self.wires() { (wire) } }
                g { @for block in self.netlist.blocks.iter().enumerate() { (symbol(block)) } }
                g { @for port in self.ports() { (port) } }
            }
        }
    }

    fn middle(&self, block: usize) -> (f64, f64) {
        let layer = self.graph.layer[block];
        let x = self.columns.column[layer] + self.columns.width[layer] / 2.0;
        let at = self.layout.index[&(layer, Item::Block(block))];
        (x, self.layout.items[at].y + self.top)
    }

    fn is_logic(&self, net: usize) -> bool {
        let driver = self.graph.driver[net].0;
        self.netlist.blocks[driver].kind.is_logic()
    }

    fn trunk_x(&self, gap: usize, net: usize) -> f64 {
        let trunk = self.routes.gaps[gap].get(&net);
        self.columns.gap[gap] + trunk.map_or(0.0, |t| t.x)
    }

    fn wires(&self) -> Vec<Markup> {
        // Per net: its horizontal and vertical pieces.
        let mut pieces: BTreeMap<usize, Vec<[f64; 4]>> = BTreeMap::new();
        let mut add = |net: usize, piece: [f64; 4]| pieces.entry(net).or_default().push(piece);
        for (gap, trunks) in self.routes.gaps.iter().enumerate() {
            for (net, trunk) in trunks {
                let x = self.trunk_x(gap, *net);
                let (low, high) = trunk.range();
                if high - low >= 0.5 {
                    add(*net, [x, low + self.top, x, high + self.top]);
                }
            }
        }
        for item in &self.layout.items {
            if let Item::Passage { net, .. } = item.item {
                let y = item.y + self.top;
                let from = self.trunk_x(item.layer, net);
                add(net, [from, y, self.trunk_x(item.layer + 1, net), y]);
            }
        }
        let mut has_start = vec![false; self.graph.driver.len()];
        for (block, ports) in self.graph.ports.iter().enumerate() {
            for (index, port) in ports.iter().enumerate().filter(|(_, p)| !p.is_tag) {
                let (x, y) = self.port_place(block, index);
                add(port.net, [self.trunk_x(self.graph.layer[block], port.net), y, x, y]);
                if !std::mem::replace(&mut has_start[port.net], true) {
                    let (x, y) = self.output_place(port.net);
                    let layer = self.graph.layer[self.graph.driver[port.net].0];
                    add(port.net, [x, y, self.trunk_x(layer + 1, port.net), y]);
                }
            }
        }
        let mut group = Vec::new();
        for (net, pieces) in pieces {
            let logic = if self.is_logic(net) { " logic" } else { "" };
            let d: String =
                pieces.iter().map(|p| path([(p[0], p[1]), (p[2], p[3])].into_iter())).collect();
            let name = &self.netlist.nets[net].name;
            group.push(html! { path.{ "wire" (logic) } d=(d) { title { (name) } } });
            for (x, y) in junctions(&pieces) {
                group.push(circle(&format!("dot{logic}"), x, y, 2.6));
            }
        }
        group
    }

    fn output_place(&self, net: usize) -> (f64, f64) {
        let (driver, output) = self.graph.driver[net];
        let (x, y) = self.middle(driver);
        let size = self.layout.sizes[driver];
        (x + size.width / 2.0, y + size.outputs[output.min(1)])
    }

    fn port_place(&self, block: usize, port: usize) -> (f64, f64) {
        let (x, y) = self.middle(block);
        let left = x - self.layout.sizes[block].width / 2.0;
        (left, y + self.layout.port_offsets[block][port])
    }

    /// Arrowheads, coefficients, tags and names of the inputs.
    fn ports(&self) -> Vec<Markup> {
        let mut group = Vec::new();
        for (block, ports) in self.graph.ports.iter().enumerate() {
            let roles = self.netlist.blocks[block].kind.facts().inputs.roles;
            let mut numbered = 0;
            for (index, port) in ports.iter().enumerate() {
                let (x, y) = self.port_place(block, index);
                let logic = if port.is_logic { " logic" } else { "" };
                let tip = path([(x, y), (x - 8.0, y - 3.2), (x - 8.0, y + 3.2)].into_iter()) + "Z";
                group.push(html! { path.{ "tip" (logic) } d=(tip) {} });
                let (tag, coefficient) = port_texts(port, self.netlist);
                let mut right = x - 10.0;
                if let Some(coefficient) = coefficient {
                    // Beside a tag; above a wire.
                    let at = if port.is_tag { y + 3.5 } else { y - 4.0 };
                    group.push(text(right, at, "coefficient", &coefficient));
                    right -= text_width(&coefficient) + 6.0;
                }
                if let Some(tag) = tag {
                    group.push(text(right, y + 3.5, "tag", &tag));
                }
                let name = match port.role {
                    Role::Side(name) => Some(name),
                    Role::Input => {
                        numbered += 1;
                        roles.get(numbered - 1).map(|role| role.1)
                    }
                };
                if let Some(name) = name {
                    group.push(text(x + 2.5, y + 3.0, "port", name));
                }
            }
        }
        group
    }

    /// Dashed frames round instances of sub-patches whose blocks stand together.
    fn frames(&self) -> Vec<Markup> {
        let mut boxes: BTreeMap<&str, [f64; 4]> = BTreeMap::new();
        let bounds = |block: usize| {
            let (x, y) = self.middle(block);
            let size = self.layout.sizes[block];
            [
                x - size.width / 2.0,
                y - size.height / 2.0 - size.above,
                x + size.width / 2.0,
                y + size.height / 2.0 + size.below,
            ]
        };
        let blocks = &self.netlist.blocks;
        for (block, content) in blocks.iter().enumerate() {
            for (dot, _) in content.name.match_indices('.') {
                let new = bounds(block);
                boxes
                    .entry(&content.name[..dot])
                    .and_modify(|b| {
                        *b = [
                            b[0].min(new[0]),
                            b[1].min(new[1]),
                            b[2].max(new[2]),
                            b[3].max(new[3]),
                        ];
                    })
                    .or_insert(new);
            }
        }
        let mut group = Vec::new();
        for (name, [left, top, right, bottom]) in boxes {
            let prefix = format!("{name}.");
            let is_alone = blocks.iter().enumerate().all(|(block, content)| {
                let [l, t, r, b] = bounds(block);
                let is_apart = r < left || l > right || b < top || t > bottom;
                content.name.starts_with(&prefix) || is_apart
            });
            // A block that a field made bears the name of its owner, and is no sub-patch.
            if !is_alone || blocks.iter().any(|b| b.name == name) {
                continue;
            }
            let pad = 10.0;
            let (width, height) = (right - left + 2.0 * pad, bottom - top + 2.0 * pad + 6.0);
            group.push(rect("frame", [left - pad, top - pad - 6.0, width, height], 6.0));
            group.push(text(left - pad + 6.0, top - pad + 5.0, "frame-name", name));
        }
        group
    }
}

fn extent(item: Item, layout: &Layout) -> (f64, f64) {
    match item {
        Item::Block(block) => layout.sizes[block].extent(),
        Item::Passage { .. } => (6.0, 6.0),
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Points at which three or more pieces of a net meet.
fn junctions(pieces: &[[f64; 4]]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> =
        pieces.iter().flat_map(|p| [(p[0], p[1]), (p[2], p[3])]).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup_by(|a, b| (a.0 - b.0).abs() < 0.5 && (a.1 - b.1).abs() < 0.5);
    points
        .into_iter()
        .filter(|(x, y)| {
            let mut arms = 0;
            for [x1, y1, x2, y2] in pieces {
                let is_start = (x1 - x).abs() < 0.5 && (y1 - y).abs() < 0.5;
                let is_end = (x2 - x).abs() < 0.5 && (y2 - y).abs() < 0.5;
                let is_empty = (x1 - x2).abs() < 0.5 && (y1 - y2).abs() < 0.5;
                let is_level = (y1 - y2).abs() < 0.5;
                let is_inside = if is_level {
                    (y1 - y).abs() < 0.5 && x1.min(*x2) < *x && *x < x1.max(*x2)
                } else {
                    (x1 - x).abs() < 0.5 && y1.min(*y2) < *y && *y < y1.max(*y2)
                };
                arms += match (is_empty, is_start || is_end, is_inside) {
                    (true, _, _) => 0,
                    (_, true, _) => 1,
                    (_, _, true) => 2,
                    _ => 0,
                };
            }
            arms >= 3
        })
        .collect()
}
