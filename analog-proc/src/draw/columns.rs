//! Left edges and widths on the page: columns of symbols with the texts before their ports,
//! and the gaps between them.

use super::graph::{Graph, Port};
use super::label;
use super::layout::Layout;
use super::route::Routes;
use crate::net::Netlist;

/// White round the drawing.
pub(super) const BORDER: f64 = 30.0;

/// Columns and gaps.
pub(super) struct Columns {
    /// Left edge of the trunk zone of each gap.
    pub(super) gap: Vec<f64>,
    /// Left edge of the symbols of each column.
    pub(super) column: Vec<f64>,
    /// Width of the symbols of each column.
    pub(super) width: Vec<f64>,
    pub(super) total: f64,
}

pub(super) fn columns(
    graph: &Graph,
    netlist: &Netlist,
    layout: &Layout,
    routes: &Routes,
) -> Columns {
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
pub(super) fn text_width(text: &str) -> f64 {
    6.6 * text.chars().count() as f64
}

/// Tag and coefficient that stand before a port.
pub(super) fn port_texts(port: &Port, netlist: &Netlist) -> (Option<String>, Option<String>) {
    let tag = port.is_tag.then(|| netlist.nets[port.net].name.clone());
    (tag, label::coefficient(port.coefficient))
}
