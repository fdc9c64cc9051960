//! Symbols of the blocks, as analog computers have drawn them since the 1950s.
//!
//! Each is drawn about its middle; inputs enter at the left edge, the output
//! leaves at the right. The integrator is the triangle with a bar at its back,
//! the summer the plain triangle, the pot a circle with its setting.

use super::label::number;
use super::pen::Pen;
use crate::net::Block;
use maud::{Markup, html};

/// Distance between ports.
pub(super) const PORT_PITCH: f64 = 20.0;

/// Room that a symbol takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Room for text above (initial condition) and below (name).
    pub(super) above: f64,
    pub(super) below: f64,
    /// Heights of the outputs about the middle.
    pub(super) outputs: [f64; 2],
}

impl Size {
    /// Room above and below the middle, texts included.
    pub(super) fn extent(&self) -> (f64, f64) {
        (self.height / 2.0 + self.above, self.height / 2.0 + self.below)
    }
}

/// Room for a block with so many ports.
pub(super) fn size(block: &Block, ports: usize) -> Size {
    let facts = block.kind.facts();
    let (width, least) = facts.size;
    Size {
        width,
        height: f64::max(least, PORT_PITCH * ports as f64),
        above: if block.kind.component().caption().is_some() { 16.0 } else { 2.0 },
        below: 16.0,
        outputs: if facts.outputs.is_empty() { [0.0, 0.0] } else { [-12.0, 12.0] },
    }
}

/// Draws a block with its middle at `(x, y)`.
pub(super) fn draw(block: &Block, note: Option<&str>, size: Size, x: f64, y: f64) -> Markup {
    let mut pen = Pen {
        elements: String::new(),
        x,
        y,
        half_width: size.width / 2.0,
        half_height: size.height / 2.0,
    };
    let component = block.kind.component();
    (block.kind.facts().symbol)(&mut pen);
    component.symbol(&mut pen);
    if let Some(caption) = component.caption() {
        pen.text(0.0, -pen.half_height - 5.0, "value", &caption);
    }
    pen.text(0.0, pen.half_height + 13.0, "name", &block.name);
    let mut hint = block.name.clone();
    if let Some(max) = block.max {
        hint.push_str(&format!(", max {}", number(max)));
    }
    if let Some(note) = note {
        hint.push_str(&format!(": {note}"));
    }
    html! { g { (pen.markup()) title { (hint) } } }
}
