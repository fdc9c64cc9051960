//! The operations of the flat program, and what each computes.
//!
//! One match evaluates them all: no dispatch by pointer, no hashing, no
//! allocation. They read and write one flat array of nets by `u32` index;
//! what stands still within a step comes from [`Frozen`]. Which of them run,
//! and when, is decided by [`crate::machine`] and [`crate::kernel`]. It is long, but
//! one concept: an operation's operands and its value belong in one view, and the
//! match that evaluates them must be one match to be fast.

use crate::machine::{Frozen, Machine};

/// Index into the flat array of nets.
pub(crate) type Slot = u32;

/// One weighted net.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Term {
    pub slot: Slot,
    pub c: f64,
}

impl Term {
    #[inline(always)]
    pub fn of(self, nets: &[f64]) -> f64 {
        self.c * nets[self.slot as usize]
    }
}

/// One memoryless operation; `o` is the net it drives, other letters are nets it reads.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Op {
    Sum1 {
        o: Slot,
        a: Slot,
        ca: f64,
    },
    Sum2 {
        o: Slot,
        a: Slot,
        b: Slot,
        ca: f64,
        cb: f64,
    },
    Sum3 {
        o: Slot,
        a: Slot,
        b: Slot,
        d: Slot,
        ca: f64,
        cb: f64,
        cd: f64,
    },
    SumN {
        o: Slot,
        start: u32,
        len: u32,
    },
    /// `c·a·b`.
    Product {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `c·a/b`.
    Quotient {
        o: Slot,
        a: Slot,
        b: Slot,
        c: f64,
    },
    /// `√max(c·a, 0)`: the argument's sign is a guarded surface.
    Root {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Sine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    Cosine {
        o: Slot,
        a: Slot,
        c: f64,
    },
    /// Sine into `o`, cosine into the net after it.
    SinCos {
        o: Slot,
        a: Slot,
        c: f64,
    },
    /// Turns the terms at `start` by the angle whose sine is the term after them.
    Rotate {
        x: Slot,
        y: Slot,
        start: u32,
    },
    Arctangent {
        o: Slot,
        e: u32,
        y: Term,
        x: Term,
    },
    /// The present piece of curve `e`.
    Curve {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    /// The constant of element `e` (comparator, relay).
    Constant {
        o: Slot,
        e: u32,
    },
    DeadZone {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        w: Slot,
    },
    Limit {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
        low: Slot,
        high: Slot,
    },
    /// The present extreme of the terms from `start`.
    Extreme {
        o: Slot,
        e: u32,
        start: u32,
        len: u32,
    },
    Surface {
        o: Slot,
        e: u32,
        table: u32,
        x: Term,
        y: Term,
    },
    Friction {
        o: Slot,
        e: u32,
        a: Slot,
        c: f64,
    },
    Dac {
        o: Slot,
        hold: u32,
    },
    Mdac {
        o: Slot,
        hold: u32,
        a: Slot,
        c: f64,
    },
    Dcu {
        o: Slot,
        dcu: u32,
        a: Slot,
        c: f64,
    },
    Switch {
        o: Slot,
        control: Slot,
        a: Term,
        b: Term,
    },
    Track {
        o: Slot,
        control: Slot,
        a: Slot,
        c: f64,
        store: u32,
    },
    Delay {
        o: Slot,
        line: u32,
    },
    Wave {
        o: Slot,
        wave: u32,
    },
    Time {
        o: Slot,
    },
    And {
        o: Slot,
        start: u32,
        len: u32,
    },
    Or {
        o: Slot,
        start: u32,
        len: u32,
    },
    Not {
        o: Slot,
        a: Slot,
    },
}

impl Op {
    /// Calls `f` with every net that the operation drives.
    pub(crate) fn drives(&self, mut f: impl FnMut(Slot)) {
        match *self {
            Op::Rotate { x, y, .. } => {
                f(x);
                f(y);
            }
            Op::SinCos { o, .. } => {
                f(o);
                f(o + 1);
            }
            Op::Sum1 { o, .. }
            | Op::Sum2 { o, .. }
            | Op::Sum3 { o, .. }
            | Op::SumN { o, .. }
            | Op::Product { o, .. }
            | Op::Quotient { o, .. }
            | Op::Root { o, .. }
            | Op::Sine { o, .. }
            | Op::Cosine { o, .. }
            | Op::Arctangent { o, .. }
            | Op::Curve { o, .. }
            | Op::Constant { o, .. }
            | Op::DeadZone { o, .. }
            | Op::Limit { o, .. }
            | Op::Extreme { o, .. }
            | Op::Surface { o, .. }
            | Op::Friction { o, .. }
            | Op::Dac { o, .. }
            | Op::Mdac { o, .. }
            | Op::Dcu { o, .. }
            | Op::Switch { o, .. }
            | Op::Track { o, .. }
            | Op::Delay { o, .. }
            | Op::Wave { o, .. }
            | Op::Time { o }
            | Op::And { o, .. }
            | Op::Or { o, .. }
            | Op::Not { o, .. } => f(o),
        }
    }

    /// Calls `f` with every net that the operation reads.
    pub(crate) fn reads(&self, terms: &[Term], mut f: impl FnMut(Slot)) {
        let listed = |start: u32, len: u32, f: &mut dyn FnMut(Slot)| {
            for term in &terms[start as usize..(start + len) as usize] {
                f(term.slot);
            }
        };
        match *self {
            Op::Constant { .. }
            | Op::Dac { .. }
            | Op::Delay { .. }
            | Op::Wave { .. }
            | Op::Time { .. } => {}
            Op::Sum1 { a, .. }
            | Op::Root { a, .. }
            | Op::Sine { a, .. }
            | Op::Cosine { a, .. }
            | Op::SinCos { a, .. }
            | Op::Curve { a, .. }
            | Op::Friction { a, .. }
            | Op::Mdac { a, .. }
            | Op::Dcu { a, .. }
            | Op::Not { a, .. } => f(a),
            Op::Sum2 { a, b, .. } | Op::Product { a, b, .. } | Op::Quotient { a, b, .. } => {
                f(a);
                f(b);
            }
            Op::Sum3 { a, b, d, .. } => {
                f(a);
                f(b);
                f(d);
            }
            Op::SumN { start, len, .. }
            | Op::Extreme { start, len, .. }
            | Op::And { start, len, .. }
            | Op::Or { start, len, .. } => listed(start, len, &mut f),
            Op::Rotate { start, .. } => {
                listed(start, 3, &mut f);
                f(terms[start as usize + 2].slot + 1);
            }
            Op::Arctangent { y, x, .. } | Op::Surface { y, x, .. } => {
                f(y.slot);
                f(x.slot);
            }
            Op::DeadZone { a, w, .. } => {
                f(a);
                f(w);
            }
            Op::Limit { a, low, high, .. } => {
                f(a);
                f(low);
                f(high);
            }
            Op::Switch { control, a, b, .. } => {
                f(control);
                f(a.slot);
                f(b.slot);
            }
            Op::Track { control, a, .. } => {
                f(control);
                f(a);
            }
        }
    }
}

impl Machine {
    #[inline(always)]
    pub(crate) fn sum(&self, start: u32, len: u32, nets: &[f64]) -> f64 {
        let terms = &self.terms[start as usize..(start + len) as usize];
        terms.iter().map(|term| term.of(nets)).sum()
    }

    /// Evaluates one operation.
    #[inline]
    pub(crate) fn evaluate(&self, op: &Op, f: &Frozen, t_s: f64, nets: &mut [f64]) {
        macro_rules! net {
            ($s:expr) => {
                nets[$s as usize]
            };
        }
        match *op {
            Op::Sum1 { o, a, ca } => net!(o) = ca * net!(a),
            Op::Sum2 { o, a, b, ca, cb } => net!(o) = ca * net!(a) + cb * net!(b),
            Op::Sum3 {
                o,
                a,
                b,
                d,
                ca,
                cb,
                cd,
            } => {
                net!(o) = ca * net!(a) + cb * net!(b) + cd * net!(d);
            }
            Op::SumN { o, start, len } => net!(o) = self.sum(start, len, nets),
            Op::Product { o, a, b, c } => net!(o) = c * net!(a) * net!(b),
            Op::Quotient { o, a, b, c } => net!(o) = c * net!(a) / net!(b),
            Op::Root { o, a, c } => net!(o) = root(c * net!(a)),
            Op::Sine { o, a, c } => net!(o) = libm::sin(c * net!(a)),
            Op::Cosine { o, a, c } => net!(o) = libm::cos(c * net!(a)),
            Op::SinCos { o, a, c } => {
                let (sin, cos) = libm::sincos(c * net!(a));
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
                let (y, x) = (y.of(nets), x.of(nets));
                net!(o) = crate::block::function::arctangent(y, x, f.region[e as usize]);
            }
            Op::Curve { o, e, a, c } => net!(o) = f.piece[e as usize].at(c * net!(a)),
            Op::Constant { o, e } => net!(o) = f.piece[e as usize].y0,
            Op::DeadZone { o, e, a, c, w } => {
                net!(o) = dead_zone(f.region[e as usize], c * net!(a), net!(w));
            }
            Op::Limit {
                o,
                e,
                a,
                c,
                low,
                high,
            } => {
                net!(o) = match f.region[e as usize] {
                    0 => net!(low),
                    1 => c * net!(a),
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
                net!(o) = if f.region[e as usize] == crate::block::friction::STUCK {
                    -c * net!(a)
                } else {
                    f.piece[e as usize].y0
                };
            }
            Op::Dac { o, hold } => net!(o) = f.holds[hold as usize].at_time(t_s),
            Op::Mdac { o, hold, a, c } => {
                net!(o) = f.holds[hold as usize].at_time(t_s) * c * net!(a);
            }
            Op::Dcu { o, dcu, a, c } => net!(o) = f.dcus[dcu as usize] * c * net!(a),
            Op::Switch { o, control, a, b } => {
                net!(o) = if net!(control) != 0.0 {
                    a.of(nets)
                } else {
                    b.of(nets)
                };
            }
            Op::Track {
                o,
                control,
                a,
                c,
                store,
            } => {
                net!(o) = if net!(control) != 0.0 {
                    c * net!(a)
                } else {
                    f.tracked[store as usize]
                };
            }
            Op::Delay { o, line } => net!(o) = f.lines[line as usize].read(t_s),
            Op::Wave { o, wave } => {
                let w = &self.waves[wave as usize];
                net!(o) = w.at(t_s, f.started[wave as usize]);
            }
            Op::Time { o } => net!(o) = t_s,
            Op::And { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = f64::from(terms.iter().all(|term| net!(term.slot) != 0.0));
            }
            Op::Or { o, start, len } => {
                let terms = &self.terms[start as usize..(start + len) as usize];
                net!(o) = f64::from(terms.iter().any(|term| net!(term.slot) != 0.0));
            }
            Op::Not { o, a } => net!(o) = f64::from(net!(a) == 0.0),
        }
    }
}

/// A dead zone of half width `w`, by its region.
#[inline(always)]
pub(crate) fn dead_zone(region: u32, u: f64, w: f64) -> f64 {
    match region {
        0 => u + w,
        1 => 0.0,
        _ => u - w,
    }
}

/// Square root of the positive part, NaN kept.
#[inline(always)]
fn root(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x.sqrt() }
}
