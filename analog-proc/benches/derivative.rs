//! The derivative pass and the integration of three patches, against the same
//! equations written by hand with the same tableau and the same step control.
//!
//! The hand version has its coefficients in the instructions, looks at no corner and
//! locates no event. Where the rest goes, measured with callgrind and perf:
//!
//! - Lorenz, rod: a pass has a fixed part of about 150 instructions (finding the
//!   groups, control of single integrators, the call itself), most of Lorenz's pass;
//!   integrating, it is small beside the stages of the method.
//! - Stage, pass: 1400 instructions, of which sine and cosine 80; about 30 each for 20
//!   folded operations, and 12 to 20 each for 20 rows. A quarter are checked
//!   indices, a tenth is choosing the operation.
//! - Stage, integration: derivatives 30 %, the method's own sums 13 %, witnesses and the
//!   search for crossings 25 %, nets that no derivative reads 15 %, sine and cosine 6 %.

#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

#[path = "../tests/common/bench.rs"]
mod bench;

use std::{hint::black_box, path::Path};

use analog_proc::patch::{bundle_from_path, compile};
use bench::Bench;
use criterion::{Criterion, criterion_group, criterion_main};
use engine::element::dac::DacPiece;
use engine::integration::Integration;
use engine::simulation::Simulation;
use interface::Tick;

const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const C: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Adaptive 5(4) by hand on an array of fixed size; returns the state and the steps.
fn by_hand<const N: usize>(
    f: impl Fn(f64, &[f64; N]) -> [f64; N],
    mut y: [f64; N],
    stop_s: f64,
    rtol: f64,
    atol: f64,
) -> ([f64; N], u32) {
    let (mut t, mut h, mut steps) = (0.0, 1e-4_f64, 0);
    let mut k = [[0.0; N]; 7];
    k[0] = f(t, &y);
    while t < stop_s {
        h = h.min(stop_s - t);
        let mut end = y;
        for (stage, row) in A.iter().enumerate() {
            for i in 0..N {
                let mut sum = 0.0;
                for (a, k) in row.iter().zip(&k) {
                    sum += a * k[i];
                }
                end[i] = y[i] + h * sum;
            }
            k[stage + 1] = f(t + C[stage] * h, &end);
        }
        let mut norm = 1e-10_f64;
        for i in 0..N {
            let sum: f64 = (0..7).map(|s| E[s] * k[s][i]).sum();
            norm = norm.max((h * sum).abs() / (atol + rtol * y[i].abs().max(end[i].abs())));
        }
        if norm <= 1.0 {
            t += h;
            y = end;
            k[0] = k[6];
            steps += 1;
        }
        h *= (0.9 * libm::pow(norm, -0.2)).clamp(0.2, 10.0);
    }
    (y, steps)
}

struct Run<const N: usize> {
    name: &'static str,
    start: [f64; N],
    stop_s: f64,
    rtol: f64,
    atol: f64,
    /// Sets, after a reset, what the digital side would.
    preset: fn(&mut Simulation),
}

fn compare<const N: usize>(
    c: &mut Criterion,
    simulation: &mut Simulation,
    run: &Run<N>,
    f: impl Fn(f64, &[f64; N]) -> [f64; N] + Copy,
) {
    let stop = Tick::from_secs(run.stop_s).unwrap();
    let fly = |simulation: &mut Simulation| {
        simulation.reset().unwrap();
        (run.preset)(simulation);
        simulation.advance_to(stop).unwrap()
    };
    let by_hand = || by_hand(f, black_box(run.start), run.stop_s, run.rtol, run.atol);
    fly(simulation);
    let (end, steps) = by_hand();
    println!(
        "{}: {} operations, {:?}; by hand {steps} steps, ends at {end:?}",
        run.name,
        simulation.machine().operations(),
        simulation.statistics(),
    );
    simulation.reset().unwrap();
    (run.preset)(simulation);
    let mut group = c.benchmark_group(run.name);
    group.bench_function("pass", |b| b.iter(|| black_box(simulation.derivative_pass())));
    group.bench_function("pass by hand", |b| b.iter(|| black_box(f(0.0, black_box(&run.start)))));
    group.bench_function("integrate", |b| b.iter(|| fly(simulation)));
    group.bench_function("integrate by hand", |b| b.iter(by_hand));
    group.finish();
}

