//! `flip-flop`, `one-shot`, `counter`: logic that stores.

use super::*;
use engine::element::logic::Store;
use engine::element::source::Timer;

kind! {
    FlipFlop(f) { initial: bool = f.flag("initial", false) }
    "flip-flop", "logic; set by in0, reset by in1 (reset wins)", "`initial` (false)",
    r#"in = ["p", "q"]"#, takes_logic: true, gives_logic: true, class: Some(BlockClass::Logic),
    inputs: Inputs::named(&[("set", "S"), ("reset", "R")]), storage: Storage::Value,
    symbol: |pen| pen.boxed("FF"),
}

impl Component for FlipFlop {
    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.initial_nets[o as usize] = f64::from(self.initial);
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [set, reset] = to.exactly(&block.inputs);
        to.m.stores.push(Store::FlipFlop { o, set: set.slot, reset: reset.slot });
    }
}

kind! {
    OneShot(f) { width_s: f64 = f.duration("width") }
    "one-shot", "logic: 1 for `width` after a rising edge", "`width` s",
    r#"in = ["p"], width = 0.1"#, takes_logic: true, gives_logic: true,
    class: Some(BlockClass::Logic), inputs: Inputs::exactly(1), storage: Storage::Value,
}

impl Component for OneShot {
    fn lower(&self, _: &mut Lowering, _: &Block, _: Slot) {}

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [input] = to.exactly(&block.inputs);
        let timer = to.m.timers.len() as u32;
        to.m.timers.push((o, Timer::OneShotEnd));
        let (input, width_s) = (input.slot, self.width_s);
        to.m.stores.push(Store::OneShot { o, input, width_s, timer });
    }

    fn caption(&self) -> Option<String> {
        Some(format!("{} s", number(self.width_s)))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.curve(
            "plot",
            &[(-1.0, -0.5), (-0.4, -0.5), (-0.4, 0.5), (0.4, 0.5), (0.4, -0.5), (1.0, -0.5)],
        );
    }
}

kind! {
    Counter(counter) { modulo: u32 }
    "counter", "analog: rising edges of in0, back to 0 by in1 if wired", "`modulo` (0: endless)",
    r#"in = ["p"], modulo = 10"#, takes_logic: true, class: Some(BlockClass::Logic),
    inputs: Inputs { least: 1, ..Inputs::named(&[("clock", ">"), ("reset", "R")]) },
    storage: Storage::Value,
}

fn counter(f: &mut Fields<'_, '_>) -> Option<Counter> {
    let modulo = f.whole("modulo", Some(0))?;
    let Ok(modulo) = u32::try_from(modulo) else {
        f.out_of_range("modulo", modulo as f64, "at most 4294967295");
        return None;
    };
    Some(Counter { modulo })
}

impl Component for Counter {
    fn lower(&self, _: &mut Lowering, _: &Block, _: Slot) {}

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let clock = to.slot(block.inputs[0].net);
        let reset = block.inputs.get(1).map(|i| to.slot(i.net));
        to.m.stores.push(Store::Counter { o, clock, reset, modulo: self.modulo });
    }

    fn symbol(&self, pen: &mut Pen) {
        if self.modulo == 0 {
            return pen.boxed("CTR");
        }
        pen.frame();
        pen.text(0.0, -2.0, "tiny", "CTR");
        pen.text(0.0, 12.0, "tiny", &format!("÷{}", self.modulo));
    }
}
