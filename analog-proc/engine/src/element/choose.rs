//! Regions of elements: their sides, and the choice among them.

use super::curve::{Piece, allowance};
use super::friction::STUCK;
use super::piecewise::{Choice, Fatal, LOWER_SHEET, Piecewise, UNSET};
use crate::machine::{Frozen, Machine};
use crate::op::Slot;
use crate::signal::Signal;

/// Makes a closed surface (reached at equality) count as crossed at equality.
#[inline(always)]
fn closed<N: Signal>(side: N) -> N {
    if side.value() == 0.0 { side + N::constant(f64::MIN_POSITIVE) } else { side }
}

impl Piecewise {
    /// The sides of the present region: each is smooth within a step, and positive where
    /// the region must be left; its zero is the switching surface.
    #[inline]
    pub fn sides<N: Signal>(&self, region: u32, m: &Machine, nets: &[N], put: &mut impl FnMut(N)) {
        let net = |slot: Slot| nets[slot as usize];
        let rounding = |value: f64| N::constant(4.0 * f64::EPSILON * value.abs());
        // From a flat piece to a slope; a slope ends at its corner (`allowance`).
        let out_of_flat = |value: f64| rounding(2.0 * value);
        match self {
            Piecewise::Curve(curve) => {
                curve.sides(region, &m.breakpoints, &m.initial_pieces, nets, put);
            }
            Piecewise::DeadZone { u, width } => {
                let (u, w) = (u.of(nets), net(*width));
                let band = out_of_flat(w.value());
                match region {
                    0 => put(u + w),
                    1 => {
                        put(u - w - band);
                        put(-u - w - band);
                    }
                    _ => put(w - u),
                }
            }
            Piecewise::Limiter { u, low, high } => {
                let (u, low, high) = (u.of(nets), net(*low), net(*high));
                let band = out_of_flat(low.value().abs().max(high.value().abs()));
                match region {
                    0 => {
                        put(u - low - band);
                        put(u - high - band);
                    }
                    1 => {
                        put(u - high);
                        put(low - u);
                    }
                    _ => put(high - u - band),
                }
            }
            Piecewise::Extremum { start, len, sign } => {
                let terms = &m.terms[*start as usize..(*start + *len) as usize];
                let mine: N = terms[region as usize].of(nets) * *sign;
                let band = rounding(mine.value()).value();
                for (i, term) in terms.iter().enumerate() {
                    if i != region as usize {
                        let other: N = term.of(nets) * *sign;
                        // What stands is a limit to the others; at rest the greatest is taken.
                        let allowed = match (mine.rate(), other.rate()) {
                            (Some(from), Some(to)) => allowance(band, from == 0.0, to == 0.0),
                            _ => 0.0,
                        };
                        put(other - mine - N::constant(allowed));
                    }
                }
            }
            Piecewise::Comparator { u, on_above, off_at } => put(if region == 0 {
                u.of(nets) - N::constant(*on_above)
            } else {
                closed(N::constant(*off_at) - u.of(nets))
            }),
            Piecewise::Relay { u, points, .. } => put(if region == 0 {
                u.of(nets) - N::constant(points[1])
            } else {
                N::constant(points[0]) - u.of(nets)
            }),
            Piecewise::Friction(friction) => friction.sides(region, nets, put),
            Piecewise::Cell(cell) => {
                let table = &m.tables[cell.table as usize];
                table.sides(region, cell.x.of(nets), cell.y.of(nets), put);
            }
            Piecewise::Sheet { y } => put(match region {
                0 => -y.of(nets),
                LOWER_SHEET => closed(y.of(nets)),
                _ => y.of(nets),
            }),
            Piecewise::Divisor { u } => {
                put(closed(if region == 0 { -u.of(nets) } else { u.of(nets) }))
            }
            Piecewise::Radicand { u } => put(-u.of(nets)),
            Piecewise::Overload { net: slot, level } => {
                if region == 0 {
                    let level = N::constant(*level);
                    put(net(*slot) - level);
                    put(-net(*slot) - level);
                }
            }
            Piecewise::Stops(stops) => stops.sides(region, nets, put),
        }
    }

    /// The region beyond a side, of what turns a corner there and has no memory.
    pub(crate) fn beyond(&self, region: u32, side: usize) -> Option<u32> {
        match self {
            // The lower side comes first; the lowest region has none.
            Piecewise::Curve(_) => {
                Some(if side == 0 && region > 0 { region - 1 } else { region + 1 })
            }
            Piecewise::DeadZone { .. } | Piecewise::Limiter { .. } => Some(match (region, side) {
                (0, 1) | (1, 0) => 2,
                (1, _) => 0,
                _ => 1,
            }),
            // Its sides are those of the other terms in order.
            Piecewise::Extremum { .. } => {
                let other = side as u32;
                Some(if other < region { other } else { other + 1 })
            }
            _ => None,
        }
    }

    /// Whether the region is kept: no side is positive, but for what is held.
    fn keeps(&self, e: usize, region: u32, m: &Machine, f: &Frozen, nets: &[f64]) -> bool {
        let held = m.first_side[e].map_or(&[][..], |first| &f.held[first as usize..]);
        let mut held = held.iter();
        let mut kept = true;
        self.sides(region, m, nets, &mut |side: f64| {
            // What is undefined is not kept.
            kept &= side <= held.next().copied().unwrap_or(0.0);
        });
        kept
    }

    /// Chooses the region from the inputs as they are, and puts it in force. `sharp`: what has
    /// no memory turns exactly at its corner, without the allowance for rounding.
    pub(crate) fn choose(
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
            && self.keeps(e, region, m, f, nets)
        {
            // A digital function may have new ordinates in the same region.
            if let Piecewise::Curve(curve) = self {
                f.piece[e] = curve.piece(region, &f.pieces);
            }
            return Ok(Choice::default());
        }
        let new = self.region(known, m, nets)?;
        f.region[e] = new;
        let mut choice = Choice::default();
        match self {
            Piecewise::Curve(curve) => f.piece[e] = curve.piece(new, &f.pieces),
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
        matches!(self, Piecewise::Curve(_) | Piecewise::DeadZone { .. } | Piecewise::Limiter { .. })
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
            Piecewise::Comparator { u, on_above, off_at } => {
                let u = u.of(nets);
                let above = match known {
                    Some(0) => u > *on_above,
                    Some(_) => u > *off_at,
                    None => u > 0.5 * (on_above + off_at),
                };
                u32::from(above)
            }
            Piecewise::Relay { u, points, initially_on, .. } => {
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
