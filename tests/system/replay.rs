//! Flights on the wall clock, their replay, and what runs leave behind.
//!
//! Nothing here asserts a speed: on a loaded machine frames overrun, are counted,
//! and the replay is the same all the same.

use crate::bench_top::{
    BenchTop, Busy, DIGITAL, NOTICE, assert_self_contained, expect, partner_of, runs, signal,
    stderr, until, wait_within,
};
use desk::run_dir::{RunDirectory, Trace, TraceWriter};
use interface::Tick;
use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

/// A command on runs of this test.
fn on_runs(bench: &BenchTop, args: &[&str]) -> Command {
    let mut command = bench.command(DIGITAL, args);
    command.arg("--runs").arg(bench.runs());
    command
}

/// Flies on the wall clock; its directory and what it says of its pacing.
fn fly_paced(bench: &BenchTop, args: &[&str]) -> (PathBuf, serde_json::Value) {
    let mut command = bench.fly(&["--clock", "wall", "--json"]);
    let (run, output) = bench.made(command.args(args));
    (run, serde_json::from_slice(&output.stdout).unwrap())
}

fn assert_replays(bench: &BenchTop, run: &Path, more: &[&str]) {
    let mut command = on_runs(bench, &["replay"]);
    let output = expect(command.arg(run).args(more), 0);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("identical"), "{text}");
}

/// Every overrun is listed, and counted once a frame.
fn assert_overruns_counted(summary: &serde_json::Value) {
    let overruns = summary["tables"]["overruns"].as_array().unwrap().iter();
    let mut frames: Vec<u64> = overruns.map(|o| o["frame"].as_f64().unwrap() as u64).collect();
    frames.sort_unstable();
    frames.dedup();
    assert_eq!(summary["results"]["frames_overrun"], frames.len() as f64);
}

#[test]
fn a_flight_on_the_wall_clock_replays_to_the_last_bit() {
    let bench = BenchTop::new();
    for (frame, frames) in [("10ms", 100_u64), ("1ms", 1_000)] {
        let args = ["--until", "1s", "--frame", frame, "--fast", "1"];
        let (run, pacing) = fly_paced(&bench, &args);
        // Frames 0 to n: problem time never skips.
        assert_eq!(pacing["results"]["frames"], (frames + 1) as f64);
        assert_overruns_counted(&pacing);
        let record = std::fs::read_to_string(run.join("run.toml")).unwrap();
        assert!(record.contains("clock = \"wall\""), "{record}");
        let page = std::fs::read_to_string(run.join("report.html")).unwrap();
        assert!(page.contains("Pacing by the wall clock"));

        // The updates took their time, so that the run is another than in lock-step …
        let transfers = Trace::read(&run.join("transfers.arrow")).unwrap();
        let period = 1_000_000_000 / frames as i64;
        assert!(transfers.rows() > 0 && transfers.rows() as u64 <= frames);
        for (frame, tick) in transfers.column("frame").unwrap().iter().zip(transfers.ticks()) {
            assert!(*tick > *frame as i64 * period, "updates {frame} came before their samples");
        }
        let trace = std::fs::read(run.join("trace.arrow")).unwrap();
        let (stepped, _) = bench.made(&mut bench.fly(&args));
        assert!(trace != std::fs::read(stepped.join("trace.arrow")).unwrap());
        // … and both are repeated to the last bit.
        assert_replays(&bench, &run, &[]);
        assert_replays(&bench, &run, &["--link", "memory"]);
        assert_replays(&bench, &stepped, &[]);
    }
    bench.assert_clean();
}

#[test]
fn an_overloaded_flight_replays_to_the_last_bit() {
    let bench = BenchTop::new();
    let _busy = Busy::programs(4);
    let skewed = ["--until", "400ms", "--frame", "1ms", "--fast", "1"];
    let skewed = [&skewed[..], &["--latency", "500us", "--skew", "20us"]].concat();
    for (args, frames) in [(&skewed[..], 401.0), (&["--until", "410ms", "--link", "memory"], 22.0)]
    {
        let (run, pacing) = fly_paced(&bench, args);
        assert_eq!(pacing["results"]["frames"], frames);
        assert_overruns_counted(&pacing);
        assert_replays(&bench, &run, &[]);
    }
    bench.assert_clean();
}

/// The record holds all that a flight follows from, each set to what is not its default.
#[test]
fn a_flight_of_many_settings_replays_from_its_record_alone() {
    let bench = BenchTop::new();
    let settings = "--mode roll-lost --failure-at 20000000001ns --profile ad4 --alpha held \
        --wind ensemble --seed 18446744073709551615 --misalign-pitch 0.30000000000000004 \
        --misalign-yaw -0.3333333333333333 --frame 50ms --fast 2 --latency 1234567ns \
        --skew 10001ns --until 22s";
    let settings: Vec<&str> = settings.split_whitespace().collect();
    let (run, _) = bench.made(&mut bench.fly(&settings));
    assert_replays(&bench, &run, &[]);
    bench.assert_clean();
}

/// Writes a run's transfers anew, one of them later.
fn delay_one_transfer(run: &Path) -> u64 {
    let path = run.join("transfers.arrow");
    let transfers = Trace::read(&path).unwrap();
    let mut ticks = transfers.ticks().to_vec();
    let late = (0..ticks.len() - 1)
        .find(|&n| ticks[n + 1] - ticks[n] > 1_000_000)
        .expect("no two transfers lie 1 ms apart");
    ticks[late] += 500_000;
    let file = std::fs::File::create(&path).unwrap();
    let mut writer = TraceWriter::new(file, &path, transfers.columns(), 64).unwrap();
    for (tick, frame) in ticks.iter().zip(transfers.column("frame").unwrap()) {
        writer.push(Tick(*tick), &[*frame]).unwrap();
    }
    writer.finish().unwrap();
    late as u64
}

