//! `summer`, `inverter`, `gain`, `pot`: a weighted sum, times a fixed factor.

use super::*;

kind! {
    Summer
    "summer", "Σ", "", r#"in = ["a", "-b"]"#, class: Some(BlockClass::Amplifier),
    symbol: |pen| pen.triangle(),
}

impl Component for Summer {}

kind! {
    Inverter
    "inverter", "−Σ", "", r#"in = ["a"]"#, class: Some(BlockClass::Amplifier), size: (40.0, 36.0),
}

impl Component for Inverter {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.weighted(o, block, -1.0);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.triangle();
        pen.text(-6.0, 4.0, "tiny", "−1");
    }
}

kind! {
    Gain(f) { k: f64 = f.number("k", None) }
    "gain", "k Σ", "`k`", r#"in = ["a"], k = 3.0"#, class: Some(BlockClass::Amplifier),
}

impl Component for Gain {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.weighted(o, block, self.k);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.triangle();
        pen.text(-8.0, 4.0, "tiny", &number(self.k));
    }
}

kind! {
    Pot(pot) { k: f64 }
    "pot", "k in0", "`k`, 0 to 1", r#"in = ["a"], k = 0.3"#, inputs: Inputs::exactly(1),
    class: Some(BlockClass::Potentiometer), size: (34.0, 34.0),
}

fn pot(f: &mut Fields<'_, '_>) -> Option<Pot> {
    let value = f.number("k", None)?;
    if (0.0..=1.0).contains(&value) {
        return Some(Pot { k: value });
    }
    let help =
        "a pot attenuates; use a `gain` block, or a coefficient on the input, for anything else";
    f.fault_at("k", Flaw::PotFraction { value }, help);
    None
}

impl Component for Pot {
    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.weighted(o, block, self.k);
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.circle(0.0, 1.0);
        pen.text(0.0, 4.0, "tiny", &number(self.k));
    }
}
