//! Runs that are killed at any moment and gone on with from their last checkpoint: what they leave
//! is what a run leaves that was never stopped, byte for byte.
//!
//! A few kills here; the ignored tests kill as often as the variable `KILLS` says (200 without it),
//! from the seed `KILLS_SEED`.

use crate::bench_top::{ANALOG, BenchTop, DIGITAL, argv0, children, expect, signal, stderr, until};
use crate::kills::{Chance, asked, of_base};
use std::{
    path::{Path, PathBuf},
    process::Output,
    time::{Duration, Instant},
};

/// Runs of a patch that keep checkpoints: patch, end, interval of the rows and of the checkpoints,
/// name of the output.
const RUNS: [[&str; 5]; 4] = [
    ["lorenz.toml", "2000s", "7ms", "31s", "out.csv"],
    ["bouncing-ball.toml", "3900ms", "10us", "100ms", "out.arrow"],
    ["heat-rod.toml", "4000s", "40ms", "200s", "out.html"],
    ["charge-pump-pll.toml", "60ms", "500ns", "2ms", "out.arrow"],
];

fn patch(name: &str) -> String {
    format!("{}/patch-files/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The arguments of a run whose files go into `folder`.
fn arguments(run: [&str; 5], folder: &Path, keeps: bool) -> Vec<String> {
    let [name, until, every, checkpoint, output] = run;
    let output = folder.join(output).display().to_string();
    let to = if output.ends_with("html") { "--page" } else { "--out" };
    let mut words = vec!["run".to_owned(), patch(name)];
    words.extend(["--until", until, "--every", every, to, &output].map(str::to_owned));
    if keeps {
        words.extend(["--checkpoint", checkpoint].map(str::to_owned));
    }
    words
}

fn folder(bench: &BenchTop, name: &str) -> PathBuf {
    let folder = bench.runs().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What a run has written, apart from what only tells when and how it was begun.
fn written(path: &Path) -> Vec<u8> {
    let mut bytes = std::fs::read(path).unwrap();
    if path.extension().is_some_and(|e| e == "html") {
        let text = String::from_utf8(bytes).unwrap();
        let (results, _) = text.split_once("<section id=\"provenance\">").unwrap();
        bytes = results.into();
    }
    bytes
}

/// What it has said, with the folder of its files left out.
fn said(output: &Output, folder: &Path) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(output);
    text.replace(&folder.display().to_string(), "")
}

/// Kills each of the runs again and again until it comes to its end; `count` kills in all.
fn kills_of_a_patch(count: u64) {
    let bench = BenchTop::new();
    let mut chance = Chance(asked("KILLS_SEED", 0x0C4E_C4B0));
    let wholes = RUNS.map(|run| {
        let [plain, keeping] = [false, true].map(|keeps| {
            let folder = folder(&bench, if keeps { "keeping" } else { "plain" });
            let words = arguments(run, &folder, keeps);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let started = Instant::now();
            let output = expect(&mut bench.command(ANALOG, &words), 0);
            let file = folder.join(run[4]);
            assert!(!desk::checkpoint::beside(&file).exists(), "{run:?}");
            (written(&file), said(&output, &folder), started.elapsed())
        });
        assert!(plain.0 == keeping.0, "{run:?}: a checkpoint alters the run");
        assert_eq!(plain.1, keeping.1, "{run:?}");
        keeping
    });
    let (mut killed, mut resumed) = (0, 0);
    for n in 0.. {
        if killed >= count {
            break;
        }
        let (run, whole) = (RUNS[n % RUNS.len()], &wholes[n % RUNS.len()]);
        let folder = folder(&bench, &format!("kill-{n}"));
        let file = folder.join(run[4]);
        let checkpoint = desk::checkpoint::beside(&file);
        loop {
            let goes_on = checkpoint.exists();
            let words = if goes_on {
                vec!["resume".to_owned(), checkpoint.display().to_string()]
            } else {
                arguments(run, &folder, true)
            };
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let life = Duration::from_micros(chance.below(whole.2.as_micros() as u64));
            let mut child = bench.command(ANALOG, &words).spawn().unwrap();
            std::thread::sleep(life);
            let is_hit = child.try_wait().unwrap().is_none();
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            killed += u64::from(is_hit);
            resumed += u64::from(goes_on);
            if output.status.code().is_some() {
                let told = format!("{run:?}, kill {killed}, {life:?}");
                assert!(output.status.success(), "{told}: {}", stderr(&output));
                assert!(written(&file) == whole.0, "{told}: another record");
                assert_eq!(said(&output, &folder), whole.1, "{told}");
                assert!(!checkpoint.exists(), "{told}");
                break;
            }
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
    assert!(2 * resumed >= killed, "{resumed} resumed of {killed} killed");
}

#[test]
fn a_killed_run_of_a_patch_goes_on_to_the_same_bytes() {
    kills_of_a_patch(8);
}

#[test]
#[ignore = "a soak test"]
fn many_kills_of_runs_of_patches() {
    kills_of_a_patch(asked("KILLS", 200));
}

/// Flights that keep checkpoints; the links change from one life to the next.
const FLIGHTS: [&[&str]; 4] = [
    &["--mode", "normal"],
    &["--mode", "roll-lost", "--design-case", "--profile", "paper-class"],
    &["--wind", "ensemble", "--seed", "7", "--profile", "ad4", "--frame", "200ms"],
    &["--mode", "tips-dead", "--alpha", "held", "--fast", "3", "--frame", "99ms"],
];

/// What a flight has left: trace, results and report, without when and how it was begun.
fn left_by_flight(directory: &Path) -> [Vec<u8>; 3] {
    // The report names its directory.
    let own = directory.file_name().unwrap().to_string_lossy().into_owned();
    ["trace.arrow", "summary.json", "report.html"].map(|name| {
        match String::from_utf8(written(&directory.join(name))) {
            Ok(text) => text.replace(&own, "").into(),
            Err(trace) => trace.into_bytes(),
        }
    })
}

fn kills_of_flights(count: u64) {
    let bench = BenchTop::new();
    let mut chance = Chance(asked("KILLS_SEED", 0x0F1E_E1E5));
    let fly = |words: &[&str], keeps: bool, link: &str| {
        let mut command = bench.fly(words);
        command.args(["--link", link]);
        if keeps {
            command.args(["--checkpoint", "1500ms"]);
        }
        command
    };
    let wholes = FLIGHTS.map(|words| {
        let (plain, _) = bench.made(&mut fly(words, false, "memory"));
        let started = Instant::now();
        let (keeping, output) = bench.made(&mut fly(words, true, "shm"));
        let took = started.elapsed();
        assert!(!keeping.join("checkpoint").exists());
        let [left, other] = [&plain, &keeping].map(|directory| left_by_flight(directory));
        assert!(left[0] == other[0], "{words:?}: a checkpoint alters the flight");
        assert!(left[1] == other[1], "{words:?}: a checkpoint alters the results");
        (other, said(&output, &keeping), took)
    });
    let (mut killed, mut resumed) = (0, 0);
    for n in 0.. {
        if killed >= count {
            break;
        }
        let (words, whole) = (FLIGHTS[n % FLIGHTS.len()], &wholes[n % FLIGHTS.len()]);
        let before = bench.run_directories();
        let mut directory: Option<PathBuf> = None;
        loop {
            let link = ["memory", "shm"][chance.below(2) as usize];
            let goes_on = directory.as_ref().is_some_and(|d| d.join("checkpoint").exists());
            let mut command = match &directory {
                Some(directory) if goes_on => {
                    let place = directory.display().to_string();
                    bench.command(DIGITAL, &["resume", &place, "--link", link])
                }
                _ => fly(words, true, link),
            };
            let life = Duration::from_micros(chance.below(whole.2.as_micros() as u64));
            let mut child = command.spawn().unwrap();
            std::thread::sleep(life);
            let is_hit = child.try_wait().unwrap().is_none();
            let analog = children(child.id()).into_iter().find(|pid| argv0(*pid) == "analog-proc");
            match analog {
                Some(pid) if chance.below(3) == 0 => signal(pid, rustix::process::Signal::KILL),
                _ => child.kill().unwrap(),
            }
            let output = child.wait_with_output().unwrap();
            killed += u64::from(is_hit);
            resumed += u64::from(goes_on);
            let told = format!("{words:?} over {link}, kill {killed}, {life:?}");
            let mut new = bench.run_directories();
            new.retain(|d| !before.contains(d));
            if output.status.success() {
                let directory = if goes_on { directory.unwrap() } else { new.pop().unwrap() };
                let left = left_by_flight(&directory);
                for (found, expected) in left.iter().zip(&whole.0) {
                    assert!(found == expected, "{told}: another trace, result or report");
                }
                assert_eq!(said(&output, &directory), whole.1, "{told}");
                assert!(!directory.join("checkpoint").exists(), "{told}");
                break;
            }
            let code = output.status.code();
            assert!(matches!(code, None | Some(3)), "{told}: {code:?}: {}", stderr(&output));
            if !goes_on {
                directory = new.pop();
            }
        }
    }
    assert!(2 * resumed >= killed, "{resumed} resumed of {killed} killed");
    until("the end of all sides", Duration::from_secs(10), || {
        of_base(&bench).is_empty().then_some(())
    });
    // Where nobody survived, the next session removes what is left.
    expect(&mut bench.fly(&["--until", "100ms"]), 0);
    bench.assert_clean();
}

#[test]
fn a_killed_flight_goes_on_to_the_same_bytes() {
    kills_of_flights(8);
}

#[test]
#[ignore = "a soak test"]
fn many_kills_of_flights() {
    kills_of_flights(asked("KILLS", 200));
}

#[test]
fn a_checkpoint_of_another_flight_is_refused_with_its_reason() {
    let bench = BenchTop::new();
    // A flight that goes on until it is killed: a checkpoint at every fast frame.
    let interrupted = |mode: &str| {
        let before = bench.run_directories();
        let mut child = bench.fly(&["--checkpoint", "1ms", "--mode", mode]).spawn().unwrap();
        let directory = until("the first checkpoint", Duration::from_secs(20), || {
            let new = bench.run_directories().into_iter().find(|d| !before.contains(d));
            new.filter(|d| d.join("checkpoint").exists())
        });
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed");
        child.kill().unwrap();
        child.wait().unwrap();
        directory
    };
    let (mine, other) = (interrupted("normal"), interrupted("roll-lost"));
    let place = mine.display().to_string();
    let refusal = |reason: &str| {
        let output = expect(&mut bench.command(DIGITAL, &["resume", &place]), 2);
        let text = stderr(&output);
        assert!(text.contains(reason), "{reason}: {text}");
    };
    let checkpoint = mine.join("checkpoint");
    let whole = std::fs::read(&checkpoint).unwrap();
    std::fs::write(&checkpoint, &whole[..whole.len() - 1]).unwrap();
    refusal("is cut off");
    let mut damaged = whole.clone();
    damaged[whole.len() - 1] ^= 1;
    std::fs::write(&checkpoint, &damaged).unwrap();
    refusal("is damaged");
    std::fs::write(&checkpoint, std::fs::read(other.join("checkpoint")).unwrap()).unwrap();
    refusal("is not as it was when the flight began");
    std::fs::write(&checkpoint, &whole).unwrap();
    let record = std::fs::read_to_string(mine.join("run.toml")).unwrap();
    let changed = record.replace("misalign-pitch = 0.0", "misalign-pitch = 0.5");
    assert_ne!(changed, record);
    std::fs::write(mine.join("run.toml"), changed).unwrap();
    refusal("is not as it was when the flight began");
    std::fs::write(mine.join("run.toml"), record).unwrap();
    let rows = std::fs::read(mine.join("trace.arrow")).unwrap();
    std::fs::write(mine.join("trace.arrow"), &rows[1..]).unwrap();
    refusal("is not as the checkpoint left it");
    std::fs::write(mine.join("trace.arrow"), rows).unwrap();
    expect(&mut bench.command(DIGITAL, &["resume", &place, "--link", "memory"]), 0);
    refusal("it has ended");
    for (words, reason) in [
        (["--checkpoint", "1s", "--clock", "wall"], "lock-step"),
        (["--checkpoint", "0s", "--clock", "lock-step"], "must be positive"),
    ] {
        let text = stderr(&expect(&mut bench.fly(&words), 2));
        assert!(text.contains(reason), "{text}");
    }
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused_with_its_reason() {
    let bench = BenchTop::new();
    let folder = folder(&bench, "refused");
    let own = folder.join("ball.toml");
    let original = std::fs::read_to_string(patch("bouncing-ball.toml")).unwrap();
    std::fs::write(&own, &original).unwrap();
    let out = folder.join("out.csv");
    let checkpoint = desk::checkpoint::beside(&out);
    let (own_name, out_name) = (own.display().to_string(), out.display().to_string());
    let words = ["run", &own_name, "--until", "3900ms", "--every", "1us", "--out", &out_name];
    let words = [&words[..], &["--checkpoint", "100ms"]].concat();
    let mut child = bench.command(ANALOG, &words).spawn().unwrap();
    while !checkpoint.exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before its first checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let place = checkpoint.display().to_string();
    let refusal = |reason: &str| {
        let output = expect(&mut bench.command(ANALOG, &["resume", &place]), 2);
        let text = stderr(&output).replace('\n', " ");
        assert!(text.contains(reason), "{reason}: {text}");
    };
    let whole = std::fs::read(&checkpoint).unwrap();
    std::fs::write(&checkpoint, &whole[..whole.len() / 2]).unwrap();
    refusal("is cut off");
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    std::fs::write(&checkpoint, &damaged).unwrap();
    refusal("is damaged");
    std::fs::write(&checkpoint, &whole).unwrap();
    // The last row is in the record before the checkpoint is; one that is missing shows.
    let rows = std::fs::read(&out).unwrap();
    std::fs::write(&out, &rows[..100]).unwrap();
    refusal("is not as the checkpoint left it");
    std::fs::write(&out, &rows).unwrap();
    std::fs::write(&own, original.replace("9.81", "9.82")).unwrap();
    assert_ne!(std::fs::read_to_string(&own).unwrap(), original);
    refusal("is not as it was when the run began");
    std::fs::write(&own, &original).unwrap();
    expect(&mut bench.command(ANALOG, &["resume", &place]), 0);
    refusal("cannot read");
    for [words, reason] in
        [["--checkpoint=1s", "--out"], ["--checkpoint=0s --out=x.csv", "must be positive"]]
    {
        let words: Vec<&str> = words.split(' ').collect();
        let words = [&["run", &own_name, "--until", "3s"], &words[..]].concat();
        let text = stderr(&expect(&mut bench.command(ANALOG, &words), 2));
        assert!(text.contains(reason), "{text}");
    }
}
