//! The derivative pass and the integration of three patches, against the same
//! equations written by hand with the same tableau and the same step control.

#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use analog_proc::net::{Kind, Level};
use common::{Patch, integrator};
use criterion::{Criterion, criterion_group, criterion_main};
use interface::Tick;

const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
    ],
    &[
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
    &[
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
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
    f: impl Fn(&[f64; N]) -> [f64; N],
    mut y: [f64; N],
    stop_s: f64,
    rtol: f64,
    atol: f64,
) -> ([f64; N], u32) {
    let (mut t, mut h, mut steps) = (0.0, 1e-4_f64, 0);
    let mut k = [[0.0; N]; 7];
    k[0] = f(&y);
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
            k[stage + 1] = f(&end);
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
        h *= (0.9 * norm.powf(-0.2)).clamp(0.2, 10.0);
    }
    (y, steps)
}

fn compare<const N: usize>(
    c: &mut Criterion,
    name: &str,
    patch: &Patch,
    f: impl Fn(&[f64; N]) -> [f64; N] + Copy,
    start: [f64; N],
    stop_s: f64,
) {
    let mut simulation = patch.simulation();
    let (rtol, atol) = (patch.integration.rtol, patch.integration.atol);
    let stop = Tick::from_secs(stop_s).unwrap();
    simulation.advance_to(stop).unwrap();
    let (end, steps) = by_hand(f, start, stop_s, rtol, atol);
    println!(
        "{name}: {:?}; by hand {steps} steps, ends at {:?}",
        simulation.statistics(),
        end[0]
    );
    simulation.reset().unwrap();
    let mut group = c.benchmark_group(name);
    group.bench_function("pass", |b| {
        b.iter(|| black_box(simulation.derivative_pass()))
    });
    group.bench_function("pass by hand", |b| {
        b.iter(|| black_box(f(black_box(&start))))
    });
    group.bench_function("integrate", |b| {
        b.iter(|| {
            simulation.reset().unwrap();
            simulation.advance_to(stop).unwrap()
        });
    });
    group.bench_function("integrate by hand", |b| {
        b.iter(|| by_hand(f, black_box(start), stop_s, rtol, atol));
    });
    group.finish();
}

fn lorenz(c: &mut Criterion) {
    let mut patch = Patch::new();
    patch.integration.rtol = 1e-7;
    patch.integration.atol = 1e-9;
    patch.add("x", integrator(1.0), &["10 * y", "-10 * x"]);
    patch.add("y", integrator(1.0), &["28 * x", "-1 * y", "-1 * xz"]);
    patch.add("z", integrator(1.0), &["xy", "-2.6666666666666665 * z"]);
    patch.add("xz", Kind::Multiplier, &["x", "z"]);
    patch.add("xy", Kind::Multiplier, &["x", "y"]);
    let f = |&[x, y, z]: &[f64; 3]| {
        [
            10.0 * y - 10.0 * x,
            28.0 * x - y - x * z,
            x * y - 2.666_666_666_666_666_5 * z,
        ]
    };
    compare(c, "lorenz", &patch, f, [1.0; 3], 10.0);
}

fn rod(c: &mut Criterion) {
    let mut patch = Patch::new();
    patch.integration.rtol = 1e-7;
    patch.integration.atol = 1e-9;
    for i in 0..16 {
        let mut inputs = vec![format!("-200 * u{i}")];
        if i > 0 {
            inputs.push(format!("100 * u{}", i - 1));
        }
        if i < 15 {
            inputs.push(format!("100 * u{}", i + 1));
        }
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        patch.add(&format!("u{i}"), integrator(1.0), &inputs);
    }
    let f = |u: &[f64; 16]| {
        std::array::from_fn(|i| {
            let below = if i > 0 { u[i - 1] } else { 0.0 };
            let above = if i < 15 { u[i + 1] } else { 0.0 };
            -200.0 * u[i] + 100.0 * below + 100.0 * above
        })
    };
    compare(c, "rod", &patch, f, [1.0; 16], 1.0);
}

/// One plane of the stage: rigid body, rate gyro, filter, fin tip with travel and rate
/// limits, secondary injection with dead zone and limit.
fn stage(c: &mut Criterion) {
    let mut patch = Patch::new();
    patch.integration.rtol = 1e-7;
    patch.integration.atol = 1e-9;
    let limiter = |x: f64| Kind::Limiter {
        low: Level::Fixed(-x),
        high: Level::Fixed(x),
    };
    patch.add("theta", integrator(0.1), &["rate"]);
    patch.add(
        "rate",
        integrator(0.0),
        &["1.5 * theta", "-0.1 * rate", "20 * tip", "2e-4 * force"],
    );
    patch.add("gyro", integrator(0.0), &["100 * turn"]);
    patch.add(
        "turn",
        integrator(0.0),
        &["100 * rate", "-100 * gyro", "-140 * turn"],
    );
    patch.add(
        "filter",
        integrator(0.0),
        &["-30 * theta", "-24 * gyro", "-30 * filter"],
    );
    patch.add("command", limiter(0.17), &["2 * filter"]);
    patch.add("slope", limiter(1.75), &["20 * command", "-20 * tip"]);
    patch.add("tip", integrator(0.0), &["slope"]);
    let zone = Kind::DeadZone {
        width: Level::Fixed(0.08),
    };
    patch.add("beyond", zone, &["-1 * theta", "-0.15 * gyro"]);
    patch.add("demand", limiter(15000.0), &["200000 * beyond"]);
    patch.add("force", integrator(0.0), &["10 * demand", "-10 * force"]);
    let f = |&[theta, rate, gyro, turn, filter, tip, force]: &[f64; 7]| {
        let command = (2.0 * filter).clamp(-0.17, 0.17);
        let slope = (20.0 * (command - tip)).clamp(-1.75, 1.75);
        let error = -theta - 0.15 * gyro;
        let beyond = error - error.clamp(-0.08, 0.08);
        let demand = (200_000.0 * beyond).clamp(-15000.0, 15000.0);
        [
            rate,
            1.5 * theta - 0.1 * rate + 20.0 * tip + 2e-4 * force,
            100.0 * turn,
            100.0 * rate - 100.0 * gyro - 140.0 * turn,
            -30.0 * theta - 24.0 * gyro - 30.0 * filter,
            slope,
            10.0 * demand - 10.0 * force,
        ]
    };
    let start = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    compare(c, "stage", &patch, f, start, 49.0);
}

criterion_group!(benches, lorenz, rod, stage);
criterion_main!(benches);
