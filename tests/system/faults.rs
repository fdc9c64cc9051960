//! Death of either side, at any moment.

use crate::bench_top::{
    BenchTop, NOTICE, expect, partner_of, runs, signal, stderr, trace_rows, until, wait_within,
};
use rustix::process::Signal;
use std::time::Duration;

/// A flight of some seconds, so that it can be killed on the way.
const LONG: [&str; 4] = ["--frame", "200us", "--fast", "1"];

#[test]
fn either_side_may_be_killed_at_any_moment() {
    let starting = (0..40).map(|step| (Duration::from_micros(500 * step), step % 2 == 0));
    let flying = [60, 150, 400].map(Duration::from_millis);
    let flying = flying.into_iter().flat_map(|after| [(after, true), (after, false)]);
    for (after, kill_analog) in starting.chain(flying) {
        let bench = BenchTop::alone();
        let mut child = bench.fly(&LONG).spawn().unwrap();
        let analog = partner_of(&child);
        std::thread::sleep(after);
        let is_flying = after > Duration::from_millis(50);
        // While the transport makes what both share it may wait for the dead one; whoever opens a
        // link gives it a second and a half to notice by itself.
        let notice = if is_flying { NOTICE } else { 3 * NOTICE };
        if kill_analog {
            signal(analog, Signal::KILL);
            let (output, took) = wait_within(child, Duration::from_secs(10));
            let text = stderr(&output);
            assert_eq!(output.status.code(), Some(3), "{after:?}: {text}");
            let is_told =
                text.contains("analog-proc is gone (last frame ") && text.contains("signal 9");
            assert!(is_told || !is_flying, "{after:?}: {text}");
            assert!(took < notice, "{after:?}: noticed only after {took:?}");
        } else {
            child.kill().unwrap();
            child.wait().unwrap();
            until("the end of analog-proc", notice, || (!runs(analog)).then_some(()));
        }
        if is_flying {
            // Readable up to its last complete batch, however many that are.
            let rows = bench.run_directories().first().map_or(0, |run| trace_rows(run));
            assert!(rows > 0 || kill_analog || after < Duration::from_millis(400));
        } else {
            // What both may have left, the next session of this base removes.
            expect(&mut bench.fly(&["--until", "100ms"]), 0);
        }
        bench.assert_clean();
    }
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
        let text = stderr(&output);
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
        let text = stderr(&output);
        assert!(output.status.success(), "{pause:?}: {text}");
    }
    let traces = bench.traces();
    assert!(traces.len() == 3 && traces.iter().all(|t| *t == traces[0]));
    bench.assert_clean();
}
