//! `sense`, `control`, `interrupt`: logic to and from the digital side.

use super::*;
use engine::element::logic::Store;

kind! {
    Sense(f) { line: u32 = f.channel("line", ChannelKind::Sense, 1) }
    "sense", "logic to the digital side", "`line` 0–63", r#"in = ["p"], line = 0"#,
    takes_logic: true, gives_logic: true, class: Some(BlockClass::SenseLine),
    inputs: Inputs::exactly(1),
}

impl Component for Sense {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Sense, self.line, 0.0)
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.weighted(o, block, 1.0);
        to.m.senses.push((self.line, o));
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.flag(&format!("SL {}", self.line));
    }
}

kind! {
    Control(f) {
        line: u32 = f.channel("line", ChannelKind::Control, 1),
        initial: bool = f.flag("initial", false),
    }
    "control", "logic from the digital side", "`line` 0–63; `initial` (false)", "line = 0",
    inputs: Inputs::exactly(0), gives_logic: true, class: Some(BlockClass::ControlLine),
    size: (52.0, 26.0),
}

impl Component for Control {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Control, self.line, f64::from(self.initial))
    }

    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.initial_nets[o as usize] = f64::from(self.initial);
        to.m.control_lines.push((self.line, o));
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.flag(&format!("CL {}", self.line));
    }
}

kind! {
    Interrupt(f) { line: u32 = f.channel("line", ChannelKind::Interrupt, 1) }
    "interrupt", "edges to the digital side, with their located instants", "`line` 0–31",
    r#"in = ["p"], line = 0"#, takes_logic: true, gives_logic: true,
    class: Some(BlockClass::InterruptLine), inputs: Inputs::exactly(1),
}

impl Component for Interrupt {
    fn claim(&self) -> Option<Claim> {
        Claim::one(ChannelKind::Interrupt, self.line, 0.0)
    }

    fn lower_inputs(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.stores.push(Store::Interrupt { input: o, line: self.line });
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.flag(&format!("INT {}", self.line));
    }
}
