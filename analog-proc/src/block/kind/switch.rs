//! `switch`, `track-store`: analog under the control of logic.

use super::*;

kind! {
    Switch(f) { control: NetId = f.net("control") }
    "switch", "in0 while `control` is 1, else in1", "`control`: logic net",
    r#"in = ["a", "b"], control = "p""#,
    inputs: Inputs::named(&[("when 1", "1"), ("when 0", "0")]), class: Some(BlockClass::Switch),
}

impl Component for Switch {
    fn sides(&self) -> Vec<Side> {
        vec![Side::logic("C", self.control)]
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let [a, b] = to.exactly(&block.inputs);
        let control = to.slot(self.control);
        let varying = to.vary(&[a.slot, b.slot]);
        to.push(Op::Switch { o, control, a, b }, &[o], varying);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.curve("plot", &[(-1.2, 0.6), (-0.6, 0.6)]);
        pen.curve("plot", &[(-1.2, -0.4), (-0.6, -0.4)]);
        pen.curve("plot", &[(-0.55, 0.5), (0.6, 0.0), (1.3, 0.0)]);
    }
}

kind! {
    TrackStore(f) { track: NetId = f.net("track"), ic: f64 = f.number("ic", Some(0.0)) }
    "track-store", "follows Σ while `track` is 1, then keeps it", "`track`: logic net; `ic` (0)",
    r#"in = ["a"], track = "p""#, class: Some(BlockClass::Integrator),
    symbol: |pen| pen.boxed("T/S"),
}

impl Component for TrackStore {
    fn sides(&self) -> Vec<Side> {
        vec![Side::logic("T", self.track)]
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let control = to.slot(self.track);
        let store = to.m.track_ics.len() as u32;
        to.m.track_ics.push(self.ic);
        to.through(o, block, |Term { slot: a, c }| Op::Track { o, control, a, c, store });
    }
}
