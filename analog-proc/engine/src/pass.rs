//! The derivative pass: the folded program, run.

use crate::evaluate::dead_zone;
use crate::kernel::{Place, Step};
use crate::machine::{Frozen, Machine};
use crate::op::Slot;
use crate::signal::Signal;

impl Machine {
    /// Multiplies the coefficients now held into the weights, and lists the converters
    /// whose output moves within a step; the nets of the others stand as settled.
    pub(crate) fn load(&self, f: &mut Frozen) {
        f.moving.clear();
        let moves = |dac: &&(Slot, u32)| !f.holds[dac.1 as usize].constant();
        f.moving.extend(self.kernel.dacs.iter().filter(moves));
        for scaled in &self.kernel.scaled {
            let product = scaled.dcus.iter().fold(scaled.base, |c, dcu| c * f.dcus[*dcu as usize]);
            match scaled.place {
                Place::Row(i) => f.weights[i] = product,
                Place::Step { index, k } => f.steps[index].weights()[k] = product,
            }
        }
    }

    /// Derivatives `d` of the states at `t_s`, with the states already in
    /// `nets[..states]`; brings up to date the nets that they depend on.
    #[inline]
    pub(crate) fn derivatives(&self, f: &Frozen, t_s: f64, nets: &mut [f64], d: &mut [f64]) {
        self.steps(f, t_s, nets);
        self.kernel.rows.evaluate(&f.weights, nets, d);
        for (control, &running) in self.controls.iter().zip(&f.running) {
            if !running {
                d[control.state as usize] = 0.0;
            }
        }
    }

    /// Out of line, so that the rare operations do not crowd the frequent ones.
    #[inline(never)]
    fn other(&self, i: usize, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        self.evaluate(&self.kernel.others[i], f, t_s, nets);
    }

    /// The varying nets at `t_s`, without derivatives.
    pub(crate) fn outputs(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        self.steps(f, t_s, nets);
        self.complete(f, t_s, nets);
    }

    /// After [`Machine::derivatives`], the varying nets that it left out.
    pub(crate) fn complete(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for op in &self.kernel.rest {
            self.evaluate(op, f, t_s, nets);
        }
    }

    #[inline(always)]
    fn steps(&self, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        for (o, hold) in &f.moving {
            nets[*o as usize] = f.holds[*hold as usize].at_time(t_s);
        }
        for step in &f.steps {
            self.step(step, f, t_s, nets);
        }
    }

    #[inline(always)]
    fn step(&self, step: &Step, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        match *step {
            Step::Sum1 { o, a, w: [w] } => net!(o) = w * net!(a),
            Step::Sum2 { o, a, b, w } => net!(o) = w[0] * net!(a) + w[1] * net!(b),
            Step::Sum3 { o, a, b, d, w } => {
                net!(o) = w[0] * net!(a) + w[1] * net!(b) + w[2] * net!(d);
            }
            Step::Sum { o, start, len, w } => {
                let slots = &self.kernel.slots[start as usize..(start + len) as usize];
                let weights = &f.weights[w as usize..(w + len) as usize];
                let mut sum = 0.0;
                for (slot, w) in slots.iter().zip(weights) {
                    sum += w * net!(*slot);
                }
                net!(o) = sum;
            }
            Step::Product { o, a, b, w: [w] } => net!(o) = w * net!(a) * net!(b),
            Step::Curve1 { o, e, a, w: [w] } => {
                net!(o) = f.piece[e as usize].at(w * net!(a));
            }
            Step::Curve2 { o, e, a, b, w } => {
                net!(o) = f.piece[e as usize].at(w[0] * net!(a) + w[1] * net!(b));
            }
            Step::DeadZone1 { o, e, a, width, w: [w] } => {
                net!(o) = dead_zone(f.region[e as usize], w * net!(a), net!(width));
            }
            Step::DeadZone2 { o, e, a, b, width, w } => {
                let u = w[0] * net!(a) + w[1] * net!(b);
                net!(o) = dead_zone(f.region[e as usize], u, net!(width));
            }
            Step::SinCos { o, a, w: [w] } => {
                let (sin, cos) = Signal::sin_cos(w * net!(a));
                net!(o) = sin;
                net!(o + 1) = cos;
            }
            Step::Rotate { x, y, u, v, sin, w } => {
                let (u, v) = (w[0] * net!(u), w[1] * net!(v));
                let (s, c) = (w[2] * net!(sin), net!(sin + 1));
                net!(x) = u * c - v * s;
                net!(y) = u * s + v * c;
            }
            Step::Other { i } => self.other(i as usize, f, t_s, nets),
        }
    }
}
