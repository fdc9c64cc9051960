//! Iterative operation: many runs by one request, each with the bits of a run alone.

use crate::bench_top::{ANALOG, BenchTop, bundle, expect, stderr, with_console};
use digital_proc::linkage::console::{Console, ConsoleFault, SweepRun};
use interface::{
    Tick,
    control::{ChannelKind, Clock, RunSpec, SweptRun},
    frame::{Samples, Updates},
    profile::Profile,
};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use serde_json::Value;

/// A decay of settable rate that ends in a division by zero, where it gets so far.
const DECAY: &str = r#"
title = "decay"
[blocks]
x = { kind = "integrator", in = ["-1 * rate"], ic = 1.0 }
rate = { kind = "dcu", in = ["x"], channel = 0 }
one = { kind = "constant", value = 1.0 }
past = { kind = "summer", in = ["x", "-0.01 * one"] }
pole = { kind = "divider", in = ["x", "past"] }
a = { kind = "adc", in = ["x"], channel = 0, max = 2.0 }
b = { kind = "adc", in = ["pole"], channel = 1, max = 2.0 }
"#;

const EVERY: Tick = Tick(10_000_000);

fn load(console: &mut Console<'_>) {
    console.load(bundle(DECAY), Vec::new(), Profile::ideal()).unwrap();
}

/// The `i`-th run: rates from 0.5/s on, from different starts, of different length.
fn asked(i: usize) -> SweepRun<'static> {
    let i = i as f64;
    SweepRun {
        ics: vec![("x", 1.0 + 0.1 * i)],
        settings: vec![("rate", 0.5 + 0.1 * i)],
        stop: Tick::from_secs(1.0 + 0.02 * i).unwrap(),
    }
}

fn swept(
    console: &mut Console<'_>,
    runs: impl Iterator<Item = SweepRun<'static>>,
) -> Vec<SweptRun> {
    let mut all = Vec::new();
    console.sweep(EVERY, &[0, 1], runs, |run| all.push(run)).unwrap();
    all
}

/// The same run frame by frame.
fn alone(console: &mut Console<'_>, run: SweepRun<'_>) -> Vec<f64> {
    let owned = |(name, value): &(&str, f64)| ((*name).to_owned(), *value);
    console.set_ics(run.ics.iter().map(owned).collect()).unwrap();
    console.preset(&console.settings(&run.settings).unwrap()).unwrap();
    let spec = RunSpec {
        frame: EVERY,
        latency: EVERY,
        skew: Tick::ZERO,
        stop: run.stop,
        from_ic: true,
        clock: Clock::LockStep,
    };
    let mut samples = Vec::new();
    let mut law = |frame: &Samples, _: &mut Updates| samples.extend(&frame.adc[..2]);
    console.run(&spec, &mut law).unwrap();
    samples
}

#[test]
fn a_swept_run_has_the_bits_of_one_alone_on_one_processor_or_all() {
    let all = sched_getaffinity(None).unwrap();
    let first = (0..CpuSet::MAX_CPU).find(|cpu| all.is_set(*cpu)).unwrap();
    let mut one = CpuSet::new();
    one.set(first);
    let single: Vec<Vec<f64>> = with_console(|console| {
        load(console);
        (0..30).map(|i| alone(console, asked(i))).collect()
    });
    for processors in [one, all] {
        // Of this thread, and so of the analog side's, which it starts.
        sched_setaffinity(None, &processors).unwrap();
        let runs = with_console(|console| {
            load(console);
            // Backwards first: no run may know of what ran before it.
            let mut backwards = swept(console, (0..30).rev().map(asked));
            backwards.reverse();
            let runs = swept(console, (0..30).map(asked));
            assert_eq!(runs, backwards);
            runs
        });
        for (i, (run, samples)) in runs.iter().zip(&single).enumerate() {
            assert_eq!(&run.samples, samples, "run {i}");
            assert_eq!((run.saturated, &run.fault), (false, &None), "run {i}");
        }
    }
}

#[test]
fn a_run_that_faults_ends_alone_and_a_setting_that_is_refused_is_named() {
    with_console(|console| {
        load(console);
        let long = |i: usize| SweepRun { stop: Tick::SECOND * 8, ..asked(i) };
        let runs = swept(console, [asked(0), long(9), asked(1)].into_iter());
        let faults: Vec<bool> = runs.iter().map(|run| run.fault.is_some()).collect();
        assert_eq!(faults, [false, true, false]);
        let (time, fault) = runs[1].fault.clone().unwrap();
        // 1.9·exp(−1.4 t) = 0.01 at t = ln(190)/1.4 = 3.7479; the frame after it tells.
        assert_eq!(time, EVERY * 375);
        assert!(fault.contains("pole") && fault.contains("3.7478"), "{fault}");
        assert_eq!(runs[1].samples.len(), 2 * 375, "what was sampled before stands");
        let nonsense = SweepRun { ics: vec![("x", f64::NAN)], ..asked(0) };
        let refused = console.sweep(EVERY, &[0], [asked(0), nonsense], |_| {}).unwrap_err();
        let text = refused.to_string();
        assert!(matches!(refused, ConsoleFault::Refused(_)), "{text}");
        assert!(text.contains("case 1") && text.contains("`x`"), "{text}");
        // Neither left anything behind.
        assert_eq!(swept(console, [asked(0)].into_iter())[0].samples, alone(console, asked(0)));
        assert_eq!(console.channel(ChannelKind::Adc, "b").unwrap(), 1);
    });
}

