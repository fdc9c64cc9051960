//! Death of either side, at any moment.

use crate::bench_top::{BenchTop, partner_of, runs, signal, trace_rows, until, wait_within};
use rustix::process::Signal;
use std::time::Duration;

/// A flight of some seconds, so that it can be killed on the way.
const LONG: [&str; 4] = ["--frame", "200us", "--fast", "1"];
/// In which either side must notice and end.
const NOTICE: Duration = Duration::from_secs(1);

#[test]
fn a_killed_analog_side_is_named_and_the_trace_is_kept() {
    for after_ms in [60, 150, 400] {
        let bench = BenchTop::alone();
        let child = bench.fly(&LONG).spawn().unwrap();
        let analog = partner_of(&child);
        std::thread::sleep(Duration::from_millis(after_ms));
        signal(analog, Signal::KILL);
        let (output, took) = wait_within(child, Duration::from_secs(10));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(text.contains("analog-proc") && text.contains("frame"), "{text}");
        assert!(took < NOTICE, "noticed only after {took:?}");
        if let Some(directory) = bench.run_directories().first() {
            // Readable up to its last complete batch, however many that are.
            let _ = trace_rows(directory);
        }
        bench.assert_clean();
    }
}

#[test]
fn a_killed_digital_side_ends_the_analog_one() {
    for after_ms in [60, 150, 400] {
        let bench = BenchTop::alone();
        let mut child = bench.fly(&LONG).spawn().unwrap();
        let analog = partner_of(&child);
        std::thread::sleep(Duration::from_millis(after_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        until("the end of analog-proc", NOTICE, || (!runs(analog)).then_some(()));
        if after_ms == 400 {
            assert!(trace_rows(&bench.run_directories()[0]) > 0);
        }
        bench.assert_clean();
    }
}

#[test]
fn either_side_may_die_during_start_up() {
    for step in 0..40_u64 {
        let bench = BenchTop::alone();
        let mut child = bench.fly(&LONG).spawn().unwrap();
        let delay = Duration::from_micros(500 * step);
        if step % 2 == 0 {
            let analog = partner_of(&child);
            std::thread::sleep(delay);
            signal(analog, Signal::KILL);
            let (output, took) = wait_within(child, Duration::from_secs(10));
            assert_eq!(
                output.status.code(),
                Some(3),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            assert!(took < NOTICE, "noticed only after {took:?}");
        } else {
            let analog = partner_of(&child);
            std::thread::sleep(delay);
            child.kill().unwrap();
            child.wait().unwrap();
            until("the end of analog-proc", NOTICE, || (!runs(analog)).then_some(()));
        }
        // What both may have left, the next session of this base removes.
        digital_proc_sweeps(&bench);
        bench.assert_clean();
    }
}

/// A following session removes what dead ones left.
fn digital_proc_sweeps(bench: &BenchTop) {
    let output = bench.fly(&["--until", "100ms"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn an_interrupt_ends_both_sides_cleanly() {
    let bench = BenchTop::alone();
    let child = bench.fly(&LONG).spawn().unwrap();
    let analog = partner_of(&child);
    std::thread::sleep(Duration::from_millis(200));
    signal(child.id(), Signal::INT);
    let (output, took) = wait_within(child, Duration::from_secs(10));
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.contains("interrupted"), "{text}");
    assert!(took < NOTICE && !runs(analog));
    assert!(trace_rows(&bench.run_directories()[0]) > 0);
    bench.assert_clean();
}

#[test]
fn a_stopped_side_is_given_up_within_two_seconds() {
    for stop_analog in [true, false] {
        let bench = BenchTop::alone();
        let child = bench.fly(&LONG).spawn().unwrap();
        let digital = child.id();
        let analog = partner_of(&child);
        std::thread::sleep(Duration::from_millis(200));
        if stop_analog {
            signal(analog, Signal::STOP);
        } else {
            signal(digital, Signal::STOP);
            until("the end of analog-proc", 2 * NOTICE, || (!runs(analog)).then_some(()));
            signal(digital, Signal::CONT);
        }
        let (output, took) = wait_within(child, Duration::from_secs(10));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{text}");
        assert!(took < 2 * NOTICE && !runs(analog), "{took:?}");
        assert!(!stop_analog || text.contains("stopped"), "{text}");
        bench.assert_clean();
    }
}

#[test]
fn a_side_that_is_stopped_for_a_second_loses_nothing() {
    let bench = BenchTop::alone();
    for pause in [None, Some(true), Some(false)] {
        let child = bench.fly(&LONG).spawn().unwrap();
        if let Some(stop_analog) = pause {
            let analog = partner_of(&child);
            std::thread::sleep(Duration::from_millis(200));
            let side = if stop_analog { analog } else { child.id() };
            signal(side, Signal::STOP);
            std::thread::sleep(Duration::from_secs(1));
            signal(side, Signal::CONT);
        }
        let (output, _) = wait_within(child, Duration::from_secs(60));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{pause:?}: {text}");
    }
    let traces: Vec<Vec<u8>> = bench
        .run_directories()
        .iter()
        .map(|d| std::fs::read(d.join("trace.arrow")).unwrap())
        .collect();
    assert!(traces.len() == 3 && traces.iter().all(|t| *t == traces[0]));
    bench.assert_clean();
}