fn nothing(_: &mut Simulation) {}

const SETTINGS: &str = "rtol = 1e-7\natol = 1e-9";

fn lorenz(c: &mut Criterion) {
    let mut bench = Bench::with(
        SETTINGS,
        r#"
        x = { kind = "integrator", in = ["10 * y", "-10 * x"], ic = 1.0 }
        y = { kind = "integrator", in = ["28 * x", "-1 * y", "-1 * xz"], ic = 1.0 }
        z = { kind = "integrator", in = ["xy", "-2.6666666666666665 * z"], ic = 1.0 }
        xz = { kind = "multiplier", in = ["x", "z"] }
        xy = { kind = "multiplier", in = ["x", "y"] }
    "#,
    );
    let f = |_: f64, &[x, y, z]: &[f64; 3]| {
        [10.0 * y - 10.0 * x, 28.0 * x - y - x * z, x * y - 2.666_666_666_666_666_5 * z]
    };
    let run = Run {
        name: "lorenz",
        start: [1.0; 3],
        stop_s: 10.0,
        rtol: 1e-7,
        atol: 1e-9,
        preset: nothing,
    };
    compare(c, &mut bench.simulation, &run, f);
}

fn rod(c: &mut Criterion) {
    let mut blocks = String::new();
    for i in 0..16_i32 {
        let beside = [i - 1, i + 1].into_iter().filter(|j| (0..16).contains(j));
        let inputs: String = beside.map(|j| format!(", \"100 * u{j}\"")).collect();
        blocks += &format!(
            "u{i} = {{ kind = \"integrator\", in = [\"-200 * u{i}\"{inputs}], ic = 1.0 }}\n"
        );
    }
    let mut bench = Bench::with(SETTINGS, &blocks);
    let f = |_: f64, u: &[f64; 16]| {
        std::array::from_fn(|i| {
            let below = if i > 0 { u[i - 1] } else { 0.0 };
            let above = if i < 15 { u[i + 1] } else { 0.0 };
            -200.0 * u[i] + 100.0 * below + 100.0 * above
        })
    };
    let run =
        Run { name: "rod", start: [1.0; 16], stop_s: 1.0, rtol: 1e-7, atol: 1e-9, preset: nothing };
    compare(c, &mut bench.simulation, &run, f);
}

/// The long-period patch as flown, with coefficients of about the greatest dynamic pressure, by
/// channel; the patch has none where a zero stands.
const COEFFICIENTS: [f64; 30] = [
    1.5, 1.5, -0.1, -0.1, -0.2, 0.0, 0.0, 0.0, 0.8, 0.8, 2.0, 2.0, 0.3, 1.0, 0.0, 0.0, 0.5, 0.5,
    2e5, 2e5, 5.0, 2.5, 2.5, 5e-5, 5e-5, 25.0, 25.0, 5e4, 2.5e4, 2.5e4,
];
/// Signals held: dead zone, misalignments, cant; channel and value.
const SIGNALS: [(u32, f64); 4] = [(6, 0.02), (7, 0.05), (8, 0.05), (9, 1.0)];
/// Pitch command at lift-off, rad, and its slope, rad/s.
const COMMAND: (f64, f64) = (std::f64::consts::FRAC_PI_2, -0.02);

fn second_order(rate: f64, y: f64, y_dot: f64) -> [f64; 2] {
    [100.0 * y_dot, 100.0 * rate - 100.0 * y - 140.0 * y_dot]
}

fn tip(command: f64, delta: f64) -> f64 {
    let within = command.clamp(-10_f64.to_radians(), 10_f64.to_radians());
    let rate = 100_f64.to_radians();
    (20.0 * (within - delta)).clamp(-rate, rate)
}

