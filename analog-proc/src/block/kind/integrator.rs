//! `integrator`: the sum integrated, with feedback diodes and a mode of its own.

use super::*;
use engine::element::integrator::{Control, Stops};
use engine::element::piecewise::Piecewise;

kind! {
    /// `reset_to` is read just before the edge.
    Integrator(integrator) { ic: f64, limits: Option<[f64; 2]>, operate: Option<NetId>, reset: Option<NetId>, reset_to: Option<Input> }
    "integrator", "dy/dt = Σ",
    "`ic` (0); `limits = [low, high]`: feedback diodes, no wind-up; `operate`: logic net, holds while 0; `reset`: logic net, on its rising edge y takes `reset-to` (an input; default the IC) and stays while it is 1",
    r#"in = ["a", "-2 * b"], ic = 1.0, limits = [-5, 5], operate = "p""#, storage: Storage::State,
    class: Some(BlockClass::Integrator), size: (66.0, 48.0),
}

fn integrator(f: &mut Fields<'_, '_>) -> Option<Integrator> {
    let ic = f.number("ic", Some(0.0));
    let limits = f.pair_or_none("limits");
    let operate = f.net_or_none("operate");
    let reset = f.net_or_none("reset");
    let reset_to = f.input_or_none("reset-to");
    if f.place("reset-to").is_some() && f.place("reset").is_none() {
        f.missing("reset", "\"NET\", the logic net that triggers `reset-to`");
        return None;
    }
    let (ic, limits) = (ic?, limits?);
    if let Some([low, high]) = limits {
        if !f.ordered("limits", low, high) {
            return None;
        }
        if ic < low || ic > high {
            let help = "the feedback diodes would conduct at once: move the IC or the limits";
            f.fault_at("ic", Flaw::IcOutsideLimits { ic, low, high }, help);
            return None;
        }
    }
    Some(Integrator { ic, limits, operate: operate?, reset: reset?, reset_to: reset_to? })
}

impl Component for Integrator {
    fn sides(&self) -> Vec<Side> {
        let reset_to = self.reset_to.map(|Input { net, coefficient, .. }| Side {
            coefficient,
            is_logic: false,
            ..Side::logic("IC", net)
        });
        let operate = self.operate.map(|net| Side::logic("OP", net));
        let reset = self.reset.map(|net| Side::logic("R", net));
        [reset_to, operate, reset].into_iter().flatten().collect()
    }

    fn lower_inputs(&self, to: &mut Lowering, block: &Block, o: Slot) {
        to.m.ics[o as usize] = self.ic;
        let mut terms = to.terms(&block.inputs);
        let mut stops = None;
        if let Some([low, high]) = self.limits {
            let rate = to.sum(&block.inputs);
            let element = Piecewise::Stops(Stops { state: o, rate, low, high });
            stops = Some(to.element(element, &[o, rate.slot]));
            terms = vec![rate];
        }
        to.rate(o, &terms);
        if stops.is_some() || self.operate.is_some() || self.reset.is_some() {
            let control = Control {
                state: o,
                operate: self.operate.map(|n| to.slot(n)),
                reset: self.reset.map(|n| to.slot(n)),
                reset_to: self.reset_to.as_ref().map(|i| to.term(i)),
                stops,
            };
            to.m.controls.push(control);
        }
    }

    fn caption(&self) -> Option<String> {
        let ic = format!("IC {}", number(self.ic));
        Some(match self.limits {
            Some([low, high]) => format!("{ic}  [{}, {}]", number(low), number(high)),
            None => ic,
        })
    }

    fn symbol(&self, pen: &mut Pen) {
        let back = -1.0 + 11.0 / pen.half_width;
        pen.outline("body", &[(back, -1.0), (1.0, 0.0), (back, 1.0)], true);
        pen.outline("body", &[(-1.0, -1.0), (back, -1.0), (back, 1.0), (-1.0, 1.0)], true);
    }
}
