//! `dry-friction`: a body slides against it or is stuck.

use super::*;
use engine::element::friction::Friction;
use engine::element::piecewise::Piecewise;

kind! {
    /// `−level·sgn(in0)` when sliding, `−in1` while stuck and `|in1| ≤ breakaway`.
    DryFriction(dry_friction) { level: f64, breakaway: f64 }
    "dry-friction", "friction force at velocity in0 under applied force in1",
    "`level`; `breakaway` (= `level`)", r#"in = ["a", "b"], level = 0.5"#,
    inputs: Inputs::named(&[("velocity", "v"), ("applied force", "F")]),
    class: Some(BlockClass::DiodeNetwork),
    symbol: |pen| pen.characteristic(&[(-1.0, -0.6), (0.0, -0.6), (0.0, 0.6), (1.0, 0.6)]),
}

fn dry_friction(f: &mut Fields<'_, '_>) -> Option<DryFriction> {
    let level = f.ranged("level", None, "0 or greater", |v| v >= 0.0);
    let breakaway = f.number("breakaway", level.or(Some(0.0)));
    let (level, breakaway) = (level?, breakaway?);
    if breakaway < level {
        f.out_of_range("breakaway", breakaway, "at least `level`");
        return None;
    }
    Some(DryFriction { level, breakaway })
}

impl Component for DryFriction {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let DryFriction { level, breakaway } = *self;
        let [velocity, applied] = to.exactly(&block.inputs);
        let state = ((velocity.slot as usize) < to.m.states).then_some(velocity.slot);
        let friction = Friction { velocity, applied, level, breakaway, state };
        let e = to.element(Piecewise::Friction(friction), &[velocity.slot, applied.slot]);
        to.push(Op::Friction { o, e, a: applied.slot, c: applied.c }, &[o], true);
    }

    fn caption(&self) -> Option<String> {
        Some(number(self.level))
    }
}
