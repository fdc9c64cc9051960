//! `dead-zone`, `limiter`: limits that are fixed or follow a net.

use super::*;
use engine::element::curve::{pieces_of_dead_zone, pieces_of_limiter};
use engine::element::piecewise::Piecewise;

kind! {
    DeadZone(dead_zone) { width: Level }
    "dead-zone", "Σ ∓ w beyond ±w, else 0", "`width` w: number or net",
    r#"in = ["a"], width = 0.1"#, class: Some(BlockClass::DiodeNetwork),
    symbol: |pen| pen.characteristic(&[(-1.0, -0.8), (-0.4, 0.0), (0.4, 0.0), (1.0, 0.8)]),
}

fn dead_zone(f: &mut Fields<'_, '_>) -> Option<DeadZone> {
    let entry = f.required("width", "NUMBER or \"NET\" (half the width)")?;
    let width = f.level("width", &entry.value, "width")?;
    if let Level::Fixed(value) = width
        && value < 0.0
    {
        f.out_of_range("width", value, "0 or greater");
        return None;
    }
    Some(DeadZone { width })
}

impl Component for DeadZone {
    fn sides(&self) -> Vec<Side> {
        Side::level("w", self.width).into_iter().collect()
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        match self.width {
            Level::Fixed(w) => {
                to.curve_into(o, u, &[-w, w], &pieces_of_dead_zone(w));
            }
            Level::Net(net) => {
                let w = to.slot(net);
                let e = to.element(Piecewise::DeadZone { u, width: w }, &[u.slot, w]);
                let varying = to.vary(&[u.slot, w]);
                to.push(Op::DeadZone { o, e, a: u.slot, c: u.c, w }, &[o], varying);
            }
        }
    }

    fn caption(&self) -> Option<String> {
        Some(format!("± {}", words(self.width)))
    }
}

kind! {
    Limiter(limiter) { low: Level, high: Level }
    "limiter", "Σ within limits",
    "`limits = [low, high]`, or `limit` for ±; each a number or a net",
    r#"in = ["a"], limit = "c""#, class: Some(BlockClass::DiodeNetwork),
    symbol: |pen| pen.characteristic(&[(-1.0, -0.7), (-0.5, -0.7), (0.5, 0.7), (1.0, 0.7)]),
}

fn limiter(f: &mut Fields<'_, '_>) -> Option<Limiter> {
    if let Some(entry) = f.entry("limits") {
        let [low, high] = f.levels("limits", &entry.value)?;
        if let (Level::Fixed(low), Level::Fixed(high)) = (low, high)
            && !f.ordered("limits", low, high)
        {
            return None;
        }
        return Some(Limiter { low, high });
    }
    let Some(entry) = f.entry("limit") else {
        f.missing("limits", "[LOW, HIGH], or limit = LEVEL for both sides");
        return None;
    };
    let high = f.level("limit", &entry.value, "high")?;
    let low = match high {
        Level::Fixed(value) if value > 0.0 => Level::Fixed(-value),
        Level::Fixed(value) => {
            f.out_of_range("limit", value, "greater than 0");
            return None;
        }
        Level::Net(net) => Level::Net(f.inverted(net, "low", entry.value.span)),
    };
    Some(Limiter { low, high })
}

impl Component for Limiter {
    fn sides(&self) -> Vec<Side> {
        let sides = [Side::level("hi", self.high), Side::level("lo", self.low)];
        sides.into_iter().flatten().collect()
    }

    fn lower(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let u = to.sum(&block.inputs);
        if let (Level::Fixed(low), Level::Fixed(high)) = (self.low, self.high) {
            to.curve_into(o, u, &[low, high], &pieces_of_limiter(low, high));
            return;
        }
        let (low, high) = (to.level(self.low), to.level(self.high));
        let slots = [u.slot, low, high];
        let e = to.element(Piecewise::Limiter { u, low, high }, &slots);
        let varying = to.vary(&slots);
        to.push(Op::Limit { o, e, a: u.slot, c: u.c, low, high }, &[o], varying);
    }

    fn caption(&self) -> Option<String> {
        Some(format!("[{}, {}]", words(self.low), words(self.high)))
    }
}

fn words(level: Level) -> String {
    match level {
        Level::Fixed(value) => number(value),
        Level::Net(_) => "·".to_owned(),
    }
}
