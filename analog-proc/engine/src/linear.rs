//! A machine made linear about where it stands: ẋ = A x + B u, y = C x + D u.
//!
//! Regions are frozen, so that every operation has a derivative; it is carried from each state and
//! input through the operations to the rates of the states and to the outputs (forward mode, no
//! differences). What follows from time alone (waveforms, converters' holds, noise, timers) and what is stored
//! stands still; a transport delay has no finite state and is refused where it takes part.

use crate::element::piecewise::Piecewise;
use crate::fault::RunFault;
use crate::id::NetId;
use crate::machine::Settle;
use crate::op::{Op, Slot};
use crate::signal::{Rated, Signal};
use crate::simulation::Simulation;
use nalgebra::{Complex, DMatrix, linalg::balancing::balance_parlett_reinsch};

/// A side is on its corner within so many roundings of it: what it allows before it switches.
const NEAR: f64 = 16.0;

/// The four matrices; states in the order of [`Machine::block_of_state`](crate::machine::Machine),
/// inputs and outputs as asked. Units are those of the nets, and per second.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// States by states, per second.
    pub a: DMatrix<f64>,
    /// States by inputs, per second.
    pub b: DMatrix<f64>,
    /// Outputs by states.
    pub c: DMatrix<f64>,
    /// Outputs by inputs.
    pub d: DMatrix<f64>,
}

impl Simulation {
    /// The linear model about the present state; an input stands for whatever drives its net now.
    ///
    /// # Errors
    /// [`RunFault::Delayed`] where a transport delay takes part, [`RunFault::NoSlope`] where an
    /// operation has no derivative, as a square root at zero, [`RunFault::OnCorner`] where it has two.
    pub fn linearise(&self, inputs: &[NetId], outputs: &[NetId]) -> Result<Linear, RunFault> {
        let machine = self.machine();
        let slots = |nets: &[NetId]| -> Vec<Slot> {
            nets.iter().map(|net| machine.slot_of_net[net.index()]).collect()
        };
        let (inputs, outputs) = (slots(inputs), slots(outputs));
        let n = machine.states;
        let mut linear = Linear {
            a: DMatrix::zeros(n, n),
            b: DMatrix::zeros(n, inputs.len()),
            c: DMatrix::zeros(outputs.len(), n),
            d: DMatrix::zeros(outputs.len(), inputs.len()),
        };
        self.expect_no_corner()?;
        for op in machine.settle.iter().filter_map(operation) {
            if let Op::Delay { o, .. } = *op
                && !inputs.contains(&o)
            {
                let (rates, answers) = self.slopes(o, &inputs, &outputs);
                if rates.iter().chain(&answers).any(|slope| *slope != 0.0) {
                    let block = machine.block_of_slot[o as usize];
                    return Err(RunFault::Delayed { block: machine.block_name(block) });
                }
            }
        }
        for state in 0..n as Slot {
            let (rates, answers) = self.slopes(state, &inputs, &outputs);
            linear.a.column_mut(state as usize).copy_from_slice(&rates);
            linear.c.column_mut(state as usize).copy_from_slice(&answers);
        }
        for (k, &input) in inputs.iter().enumerate() {
            let (rates, answers) = self.slopes(input, &inputs, &outputs);
            linear.b.column_mut(k).copy_from_slice(&rates);
            linear.d.column_mut(k).copy_from_slice(&answers);
        }
        let of_states = machine.block_of_state.iter().copied();
        let of_outputs = outputs.iter().map(|slot| machine.block_of_slot[*slot as usize]);
        let states = of_states.enumerate().map(|row| (row, &linear.a, &linear.b));
        let answers = of_outputs.enumerate().map(|row| (row, &linear.c, &linear.d));
        for ((i, block), by_states, by_inputs) in states.chain(answers) {
            let (by_states, by_inputs) = (by_states.row(i), by_inputs.row(i));
            if by_states.iter().chain(by_inputs.iter()).any(|slope| !slope.is_finite()) {
                let block = machine.block_name(block);
                return Err(RunFault::NoSlope { block, t_s: self.now_s() });
            }
        }
        Ok(linear)
    }

    /// A signal that stands on a corner has one slope before and another after it.
    fn expect_no_corner(&self) -> Result<(), RunFault> {
        let (machine, engine) = (self.machine(), self.engine());
        for &e in &machine.watched {
            let (block, element) = &machine.elements[e as usize];
            let net = |slot: Slot| engine.nets[slot as usize].abs();
            // What bends, and how large its corners are.
            let scale = match element {
                Piecewise::Curve(curve) => curve.band / f64::EPSILON,
                Piecewise::DeadZone { width, .. } => net(*width),
                Piecewise::Limiter { low, high, .. } => net(*low).max(net(*high)),
                Piecewise::Extremum { start, len, .. } => {
                    let terms = &machine.terms[*start as usize..(start + len) as usize];
                    terms.iter().map(|term| net(term.slot) * term.c.abs()).fold(0.0, f64::max)
                }
                Piecewise::Cell(_) => 0.0,
                _ => continue,
            };
            let mut is_on_one = false;
            let region = engine.frozen.region[e as usize];
            element.sides(region, machine, &engine.nets, &mut |side: f64| {
                is_on_one |= side.abs() <= NEAR * f64::EPSILON * scale;
            });
            if is_on_one {
                let block = machine.block_name(*block);
                return Err(RunFault::OnCorner { block, t_s: self.now_s() });
            }
        }
        Ok(())
    }

