//! The vehicle at 32.5 s as an Euler–Bernoulli beam of 50 Hermite elements from the aft end of the
//! motor to the tip of the nose, for tests: a second formulation of its bending. It knows masses
//! and loads by the figures of the data set and shares nothing with [`vehicle::structure`].

use nalgebra::{DMatrix, DVector};
use vehicle::structure::TEN_STATIONS_M;

/// Mass and stiffness on deflection (towards +z) and slope at each node.
pub struct Elements {
    nodes_m: Vec<f64>,
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

const ELEMENTS: usize = 50;
/// EI that gives the first mode its 4.25 Hz at 32.5 s, N·m².
const EI_NM2: f64 = 1.40e8;

/// Hermite functions on an element of length `h` and their derivatives, at u = 0…1.
fn hermite(h: f64, u: f64) -> [[f64; 4]; 2] {
    let (u2, u3) = (u * u, u * u * u);
    [
        [1.0 - 3.0 * u2 + 2.0 * u3, h * (u - 2.0 * u2 + u3), 3.0 * u2 - 2.0 * u3, h * (u3 - u2)],
        [
            (6.0 * u2 - 6.0 * u) / h,
            1.0 - 4.0 * u + 3.0 * u2,
            (6.0 * u - 6.0 * u2) / h,
            3.0 * u2 - 2.0 * u,
        ],
    ]
}

impl Elements {
    /// Of the vehicle at 32.5 s.
    pub fn new() -> Elements {
        let (aft, fore) = (-0.55, 22.7);
        let h = (fore - aft) / ELEMENTS as f64;
        let nodes_m: Vec<f64> = (0..=ELEMENTS).map(|i| aft + h * i as f64).collect();
        let n = 2 * nodes_m.len();
        let mut mass = DMatrix::zeros(n, n);
        let mut stiffness = DMatrix::zeros(n, n);
        let k = [
            [12.0, 6.0 * h, -12.0, 6.0 * h],
            [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
            [-12.0, -6.0 * h, 12.0, -6.0 * h],
            [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
        ];
        for (e, &at) in nodes_m[..ELEMENTS].iter().enumerate() {
            // Midpoints of 200 parts: rods may end within an element.
            for part in 0..200 {
                let u = (f64::from(part) + 0.5) / 200.0;
                let [shape, _] = hermite(h, u);
                let here = density_kgpm(at + u * h) * h / 200.0;
                for i in 0..4 {
                    for j in 0..4 {
                        mass[(2 * e + i, 2 * e + j)] += here * shape[i] * shape[j];
                    }
                }
            }
            for i in 0..4 {
                for j in 0..4 {
                    stiffness[(2 * e + i, 2 * e + j)] += EI_NM2 / h.powi(3) * k[i][j];
                }
            }
        }
        Elements { nodes_m, mass, stiffness }
    }

    /// Adds the work of a force (N) and a couple (N·m, nose up, against the slope) at a station.
    fn add(&self, load: &mut DVector<f64>, x_m: f64, force_n: f64, couple_nm: f64) {
        let h = self.nodes_m[1] - self.nodes_m[0];
        let e = (((x_m - self.nodes_m[0]) / h) as usize).min(ELEMENTS - 1);
        let [shape, slope] = hermite(h, (x_m - self.nodes_m[e]) / h);
        for i in 0..4 {
            load[2 * e + i] += force_n * shape[i] - couple_nm * slope[i];
        }
    }

    /// ω² and shapes (of modal mass 1) by increasing frequency, the rigid ones first.
    pub fn modes(&self) -> Vec<(f64, DVector<f64>)> {
        // M is singular where there is no mass, K at rigid motion; K + sM is neither, and
        // M φ = λ (K + sM) φ has λ = 1/(ω² + s).
        const SHIFT: f64 = 100.0;
        let low = (&self.stiffness + &self.mass * SHIFT).cholesky().unwrap().l();
        let half = low.solve_lower_triangular(&self.mass).unwrap();
        let square = low.solve_lower_triangular(&half.transpose()).unwrap();
        let eigen = ((&square + square.transpose()) * 0.5).symmetric_eigen();
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let shape = |i: usize| {
            let column = eigen.eigenvectors.column(i).into_owned();
            let shape = low.transpose().solve_upper_triangular(&column).unwrap();
            let mass = (shape.transpose() * &self.mass * &shape)[0];
            (1.0 / eigen.eigenvalues[i] - SHIFT, shape / mass.sqrt())
        };
        order.into_iter().take(2 + 8).map(shape).collect()
    }
}

/// The greatest |BM| at the ten stations under loads (1 rad, N, N, 3σ) every `h` s from rest,
/// looked for from a sample on: rigid motion and eight modes of ζ 0.01, by load summation.
pub fn bend(beam: &Elements, loads: &[[f64; 4]], h: f64, from: usize) -> [f64; 10] {
    let modes = beam.modes();
    let units = unit_loads(beam);
    let forces: Vec<[f64; 4]> = modes
        .iter()
        .map(|(_, shape)| std::array::from_fn(|load| shape.dot(&units[load])))
        .collect();
    let of = |loads: &[f64; 4], mode: usize| -> f64 {
        loads.iter().zip(&forces[mode]).map(|(l, f)| l * f).sum()
    };
    let mut state = vec![[0.0_f64; 2]; modes.len()];
    let mut largest = [0.0_f64; 10];
    for (i, loads_now) in loads.iter().enumerate() {
        let mut acceleration = DVector::zeros(2 * beam.nodes_m.len());
        for (m, (square, shape)) in modes.iter().enumerate() {
            let (w, now) = (square.max(0.0).sqrt(), of(loads_now, m));
            let drag = 0.02 * w;
            if i > 0 {
                // Newmark's rule of constant mean acceleration, which damps nothing; ω h is 0.03
                // in the first mode, at 1 ms.
                let [x, v] = state[m];
                let before = of(&loads[i - 1], m) - drag * v - square * x;
                let (guess, speed) = (x + h * v + h * h / 4.0 * before, v + h / 2.0 * before);
                let a = (now - drag * speed - square * guess)
                    / (1.0 + drag * h / 2.0 + square * h * h / 4.0);
                state[m] = [guess + h * h / 4.0 * a, speed + h / 2.0 * a];
            }
            // The first two are rigid.
            let a = if m < 2 { now } else { now - drag * state[m][1] - square * state[m][0] };
            acceleration += shape * a;
        }
        if i < from {
            continue;
        }
        let mut rest = -(&beam.mass * acceleration);
        for (load, unit) in loads_now.iter().zip(&units) {
            rest += unit * *load;
        }
        for (x, largest) in TEN_STATIONS_M.into_iter().zip(&mut largest) {
            // Loads behind a node, half of its own couple; between nodes by their share.
            let at = |node: usize| -> f64 {
                let behind = (0..node).map(|k| {
                    -(beam.nodes_m[node] - beam.nodes_m[k]) * rest[2 * k] + rest[2 * k + 1]
                });
                behind.sum::<f64>() + 0.5 * rest[2 * node + 1]
            };
            let place = (x - beam.nodes_m[0]) / (beam.nodes_m[1] - beam.nodes_m[0]);
            let (node, part) = (place as usize, place.fract());
            let moment: f64 = (1.0 - part) * at(node) + part * at(node + 1);
            *largest = largest.max(moment.abs());
        }
    }
    largest
}

/// μ at 32.5 s: name by name as in the data set, with the propellant that is left.
fn density_kgpm(x: f64) -> f64 {
    let left = 11_283.98 - 8_950.0;
    let rods = [
        (2_140.0, 4.2, 9.5),
        (left, 5.3, 8.2),
        (4_900.0, 14.2, 6.0),
        (1_500.0, 18.4, 2.4),
        (410.0, 20.6, 2.0),
    ];
    rods.iter().filter(|(_, at, l)| (x - at).abs() < l / 2.0).map(|(m, _, l)| m / l).sum()
}

/// Loads of 1 rad, 1 N (twice) and the 3σ misalignment, from figures of the data set at 32.5 s.
fn unit_loads(beam: &Elements) -> [DVector<f64>; 4] {
    let zero = DVector::zeros(2 * beam.nodes_m.len());
    let mut loads = [zero.clone(), zero.clone(), zero.clone(), zero];
    let qs = 95_327.0 * std::f64::consts::FRAC_PI_4;
    // Between Mach 2.0 and 2.5 at 2.238.
    let part = 0.238 / 0.5;
    let (body, body_x) = (3.20 + part * 0.10, 16.6 - part * 0.2);
    let fins = 1.35 - part * 0.25;
    let parts = 20_000;
    for i in 0..parts {
        let u = (f64::from(i) + 0.5) / f64::from(parts);
        let nose = 2.0 * u;
        beam.add(
            &mut loads[0],
            20.7 + nose,
            -qs * 2.0 * 2.0 * (2.0 - nose) / 4.0 * 2.0 / f64::from(parts),
            0.0,
        );
        let extent = 2.0 * (body * body_x - 2.0 * 21.366_667) / (body - 2.0);
        beam.add(&mut loads[0], extent * u, -qs * (body - 2.0) / f64::from(parts), 0.0);
        let x = -0.55 + 22.15 * u;
        let couple = 433_721.0 * 0.010 * density_kgpm(x) / 11_283.98 * 22.15 / f64::from(parts);
        beam.add(&mut loads[3], x, 0.0, couple);
    }
    beam.add(&mut loads[0], 0.60, -qs * fins, 0.0);
    beam.add(&mut loads[1], 0.50, 1.0, 0.0);
    beam.add(&mut loads[2], 0.60, 1.0, 0.0);
    beam.add(&mut loads[3], 0.30, 433_721.0 * (0.25_f64).to_radians().sin(), 0.0);
    loads
}
