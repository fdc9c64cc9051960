//! Elements with regions: everything whose right-hand side has corners or jumps.
//!
//! Within a step the region is frozen, so that the equations are smooth; the
//! witness function ([`Piecewise::margin`]) is positive where the region must
//! be left. The region is chosen anew only at events, by [`Piecewise::choose`],
//! and the two agree: a region is kept exactly while its margin is not positive.

use crate::block::curve::{Curve, Piece};
use crate::block::friction::{Friction, STUCK};
use crate::block::integrator::Stops;
use crate::block::surface::Cell;
use crate::machine::{Frozen, Machine};
use crate::op::{Slot, Term};

/// Region of an element that has not been settled yet.
pub(crate) const UNSET: u32 = u32::MAX;

/// What cannot be passed: it ends the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fatal {
    DividedByZero,
    NegativeRoot,
}

/// What choosing a region did.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Choice {
    pub moved: bool,
    pub overloaded: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Piecewise {
    Curve(Curve),
    /// Dead zone whose half width is a net.
    DeadZone {
        u: Term,
        width: Slot,
    },
    /// Limiter whose levels are nets. Where they have crossed, the upper one holds.
    Limiter {
        u: Term,
        low: Slot,
        high: Slot,
    },
    /// The term, of `len` from `start`, that is greatest after multiplication by `sign`.
    Extremum {
        start: u32,
        len: u32,
        sign: f64,
    },
    Comparator {
        u: Term,
        on_above: f64,
        off_at: f64,
    },
    Relay {
        u: Term,
        points: [f64; 2],
        outputs: [f64; 2],
        initially_on: bool,
    },
    Friction(Friction),
    Cell(Cell),
    /// Half plane of an arctangent.
    Sheet {
        y: Term,
    },
    Divisor {
        u: Term,
    },
    Radicand {
        u: Term,
    },
    /// Latches once `|net|` exceeds the level.
    Overload {
        net: Slot,
        level: f64,
    },
    Stops(Stops),
}

/// Makes a closed surface (reached at equality) count as crossed at equality.
#[inline(always)]
fn closed(margin: f64) -> f64 {
    if margin == 0.0 {
        f64::MIN_POSITIVE
    } else {
        margin
    }
}

/// An overload witness: every block with a `max` has one, so they are looked at in one loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OverloadWatch {
    pub element: u32,
    net: Slot,
    level: f64,
}

impl OverloadWatch {
    pub fn of(piecewise: &Piecewise, element: u32) -> Option<OverloadWatch> {
        match *piecewise {
            Piecewise::Overload { net, level } => Some(OverloadWatch {
                element,
                net,
                level,
            }),
            _ => None,
        }
    }

    #[inline(always)]
    pub fn margin(&self, region: u32, nets: &[f64]) -> f64 {
        if region == 0 {
            nets[self.net as usize].abs() - self.level
        } else {
            f64::NEG_INFINITY
        }
    }
}

impl Piecewise {
    /// Positive where the present region must be left; its zero is the switching surface.
    #[inline]
    pub fn margin(&self, region: u32, m: &Machine, nets: &[f64]) -> f64 {
        match self {
            Piecewise::Curve(curve) => curve.margin(region, &m.breakpoints, nets),
            Piecewise::DeadZone { u, width } => {
                let (u, w) = (u.of(nets), nets[*width as usize]);
                let band = 4.0 * f64::EPSILON * w.abs();
                match region {
                    0 => u + w - band,
                    1 => u.abs() - w - band,
                    _ => w - u - band,
                }
            }
            Piecewise::Limiter { u, low, high } => {
                let (u, low, high) = (u.of(nets), nets[*low as usize], nets[*high as usize]);
                let band = 4.0 * f64::EPSILON * low.abs().max(high.abs());
                match region {
                    0 => (u - low).max(u - high) - band,
                    1 => (u - high).max(low - u) - band,
                    _ => high - u - band,
                }
            }
            Piecewise::Extremum { start, len, sign } => {
                let terms = &m.terms[*start as usize..(*start + *len) as usize];
                let mine = sign * terms[region as usize].of(nets);
                let mut best = f64::NEG_INFINITY;
                for (i, term) in terms.iter().enumerate() {
                    if i != region as usize {
                        best = best.max(sign * term.of(nets));
                    }
                }
                best - mine - 4.0 * f64::EPSILON * mine.abs()
            }
            Piecewise::Comparator {
                u,
                on_above,
                off_at,
            } => {
                if region == 0 {
                    u.of(nets) - on_above
                } else {
                    closed(off_at - u.of(nets))
                }
            }
            Piecewise::Relay { u, points, .. } => {
                if region == 0 {
                    u.of(nets) - points[1]
                } else {
                    points[0] - u.of(nets)
                }
            }
            Piecewise::Friction(friction) => friction.margin(region, nets),
            Piecewise::Cell(cell) => {
                m.tables[cell.table as usize].margin(region, cell.x.of(nets), cell.y.of(nets))
            }
            Piecewise::Sheet { y } => {
                if region == 0 {
                    -y.of(nets)
                } else {
                    closed(y.of(nets))
                }
            }
            Piecewise::Divisor { u } => closed(if region == 0 { -u.of(nets) } else { u.of(nets) }),
            Piecewise::Radicand { u } => -u.of(nets),
            Piecewise::Overload { net, level } => {
                if region == 0 {
                    nets[*net as usize].abs() - level
                } else {
                    f64::NEG_INFINITY
                }
            }
            Piecewise::Stops(stops) => stops.margin(region, nets),
        }
    }