fn injection(error: f64, force: f64) -> f64 {
    let beyond = error - error.clamp(-0.02, 0.02);
    10.0 * ((2e5 * beyond).clamp(-15000.0, 15000.0) - force)
}

/// What the patch says, as one would write it by hand.
fn stage_by_hand(t_s: f64, y: &[f64; 20]) -> [f64; 20] {
    let &[
        alpha,
        theta,
        psi,
        phi,
        theta_dot,
        psi_dot,
        p,
        gyro_q,
        gyro_q_dot,
        gyro_r,
        gyro_r_dot,
        gyro_p,
        gyro_p_dot,
        tip_p,
        tip_2,
        tip_4,
        filter_p,
        filter_y,
        force_p,
        force_y,
    ] = y;
    let (sin, cos) = libm::sincos(phi);
    let q = theta_dot * cos + psi_dot * sin;
    let r = psi_dot * cos - theta_dot * sin;
    let error_theta = COMMAND.0 + COMMAND.1 * t_s - theta;
    let error_p = error_theta * cos - psi * sin;
    let error_y = -psi * cos - error_theta * sin;
    let moment_p = 5.0 * tip_p + 5e-5 * force_p + 0.05;
    let moment_y = 2.5 * tip_2 + 2.5 * tip_4 + 5e-5 * force_y + 0.05;
    let (u_yaw, u_roll) = (2.0 * filter_y, -phi - 0.3 * gyro_p);
    let [gyro_q_1, gyro_q_2] = second_order(q, gyro_q, gyro_q_dot);
    let [gyro_r_1, gyro_r_2] = second_order(r, gyro_r, gyro_r_dot);
    let [gyro_p_1, gyro_p_2] = second_order(p, gyro_p, gyro_p_dot);
    [
        theta_dot,
        theta_dot,
        psi_dot,
        p,
        1.5 * alpha - 0.1 * theta_dot + moment_p * cos - moment_y * sin,
        1.5 * psi - 0.1 * psi_dot + moment_p * sin + moment_y * cos,
        -0.2 * p + 25.0 * tip_2 - 25.0 * tip_4 + 1.0,
        gyro_q_1,
        gyro_q_2,
        gyro_r_1,
        gyro_r_2,
        gyro_p_1,
        gyro_p_2,
        tip(2.0 * filter_p, tip_p),
        tip(u_yaw + u_roll, tip_2),
        tip(u_yaw - u_roll, tip_4),
        30.0 * (error_p - 0.8 * gyro_q - filter_p),
        30.0 * (error_y - 0.8 * gyro_r - filter_y),
        injection(error_p - 0.5 * gyro_q, force_p),
        injection(error_y - 0.5 * gyro_r, force_y),
    ]
}

fn stage(c: &mut Criterion) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patch-files/long-period.toml");
    let bundle = bundle_from_path(&path).unwrap_or_else(|e| panic!("{}", e.render()));
    let ordered = compile(&bundle, &[]).unwrap_or_else(|e| panic!("{}", e.render()));
    let Integration { rtol, atol, .. } = ordered.netlist.integration;
    let mut simulation = ordered.simulation().unwrap();
    for (channel, value) in COEFFICIENTS.into_iter().enumerate() {
        simulation.set_dcu(channel as u32, value);
    }
    for (channel, value) in SIGNALS {
        simulation.set_dac(channel, DacPiece::held(value, 0.0));
    }
    let mut y = [0.0; 20];
    y[1] = COMMAND.0;
    let run = Run {
        name: "stage",
        start: y,
        stop_s: 49.0,
        rtol,
        atol,
        preset: |simulation: &mut Simulation| {
            simulation.set_dac(
                0,
                DacPiece { value: COMMAND.0, slope_per_s: COMMAND.1, from_s: 0.0, settling_s: 0.0 },
            );
            simulation.apply().unwrap();
        },
    };
    compare(c, &mut simulation, &run, stage_by_hand);
}

criterion_group!(benches, lorenz, rod, stage);
criterion_main!(benches);
