//! Digital laws that a user can state without programming.

use super::theory::{Refusal, require, sampled_loop::LinearLaw};
use interface::frame::{Samples, Updates};
use nalgebra::DMatrix;
use std::collections::VecDeque;
use vehicle::table::Table;

/// Longest delay and difference equation, frames.
const LONGEST: usize = 100_000;

/// One law between ADC and DAC channels, with its memory.
#[derive(Clone, Debug)]
pub enum Element {
    /// `y = G x`, one row an output.
    Gain(Vec<Vec<f64>>),
    /// `Σ a_i y_{n−i} = Σ b_i x_{n−i}`, memory zero at the start.
    Difference {
        numerator: Vec<f64>,
        denominator: Vec<f64>,
        /// x, latest first.
        inputs: VecDeque<f64>,
        /// y, latest first.
        outputs: VecDeque<f64>,
    },
    /// `y_n = k x_{n−d}`, zero before.
    Delay {
        /// k.
        gain: f64,
        /// The d values on their way, oldest first.
        line: VecDeque<f64>,
    },
    /// `y = f(x)`, linear between breakpoints; beyond the ends the end values hold, as in the analog
    /// function generators.
    Table(Table),
}

impl Element {
    /// A delay of `frames`.
    pub fn delay(frames: u32, gain: f64) -> Result<Element, Refusal> {
        require("the gain", gain, true, "finite")?;
        require(
            "the delay",
            f64::from(frames),
            frames as usize <= LONGEST,
            "at most 100000 frames",
        )?;
        Ok(Element::Delay { gain, line: VecDeque::from(vec![0.0; frames as usize]) })
    }

    /// A difference equation.
    pub fn difference(numerator: Vec<f64>, denominator: Vec<f64>) -> Result<Element, Refusal> {
        let leading = denominator.first().copied().unwrap_or(0.0);
        require("the denominator's first coefficient", leading, leading != 0.0, "not zero")?;
        for c in numerator.iter().chain(&denominator) {
            require("a coefficient", *c, true, "finite")?;
        }
        let n = numerator.len();
        require("the numerator's length", n as f64, (1..=LONGEST).contains(&n), "1 to 100000")?;
        Ok(Element::Difference {
            inputs: VecDeque::from(vec![0.0; n]),
            outputs: VecDeque::from(vec![0.0; denominator.len()]),
            numerator,
            denominator,
        })
    }

    /// In state space; none of a table.
    pub fn linear(&self) -> Option<LinearLaw> {
        Some(match self {
            Element::Gain(rows) => {
                let (outputs, inputs) = (rows.len(), rows.first().map_or(0, Vec::len));
                LinearLaw {
                    f: DMatrix::zeros(0, 0),
                    g: DMatrix::zeros(0, inputs),
                    h: DMatrix::zeros(outputs, 0),
                    j: DMatrix::from_fn(outputs, inputs, |i, k| rows[i][k]),
                }
            }
            // Memory: x_{n−1} …, then y_{n−1} …
            Element::Difference { numerator, denominator, .. } => {
                let (b, a) = (numerator.len() - 1, denominator.len() - 1);
                let lead = denominator[0];
                let of_memory = |k: usize| match k.checked_sub(b) {
                    None => numerator[k + 1] / lead,
                    Some(k) => -denominator[k + 1] / lead,
                };
                let h = DMatrix::from_fn(1, b + a, |_, k| of_memory(k));
                let mut f = DMatrix::zeros(b + a, b + a);
                let mut g = DMatrix::zeros(b + a, 1);
                let j = DMatrix::from_element(1, 1, numerator[0] / lead);
                for k in 0..b + a {
                    match k {
                        0 if b > 0 => g[(0, 0)] = 1.0,
                        _ if k == b => {
                            f.row_mut(k).copy_from(&h.row(0));
                            g[(k, 0)] = j[(0, 0)];
                        }
                        _ => f[(k, k - 1)] = 1.0,
                    }
                }
                LinearLaw { f, g, h, j }
            }
            Element::Delay { gain, line } => {
                let frames = line.len();
                let one = |value| DMatrix::from_element(1, 1, value);
                let end = |k: usize, value: f64| if k + 1 == frames { value } else { 0.0 };
                LinearLaw {
                    f: DMatrix::from_fn(frames, frames, |i, k| f64::from(u8::from(i == k + 1))),
                    g: DMatrix::from_fn(frames, 1, |i, _| if i == 0 { *gain } else { 0.0 }),
                    h: DMatrix::from_fn(1, frames, |_, k| end(k, 1.0)),
                    j: one(if frames == 0 { *gain } else { 0.0 }),
                }
            }
            Element::Table(_) => return None,
        })
    }

