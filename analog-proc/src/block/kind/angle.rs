//! `sine`, `cosine`, `arctangent`, `resolver`.

use super::*;
use engine::element::piecewise::Piecewise;

kind! {
    Sine
    "sine", "sin Σ (rad)", "", r#"in = ["a"]"#, class: Some(BlockClass::Resolver),
    symbol: |pen| pen.boxed("sin"),
}

impl Component for Sine {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.through(o, block, |Term { slot: a, c }| Op::Sine { o, a, c });
    }
}

kind! {
    Cosine
    "cosine", "cos Σ (rad)", "", r#"in = ["a"]"#, class: Some(BlockClass::Resolver),
    symbol: |pen| pen.boxed("cos"),
}

impl Component for Cosine {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.through(o, block, |Term { slot: a, c }| Op::Cosine { o, a, c });
    }
}

kind! {
    Arctangent
    "arctangent",
    "atan2(in0, in1), rad, all quadrants; of a vector at zero, the direction in which it leaves",
    "", r#"in = ["a", "b"]"#, inputs: Inputs::named(&[("y", "y"), ("x", "x")]),
    class: Some(BlockClass::Resolver), symbol: |pen| pen.boxed("atan"),
}

impl Component for Arctangent {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [y, x] = to.exactly(&block.inputs);
        let e = to.element(Piecewise::Sheet { y }, &[y.slot]);
        let varying = to.vary(&[y.slot, x.slot]);
        to.push(Op::Arctangent { o, e, y, x }, &[o], varying);
    }
}

kind! {
    Resolver
    "resolver",
    "two nets, (in0, in1) turned by in2 rad: `NAME.x` = in0 cos in2 − in1 sin in2, `NAME.y` = in0 sin in2 + in1 cos in2",
    "", r#"in = ["a", "b", "c"]"#,
    inputs: Inputs::named(&[("x", "x"), ("y", "y"), ("angle", "∠")]), outputs: &["x", "y"],
    class: Some(BlockClass::Resolver), symbol: |pen| pen.boxed("R"),
}

impl Component for Resolver {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let terms: [Term; 3] = to.exactly(&block.inputs);
        let y = to.slot(block.outputs[1]);
        let varying = to.vary(&terms.map(|t| t.slot));
        let [u, v, angle] = terms;
        let sine = to.sine_of(angle);
        let (start, _) = to.store_terms(&[u, v, sine]);
        to.push(Op::Rotate { x: o, y, start }, &[o, y], varying);
        to.overload(y, block.max);
    }
}
