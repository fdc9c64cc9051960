//! `abs`, `min`, `max`: what diodes choose.

use super::*;
use engine::element::curve::pieces_of_abs;
use engine::element::piecewise::Piecewise;

kind! {
    Abs
    "abs", r"\|Σ\|", "", r#"in = ["a"]"#, class: Some(BlockClass::DiodeNetwork),
    symbol: |pen| pen.boxed("|x|"),
}

impl Component for Abs {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        to.curve_into(o, u, &[0.0], &pieces_of_abs());
    }
}

kind! {
    Min
    "min", "least of 2 or more inputs", "", r#"in = ["a", "b"]"#, inputs: Inputs::at_least(2),
    class: Some(BlockClass::DiodeNetwork), symbol: |pen| pen.boxed("min"),
}

impl Component for Min {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        extremum(to, block, o, -1.0);
    }
}

kind! {
    Max
    "max", "greatest of 2 or more inputs", "", r#"in = ["a", "b"]"#, inputs: Inputs::at_least(2),
    class: Some(BlockClass::DiodeNetwork), symbol: |pen| pen.boxed("max"),
}

impl Component for Max {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        extremum(to, block, o, 1.0);
    }
}

fn extremum(to: &mut Lowering, block: &Block, o: Slot, sign: f64) {
    let terms = to.terms(&block.inputs);
    let slots: Vec<Slot> = terms.iter().map(|t| t.slot).collect();
    let (start, len) = to.store_terms(&terms);
    let e = to.element(Piecewise::Extremum { start, len, sign }, &slots);
    let varying = to.vary(&slots);
    to.push(Op::Extreme { o, e, start, len }, &[o], varying);
}
