//! What the surfaces read, with its rates, at any instant of a step.
//!
//! The states and their rates at the ends of a step, or from the dense output
//! between them, are carried through the operations behind the surfaces. What
//! these read besides stands still until the next settling.

use super::Engine;
use super::search::START;
use crate::element::pace::Pace;
use crate::element::piecewise::{LEFT_DOWNWARD, LOWER_SHEET, Piecewise};
use crate::machine::Machine;
use crate::signal::{Doubted, Rated, Signal};
use serde::{Deserialize, Serialize};

/// A side that the present region has not; finite, so that differences of it are numbers.
const ABSENT: f64 = -1e300;

/// Rounding of a state that was reached by steps of different length, in parts of it.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Further from zero than this part of the greatest net, no rounding makes a side positive.
const NEAR: f64 = 1e-9;

/// How far an angle may go on beyond the cut for rounding, rad.
const MOST_BEYOND: f64 = 1e-9;

/// Whether a vector is at its origin and does not stay there.
fn is_passing(y: Rated, x: Rated) -> bool {
    y.value == 0.0 && x.value == 0.0 && (y.rate != 0.0 || x.rate != 0.0)
}

/// The sides of all watched regions at one instant of a step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Node {
    /// Its place in the step, 0 to 1.
    pub theta: f64,
    pub sides: Vec<Rated>,
    /// What rounding alone can have made of each, where it was asked for (`doubted`).
    pub noise: Vec<f64>,
    pub doubted: bool,
}

fn sides<N: Signal>(machine: &Machine, region: &[u32], nets: &[N], sides: &mut [N]) {
    let mut rest = sides;
    for &e in &machine.watched {
        let element = &machine.elements[e as usize].1;
        let (own, others) = rest.split_at_mut(element.side_count());
        let mut own = own.iter_mut();
        element.sides(region[e as usize], machine, nets, &mut |side| {
            if let Some(place) = own.next() {
                *place = side;
            }
        });
        for place in own {
            *place = N::constant(ABSENT);
        }
        rest = others;
    }
}

impl Engine {
    /// After settling: everything from the nets as they stand.
    pub(super) fn watch_start(&mut self) {
        let states = self.step.y0.len();
        for (rated, net) in self.rated_start.iter_mut().zip(&self.nets) {
            *rated = Rated::constant(*net);
        }
        for (rated, rate) in self.rated_start.iter_mut().zip(&self.step.f0) {
            rated.rate = *rate;
        }
        for op in &self.machine.watch {
            let (frozen, t_s) = (&self.frozen, self.t_s);
            self.machine.evaluate(op, frozen, t_s, &mut self.rated_start);
        }
        self.rated[states..].copy_from_slice(&self.rated_start[states..]);
        self.followed = false;
        let region = &self.frozen.region;
        let start = &mut self.nodes[START];
        start.doubted = false;
        sides(&self.machine, region, &self.rated_start, &mut start.sides);
        self.look_at_paces();
    }

    /// Before the directions of vectors at zero are found: what they were does not count.
    pub(super) fn forget_directions(&mut self) {
        for (pace, _) in &self.machine.paces {
            if let Pace::Direction { e, .. } = *pace {
                self.frozen.piece[e as usize].y0 = 0.0;
                let sheet = &mut self.frozen.region[e as usize];
                *sheet = (*sheet).min(LOWER_SHEET);
            }
        }
    }

    /// After settling: where a vector is zero and moves, what stands exactly at its corner and moves
    /// beyond has left it, so that the rates are those of the instants that follow. Whether anything
    /// has.
    pub(super) fn leave_corners(&mut self) -> bool {
        let leaves = |(pace, _): &(Pace, _)| match *pace {
            Pace::Direction { y, x, .. } => {
                let (y, x): (Rated, Rated) = (y.of(&self.rated_start), x.of(&self.rated_start));
                is_passing(y, x)
            }
            _ => false,
        };
        if !self.machine.paces.iter().any(leaves) {
            return false;
        }
        let mut left = None;
        let sides = self.nodes[START].sides.iter().zip(&self.machine.element_of_side).enumerate();
        for (i, (side, &e)) in sides {
            let element = self.machine.elements[e as usize].1;
            let first = self.machine.first_side[e as usize].unwrap_or(i as u32);
            let region = &mut self.frozen.region[e as usize];
            if left != Some(e)
                && side.value == 0.0
                && side.rate > 0.0
                && let Some(beyond) = element.beyond(*region, i - first as usize)
            {
                *region = beyond;
                if let Piecewise::Curve(curve) = element {
                    self.frozen.piece[e as usize] = curve.piece(beyond, &self.frozen.pieces);
                }
                left = Some(e);
            }
        }
        left.is_some()
    }

