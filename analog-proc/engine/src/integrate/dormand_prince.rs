//! The explicit method 5(4) of Dormand and Prince, with dense output of order four.
//!
//! Coefficients: Dormand and Prince, J. Comput. Appl. Math. 6 (1980) 19–26;
//! dense output: Hairer, Nørsett and Wanner, Solving Ordinary Differential
//! Equations I, section II.6.

use super::{Step, System};
use serde::{Deserialize, Serialize};

const C2: f64 = 1.0 / 5.0;
const C3: f64 = 3.0 / 10.0;
const C4: f64 = 4.0 / 5.0;
const C5: f64 = 8.0 / 9.0;
const A21: f64 = 1.0 / 5.0;
const A31: f64 = 3.0 / 40.0;
const A32: f64 = 9.0 / 40.0;
const A41: f64 = 44.0 / 45.0;
const A42: f64 = -56.0 / 15.0;
const A43: f64 = 32.0 / 9.0;
const A51: f64 = 19372.0 / 6561.0;
const A52: f64 = -25360.0 / 2187.0;
const A53: f64 = 64448.0 / 6561.0;
const A54: f64 = -212.0 / 729.0;
const A61: f64 = 9017.0 / 3168.0;
const A62: f64 = -355.0 / 33.0;
const A63: f64 = 46732.0 / 5247.0;
const A64: f64 = 49.0 / 176.0;
const A65: f64 = -5103.0 / 18656.0;
const A71: f64 = 35.0 / 384.0;
const A73: f64 = 500.0 / 1113.0;
const A74: f64 = 125.0 / 192.0;
const A75: f64 = -2187.0 / 6784.0;
const A76: f64 = 11.0 / 84.0;
const E1: f64 = 71.0 / 57600.0;
const E3: f64 = -71.0 / 16695.0;
const E4: f64 = 71.0 / 1920.0;
const E5: f64 = -17253.0 / 339_200.0;
const E6: f64 = 22.0 / 525.0;
const E7: f64 = -1.0 / 40.0;
const D1: f64 = -12_715_105_075.0 / 11_282_082_432.0;
const D3: f64 = 87_487_479_700.0 / 32_700_410_799.0;
const D4: f64 = -10_690_763_975.0 / 1_880_347_072.0;
const D5: f64 = 701_980_252_875.0 / 199_316_789_632.0;
const D6: f64 = -1_453_857_185.0 / 822_651_844.0;
const D7: f64 = 69_997_945.0 / 29_380_423.0;

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DormandPrince {
    k2: Vec<f64>,
    k3: Vec<f64>,
    k4: Vec<f64>,
    k5: Vec<f64>,
    k6: Vec<f64>,
}

impl DormandPrince {
    pub fn new(states: usize) -> DormandPrince {
        let zeros = || vec![0.0; states];
        DormandPrince { k2: zeros(), k3: zeros(), k4: zeros(), k5: zeros(), k6: zeros() }
    }

    /// h·‖f(y₇) − f(y₆)‖ / ‖y₇ − y₆‖ of a step that has been made the past: its last two stages
    /// lie at one instant, so that they show the rate of the fastest component (Hairer and
    /// Wanner, Solving Ordinary Differential Equations II, IV.2). Each state counts on the
    /// scale of its tolerance.
    pub fn step_rate(&self, step: &Step, atol: &[f64], rtol: f64) -> Option<f64> {
        let (y7, f7) = (&step.y0, &step.f0);
        let (y0, k1, h) = (&step.y1, &step.f1, step.h_s);
        let (mut rise, mut run) = (0.0_f64, 0.0_f64);
        for i in 0..y7.len() {
            let sum = A61 * k1[i] + A62 * self.k2[i] + A63 * self.k3[i] + A64 * self.k4[i];
            let y6 = y0[i] + h * (sum + A65 * self.k5[i]);
            let scale = atol[i] + rtol * y7[i].abs();
            rise = rise.max((f7[i] - self.k6[i]).abs() / scale);
            run = run.max((y7[i] - y6).abs() / scale);
        }
        let rate = h * rise / run;
        rate.is_finite().then_some(rate)
    }

