//! What each operation computes.
//!
//! One match evaluates them all: no dispatch by pointer, no hashing, no allocation. What stands
//! still within a step comes from [`Frozen`].

use crate::element::friction::STUCK;
use crate::machine::{Frozen, Machine};
use crate::op::Op;
use crate::signal::Signal;

impl Machine {
    #[inline(always)]
    fn sum<N: Signal>(&self, start: u32, len: u32, nets: &[N]) -> N {
        let terms = &self.terms[start as usize..(start + len) as usize];
        let Some((first, rest)) = terms.split_first() else {
            return N::constant(0.0);
        };
        rest.iter().fold(first.of(nets), |sum, term| sum + term.of(nets))
    }

    /// Evaluates one operation.
    #[inline]
    pub(crate) fn evaluate<N: Signal>(&self, op: &Op, f: &Frozen, t_s: f64, nets: &mut [N]) {
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        let on = |level: bool| N::constant(f64::from(level));
        match *op {
            Op::Sum1 { o, a, ca } => net!(o) = net!(a) * ca,
            Op::Sum2 { o, a, b, ca, cb } => net!(o) = net!(a) * ca + net!(b) * cb,
            Op::Sum3 { o, a, b, d, ca, cb, cd } => {
                net!(o) = net!(a) * ca + net!(b) * cb + net!(d) * cd;
            }
            Op::SumN { o, start, len } => net!(o) = self.sum(start, len, nets),
            Op::Product { o, a, b, c } => net!(o) = net!(a) * c * net!(b),
            Op::Quotient { o, a, b, c } => net!(o) = net!(a) * c / net!(b),
            Op::Root { o, a, c } => net!(o) = (net!(a) * c).root(),
            Op::Sine { o, a, c } => net!(o) = (net!(a) * c).sin(),
            Op::Cosine { o, a, c } => net!(o) = (net!(a) * c).cos(),
            Op::SinCos { o, a, c } => {
                let (sin, cos) = (net!(a) * c).sin_cos();
                net!(o) = sin;
                net!(o + 1) = cos;
            }
            Op::Rotate { x, y, start } => {
                let i = start as usize;
                let (u, v) = (self.terms[i].of(nets), self.terms[i + 1].of(nets));
                let sine = self.terms[i + 2];
                let (sin, cos) = (sine.of(nets), net!(sine.slot + 1));
                net!(x) = u * cos - v * sin;
                net!(y) = u * sin + v * cos;
            }
            Op::Arctangent { o, e, y, x } => {
                let (y, x): (N, N) = (y.of(nets), x.of(nets));
                net!(o) = if y.value() == 0.0 && x.value() == 0.0 {
                    N::constant(f.piece[e as usize].y0)
                } else {
                    N::angle(y, x, f.region[e as usize])
                };
            }
            Op::Curve { o, e, a, c } => net!(o) = f.piece[e as usize].at(net!(a) * c),
            Op::Constant { o, e } => net!(o) = N::constant(f.piece[e as usize].y0),
            Op::DeadZone { o, e, a, c, w } => {
                net!(o) = dead_zone(f.region[e as usize], net!(a) * c, net!(w));
            }
            Op::Limit { o, e, a, c, low, high } => {
                net!(o) = match f.region[e as usize] {
                    0 => net!(low),
                    1 => net!(a) * c,
                    _ => net!(high),
                };
            }
            Op::Extreme { o, e, start, .. } => {
                net!(o) = self.terms[(start + f.region[e as usize]) as usize].of(nets);
            }
            Op::Surface { o, e, table, x, y } => {
                let (x, y) = (x.of(nets), y.of(nets));
                net!(o) = self.tables[table as usize].at(f.region[e as usize], x, y);
            }
            Op::Friction { o, e, a, c } => {
                net!(o) = if f.region[e as usize] == STUCK {
                    net!(a) * -c
                } else {
                    N::constant(f.piece[e as usize].y0)
                };
            }
            Op::Dac { o, hold } => net!(o) = f.holds[hold as usize].signal(t_s),
            Op::Mdac { o, hold, a, c } => {
                net!(o) = f.holds[hold as usize].signal::<N>(t_s) * c * net!(a);
            }
            Op::Dcu { o, dcu, a, c } => net!(o) = net!(a) * (f.dcus[dcu as usize] * c),
            Op::Switch { o, control, a, b } => {
                net!(o) = if net!(control).value() != 0.0 { a.of(nets) } else { b.of(nets) };
            }
            Op::Track { o, control, a, c, store } => {
                net!(o) = if net!(control).value() != 0.0 {
                    net!(a) * c
                } else {
                    N::constant(f.tracked[store as usize])
                };
            }
            Op::Delay { o, line } => net!(o) = f.lines[line as usize].signal(t_s),
            Op::Wave { o, wave } => {
                let w = &self.waves[wave as usize];
                net!(o) = w.signal(t_s, f.started[wave as usize]);
            }
            Op::Time { o } => net!(o) = N::of_time(t_s, t_s, || 1.0),
            Op::And { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = on(terms.iter().all(|term| net!(term.slot).value() != 0.0));
            }
            Op::Or { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = on(terms.iter().any(|term| net!(term.slot).value() != 0.0));
            }
            Op::Not { o, a } => net!(o) = on(net!(a).value() == 0.0),
        }
    }
}

/// A dead zone of half width `w`, by its region.
#[inline(always)]
pub(crate) fn dead_zone<N: Signal>(region: u32, u: N, w: N) -> N {
    match region {
        0 => u + w,
        1 => N::constant(0.0),
        _ => u - w,
    }
}
