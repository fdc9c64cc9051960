//! Dry friction with sticking.
//!
//! Sliding, the force is `−level·sgn(velocity)`; stuck, it balances the applied
//! force, until that exceeds the break-away level. The velocity's zero is
//! located; where the velocity is an integrator's output it is then set to
//! exactly zero, so that a stuck body does not creep.

use crate::element::curve::Piece;
use crate::op::Term;
use crate::signal::Signal;

pub const STUCK: u32 = 0;
const FORWARD: u32 = 1;
const BACKWARD: u32 = 2;

#[derive(Clone, Copy, Debug)]
pub struct Friction {
    pub velocity: Term,
    pub applied: Term,
    pub level: f64,
    pub breakaway: f64,
    /// The state that is the velocity, if it is one.
    pub state: Option<u32>,
}

impl Friction {
    pub fn sides<N: Signal>(&self, region: u32, nets: &[N], put: &mut impl FnMut(N)) {
        match region {
            STUCK => {
                let (applied, limit) = (self.applied.of(nets), N::constant(self.breakaway));
                put(applied - limit);
                put(-applied - limit);
            }
            FORWARD => put(-self.velocity.of(nets)),
            _ => put(self.velocity.of(nets)),
        }
    }

    pub fn choose(&self, region: Option<u32>, nets: &[f64]) -> u32 {
        let velocity = self.velocity.of(nets);
        let applied = self.applied.of(nets);
        let by_velocity = if velocity > 0.0 { FORWARD } else { BACKWARD };
        let by_force = if applied > 0.0 { FORWARD } else { BACKWARD };
        let holds = applied.abs() <= self.breakaway;
        match region {
            Some(STUCK) => by_force,
            Some(_) if holds => STUCK,
            Some(_) => by_velocity,
            None if velocity != 0.0 => by_velocity,
            None if holds => STUCK,
            None => by_force,
        }
    }

    pub fn piece(&self, region: u32) -> Piece {
        Piece::flat(match region {
            STUCK => 0.0,
            FORWARD => -self.level,
            _ => self.level,
        })
    }
}