    pub fn attempt(&mut self, system: System, step: &mut Step, nets: &mut [f64]) -> f64 {
        let n = step.y0.len();
        if n == 0 {
            return super::euler::attempt(system, step, nets);
        }
        let (h, t) = (step.h_s, step.t0_s);
        let (m, f) = (system.machine, system.frozen);
        let y0 = &step.y0[..n];
        let k1 = &step.f0[..n];
        {
            let y = &mut nets[..n];
            for i in 0..n {
                y[i] = y0[i] + h * (A21 * k1[i]);
            }
        }
        m.derivatives(f, t + C2 * h, nets, &mut self.k2);
        {
            let (y, k2) = (&mut nets[..n], &self.k2[..n]);
            for i in 0..n {
                y[i] = y0[i] + h * (A31 * k1[i] + A32 * k2[i]);
            }
        }
        m.derivatives(f, t + C3 * h, nets, &mut self.k3);
        {
            let (y, k2, k3) = (&mut nets[..n], &self.k2[..n], &self.k3[..n]);
            for i in 0..n {
                y[i] = y0[i] + h * (A41 * k1[i] + A42 * k2[i] + A43 * k3[i]);
            }
        }
        m.derivatives(f, t + C4 * h, nets, &mut self.k4);
        {
            let (y, k2, k3) = (&mut nets[..n], &self.k2[..n], &self.k3[..n]);
            let k4 = &self.k4[..n];
            for i in 0..n {
                y[i] = y0[i] + h * (A51 * k1[i] + A52 * k2[i] + A53 * k3[i] + A54 * k4[i]);
            }
        }
        m.derivatives(f, t + C5 * h, nets, &mut self.k5);
        {
            let (y, k2, k3) = (&mut nets[..n], &self.k2[..n], &self.k3[..n]);
            let (k4, k5) = (&self.k4[..n], &self.k5[..n]);
            for i in 0..n {
                let sum = A61 * k1[i] + A62 * k2[i] + A63 * k3[i] + A64 * k4[i] + A65 * k5[i];
                y[i] = y0[i] + h * sum;
            }
        }
        m.derivatives(f, t + h, nets, &mut self.k6);
        let (k3, k4) = (&self.k3[..n], &self.k4[..n]);
        let (k5, k6) = (&self.k5[..n], &self.k6[..n]);
        {
            let y = &mut nets[..n];
            for i in 0..n {
                let sum = A71 * k1[i] + A73 * k3[i] + A74 * k4[i] + A75 * k5[i] + A76 * k6[i];
                y[i] = y0[i] + h * sum;
            }
        }
        step.y1[..n].copy_from_slice(&nets[..n]);
        m.derivatives(f, t + h, nets, &mut step.f1);
        step.evaluations += 6;
        let k7 = &step.f1[..n];
        {
            let quartic = &mut step.quartic[..n];
            for i in 0..n {
                let sum = D1 * k1[i] + D3 * k3[i] + D4 * k4[i] + D5 * k5[i] + D6 * k6[i];
                quartic[i] = h * (sum + D7 * k7[i]);
            }
        }
        let (mut norm, mut worst) = (0.0_f64, step.worst);
        let (y1, atol) = (&step.y1[..n], &system.atol[..n]);
        for i in 0..n {
            let sum = E1 * k1[i] + E3 * k3[i] + E4 * k4[i] + E5 * k5[i] + E6 * k6[i] + E7 * k7[i];
            let size = y0[i].abs().max(y1[i].abs());
            let scaled = (h * sum).abs() / (atol[i] + system.rtol * size);
            // An undefined error stays undefined: it must not pass as a small one.
            if scaled > norm || scaled.is_nan() {
                norm = scaled;
                worst = i;
            }
        }
        step.worst = worst;
        norm
    }
}