    /// Derivatives of the rates by the states where they stand, per second; delays stand still.
    pub(crate) fn rates_by_states(&self) -> DMatrix<f64> {
        let n = self.machine().states;
        let columns: Vec<f64> =
            (0..n as Slot).flat_map(|state| self.slopes(state, &[], &[]).0).collect();
        DMatrix::from_vec(n, n, columns)
    }

    /// By how much the rates of all states and the outputs change with the net `moved`, all other
    /// states and inputs standing still.
    fn slopes(&self, moved: Slot, inputs: &[Slot], outputs: &[Slot]) -> (Vec<f64>, Vec<f64>) {
        let (machine, frozen) = (self.machine(), &self.engine().frozen);
        let mut nets: Vec<Rated> =
            self.engine().nets.iter().map(|value| Rated::constant(*value)).collect();
        nets[moved as usize].rate = 1.0;
        let mut driven = Vec::new();
        for op in machine.settle.iter().filter_map(operation) {
            driven.clear();
            op.drives(|slot| driven.push(slot));
            let stands_still = match *op {
                Op::Dac { .. } | Op::Delay { .. } | Op::Wave { .. } | Op::Time { .. } => true,
                Op::Mdac { o, hold, a, c } => {
                    nets[o as usize] =
                        nets[a as usize] * (c * frozen.holds[hold as usize].at_time(self.now_s()));
                    false
                }
                // Its angle jumps with any move: `y` and `x` are zero.
                Op::Arctangent { o, y, x, .. }
                    if [y, x].iter().all(|term| term.of(&nets).value == 0.0)
                        && [y, x].iter().any(|term| term.of(&nets).rate != 0.0) =>
                {
                    nets[o as usize].rate = f64::NAN;
                    false
                }
                _ => {
                    machine.evaluate(op, frozen, self.now_s(), &mut nets);
                    false
                }
            };
            for &slot in &driven {
                let is_given = stands_still || inputs.contains(&slot) || slot == moved;
                if is_given {
                    nets[slot as usize].rate = f64::from(u8::from(slot == moved));
                }
            }
        }
        let mut rates = vec![0.0; machine.states];
        for (state, terms) in &machine.rates {
            rates[*state as usize] = terms.iter().map(|term| term.of(&nets).rate).sum();
        }
        for (control, running) in machine.controls.iter().zip(&frozen.running) {
            if !running {
                rates[control.state as usize] = 0.0;
            }
        }
        (rates, outputs.iter().map(|slot| nets[*slot as usize].rate).collect())
    }
}

impl Linear {
    /// Transfer from input `k` to output `i` at s = jω: C (jω − A)⁻¹ B + D. No number at a pole.
    pub fn response(&self, output: usize, input: usize, omega_radps: f64) -> Complex<f64> {
        let n = self.a.nrows();
        if n == 0 {
            return Complex::new(self.d[(output, input)], 0.0);
        }
        let complex = |value: f64| Complex::new(value, 0.0);
        let resolvent = DMatrix::from_fn(n, n, |i, j| {
            let s = if i == j { Complex::new(0.0, omega_radps) } else { complex(0.0) };
            s - complex(self.a[(i, j)])
        });
        let state = resolvent.lu().solve(&self.b.column(input).map(complex));
        let Some(state) = state else {
            return Complex::new(f64::NAN, f64::NAN);
        };
        let through: Complex<f64> = (0..n).map(|j| state[j] * self.c[(output, j)]).sum();
        through + complex(self.d[(output, input)])
    }

    /// Eigenvalues of A, per second, by their size; none where the iteration gives up.
    pub fn roots(&self) -> Vec<Complex<f64>> {
        eigenvalues(&self.a)
    }
}

/// Eigenvalues by their size, the positive imaginary part of a pair first. Empty where an entry is
/// not finite or the QR iteration gives up.
///
/// Those that stand alone (a row or column of nothing but its diagonal, as of integrators in series)
/// are exact; the rest is balanced by powers of two, so that units do not cost digits: B. N. Parlett
/// and C. Reinsch, Numer. Math. 13 (1969).
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
    // Bounded, so that no matrix can keep the iteration going for ever.
    const ITERATIONS: usize = 10_000;
    if matrix.is_empty() || matrix.iter().any(|v| !v.is_finite()) {
        return Vec::new();
    }
    let mut left: Vec<usize> = (0..matrix.nrows()).collect();
    let mut roots = Vec::new();
    let stands_alone = |left: &[usize], i: usize| {
        let others = || left.iter().filter(move |j| **j != i);
        others().all(|&j| matrix[(i, j)] == 0.0) || others().all(|&j| matrix[(j, i)] == 0.0)
    };
    while let Some(place) = left.iter().position(|&i| stands_alone(&left, i)) {
        let i = left.remove(place);
        roots.push(Complex::new(matrix[(i, i)], 0.0));
    }
    if !left.is_empty() {
        let mut rest = DMatrix::from_fn(left.len(), left.len(), |i, j| matrix[(left[i], left[j])]);
        // Its squares must not overflow.
        if rest.iter().all(|v| v.abs() < 1e150) {
            balance_parlett_reinsch(&mut rest);
        }
        let Some(schur) = rest.try_schur(f64::EPSILON, ITERATIONS) else {
            return Vec::new();
        };
        roots.extend(schur.complex_eigenvalues().iter());
    }
    let size = |z: &Complex<f64>| libm::hypot(z.re, z.im);
    roots.sort_by(|a, b| size(a).total_cmp(&size(b)).then(b.im.total_cmp(&a.im)));
    roots
}

fn operation(settle: &Settle) -> Option<&Op> {
    match settle {
        Settle::Op(op) => Some(op),
        Settle::Decide(_) => None,
    }
}