#[test]
fn a_replay_that_differs_says_where() {
    let bench = BenchTop::new();
    let (run, _) = fly_paced(&bench, &["--until", "400ms", "--frame", "20ms", "--fast", "1"]);
    assert_replays(&bench, &run, &[]);
    let late = delay_one_transfer(&run);
    let output = expect(on_runs(&bench, &["replay"]).arg(&run), 1);
    let text = stderr(&output);
    let row: u64 = text
        .split("row ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .unwrap_or_else(|| panic!("no row named: {text}"))
        .parse()
        .unwrap();
    // Nothing can differ before the samples that follow the delayed transfer.
    assert!(row > late, "{text}");
    assert!(text.contains("bits"), "{text}");
}

#[test]
fn runs_are_listed_exported_and_plotted() {
    let bench = BenchTop::new();
    let (run, _) = fly_paced(&bench, &["--until", "200ms"]);
    let name = run.file_name().unwrap().to_str().unwrap().to_owned();
    let rows = RunDirectory::open(&run).unwrap().read_trace().unwrap().rows();
    let text = |output: std::process::Output| String::from_utf8(output.stdout).unwrap();

    let list = text(expect(&mut on_runs(&bench, &["list"]), 0));
    assert!(
        list.contains(&name) && list.contains("complete") && list.contains("fly normal"),
        "{list}"
    );
    let list = expect(&mut on_runs(&bench, &["list", "--json"]), 0);
    let list: serde_json::Value = serde_json::from_slice(&list.stdout).unwrap();
    assert_eq!(list["tables"]["runs"][0]["name"], name.as_str());

    let printed = text(expect(&mut on_runs(&bench, &["export", "last", "--csv"]), 0));
    assert_eq!(printed.lines().count(), rows + 1);
    assert!(printed.starts_with("tick_ns,time_s,velocity_m_s [m/s],"), "{printed}");
    let file = run.join("of-mine.csv");
    expect(on_runs(&bench, &["export", "last", "--csv"]).arg("--out").arg(&file), 0);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), printed);
    let transfers = text(expect(&mut on_runs(&bench, &["export", "last", "--transfers"]), 0));
    assert!(transfers.starts_with("tick_ns,time_s,frame\n"), "{transfers}");

    expect(&mut on_runs(&bench, &["plot", &name]), 0);
    let page = assert_self_contained(&run.join("plots.html"));
    assert!(page.contains("<svg") && page.contains("dynamic_pressure_pa"));

    let output = expect(&mut on_runs(&bench, &["export", "lats"]), 2);
    assert!(stderr(&output).contains("lats"));
}

#[test]
fn a_damaged_record_is_refused_with_its_line() {
    let bench = BenchTop::new();
    expect(&mut bench.fly(&["--until", "200ms"]), 0);
    let run = bench.run_directories().remove(0);
    let path = run.join("run.toml");
    let sound = std::fs::read_to_string(&path).unwrap();
    for (from, to) in [
        ("frame = \"100ms\"", "frame = \"100\""),
        ("fast = 5", "fast = five"),
        ("link = \"shm\"", "link = shm\""),
        ("wind = \"none\"", "wind = \"gale\""),
        ("alpha = \"redundant\"", "alpha = \"held-up\""),
        ("misalign-pitch = 0.0", "misalign-pitch = 0.0."),
    ] {
        let at = sound.find(from).unwrap_or_else(|| panic!("{from} is not in\n{sound}"));
        let line = 1 + sound[..at].matches('\n').count();
        std::fs::write(&path, sound.replacen(from, to, 1)).unwrap();
        let output = expect(on_runs(&bench, &["replay"]).arg(&run), 2);
        let text = stderr(&output);
        assert!(text.contains(&format!("run.toml:{line}:")), "{to}: {text}");
    }
    // What parses but cannot be flown is refused too.
    std::fs::write(&path, sound.replacen("fast = 5", "fast = 7", 1)).unwrap();
    let output = expect(on_runs(&bench, &["replay"]).arg(&run), 2);
    assert!(stderr(&output).contains("run.toml"));
    bench.assert_clean();
}

#[test]
fn either_side_notices_a_death_between_the_frames() {
    let bench = BenchTop::alone();
    let paced = ["--clock", "wall", "--frame", "5s", "--fast", "1"];
    for digital_dies in [false, true] {
        let child = bench.fly(&paced).spawn().unwrap();
        let analog = partner_of(&child);
        until("the trace", Duration::from_secs(20), || {
            let directories = bench.run_directories();
            directories.iter().any(|d| d.join("transfers.arrow").is_file()).then_some(())
        });
        // Both now wait for the next frame, seconds away.
        std::thread::sleep(Duration::from_millis(300));
        let dying = if digital_dies { child.id() } else { analog };
        signal(dying, rustix::process::Signal::KILL);
        // A frame lasts 5 s.
        let (output, _) = wait_within(child, NOTICE);
        if !digital_dies {
            assert_eq!(output.status.code(), Some(3));
            let text = stderr(&output);
            assert!(text.contains("analog-proc is gone"), "{text}");
        }
        until("the end of the analog side", NOTICE, || (!runs(analog)).then_some(()));
        for directory in bench.run_directories() {
            std::fs::remove_dir_all(directory).unwrap();
        }
    }
    until("the session's removal", Duration::from_secs(3), || {
        std::fs::read_dir(bench.base()).map_or(true, |mut d| d.next().is_none()).then_some(())
    });
}
