//! The whole 49 s flight, start-up and report included: both processes over
//! shared memory, against one process over the memory link and against the
//! monolithic reference (plain Rust, RK4 at 1 ms, no frames, no files).
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use std::{
    path::Path,
    process::{Command, Stdio},
    time::Duration,
};
use vehicle::{
    Vehicle,
    reference::{self, FlightCase},
};

/// One flight as a user runs it; its run directory is removed again.
fn fly(directory: &Path, link: &str) {
    let status = Command::new(env!("CARGO_BIN_EXE_digital-proc"))
        .args(["fly", "--link", link, "--out"])
        .arg(directory.join("runs"))
        .env("HYBRID_BASE", directory.join("sessions"))
        .stdout(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    std::fs::remove_dir_all(directory.join("runs")).unwrap();
}

fn flight(criterion: &mut Criterion) {
    let directory = tempfile::tempdir().unwrap();
    let vehicle = Vehicle::shipped().unwrap();
    let mut group = criterion.benchmark_group("flight of 49 s");
    group.sample_size(20).measurement_time(Duration::from_secs(8));
    group.bench_function("two processes", |b| b.iter(|| fly(directory.path(), "shm")));
    group.bench_function("memory link", |b| b.iter(|| fly(directory.path(), "memory")));
    group.bench_function("monolithic reference", |b| {
        b.iter(|| reference::fly(&vehicle, &FlightCase::undisturbed(), 1000, |_| {}).unwrap());
    });
    group.finish();
}

criterion_group!(benches, flight);
criterion_main!(benches);
