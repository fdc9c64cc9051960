//! Runs that are killed at any moment and gone on with from their last checkpoint: what they leave
//! is what a run leaves that was never stopped, byte for byte.
//!
//! A few kills here; the ignored tests kill as often as the variable `KILLS` says (200 without it),
//! from the seed `KILLS_SEED`.

use crate::bench_top::{ANALOG, BenchTop, expect, stderr};
use crate::kills::{Chance, asked};
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
