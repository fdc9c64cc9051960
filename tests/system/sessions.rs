//! Many sessions side by side, which load every core, and sessions that are joined by name.

use crate::bench_top::{BenchTop, expect, stderr, wait_within};
use std::time::Duration;

#[test]
fn fifty_sessions_at_once_do_not_disturb_each_other() {
    let bench = BenchTop::new();
    let children: Vec<_> =
        (0..50).map(|_| bench.fly(&["--until", "3s"]).spawn().unwrap()).collect();
    for child in children {
        // A hundred processes share two cores here.
        let (output, _) = wait_within(child, Duration::from_secs(120));
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let traces = bench.traces();
    assert_eq!(traces.len(), 50);
    assert!(traces.iter().all(|t| *t == traces[0]), "the sessions' traces differ");
    bench.assert_clean();
}

#[test]
fn a_session_of_another_terminal_can_be_joined() {
    let bench = BenchTop::new();
    let serve = bench.serve("lab");
    expect(&mut bench.fly(&["--until", "2s", "--attach", "lab"]), 0);
    let (output, _) = wait_within(serve, Duration::from_secs(5));
    assert!(output.status.success(), "{}", stderr(&output));
    bench.assert_clean();
}