    fn step(&mut self, x: &[f64], y: &mut [f64]) {
        match self {
            Element::Gain(rows) => {
                for (y, row) in y.iter_mut().zip(rows) {
                    *y = row.iter().zip(x).map(|(g, x)| g * x).sum();
                }
            }
            Element::Difference { numerator, denominator, inputs, outputs } => {
                inputs.pop_back();
                inputs.push_front(x[0]);
                let forward: f64 = numerator.iter().zip(inputs.iter()).map(|(b, x)| b * x).sum();
                let back: f64 =
                    denominator[1..].iter().zip(outputs.iter()).map(|(a, y)| a * y).sum();
                y[0] = (forward - back) / denominator[0];
                outputs.pop_back();
                outputs.push_front(y[0]);
            }
            Element::Delay { gain, line } => {
                line.push_back(*gain * x[0]);
                y[0] = line.pop_front().unwrap_or(0.0);
            }
            Element::Table(table) => y[0] = table.lookup(x[0]).value,
        }
    }
}

/// All laws of a study, run in order once a frame.
#[derive(Clone, Debug)]
pub struct LoopLaw {
    measure: usize,
    parts: Vec<(Vec<usize>, Vec<usize>, Element)>,
    record: Vec<f64>,
}

impl LoopLaw {
    /// Laws as (ADC channels, DAC channels, element); `measure` is the ADC channel to record.
    pub fn new(measure: usize, parts: Vec<(Vec<usize>, Vec<usize>, Element)>) -> LoopLaw {
        LoopLaw { measure, parts, record: Vec::new() }
    }

    /// One frame.
    pub fn step(&mut self, samples: &Samples, updates: &mut Updates) {
        self.record.push(samples.adc[self.measure]);
        for (inputs, outputs, element) in &mut self.parts {
            let x: Vec<f64> = inputs.iter().map(|i| samples.adc[*i]).collect();
            let mut y = vec![0.0; outputs.len()];
            element.step(&x, &mut y);
            for (channel, value) in outputs.iter().zip(y) {
                updates.set_dac(*channel, value);
            }
        }
    }

    /// The recorded ADC, one value a frame.
    pub fn record(&self) -> &[f64] {
        &self.record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(mut e: Element, input: &[f64]) -> Vec<f64> {
        input
            .iter()
            .map(|x| {
                let mut y = [0.0];
                e.step(&[*x], &mut y);
                y[0]
            })
            .collect()
    }

    /// The same in state space.
    fn drive_linear(e: &Element, input: &[f64]) -> Vec<f64> {
        let law = e.linear().unwrap();
        let mut w = DMatrix::zeros(law.f.nrows(), 1);
        input
            .iter()
            .map(|x| {
                let y = (&law.h * &w + &law.j * *x)[(0, 0)];
                w = &law.f * &w + &law.g * *x;
                y
            })
            .collect()
    }

    #[test]
    fn elements_do_what_they_say() {
        let impulse = [1.0, 0.0, 0.0, 0.0];
        assert_eq!(drive(Element::delay(2, 3.0).unwrap(), &impulse), [0.0, 0.0, 3.0, 0.0]);
        assert_eq!(drive(Element::delay(0, 3.0).unwrap(), &impulse), [3.0, 0.0, 0.0, 0.0]);
        // 2 y_n − y_{n−1} = x_n + x_{n−1}: y = 1/2, 3/4, 3/8, 3/16, exact in binary.
        let e = Element::difference(vec![1.0, 1.0], vec![2.0, -1.0]).unwrap();
        assert_eq!(drive(e, &impulse), [0.5, 0.75, 0.375, 0.1875]);
        let e = Element::difference(vec![1.0, 1.0], vec![2.0, -1.0]).unwrap();
        assert_eq!(drive_linear(&e, &impulse), [0.5, 0.75, 0.375, 0.1875]);
        // Three of x, three of y, and neither.
        for (b, a) in [
            (vec![1.0, -2.0, 0.5], vec![4.0, 1.0, -0.25]),
            (vec![3.0], vec![1.0, 0.5, 0.25]),
            (vec![3.0, 2.0, 1.0], vec![-2.0]),
            (vec![3.0], vec![2.0]),
        ] {
            let e = Element::difference(b, a).unwrap();
            assert_eq!(drive_linear(&e, &impulse), drive(e, &impulse)[..]);
        }
        for frames in [0, 1, 3] {
            let e = Element::delay(frames, 3.0).unwrap();
            assert_eq!(drive_linear(&e, &impulse), drive(e, &impulse)[..]);
        }
        assert!(Element::difference(vec![], vec![1.0]).is_err());
        assert!(Element::difference(vec![1.0], vec![]).is_err());
        assert!(Element::delay(u32::MAX, 1.0).is_err());
    }
}
