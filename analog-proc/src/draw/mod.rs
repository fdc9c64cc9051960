//! Wiring diagrams: a patch in the symbols of analog computation, as SVG.
//!
//! Signals run from left to right, feedback from right to left; solid wires are
//! analog, dashed ones logic. Coefficients stand beside the inputs, initial
//! conditions above the integrators. A large patch shows its long wires as
//! named tags. The drawing shows the patch that would run: sub-patches are
//! expanded and parameters put in.

mod graph;
mod label;
mod level;
mod pen;
mod place;
mod route;
mod sheet;
mod symbol;

pub(crate) use label::number;
pub(crate) use pen::{Pen, round};

use crate::net::Netlist;
use crate::order::Ordered;
use graph::{Graph, Port};
use place::{Item, Layout};
use route::Routes;
use sheet::Sheet;

/// White round the drawing.
const BORDER: f64 = 30.0;
/// Room for the title.
const HEAD: f64 = 56.0;

const STYLE: &str = "
svg { background: #ffffff; font-family: 'DejaVu Sans', Verdana, Helvetica, Arial, sans-serif; }
.paper { fill: #ffffff; }
.body { fill: #f4f7fb; stroke: #1b2a41; stroke-width: 1.6; stroke-linejoin: round; }
.wire { fill: none; stroke: #33506e; stroke-width: 1.3; }
.logic { stroke: #a8501c; stroke-dasharray: 5 3; }
.dot, .tip { fill: #33506e; }
.dot.logic, .tip.logic { fill: #a8501c; stroke: none; }
.plot { fill: none; stroke: #1b2a41; stroke-width: 1.6; }
.axis { fill: none; stroke: #9aa7b8; stroke-width: 0.8; }
.frame { fill: none; stroke: #7a8799; stroke-width: 1; stroke-dasharray: 7 4; }
text { fill: #1b2a41; text-anchor: middle; font-size: 11px; }
.title { font-size: 20px; font-weight: bold; text-anchor: start; }
.subtitle { font-size: 12px; text-anchor: start; fill: #5c6b7f; }
.name { font-weight: bold; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
.value { font-size: 10.5px; fill: #0b6b3a; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
.coefficient { font-size: 10.5px; text-anchor: end; fill: #0b5394; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
.tag { font-size: 10.5px; text-anchor: end; font-style: italic; fill: #33506e; }
.port { font-size: 8.5px; text-anchor: start; fill: #5c6b7f; }
.frame-name { text-anchor: start; fill: #5c6b7f; font-style: italic; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
.sign { font-size: 22px; }
.word { font-size: 14px; }
.tiny { font-size: 10.5px; }
@media (prefers-color-scheme: dark) {
  svg { background: #10161f; }
  .paper { fill: #10161f; }
  .body { fill: #1c2736; stroke: #d5deea; }
  .wire { stroke: #8fb4dc; }
  .logic { stroke: #f0a060; }
  .dot, .tip { fill: #8fb4dc; }
  .dot.logic, .tip.logic { fill: #f0a060; }
  .plot { stroke: #d5deea; }
  .axis { stroke: #5a6a80; }
  text { fill: #e6edf5; }
  .name, .value, .coefficient, .frame-name { stroke: #10161f; }
  .value { fill: #7fd6a4; }
  .coefficient { fill: #8ec5ff; }
  .tag { fill: #8fb4dc; }
  .subtitle, .port, .frame-name { fill: #9fb0c4; }
}
";

/// Draws a patch.
pub fn svg(ordered: &Ordered) -> String {
    let netlist = &ordered.netlist;
    let mut graph = graph::build(ordered);
    let layout = place::place(&mut graph, netlist);
    let routes = route::route(&graph, &layout);
    let columns = columns(&graph, netlist, &layout, &routes);
    let sheet = Sheet {
        netlist,
        graph: &graph,
        layout: &layout,
        routes: &routes,
        columns: &columns,
        top: top(&layout),
    };
    sheet.document(ordered).into_string()
}

/// Left edges and widths on the page.
struct Columns {
    /// Left edge of the trunk zone of each gap.
    gap: Vec<f64>,
    /// Left edge of the symbols of each column.
    column: Vec<f64>,
    /// Width of the symbols of each column.
    width: Vec<f64>,
    total: f64,
}

fn columns(graph: &Graph, netlist: &Netlist, layout: &Layout, routes: &Routes) -> Columns {
    let mut width = vec![0.0; graph.layers];
    let mut labels = vec![12.0; graph.layers];
    let mut names = vec![0.0; graph.layers];
    for (block, ports) in graph.ports.iter().enumerate() {
        let layer = graph.layer[block];
        width[layer] = f64::max(width[layer], layout.sizes[block].width);
        names[layer] = f64::max(names[layer], text_width(&netlist.blocks[block].name));
        for port in ports {
            let (tag, coefficient) = port_texts(port, netlist);
            let needed = 14.0
                + coefficient.map_or(0.0, |c| text_width(&c))
                + tag.map_or(0.0, |t| 8.0 + text_width(&t));
            labels[layer] = f64::max(labels[layer], needed);
        }
    }
    let mut out = Columns { gap: Vec::new(), column: Vec::new(), width, total: 0.0 };
    let mut x = BORDER;
    for layer in 0..=graph.layers {
        out.gap.push(x);
        let is_empty = routes.gaps[layer].is_empty();
        x += if is_empty { 8.0 } else { routes.widths[layer] };
        if layer < graph.layers {
            x += labels[layer];
            // Names are wider than many symbols; half of the excess on either side.
            let excess = f64::max(0.0, names[layer] - out.width[layer] - 24.0);
            x += excess / 2.0;
            out.column.push(x);
            x += out.width[layer] + excess / 2.0;
        }
    }
    out.total = x + BORDER;
    out
}

/// Width of a text of 11 px, px; generous for the usual sans-serif fonts.
fn text_width(text: &str) -> f64 {
    6.6 * text.chars().count() as f64
}

/// Tag and coefficient that stand before a port.
fn port_texts(port: &Port, netlist: &Netlist) -> (Option<String>, Option<String>) {
    let tag = port.is_tag.then(|| netlist.nets[port.net].name.clone());
    (tag, label::coefficient(port.coefficient))
}

/// Shift that brings the highest item below the title.
fn top(layout: &Layout) -> f64 {
    let highest = layout
        .items
        .iter()
        .map(|item| item.y - extent(item.item, layout).0)
        .fold(f64::INFINITY, f64::min);
    HEAD + BORDER - if highest.is_finite() { highest } else { 0.0 }
}

fn extent(item: Item, layout: &Layout) -> (f64, f64) {
    match item {
        Item::Block(block) => {
            let size = layout.sizes[block];
            (size.height / 2.0 + size.above, size.height / 2.0 + size.below)
        }
        Item::Passage { .. } => (6.0, 6.0),
    }
}
