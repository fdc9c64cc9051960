//! `rate-limiter`, `backlash`, `lag`: an integrator that follows the sum, as a programmer
//! would patch it.

use super::*;
use crate::block::curve::{Piece, pieces_of_dead_zone, pieces_of_limiter};
use crate::block::scaled;

kind! {
    /// `dy/dt = sat((Σ − y)/tau, ±rate)`.
    RateLimiter { rate: f64, tau: f64, ic: f64 }
    "rate-limiter", "follows Σ, slope within ±`rate`", "`rate` 1/s; `tau` s (1e-3); `ic` (0)",
    r#"in = ["a"], rate = 2.0"#, storage: Storage::State, class: Some(BlockClass::Integrator),
}

impl Component for RateLimiter {
    fn read(f: &mut Fields<'_, '_>) -> Option<Self> {
        let rate = f.positive("rate", None);
        let tau = f.positive("tau", Some(1e-3));
        let ic = f.number("ic", Some(0.0));
        Some(RateLimiter { rate: rate?, tau: tau?, ic: ic? })
    }

    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let RateLimiter { rate, tau, .. } = *self;
        let mut terms = scaled(to.terms(&block.inputs), 1.0 / tau);
        terms.push(Term { slot: o, c: -1.0 / tau });
        follow(to, o, &terms, &[-rate, rate], &pieces_of_limiter(-rate, rate), 1.0);
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
    Backlash { width: f64, tau: f64, ic: f64 }
    "backlash", "follows Σ with play", "`width`, the whole play; `tau` s (1e-3); `ic` (0)",
    r#"in = ["a"], width = 0.2"#, storage: Storage::State, class: Some(BlockClass::DiodeNetwork),
}

impl Component for Backlash {
    fn read(f: &mut Fields<'_, '_>) -> Option<Self> {
        let width = f.positive("width", None);
        let tau = f.positive("tau", Some(1e-3));
        let ic = f.number("ic", Some(0.0));
        Some(Backlash { width: width?, tau: tau?, ic: ic? })
    }

    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        let mut terms = to.terms(&block.inputs);
        terms.push(Term { slot: o, c: -1.0 });
        let half = 0.5 * self.width;
        follow(to, o, &terms, &[-half, half], &pieces_of_dead_zone(half), 1.0 / self.tau);
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
    Lag { tau: f64, gain: f64, ic: f64 }
    "lag", "tau dy/dt = gain Σ − y", "`tau` s; `gain` (1); `ic` (0)", r#"in = ["a"], tau = 0.5"#,
    storage: Storage::State, class: Some(BlockClass::Integrator),
}

impl Component for Lag {
    fn read(f: &mut Fields<'_, '_>) -> Option<Self> {
        let tau = f.positive("tau", None);
        let gain = f.number("gain", Some(1.0));
        let ic = f.number("ic", Some(0.0));
        Some(Lag { tau: tau?, gain: gain?, ic: ic? })
    }

    fn lower(&self, to: &mut Lowering, _: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
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

/// `dy/dt = factor · curve(Σ terms)`.
fn follow(
    to: &mut Lowering,
    o: Slot,
    terms: &[Term],
    corners: &[f64],
    pieces: &[Piece],
    factor: f64,
) {
    let slot = to.hidden();
    to.sum_into(slot, terms);
    let driven = to.hidden();
    to.curve_into(driven, Term { slot, c: 1.0 }, corners, pieces);
    to.rate(o, &[Term { slot: driven, c: factor }]);
}
