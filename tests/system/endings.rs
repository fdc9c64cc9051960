//! How a command ends that is told to, or whose output goes nowhere.

use crate::bench_top::{ANALOG, BenchTop, DIGITAL, partner_of, runs, signal, until, wait_within};
use rustix::process::Signal;
use std::{fs::OpenOptions, path::PathBuf, process::Command, time::Duration};

/// Each ends a run in good order.
const SIGNALS: [Signal; 4] = [Signal::INT, Signal::TERM, Signal::HUP, Signal::QUIT];
const NOTICE: Duration = Duration::from_secs(1);
const INTERRUPTED: Option<i32> = Some(130);
const OUTPUT_FAILED: Option<i32> = Some(4);

/// x follows a cosine at 1e13 a second: 3e12 steps a second.
const STIFF_PATCH: &str = r#"
title = "stiff"
[blocks]
s = { kind = "integrator", in = ["c"], ic = 0.0 }
c = { kind = "integrator", in = ["-1 * s"], ic = 1.0 }
x = { kind = "integrator", in = ["-1e13 * x", "1e13 * c"], ic = 1.0 }
"#;

fn stiff_patch(bench: &BenchTop) -> PathBuf {
    std::fs::create_dir_all(bench.runs()).unwrap();
    let path = bench.runs().join("stiff.toml");
    std::fs::write(&path, STIFF_PATCH).unwrap();
    path
}

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
        assert!(took < NOTICE && !runs(analog), "{ending:?}: {took:?}");
        bench.assert_clean();

        let serve = ["serve", "--session", "idle"];
        let serve = bench.command(ANALOG, &serve).spawn().unwrap();
        until("the session", Duration::from_secs(5), || {
            bench.base().join("idle.session").is_dir().then_some(())
        });
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
    let patch = stiff_patch(&bench);
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
        let text = String::from_utf8_lossy(&output.stderr);
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
        let text = String::from_utf8_lossy(&output.stderr);
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
    let text = String::from_utf8_lossy(&output.stderr);
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
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("ulimit -n"), "{text}");
}
