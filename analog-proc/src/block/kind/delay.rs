//! `transport-delay`: the sum of a while ago.

use super::*;
use engine::element::delay::DelayLine;

kind! {
    TransportDelay(f) {
        delay: f64 = f.duration("delay"),
        initial: f64 = f.number("initial", Some(0.0)),
    }
    "transport-delay", "Σ as it was `delay` ago", "`delay` s; `initial` (0)",
    r#"in = ["a"], delay = 0.2"#, storage: Storage::Value,
    class: Some(BlockClass::FunctionGenerator),
}

impl Component for TransportDelay {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        let line = to.m.lines.len() as u32;
        let input = Term { slot: 0, c: 0.0 };
        to.m.lines.push(DelayLine::new(input, self.delay, self.initial));
        to.m.step_cap_s = to.m.step_cap_s.min(self.delay);
        to.push(Op::Delay { o, line }, &[o], true);
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let input = to.sum(&block.inputs);
        let line = to.fast.iter().find_map(|op| match op {
            Op::Delay { o: out, line } if *out == o => Some(*line as usize),
            _ => None,
        });
        if let Some(line) = line {
            to.m.lines[line].input = input;
        }
    }

    fn caption(&self) -> Option<String> {
        Some(format!("T {} s", number(self.delay)))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.text(0.0, 5.0, "word", "e⁻ˢᵀ");
    }
}