    /// Within a step: a vector that comes to its origin has there the angle that it comes with; an
    /// event tells to which it leaves. Whether that changes an angle.
    fn arrive_at_origin(&mut self) -> bool {
        let mut changed = false;
        for (i, (pace, _)) in self.machine.paces.iter().enumerate() {
            let Pace::Direction { e, y, x } = *pace else {
                continue;
            };
            let (y, x): (Rated, Rated) = (y.of(&self.rated), x.of(&self.rated));
            if is_passing(y, x) && !self.paces.began_at_origin(i) {
                let sheet = self.frozen.region[e as usize];
                let angle = f64::angle(-y.rate, -x.rate, sheet);
                let place = &mut self.frozen.piece[e as usize].y0;
                changed |= *place != angle;
                *place = angle;
            }
        }
        changed
    }

    /// After settling: a vector that is zero has the angle to which it leaves, and its sheet; zero,
    /// if it does not move. Whether that changes an angle.
    pub(super) fn turn_vectors(&mut self) -> bool {
        let mut turned = false;
        for (pace, _) in &self.machine.paces {
            let Pace::Direction { e, y, x } = *pace else {
                continue;
            };
            let (y, x): (Rated, Rated) = (y.of(&self.rated_start), x.of(&self.rated_start));
            if y.value == 0.0 && x.value == 0.0 {
                let moves = y.rate != 0.0 || x.rate != 0.0;
                let angle = if moves { libm::atan2(y.rate, x.rate) } else { 0.0 };
                let place = &mut self.frozen.piece[e as usize].y0;
                turned |= *place != angle;
                *place = angle;
                self.frozen.region[e as usize] = if angle < 0.0 { LEFT_DOWNWARD } else { 0 };
            }
        }
        turned
    }

    pub(super) fn look_at_paces(&mut self) {
        let (lines, t_s) = (&self.frozen.lines, self.t_s);
        self.paces.look(&self.machine, lines, t_s, &self.rated_start);
    }

    fn rate_nets(&mut self, t_s: f64) {
        for op in &self.machine.watch {
            self.machine.evaluate(op, &self.frozen, t_s, &mut self.rated);
        }
    }

    /// Brings `rated` to the end of the step as it now is.
    pub(super) fn rate_end(&mut self) {
        let ends = self.step.y1.iter().zip(&self.step.f1);
        for (rated, (y, f)) in self.rated.iter_mut().zip(ends) {
            *rated = Rated { value: *y, rate: *f };
        }
        let end_s = self.step.t0_s + self.step.h_s;
        self.rate_nets(end_s);
        if self.arrive_at_origin() {
            self.machine.derivatives(&self.frozen, end_s, &mut self.nets, &mut self.step.f1);
            self.step.evaluations += 1;
            for (rated, f) in self.rated.iter_mut().zip(&self.step.f1) {
                rated.rate = *f;
            }
            self.rate_nets(end_s);
        }
    }

    /// Brings `rated` to the place `theta` of the step.
    pub(super) fn rate_at(&mut self, theta: f64) {
        let moving = Rated { value: theta, rate: 1.0 / self.step.h_s };
        self.step.dense(moving, &mut self.rated);
        self.step.evaluations += 1;
        let t_s = self.step.t0_s + theta * self.step.h_s;
        self.rate_nets(t_s);
        if self.arrive_at_origin() {
            self.rate_nets(t_s);
        }
    }

