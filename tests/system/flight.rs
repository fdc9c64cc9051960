//! The flight that the README promises.

use crate::bench_top::{
    BenchTop, argv0, assert_self_contained, children, expect, partner_of, runs, stderr, until,
    wait_within,
};
use std::time::Duration;

#[test]
fn the_normal_flight_comes_out_as_designed() {
    let bench = BenchTop::new();
    let output = expect(bench.fly(&[]).arg("--json"), 0);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let at = |path: &str| summary["results"][path].as_f64().unwrap();
    // The design's figures and the digits they are given to; the velocity's
    // and altitude's last digits are units, Mach's and q's tenths.
    for (path, figure, within) in [
        ("max_q_pa", 95e3, 1e3),
        ("max_q_time_s", 32.0, 1.0),
        ("max_q_mach", 2.2, 0.1),
        ("max_q_altitude_m", 9.7e3, 0.2e3),
        ("burn_out_velocity_m_s", 1053.0, 2.0),
        ("burn_out_flight_path_angle_deg", 67.0, 0.5),
        ("burn_out_altitude_m", 23.6e3, 0.1e3),
    ] {
        assert!((at(path) - figure).abs() < within, "{path}: {} against {figure}", at(path));
    }
    let directory = &bench.run_directories()[0];
    assert_eq!(summary["run"], directory.to_str().unwrap());
    for file in ["run.toml", "trace.arrow", "summary.json"] {
        assert!(directory.join(file).is_file(), "{file} is missing");
    }
    let page = assert_self_contained(&directory.join("report.html"));
    // 23 curves of at most 800 points of at most 10 bytes, and 70 kB for the rest.
    assert!(page.len() < 23 * 800 * 10 + 70_000, "{} bytes", page.len());
    bench.assert_clean();
}

#[test]
fn two_processes_of_two_names_fly_and_none_is_left() {
    let bench = BenchTop::new();
    // Millisecond frames make the flight last long enough to be looked at.
    let child = bench.fly(&["--frame", "1ms", "--fast", "1"]).spawn().unwrap();
    let analog = partner_of(&child);
    assert_eq!(argv0(analog), "analog-proc");
    assert_eq!(children(child.id()), [analog]);
    let name = |pid| std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
    until("the name of analog-proc", Duration::from_secs(5), || {
        (name(analog).trim_end() == "analog-proc").then_some(())
    });
    assert_eq!(name(child.id()).trim_end(), "digital-proc");
    let (output, _) = wait_within(child, Duration::from_secs(60));
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(!runs(analog));
    bench.assert_clean();
}

#[test]
fn mistakes_on_the_command_line_are_explained() {
    let bench = BenchTop::new();
    for (args, word) in [
        (&["--mode", "rol-lost"][..], "roll-lost"),
        (&["--frame", "100"][..], "unit"),
        (&["--frame", "1ns", "--fast", "3"][..], "--fast"),
        (&["--fast", "0"][..], "at least 1"),
        (&["--misalign-yaw", "nan"][..], "finite"),
        (&["--latency", "1s"][..], "--latency"),
        (&["--profile", "ad5"][..], "ad4"),
        (&["--vehicle", "no-such.toml"][..], "no-such.toml"),
        (&["--attach", "nobody"][..], "nobody"),
    ] {
        let text = stderr(&expect(&mut bench.fly(args), 2));
        assert!(text.contains(word), "{args:?}: {text}");
    }
    bench.assert_clean();
}
