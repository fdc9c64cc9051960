//! `and`, `or`, `not`.

use super::*;
use crate::draw::round;

kind! {
    And
    "and", "logic: 1 while all of 2 or more inputs are 1", "", r#"in = ["p", "q"]"#,
    takes_logic: true, gives_logic: true, class: Some(BlockClass::Logic),
    inputs: Inputs::at_least(2),
}

impl Component for And {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let (start, len) = to.store_terms(&to.terms(&block.inputs));
        to.push(Op::And { o, start, len }, &[o], false);
    }

    fn symbol(&self, pen: &mut Pen) {
        gate(pen, false);
    }
}

kind! {
    Or
    "or", "logic: 1 while any of 2 or more inputs is 1", "", r#"in = ["p", "q"]"#,
    takes_logic: true, gives_logic: true, class: Some(BlockClass::Logic),
    inputs: Inputs::at_least(2),
}

impl Component for Or {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let (start, len) = to.store_terms(&to.terms(&block.inputs));
        to.push(Op::Or { o, start, len }, &[o], false);
    }

    fn symbol(&self, pen: &mut Pen) {
        gate(pen, true);
    }
}

kind! {
    Not
    "not", "logic: 1 while its input is 0", "", r#"in = ["p"]"#, takes_logic: true,
    gives_logic: true, class: Some(BlockClass::Logic), inputs: Inputs::exactly(1),
    size: (34.0, 34.0),
}

impl Component for Not {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [a] = to.exactly(&block.inputs);
        to.push(Op::Not { o, a: a.slot }, &[o], false);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.outline("body", &[(-1.0, -1.0), (0.6, 0.0), (-1.0, 1.0)], true);
        pen.circle(0.8, 0.2);
    }
}

/// The D of an and gate, or the shield of an or gate.
fn gate(pen: &mut Pen, is_or: bool) {
    let (x, y) = (pen.x, pen.y);
    let (w, h) = (pen.half_width, pen.half_height);
    let (left, right, top, bottom) = (round(x - w), round(x + w), round(y - h), round(y + h));
    let d = if is_or {
        format!(
            "M{left} {top}Q{x} {top} {right} {y}Q{x} {bottom} {left} {bottom}Q{} {y} {left} {top}Z",
            round(x - 0.6 * w)
        )
    } else {
        format!("M{left} {top}H{x}Q{right} {top} {right} {y}Q{right} {bottom} {x} {bottom}H{left}Z")
    };
    pen.body(&d);
    pen.text(-4.0, 5.0, "word", if is_or { "≥1" } else { "&" });
}