    /// The sides of what `rated` holds, into a node at `theta`.
    pub(super) fn look_at_sides(&mut self, node: usize, theta: f64) {
        let node = &mut self.nodes[node];
        node.theta = theta;
        node.doubted = false;
        sides(&self.machine, &self.frozen.region, &self.rated, &mut node.sides);
    }

    /// What rounding alone can have made of the sides of a node, while `rated` holds the nets
    /// there (`rated_start` at the start of the step), if that is not known yet.
    pub(super) fn find_noise(&mut self, node: usize) {
        if std::mem::replace(&mut self.nodes[node].doubted, true) {
            return;
        }
        self.doubt(node == START, self.nodes[node].theta);
        let (region, doubts) = (&self.frozen.region, &mut self.doubts);
        sides(&self.machine, region, &self.doubted, doubts);
        let noise = &mut self.nodes[node].noise;
        for (noise, side) in noise.iter_mut().zip(doubts) {
            *noise = if side.doubt.is_finite() { side.doubt } else { 0.0 };
        }
        // What is doubted of a short vector is no reason to let its angle go on beyond the cut.
        let nets = if node == START { &self.rated_start } else { &self.rated };
        for (pace, _) in &self.machine.paces {
            if let Pace::Direction { e, x, .. } = *pace
                && let Some(side) = self.machine.first_side[e as usize]
            {
                let x: Rated = x.of(nets);
                let noise = &mut self.nodes[node].noise[side as usize];
                *noise = noise.min(MOST_BEYOND * x.value.abs());
            }
        }
    }

    /// What rounding leaves undecided of the nets that `rated` holds, at the place `theta` of
    /// the step (of those that `rated_start` holds, `at_start`).
    pub(super) fn doubt(&mut self, at_start: bool, theta: f64) {
        let nets = if at_start { &self.rated_start } else { &self.rated };
        for (doubted, rated) in self.doubted.iter_mut().zip(nets) {
            *doubted = Doubted::constant(rated.value);
        }
        for i in 0..self.step.y0.len() {
            let (value, sunk) = (self.doubted[i].value, self.is_sunk(i));
            self.doubted[i].doubt = if sunk { self.atol[i] } else { ROUNDING * value.abs() };
        }
        let t_s = if at_start { self.t_s } else { self.step.t0_s + theta * self.step.h_s };
        for op in &self.machine.watch {
            self.machine.evaluate(op, &self.frozen, t_s, &mut self.doubted);
        }
    }

    /// Before settling: a signal that is within rounding of a surface and moves away from it has
    /// not crossed it, unless something jumps.
    pub(super) fn hold_what_leaves(&mut self) {
        let near = NEAR * self.greatest_net();
        let sides = &self.nodes[START].sides;
        if sides.iter().any(|side| side.rate < 0.0 && side.value.abs() <= near) {
            self.find_noise(START);
        }
        let start = &self.nodes[START];
        let sides = start.sides.iter().zip(&start.noise);
        for (held, (side, noise)) in self.frozen.held.iter_mut().zip(sides) {
            let leaves = start.doubted && side.rate < 0.0 && side.value.abs() <= *noise;
            *held = if leaves { *noise } else { 0.0 };
        }
    }
}

impl Machine {
    /// Whether a side is that of an arctangent's sheet: beyond it the angle goes on, so that
    /// rounding is no reason to leave the sheet, but one to stay (a vector that comes to rest on
    /// the cut, or touches it, has not crossed it).
    #[inline(always)]
    pub(super) fn is_sheet(&self, side: usize) -> bool {
        let element = self.element_of_side[side];
        matches!(self.elements[element as usize].1, Piecewise::Sheet { .. })
    }

    /// Whether a side is positive: what returns is so only by more than its rounding, and so is
    /// that of a sheet.
    #[inline(always)]
    pub(super) fn is_beyond(&self, i: usize, side: Rated, noise: f64) -> bool {
        side.value > 0.0
            && (side.value > noise.max(f64::MIN_POSITIVE) || side.rate >= 0.0 && !self.is_sheet(i))
    }
}
