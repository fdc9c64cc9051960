//! `rate-limiter`, `backlash`, `lag`: an integrator that follows the sum, as a programmer
//! would patch it.

use super::*;
use crate::block::lowering::scaled;
use engine::element::curve::{Piece, pieces_of_dead_zone, pieces_of_limiter};

kind! {
    /// `dy/dt = sat((Σ − y)/tau, ±rate)`.
    RateLimiter(f) {
        rate: f64 = f.positive("rate", None),
        tau: f64 = f.positive("tau", Some(1e-3)),
        ic: f64 = f.number("ic", Some(0.0)),
    }
    "rate-limiter", "follows Σ, slope within ±`rate`", "`rate` 1/s; `tau` s (1e-3); `ic` (0)",
    r#"in = ["a"], rate = 2.0"#, storage: Storage::State, class: Some(BlockClass::Integrator),
}

impl Component for RateLimiter {
    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
        let RateLimiter { rate, tau, .. } = *self;
        let mut terms = scaled(to.terms(&block.inputs), 1.0 / tau);
        terms.push(Term { slot: o, c: -1.0 / tau });
        follow(to, o, &terms, rate, &pieces_of_limiter(-rate, rate), 1.0);
    }

    fn caption(&self) -> Option<String> {
        Some(format!("± {} /s", number(self.rate)))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.curve("axis", &[(-1.0, -0.7), (-0.7, -0.7), (-0.7, 0.7), (1.0, 0.7)]);
        pen.curve("plot", &[(-1.0, -0.7), (-0.7, -0.7), (0.6, 0.7), (1.0, 0.7)]);
    }
}

kind! {
    /// `dy/dt = dz(Σ − y, width/2)/tau`: a dead zone in front of a fast integrator.
    Backlash(f) {
        width: f64 = f.positive("width", None),
        tau: f64 = f.positive("tau", Some(1e-3)),
        ic: f64 = f.number("ic", Some(0.0)),
    }
    "backlash", "follows Σ with play", "`width`, the whole play; `tau` s (1e-3); `ic` (0)",
    r#"in = ["a"], width = 0.2"#, storage: Storage::State, class: Some(BlockClass::DiodeNetwork),
}

impl Component for Backlash {
    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
        let mut terms = to.terms(&block.inputs);
        terms.push(Term { slot: o, c: -1.0 });
        let half = 0.5 * self.width;
        follow(to, o, &terms, half, &pieces_of_dead_zone(half), 1.0 / self.tau);
    }

    fn caption(&self) -> Option<String> {
        Some(number(self.width))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.characteristic(&[(-1.0, -0.7), (-0.4, -0.7), (1.0, 0.7)]);
        pen.curve("plot", &[(1.0, 0.7), (0.4, 0.7), (-1.0, -0.7)]);
    }
}

kind! {
    Lag(f) {
        tau: f64 = f.positive("tau", None),
        gain: f64 = f.number("gain", Some(1.0)),
        ic: f64 = f.number("ic", Some(0.0)),
    }
    "lag", "tau dy/dt = gain Σ − y", "`tau` s; `gain` (1); `ic` (0)", r#"in = ["a"], tau = 0.5"#,
    storage: Storage::State, class: Some(BlockClass::Integrator),
}

impl Component for Lag {
    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
        let mut terms = scaled(to.terms(&block.inputs), self.gain / self.tau);
        terms.push(Term { slot: o, c: -1.0 / self.tau });
        to.rate(o, &terms);
    }

    fn caption(&self) -> Option<String> {
        let Lag { tau, gain, ic } = *self;
        let gain = if gain == 1.0 { String::new() } else { format!("K {}  ", number(gain)) };
        let ic = if ic == 0.0 { String::new() } else { format!("  IC {}", number(ic)) };
        Some(format!("{gain}τ {} s{ic}", number(tau)))
    }

    fn symbol(&self, pen: &mut Pen) {
        pen.frame();
        pen.text(0.0, -4.0, "tiny", "1");
        pen.outline("plot", &[(-0.6, 0.0), (0.6, 0.0)], false);
        pen.text(0.0, 13.0, "tiny", "1+τs");
    }
}

/// `dy/dt = c · curve(Σ terms)`, the curve with corners at `±half`.
fn follow(to: &mut Lowering, o: Slot, terms: &[Term], half: f64, pieces: &[Piece], c: f64) {
    let slot = to.hidden();
    to.sum_into(slot, terms);
    let driven = to.hidden();
    to.curve_into(driven, Term { slot, c: 1.0 }, &[-half, half], pieces);
    to.rate(o, &[Term { slot: driven, c }]);
}
