//! Random patches: does the engine, with default settings, ever give a wrong answer silently?
//!
//! `FUZZ_PATCHES` and `FUZZ_SEED` say how many patches of each family to try and from which
//! seed on (400 and 0); `soak` is the same at length, on two threads. Failing patches are shrunk
//! and printed; `FUZZ_OUT` names a folder to put them into.

#![allow(clippy::unwrap_used)]

#[path = "../common/bench.rs"]
mod bench;
mod corpus;
mod generator;
mod judge;
mod patch;
mod random;
#[path = "../common/roots.rs"]
mod roots;
mod shrink;
mod snapshot;
mod truth;

use judge::{Verdict, judge};
use patch::Patch;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

/// Hundreds of times what a patch of this size takes.
const DEADLINE: Duration = Duration::from_secs(20);

/// Failures that are shrunk; the others are counted.
const SHRUNK: u64 = 5;

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |v| v.parse().unwrap())
}

/// Judges patches `from..from + count` on some threads; the verdicts by seed. A patch that takes
/// longer than the deadline is left to its thread, and another thread goes on.
fn judge_all(from: u64, count: u64, threads: usize) -> BTreeMap<u64, Verdict> {
    let next = Arc::new(AtomicU64::new(from));
    let (sender, receiver) = mpsc::channel();
    let spawn = || {
        let (sender, next) = (sender.clone(), Arc::clone(&next));
        std::thread::spawn(move || {
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= from + count || sender.send((seed, None)).is_err() {
                    return;
                }
                let verdict = judge(&generator::patch(seed), seed);
                if sender.send((seed, Some(verdict))).is_err() {
                    return;
                }
            }
        });
    };
    (0..threads).for_each(|_| spawn());
    let mut verdicts = BTreeMap::new();
    let mut running: BTreeMap<u64, Instant> = BTreeMap::new();
    while (verdicts.len() as u64) < count {
        match receiver.recv_timeout(Duration::from_secs(1)) {
            Ok((seed, None)) => {
                running.insert(seed, Instant::now());
            }
            Ok((seed, Some(verdict))) => {
                if running.remove(&seed).is_some() {
                    verdicts.insert(seed, verdict);
                }
            }
            Err(_) => {
                let late = running.iter().find(|(_, since)| since.elapsed() > DEADLINE);
                if let Some(seed) = late.map(|(seed, _)| *seed) {
                    running.remove(&seed);
                    let verdict = Verdict::Endless("all: past its deadline".into());
                    verdicts.insert(seed, verdict);
                    spawn();
                }
            }
        }
    }
    verdicts
}

/// Kinds of a patch's blocks, what every patch has left out.
fn kinds(patch: &Patch) -> String {
    let mut kinds: Vec<&str> = patch.blocks.iter().map(|b| b.kind).collect();
    kinds.retain(|k| *k != "constant");
    kinds.sort_unstable();
    kinds.dedup();
    kinds.join("+")
}

/// The verdict on a patch, unless it takes longer than a second or so.
fn soon(patch: &Patch, seed: u64) -> Option<Verdict> {
    let (sender, receiver) = mpsc::channel();
    let patch = patch.clone();
    std::thread::spawn(move || sender.send(judge(&patch, seed)));
    receiver.recv_timeout(Duration::from_secs(2)).ok()
}

/// The smallest patch that is wrong as the patch of `seed` is, with what differs.
fn smallest(seed: u64, verdict: &Verdict) -> String {
    let wrong = |verdict: &Verdict| match verdict {
        Verdict::Wrong(text) | Verdict::Endless(text) => Some(text.clone()),
        _ => None,
    };
    let text = wrong(verdict).unwrap_or_default();
    // The same of the runs must stay wrong: another's cause may be another.
    let what = text.split(':').next().unwrap_or_default();
    let still = |p: &Patch| {
        let text = soon(p, seed).as_ref().and_then(wrong);
        text.filter(|t| t.starts_with(what))
    };
    let small = shrink::shrink(&generator::patch(seed), |p| still(p).is_some());
    format!(
        "# seed {seed}, until = {} s, kinds {}\n# {}\n{}",
        small.until_s,
        kinds(&small),
        still(&small).unwrap_or(text.clone()),
        small.text()
    )
}