/// Peak of this process' memory, KiB.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
#[ignore = "needs the process to itself; run by the soak"]
fn a_hundred_thousand_runs_need_no_more_memory_than_a_thousand() {
    with_console(|console| {
        load(console);
        let mut count = |runs: usize| {
            let mut counted = 0;
            let short = |i: usize| SweepRun { stop: EVERY * 10, ..asked(i % 50) };
            console.sweep(EVERY, &[0, 1], (0..runs).map(short), |_| counted += 1).unwrap();
            assert_eq!(counted, runs);
            peak_kib()
        };
        let (thousand, many) = (count(1_000), count(100_000));
        // Allocators keep some of what threads have freed; the runs' own samples are 17 MB.
        assert!(many < thousand + 8 * 1024, "{thousand} KiB, then {many} KiB");
    });
}

/// `analog-proc sweep` against runs of the same settings, and against ω = ω₀ √(1 − ζ²).
#[test]
fn a_students_sweep_has_the_numbers_of_his_runs() {
    let top = BenchTop::new();
    std::fs::create_dir_all(top.runs()).unwrap();
    let patch = concat!(env!("CARGO_MANIFEST_DIR"), "/patch-files/damped-oscillator.toml");
    let page = top.runs().join("zeta.html").display().to_string();
    let sets = ["--set", "zeta=0.02:0.32:4", "--set", "wn=1.5,2"];
    let args = [&["sweep", patch, "--until", "20s", "--page", &page, "--json"], &sets[..]].concat();
    let told = expect(&mut top.command(ANALOG, &args), 0).stdout;
    let told: Value = serde_json::from_slice(&told).unwrap();
    let rows = told["tables"]["sweep"].as_array().unwrap();
    assert_eq!(rows.len(), 8);
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let (zeta, wn) = (number("zeta"), number("wn"));
        let (zeta_set, wn_set) = (format!("zeta={zeta}"), format!("wn={wn}"));
        let csv = top.runs().join("one.csv").display().to_string();
        let one = ["run", patch, "--until", "20s", "--every", "20ms", "--out", &csv];
        let args = [&one[..], &["--set", &zeta_set, "--set", &wn_set]].concat();
        expect(&mut top.command(ANALOG, &args), 0);
        let text = std::fs::read_to_string(&csv).unwrap();
        let place = text.lines().next().unwrap().split(',').position(|name| name == "x").unwrap();
        let column: Vec<f64> = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').nth(place).unwrap().parse().unwrap())
            .collect();
        let extreme = |of: fn(f64, f64) -> f64| column.iter().copied().reduce(of).unwrap();
        for (key, truth) in [
            ("x_last", *column.last().unwrap()),
            ("x_least", extreme(f64::min)),
            ("x_greatest", extreme(f64::max)),
        ] {
            // The reader of JSON may lose the last bit.
            assert!((number(key) - truth).abs() <= f64::EPSILON * truth.abs(), "{key} {row}");
        }
        if zeta < 0.05 {
            // A decay crosses its mean a little off zero: below a hundredth of the period.
            let truth = std::f64::consts::TAU / (wn * (1.0 - zeta * zeta).sqrt());
            assert!((number("x_period_s") / truth - 1.0).abs() < 1e-2, "{row}");
        }
    }
    let page = std::fs::read_to_string(&page).unwrap();
    assert!(page.contains("zeta = 0.02") && page.contains("<svg"));
    let refused = |sets: &[&str], told: &str| {
        let args = [&["sweep", patch, "--until", "1s"], sets].concat();
        let text = stderr(&expect(&mut top.command(ANALOG, &args), 2));
        assert!(text.contains(told), "{text}");
    };
    refused(&["--set", "zeta=1:2"], "LOW:HIGH:COUNT");
    refused(&["--set", "zeta=0:1:9:log"], "positive");
    refused(&["--set", "zeta=1", "--set", "zeta=2"], "twice");
    refused(&["--set", "zeta=0:1:1000", "--set", "wn=1:2:1000"], "1000000 runs");
    refused(&["--set", "zetta=1,2"], "zeta");
}
