//! `multiplier`, `divider`, `square`, `square-root`.

use super::*;
use engine::element::piecewise::Piecewise;

kind! {
    Multiplier
    "multiplier", "product of 2 or more inputs", "", r#"in = ["a", "b"]"#,
    inputs: Inputs::at_least(2), class: Some(BlockClass::Multiplier),
    symbol: |pen| pen.boxed("×"),
}

impl Component for Multiplier {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let terms = to.terms(&block.inputs);
        let mut left = terms[0];
        for (i, right) in terms.iter().enumerate().skip(1) {
            let slot = if i + 1 == terms.len() { o } else { to.hidden() };
            let varying = to.vary(&[left.slot, right.slot]);
            let op = Op::Product { o: slot, a: left.slot, b: right.slot, c: left.c * right.c };
            to.push(op, &[slot], varying);
            left = Term { slot, c: 1.0 };
        }
    }
}

kind! {
    Divider
    "divider", "in0 / in1; zero divisor ends the run", "", r#"in = ["a", "b"]"#,
    inputs: Inputs::named(&[("dividend", "÷·"), ("divisor", "·÷")]),
    class: Some(BlockClass::Multiplier), symbol: |pen| pen.boxed("÷"),
}

impl Component for Divider {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [a, b] = to.exactly(&block.inputs);
        to.element(Piecewise::Divisor { u: b }, &[b.slot]);
        let varying = to.vary(&[a.slot, b.slot]);
        to.push(Op::Quotient { o, a: a.slot, b: b.slot, c: a.c / b.c }, &[o], varying);
    }
}

kind! {
    Square
    "square", "Σ²", "", r#"in = ["a"]"#, class: Some(BlockClass::Multiplier),
    symbol: |pen| pen.boxed("x²"),
}

impl Component for Square {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.through(o, block, |Term { slot: a, c }| Op::Product { o, a, b: a, c: c * c });
    }
}

kind! {
    SquareRoot
    "square-root", "√Σ; negative Σ ends the run", "", r#"in = ["c"]"#,
    class: Some(BlockClass::Multiplier), symbol: |pen| pen.boxed("√"),
}

impl Component for SquareRoot {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        to.element(Piecewise::Radicand { u }, &[u.slot]);
        let varying = to.vary(&[u.slot]);
        to.push(Op::Root { o, a: u.slot, c: u.c }, &[o], varying);
    }
}