/// Reports verdicts; panics where one is wrong, or too many say nothing.
fn report(verdicts: &BTreeMap<u64, Verdict>) {
    let count = |f: fn(&Verdict) -> bool| verdicts.values().filter(|v| f(v)).count();
    let all = verdicts.len();
    let sensitive = count(|v| *v == Verdict::Sensitive);
    let flagged = count(|v| *v == Verdict::Flagged);
    let refused = count(|v| matches!(v, Verdict::Refused(_)));
    let unfit = count(|v| matches!(v, Verdict::Unfit(_)));
    println!(
        "{all} patches: {} agree, {} end in the same fault, {sensitive} are ill-conditioned, {flagged} are flagged, {refused} are refused, {unfit} are unfit",
        count(|v| *v == Verdict::Agreed),
        count(|v| *v == Verdict::SameFault),
    );
    let endless = count(|v| matches!(v, Verdict::Endless(_)));
    let (mut wrong, mut unbounded) = (Vec::new(), Vec::new());
    let out = std::env::var("FUZZ_OUT").ok();
    for (seed, verdict) in verdicts {
        if let Verdict::Refused(text) = verdict {
            println!("seed {seed} refused: {text}");
        }
        if let Verdict::Unfit(text) = verdict
            && text != "too large"
        {
            println!("seed {seed} unfit: {text}");
        }
        let (Verdict::Wrong(text) | Verdict::Endless(text)) = verdict else {
            continue;
        };
        println!("seed {seed}: {text}");
        if matches!(verdict, Verdict::Wrong(_)) {
            wrong.push(*seed);
        } else {
            unbounded.push(*seed);
        }
    }
    let most = setting("FUZZ_SHRINK", SHRUNK) as usize;
    for seed in wrong.iter().take(most).chain(unbounded.iter().take(most)) {
        let report = smallest(*seed, &verdicts[seed]);
        println!("{report}");
        if let Some(folder) = &out {
            std::fs::write(format!("{folder}/{seed}.toml"), report).unwrap();
        }
    }
    let wrong = wrong.len();
    // Some patches are work without bound: sines of what runs away, a delayed map that folds
    // its past ever finer.
    assert!(500 * endless <= all.max(500), "{endless} of {all} do not end");
    assert_eq!(wrong, 0, "patches with silently wrong answers");
    assert!(
        100 * (sensitive + flagged) < 3 * all.max(34),
        "{sensitive} of {all} ill-conditioned, {flagged} flagged"
    );
    assert!(100 * refused < all.max(100), "{refused} of {all} refused");
}

#[test]
fn random_patches_agree_with_their_references() {
    let verdicts = judge_all(setting("FUZZ_SEED", 0), setting("FUZZ_PATCHES", 400), 1);
    report(&verdicts);
}

/// Patches of known events, `count` of them.
fn truths(from: u64, count: u64) {
    let mut open = 0;
    let mut wrong = Vec::new();
    for seed in from..from + count {
        match truth::judge(seed) {
            Ok(true) => {}
            Ok(false) => open += 1,
            Err(text) => {
                if wrong.len() < 20 {
                    println!("{text}");
                }
                wrong.push(seed);
            }
        }
    }
    println!(
        "{count} patches of known events: {open} leave their counts open, {} are wrong",
        wrong.len()
    );
    assert!(wrong.is_empty(), "{} are wrong: {wrong:?}", wrong.len());
    assert!(100 * open <= 3 * count.max(34), "{open} of {count} leave their counts open");
}

#[test]
fn known_events_are_all_found() {
    truths(setting("FUZZ_SEED", 0), setting("FUZZ_PATCHES", 400));
}

#[test]
#[ignore = "minutes: .ci/soak"]
fn soak_of_known_events() {
    truths(setting("FUZZ_SEED", 0), setting("FUZZ_PATCHES", 100_000));
}

#[test]
#[ignore = "half an hour: .ci/soak"]
fn soak() {
    let verdicts = judge_all(setting("FUZZ_SEED", 0), setting("FUZZ_PATCHES", 100_000), 2);
    report(&verdicts);
}

#[test]
fn patches_repeat_by_seed() {
    for seed in 0..200 {
        assert_eq!(generator::patch(seed), generator::patch(seed));
    }
}

#[test]
#[ignore = "prints the patch of FUZZ_SEED"]
fn show() {
    let patch = generator::patch(setting("FUZZ_SEED", 0));
    println!("# until {} s\n{}", patch.until_s, patch.text());
}
