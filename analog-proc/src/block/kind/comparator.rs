//! `comparator`, `relay`: what switches where the sum passes a threshold.

use super::*;
use engine::element::piecewise::Piecewise;

kind! {
    Comparator(f) {
        threshold: f64 = f.number("threshold", Some(0.0)),
        hysteresis: f64 = f.ranged("hysteresis", Some(0.0), "0 or greater", |v| v >= 0.0),
    }
    "comparator", "logic: Σ > `threshold`", "`threshold` (0); `hysteresis`, total (0)",
    r#"in = ["a"], threshold = 0.5"#, gives_logic: true, class: Some(BlockClass::Comparator),
}

impl Component for Comparator {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        let on_above = self.threshold + 0.5 * self.hysteresis;
        let off_at = self.threshold - 0.5 * self.hysteresis;
        let e = to.element(Piecewise::Comparator { u, on_above, off_at }, &[u.slot]);
        to.push(Op::Constant { o, e }, &[o], false);
    }

    fn caption(&self) -> Option<String> {
        let threshold = format!("> {}", number(self.threshold));
        let band = self.hysteresis / 2.0;
        Some(if band > 0.0 { format!("{threshold} ± {}", number(band)) } else { threshold })
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.triangle();
        pen.text(-9.0, 5.0, "word", ">");
    }
}

kind! {
    Relay(relay) { points: [f64; 2], outputs: [f64; 2], initially_on: bool }
    "relay", "`outputs[1]` once Σ > `points[1]`, `outputs[0]` once Σ < `points[0]`",
    "`points`, `outputs`, `initially-on` (false)",
    r#"in = ["a"], points = [-0.1, 0.1], outputs = [0, 5]"#, class: Some(BlockClass::Comparator),
}

fn relay(f: &mut Fields<'_, '_>) -> Option<Relay> {
    let points = f.pair("points");
    let outputs = f.pair("outputs");
    let initially_on = f.flag("initially-on", false);
    let points = points?;
    if points[0] > points[1] && !f.ordered("points", points[0], points[1]) {
        return None;
    }
    Some(Relay { points, outputs: outputs?, initially_on: initially_on? })
}

impl Component for Relay {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let Relay { points, outputs, initially_on } = *self;
        let u = to.sum(&block.inputs);
        let e = to.element(Piecewise::Relay { u, points, outputs, initially_on }, &[u.slot]);
        to.push(Op::Constant { o, e }, &[o], false);
    }

    fn caption(&self) -> Option<String> {
        let ([off_at, on_at], [off, on]) = (self.points.map(number), self.outputs.map(number));
        Some(format!("at {off_at}, {on_at}: {off} / {on}"))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.characteristic(&[(-1.0, -0.6), (0.35, -0.6), (0.35, 0.6), (1.0, 0.6)]);
        pen.curve("plot", &[(0.35, 0.6), (-0.35, 0.6), (-0.35, -0.6)]);
    }
}
