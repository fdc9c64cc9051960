//! A flight gives the same trace to the last bit, whatever joins or loads the two sides.

use crate::bench_top::BenchTop;
use std::process::Command;

fn trace_of(command: &mut Command, bench: &BenchTop) -> Vec<u8> {
    std::fs::read(bench.made(command).0.join("trace.arrow")).unwrap()
}

/// The same command on one core only.
fn pinned(bench: &BenchTop, args: &[&str]) -> Command {
    let plain = bench.fly(args);
    let mut command = bench.command("taskset", &["-c", "0"]);
    command.arg(plain.get_program()).args(plain.get_args());
    command
}

#[test]
fn memory_and_shared_memory_one_core_and_two_fly_alike() {
    for args in [&[][..], &["--until", "12s", "--latency", "20ms", "--skew", "100us"]] {
        let bench = BenchTop::new();
        let shm = trace_of(&mut bench.fly(args), &bench);
        let memory = trace_of(bench.fly(args).args(["--link", "memory"]), &bench);
        assert!(shm == memory, "{args:?}: the memory link differs");
        assert!(shm == trace_of(&mut pinned(&bench, args), &bench), "{args:?}: one core differs");
        bench.assert_clean();
    }
}

#[test]
fn two_hundred_repeats_are_identical() {
    let bench = BenchTop::new();
    let first = trace_of(&mut bench.fly(&["--until", "5s"]), &bench);
    for repeat in 1..200 {
        let again = trace_of(&mut bench.fly(&["--until", "5s"]), &bench);
        assert!(first == again, "repeat {repeat} differs");
        for directory in bench.run_directories().into_iter().skip(1) {
            std::fs::remove_dir_all(directory).unwrap();
        }
    }
    bench.assert_clean();
}
