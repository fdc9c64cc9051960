//! A linear plant closed through a linear digital law: one frame as a matrix, whatever the order of
//! either, with latency and any [`Hold`].
//!
//! Plant `ẋ = A x + B y, m = C x + D y` with y the DAC outputs; law
//! `u_n = H w_n + J m_n, w_{n+1} = F w_n + G m_n`, sampled at `t_n = nT` and transferred at `t_n + τ`,
//! 0 ≤ τ ≤ T. Where a sample and a transfer fall on one instant the sample comes first.

use super::{Refusal, frame_and_latency, hold::Hold, period_map::PeriodMap};
use nalgebra::DMatrix;

/// A plant in state space; n states, m inputs (DACs), p outputs (ADCs).
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// A, n×n, 1/s.
    pub a: DMatrix<f64>,
    /// B, n×m, 1/s.
    pub b: DMatrix<f64>,
    /// C, p×n.
    pub c: DMatrix<f64>,
    /// D, p×m.
    pub d: DMatrix<f64>,
}

/// A law in state space; w words of memory, p inputs (ADCs), m outputs (DACs).
#[derive(Clone, Debug, PartialEq)]
pub struct LinearLaw {
    /// F, w×w.
    pub f: DMatrix<f64>,
    /// G, w×p.
    pub g: DMatrix<f64>,
    /// H, m×w.
    pub h: DMatrix<f64>,
    /// J, m×p.
    pub j: DMatrix<f64>,
}

/// One frame from just before a sample to just before the next.
///
/// State `[x; y; ẏ; pending; last transferred; w]`, n + 4 m + w.
///
/// # Errors
/// A frame or latency out of range.
pub fn period_map(
    plant: &Plant,
    law: &LinearLaw,
    hold: Hold,
    frame_s: f64,
    latency_s: f64,
) -> Result<PeriodMap, Refusal> {
    let (frame, latency) = frame_and_latency(frame_s, latency_s)?;
    let (n, m, w) = (plant.a.nrows(), plant.b.ncols(), law.f.nrows());
    let size = n + 4 * m + w;
    let [y, slope, pending, last, memory] = [0, 1, 2, 3, 4].map(|k| n + k * m);

    let mut generator = DMatrix::zeros(size, size);
    generator.view_mut((0, 0), (n, n)).copy_from(&plant.a);
    generator.view_mut((0, y), (n, m)).copy_from(&plant.b);
    generator.view_mut((y, slope), (m, m)).fill_with_identity();

    let mut sample = DMatrix::identity(size, size);
    sample.rows_mut(pending, m).fill(0.0);
    sample.view_mut((pending, 0), (m, n)).copy_from(&(&law.j * &plant.c));
    sample.view_mut((pending, y), (m, m)).copy_from(&(&law.j * &plant.d));
    sample.view_mut((pending, memory), (m, w)).copy_from(&law.h);
    sample.rows_mut(memory, w).fill(0.0);
    sample.view_mut((memory, 0), (w, n)).copy_from(&(&law.g * &plant.c));
    sample.view_mut((memory, y), (w, m)).copy_from(&(&law.g * &plant.d));
    sample.view_mut((memory, memory), (w, w)).copy_from(&law.f);

    let mut transfer = DMatrix::identity(size, size);
    for k in 0..m {
        let [y, slope, pending, last] = [y, slope, pending, last].map(|start| start + k);
        for row in [y, slope, last] {
            transfer.row_mut(row).fill(0.0);
        }
        transfer[(last, pending)] = 1.0;
        // What the line through the last two values, or towards the last one, begins at.
        transfer[(y, if hold == Hold::Interpolating { last } else { pending })] = 1.0;
        if hold != Hold::ZeroOrder {
            transfer[(slope, pending)] = 1.0 / frame;
            transfer[(slope, last)] = -1.0 / frame;
        }
    }

    let mut map = PeriodMap::new(size);
    if latency == frame {
        // The transfer of the frame before falls on the instant of this sample, which sees the
        // output as it was.
        for row in (y..y + 2 * m).chain(last..last + m) {
            sample.row_mut(row).copy_from(&transfer.row(row));
        }
        map.jump(&sample);
        map.flow(&generator, frame);
        return Ok(map);
    }
    map.jump(&sample);
    map.flow(&generator, latency);
    map.jump(&transfer);
    map.flow(&generator, frame - latency);
    Ok(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x' = −x + u, m = x + u/2, u = −0.8 m a whole frame late: the sample sees the output before
    /// the transfer that falls on its instant. With φ = e^{−T}: (z − φ) (z² + 0.4) + 0.8 (1 − φ) z = 0.
    #[test]
    fn a_sample_comes_before_the_transfer_of_its_instant() {
        let one = |value| DMatrix::from_element(1, 1, value);
        let plant = Plant { a: one(-1.0), b: one(1.0), c: one(1.0), d: one(0.5) };
        let none = |rows, columns| DMatrix::zeros(rows, columns);
        let law = LinearLaw { f: none(0, 0), g: none(0, 1), h: none(1, 0), j: one(-0.8) };
        let map = period_map(&plant, &law, Hold::ZeroOrder, 0.1, 0.1).unwrap();
        let phi = libm::exp(-0.1);
        let roots = map.discrete_roots().unwrap();
        let at_all = roots.iter().filter(|z| z.norm_sqr() > 1e-12);
        assert_eq!(at_all.clone().count(), 3);
        for z in at_all {
            let left = (z - phi) * (z * z + 0.4) + z * (0.8 * (1.0 - phi));
            assert!(left.norm_sqr() < 1e-24, "{z}: {left}");
        }
    }
}
