//! How a command ends that is told to, or whose output goes nowhere.

use crate::bench_top::{
    ANALOG, BenchTop, DIGITAL, NOTICE, partner_of, runs, signal, stderr, trace_rows, wait_within,
};
use rustix::process::Signal;
use std::{fs::OpenOptions, process::Command, time::Duration};

/// Each ends a run in good order.
const SIGNALS: [Signal; 4] = [Signal::INT, Signal::TERM, Signal::HUP, Signal::QUIT];
const INTERRUPTED: Option<i32> = Some(130);
const OUTPUT_FAILED: Option<i32> = Some(4);

/// A file that is always full.
fn full() -> std::process::Stdio {
    let full = OpenOptions::new().write(true).open("/dev/full");
    full.unwrap().into()
}

#[test]
fn every_ending_signal_ends_a_flight_and_an_idle_session() {
    for ending in SIGNALS {
        let bench = BenchTop::alone();
        let flight = bench.fly(&["--frame", "200us", "--fast", "1"]).spawn().unwrap();
        let analog = partner_of(&flight);
        std::thread::sleep(Duration::from_millis(200));
        signal(flight.id(), ending);
        let (output, took) = wait_within(flight, Duration::from_secs(10));
        assert_eq!(output.status.code(), INTERRUPTED, "{ending:?}");
        assert!(stderr(&output).contains("interrupted"), "{ending:?}: {}", stderr(&output));
        assert!(took < NOTICE && !runs(analog), "{ending:?}: {took:?}");
        assert!(trace_rows(&bench.run_directories()[0]) > 0);
        bench.assert_clean();

        let serve = bench.serve("idle");
        std::thread::sleep(Duration::from_millis(50));
        signal(serve.id(), ending);
        let (output, took) = wait_within(serve, Duration::from_secs(10));
        assert_eq!(output.status.code(), INTERRUPTED, "{ending:?}");
        assert!(took < NOTICE, "{ending:?}: {took:?}");
        bench.assert_clean();
    }
}

#[test]
fn a_run_that_integrates_heeds_signals_and_keeps_its_rows() {
    let bench = BenchTop::alone();
    let patch = bench.stiff_patch();
    for ending in SIGNALS {
        let out = bench.runs().join("rows.csv");
        let run = bench
            .command(ANALOG, &["run", "--until", "1ms", "--every", "1ns", "--out"])
            .args([&out, &patch])
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(300));
        signal(run.id(), ending);
        let (output, took) = wait_within(run, Duration::from_secs(10));
        let text = stderr(&output);
        assert_eq!(output.status.code(), INTERRUPTED, "{ending:?}: {text}");
        assert!(text.contains("interrupted") && text.contains(" s"), "{text}");
        assert!(took < NOTICE, "{ending:?}: {took:?}");
        let rows = std::fs::read_to_string(&out).unwrap();
        assert!(rows.lines().count() > 10 && rows.ends_with('\n'));
    }
}

#[test]
fn a_full_standard_output_is_told_and_no_panic() {
    let bench = BenchTop::new();
    let patch = concat!(env!("CARGO_MANIFEST_DIR"), "/patch-files/lorenz.toml");
    let analog: [&[&str]; 3] =
        [&["check", patch], &["draw", patch, "--out", "-"], &["run", patch, "--until", "1s"]];
    let out = bench.runs().display().to_string();
    let flown = format!("{out}/flown");
    let digital: [&[&str]; 5] = [
        &["fly", "--until", "100ms", "--out", &flown],
        &["sampling", "circle", "--json", "--out", &out],
        &["failures", "--text"],
        &["list", "--runs", &out],
        &["export", "last", "--runs", &flown],
    ];
    let all = analog.map(|args| (ANALOG, args)).into_iter();
    for (binary, args) in all.chain(digital.map(|args| (DIGITAL, args))) {
        let mut command: Command = bench.command(binary, args);
        let output = command.stdout(full()).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), OUTPUT_FAILED, "{args:?}: {text}");
        assert!(text.contains("No space left"), "{args:?}: {text}");
        assert!(!text.contains("panicked"), "{args:?}: {text}");
        // Nor where there is nobody to be told.
        let status = bench.command(binary, args).stdout(full()).stderr(full()).status();
        assert_eq!(status.unwrap().code(), OUTPUT_FAILED, "{args:?}");
    }
    bench.assert_clean();
}

#[test]
fn what_cannot_be_written_leaves_no_half_file() {
    let bench = BenchTop::new();
    // A limit on the size of files stands for a full disk. SIGXFSZ is ignored, as a
    // shell's `trap ''` does, so that the write fails instead.
    let shell = format!(
        "trap '' XFSZ; ulimit -f 20; exec {DIGITAL} fly --until 300ms --link memory --out {}",
        bench.runs().display()
    );
    let output = bench.command("bash", &["-c", &shell]).output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), OUTPUT_FAILED, "{text}");
    assert!(text.contains("cannot write"), "{text}");
    for directory in bench.run_directories() {
        for entry in std::fs::read_dir(directory).unwrap() {
            let name = entry.unwrap().file_name();
            assert!(!name.to_string_lossy().ends_with(".partial"), "{name:?}");
        }
    }
    bench.assert_clean();
}

#[test]
fn too_few_files_are_told_at_once() {
    let bench = BenchTop::new();
    let shell = format!("ulimit -n 24; exec {DIGITAL} fly --until 100ms");
    let run = bench.command("bash", &["-c", &shell]).spawn().unwrap();
    let (output, _) = wait_within(run, Duration::from_secs(2));
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("ulimit -n"), "{text}");
}