    /// The net that an overload witness watches.
    pub fn watched_net(&self) -> Option<Slot> {
        match self {
            Piecewise::Overload { net, .. } => Some(*net),
            _ => None,
        }
    }

    /// The fault of leaving the region within a step, where that is one whatever else
    /// happens at that instant.
    pub fn fatal(&self) -> Option<Fatal> {
        match self {
            Piecewise::Divisor { .. } => Some(Fatal::DividedByZero),
            _ => None,
        }
    }

    /// Chooses the region from the inputs as they are, and puts it in force. `sharp`: what has
    /// no memory turns exactly at its corner, without the allowance for rounding.
    pub fn choose(
        &self,
        e: usize,
        m: &Machine,
        f: &mut Frozen,
        nets: &mut [f64],
        sharp: bool,
    ) -> Result<Choice, Fatal> {
        let old = f.region[e];
        let known = (old != UNSET).then_some(old);
        if let Some(region) = known
            && !matches!(self, Piecewise::Stops(_))
            && !(sharp && self.has_allowance())
            && self.margin(region, m, nets) <= 0.0
        {
            // A digital function may have new ordinates in the same region.
            if let Piecewise::Curve(curve) = self {
                curve.install(region, f, e);
            }
            return Ok(Choice::default());
        }
        let new = self.region(known, m, nets)?;
        f.region[e] = new;
        let mut choice = Choice::default();
        match self {
            Piecewise::Curve(curve) => curve.install(new, f, e),
            Piecewise::Comparator { .. } => f.piece[e] = Piece::flat(f64::from(new)),
            Piecewise::Relay { outputs, .. } => f.piece[e] = Piece::flat(outputs[new as usize]),
            Piecewise::Friction(friction) => {
                f.piece[e] = friction.piece(new);
                if let (STUCK, Some(state)) = (new, friction.state) {
                    choice.moved = nets[state as usize] != 0.0;
                    nets[state as usize] = 0.0;
                }
            }
            Piecewise::Stops(stops) => {
                if let Some(stand) = stops.stand(new) {
                    choice.moved = nets[stops.state as usize] != stand;
                    nets[stops.state as usize] = stand;
                }
            }
            Piecewise::Overload { .. } => choice.overloaded = new == 1,
            _ => {}
        }
        Ok(choice)
    }

    /// Whether the margin allows for rounding at a corner where nothing jumps.
    fn has_allowance(&self) -> bool {
        matches!(
            self,
            Piecewise::Curve(_)
                | Piecewise::DeadZone { .. }
                | Piecewise::Limiter { .. }
                | Piecewise::Extremum { .. }
        )
    }

    fn region(&self, known: Option<u32>, m: &Machine, nets: &[f64]) -> Result<u32, Fatal> {
        Ok(match self {
            Piecewise::Curve(curve) => curve.locate(&m.breakpoints, nets),
            Piecewise::DeadZone { u, width } => {
                let (u, w) = (u.of(nets), nets[*width as usize]);
                if u > w {
                    2
                } else if u < -w {
                    0
                } else {
                    1
                }
            }
            Piecewise::Limiter { u, low, high } => {
                let u = u.of(nets);
                if u > nets[*high as usize] {
                    2
                } else if u < nets[*low as usize] {
                    0
                } else {
                    1
                }
            }
            Piecewise::Extremum { start, len, sign } => {
                let terms = &m.terms[*start as usize..(*start + *len) as usize];
                let mut best = 0;
                for (i, term) in terms.iter().enumerate() {
                    if sign * term.of(nets) > sign * terms[best].of(nets) {
                        best = i;
                    }
                }
                best as u32
            }
            Piecewise::Comparator {
                u,
                on_above,
                off_at,
            } => {
                let u = u.of(nets);
                let above = match known {
                    Some(0) => u > *on_above,
                    Some(_) => u > *off_at,
                    None => u > 0.5 * (on_above + off_at),
                };
                u32::from(above)
            }
            Piecewise::Relay {
                u,
                points,
                initially_on,
                ..
            } => {
                let u = u.of(nets);
                let on = known.map_or(*initially_on, |r| r == 1);
                u32::from(if on { u >= points[0] } else { u > points[1] })
            }
            Piecewise::Friction(friction) => friction.choose(known, nets),
            Piecewise::Cell(cell) => {
                m.tables[cell.table as usize].locate(cell.x.of(nets), cell.y.of(nets))
            }
            Piecewise::Sheet { y } => u32::from(y.of(nets) < 0.0),
            // A jump over zero at an event is no division by zero; a passage through it
            // within a step is one, and is refused where it is located.
            Piecewise::Divisor { u } => match u.of(nets) {
                0.0 => return Err(Fatal::DividedByZero),
                u => u32::from(u < 0.0),
            },
            Piecewise::Radicand { u } => {
                if u.of(nets) < 0.0 {
                    return Err(Fatal::NegativeRoot);
                }
                0
            }
            Piecewise::Overload { net, level } => {
                u32::from(known == Some(1) || nets[*net as usize].abs() > *level)
            }
            Piecewise::Stops(stops) => stops.choose(nets),
        })
    }
}
