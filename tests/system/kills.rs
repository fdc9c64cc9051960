//! Kill -9 of either side, at random moments and at chosen system calls.
//!
//! Whatever dies and when: the other side ends within a second (three while the
//! transport is being made) with exit code 3, and once it has ended nothing is left in the
//! session base or in shared memory. Where nobody survived, there is nobody to clean: what
//! is left then the next session removes.
//!
//! The tests here kill a few dozen times; those that are ignored kill as often as the
//! variable `KILLS` says (1000 without it), from the seed `KILLS_SEED`. A failure names
//! the command, the victim and the moment.

use crate::bench_top::{
    ANALOG, BenchTop, DIGITAL, NOTICE, argv0, children, expect, runs, signal, stderr, until,
    wait_within,
};
use rustix::process::{Pid, Signal, WaitOptions, set_child_subreaper, waitpid};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    process::{Child, Command, Output},
    time::{Duration, Instant},
};

/// In which a survivor must have ended if the transport may still be in the making.
const NOTICE_MAKING: Duration = Duration::from_secs(3);
/// The transport is made within this time, even on a busy machine.
const MAKING: Duration = Duration::from_millis(400);
/// Exit code of a side whose partner failed.
const PARTNER_FAILED: i32 = 3;

/// A study of the patch whose frames never end.
const STIFF_STUDY: &str = r#"
title = "stiff"
patch = "stiff.toml"
stop = "1s"
measure = "a"
[sweep]
frame = ["20ms"]
latency = [0.0]
[[law]]
kind = "difference-equation"
input = "a"
output = "u"
numerator = [1.0]
denominator = [1.0]
"#;

/// What is run and killed, and how long it may live before that.
const KINDS: [(&str, Duration); 5] = [
    ("fly --frame 200us --fast 1", Duration::from_millis(500)),
    ("short-period pitch", Duration::from_millis(1500)),
    ("sampling circle", Duration::from_millis(500)),
    // As many sessions as there are processors, and one more.
    ("long-period", Duration::from_millis(1500)),
    (STIFF, Duration::from_millis(300)),
];
/// Takes a study.
const STIFF: &str = "sampling loop";

/// xorshift64*: kills need no better chance than this, and repeat from their seed.
pub struct Chance(pub u64);

impl Chance {
    pub fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) % n
    }
}

pub fn asked(variable: &str, default: u64) -> u64 {
    let text = std::env::var(variable).ok();
    text.map_or(default, |t| t.parse().unwrap())
}

fn start(bench: &BenchTop, kind: &str) -> Child {
    let mut command = bench.command(DIGITAL, &kind.split(' ').collect::<Vec<_>>());
    if kind == STIFF {
        bench.stiff_patch();
        command.arg(bench.file("study.toml", STIFF_STUDY));
    }
    command.arg("--out").arg(bench.runs()).spawn().unwrap()
}

/// Every live process that uses the base of `bench`.
pub fn of_base(bench: &BenchTop) -> Vec<u32> {
    let mark = format!("HYBRID_BASE={}", bench.base().display());
    let uses = |pid: &u32| {
        let all = std::fs::read(format!("/proc/{pid}/environ")).unwrap_or_default();
        all.split(|b| *b == 0).any(|v| v == mark.as_bytes()) && runs(*pid)
    };
    let entries = std::fs::read_dir("/proc").unwrap().flatten();
    entries
        .filter_map(|e| e.file_name().to_str()?.parse().ok())
        .filter(|pid| *pid != std::process::id())
        .filter(uses)
        .collect()
}

/// The prefix of every session of the base that has one.
fn of_sessions(bench: &BenchTop) -> BTreeSet<String> {
    let sessions = std::fs::read_dir(bench.base());
    let prefix = |e: std::fs::DirEntry| std::fs::read_to_string(e.path().join("prefix")).ok();
    let sessions = sessions.into_iter().flatten().flatten();
    sessions.filter_map(prefix).filter(|p| p.ends_with('_')).collect()
}

/// Files of shared memory that a process has mapped, by the prefix of its session.
fn prefixes(pid: u32) -> BTreeSet<String> {
    let maps = std::fs::read_to_string(format!("/proc/{pid}/maps")).unwrap_or_default();
    maps.lines()
        .filter_map(|l| Some(l.split_once("/dev/shm/hybrid")?.1))
        .filter_map(|name| Some(format!("hybrid{}_", name.split_once('_')?.0)))
        .collect()
}

fn shared_memory(prefixes: &BTreeSet<String>) -> Vec<PathBuf> {
    let entries = std::fs::read_dir("/dev/shm").unwrap().flatten();
    entries
        .filter(|e| {
            let name = e.file_name().to_string_lossy().into_owned();
            prefixes.iter().any(|p| name.starts_with(p))
        })
        .map(|e| e.path())
        .collect()
}

/// Waits for an analog side that has lost its parent to this process; its exit code.
fn orphan_ends(pid: u32, limit: Duration, told: &str) -> Option<i32> {
    let started = Instant::now();
    let pid = Pid::from_raw(pid as i32);
    loop {
        match waitpid(pid, WaitOptions::NOHANG) {
            Ok(Some((_, status))) => return status.exit_status(),
            // Not adopted yet, or its parent took its end.
            Ok(None) => {}
            Err(_) if pid.is_none_or(|p| !runs(p.as_raw_nonzero().get() as u32)) => return None,
            Err(_) => {}
        }
        assert!(started.elapsed() < limit, "{told}: the analog side lives on after {limit:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What a kill left, once all have ended.
fn left(bench: &BenchTop, prefixes: &BTreeSet<String>) -> Vec<PathBuf> {
    let mut left = shared_memory(prefixes);
    if let Ok(entries) = std::fs::read_dir(bench.base()) {
        left.extend(entries.flatten().map(|e| e.path()));
    }
    left
}

/// The next session of the base removes what nobody survived to remove.
fn swept(bench: &BenchTop, prefixes: &BTreeSet<String>, told: &str) {
    expect(&mut bench.fly(&["--until", "100ms"]), 0);
    let left = left(bench, prefixes);
    assert!(left.is_empty(), "{told}: left after a sweep: {left:?}");
}

/// One kill of a side at a random moment.
fn kill_once(bench: &BenchTop, (kind, life): (&str, Duration), chance: &mut Chance) {
    let kill_analog = chance.below(2) == 0;
    let after = Duration::from_micros(chance.below(life.as_micros() as u64));
    let victim = if kill_analog { "analog" } else { "digital" };
    let told = format!("{kind}, {victim} side killed after {after:?}");
    let mut child = start(bench, kind);
    std::thread::sleep(after);
    let mut analogs = children(child.id());
    analogs.retain(|pid| argv0(*pid) == "analog-proc");
    let chosen = chance.below(analogs.len().max(1) as u64) as usize;
    let analog = analogs.get(chosen).copied();
    let limit = if after > MAKING { NOTICE } else { NOTICE_MAKING };
    let mut known = of_sessions(bench);
    known.extend(prefixes(child.id()));
    known.extend(analogs.into_iter().flat_map(prefixes));
    if kill_analog {
        // It may not have come yet, or have gone: then the digital side ends by itself.
        let hit = analog.inspect(|pid| signal(*pid, Signal::KILL));
        if hit.is_none() && kind == STIFF {
            signal(child.id(), Signal::TERM);
        }
        let patience = if hit.is_some() { limit } else { Duration::from_secs(30) };
        let patience = if kind == STIFF { limit } else { patience };
        let (output, _) = wait_within_or(child, patience, &told);
        let code = output.status.code();
        // Killed after its last word it harms nobody.
        let fine = match hit {
            Some(_) if kind == STIFF => code == Some(PARTNER_FAILED),
            Some(_) => [Some(PARTNER_FAILED), Some(0)].contains(&code),
            None => [Some(0), Some(130)].contains(&code),
        };
        assert!(fine, "{told}: exit {code:?}: {}", stderr(&output));
        let left = left(bench, &known);
        assert!(left.is_empty(), "{told}: left: {left:?}");
        return;
    }
    child.kill().unwrap();
    child.wait().unwrap();
    survivors_end(bench, limit, &known, &told);
}

/// Waits for whoever uses the base after a digital side was killed. An analog side that
/// lost its partner leaves nothing.
fn survivors_end(bench: &BenchTop, limit: Duration, known: &BTreeSet<String>, told: &str) {
    let mut known = known.clone();
    known.extend(of_sessions(bench));
    let mut cleaned = false;
    for pid in of_base(bench) {
        known.extend(prefixes(pid));
        let code = orphan_ends(pid, limit, told);
        assert!(
            matches!(code, None | Some(0 | PARTNER_FAILED)),
            "{told}: the analog side ended with {code:?}"
        );
        cleaned |= code == Some(PARTNER_FAILED);
    }
    let left = left(bench, &known);
    if left.is_empty() {
        return;
    }
    assert!(!cleaned, "{told}: left by a survivor: {left:?}");
    swept(bench, &known, told);
}

fn wait_within_or(child: Child, limit: Duration, told: &str) -> (Output, Duration) {
    let pid = child.id();
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| wait_within(child, limit)));
    done.unwrap_or_else(|_| panic!("{told}: process {pid} lives on after {limit:?}"))
}

fn random_kills(count: u64) {
    set_child_subreaper(Some(rustix::process::getpid())).unwrap();
    let mut chance = Chance(asked("KILLS_SEED", 0x0DDB_1A5E));
    let bench = BenchTop::alone();
    for n in 0..count {
        kill_once(&bench, KINDS[n as usize % KINDS.len()], &mut chance);
        let _ = std::fs::remove_dir_all(bench.runs());
    }
    bench.assert_clean();
}

#[test]
fn random_kills_of_either_side() {
    random_kills(20);
}

#[test]
#[ignore = "a soak test"]
fn many_random_kills_of_either_side() {
    random_kills(asked("KILLS", 1000));
}

/// System calls by which a side makes, uses and leaves its session.
const CALLS: &str = "openat,ftruncate,fchmod,mmap,munmap,flock,unlink,rmdir,mkdir,close,write,fstat,\
    poll,futex,clone3,getdents64";

fn strace() -> Option<()> {
    let there = Command::new("strace").arg("--version").output().is_ok();
    if !there {
        // Past the harness, which keeps the words of tests that pass to itself.
        let _ = std::fs::write(
            "/dev/stderr",
            "NOT TESTED: kills at chosen system calls, for want of strace\n",
        );
    }
    there.then_some(())
}

/// A command under strace, which kills it at its `nth` call of `call`, and it alone.
fn traced(
    bench: &BenchTop,
    log: &Path,
    inject: Option<(&str, u64)>,
    of: (&str, &[&str]),
) -> Command {
    let mut command = bench.command("strace", &["-qq", "-o"]);
    command.arg(log);
    let calls = inject.map_or(CALLS, |(call, _)| call);
    command.args(["-e", &format!("trace={calls}")]);
    if let Some((call, nth)) = inject {
        command.args(["-e", &format!("inject={call}:signal=KILL:when={nth}")]);
    }
    command.arg("--").arg(of.0).args(of.1);
    command
}

/// How often a side makes each of [`CALLS`] in a short flight.
fn counted(bench: &BenchTop, digital: bool) -> Vec<(&'static str, u64)> {
    let log = bench.runs().with_extension("strace");
    flight_under_strace(bench, &log, None, digital, "counting");
    let text = std::fs::read_to_string(&log).unwrap();
    let times = |call: &str| text.lines().filter(|l| l.starts_with(&format!("{call}("))).count();
    let made = CALLS.split(',').map(|call| (call, times(call) as u64));
    made.filter(|(_, count)| *count > 0).collect()
}

/// A flight of which one side is traced, and perhaps killed.
fn flight_under_strace(
    bench: &BenchTop,
    log: &Path,
    inject: Option<(&str, u64)>,
    digital: bool,
    told: &str,
) {
    let out = bench.runs().display().to_string();
    let flight = ["fly", "--until", "300ms", "--out", &out];
    // What strace needs beside the program itself.
    let patience = NOTICE_MAKING + Duration::from_secs(2);
    if digital {
        let child = traced(bench, log, inject, (DIGITAL, &flight)).spawn().unwrap();
        let (output, _) = wait_within_or(child, Duration::from_secs(20), told);
        let killed = output.status.code().is_none();
        assert!(killed || output.status.success(), "{told}: {}", stderr(&output));
        survivors_end(bench, NOTICE_MAKING, &BTreeSet::new(), told);
        return;
    }
    let serve = ["serve", "--session", "kills"];
    let server = traced(bench, log, inject, (ANALOG, &serve)).spawn().unwrap();
    let mut server = Some(server);
    let root = bench.base().join("kills.session");
    let gone = |server: &mut Option<Child>| {
        server.as_mut().is_none_or(|s| s.try_wait().unwrap().is_some())
    };
    until("the session or its end", patience, || {
        (root.join("analog-proc.lock").is_file() || gone(&mut server)).then_some(())
    });
    let mut attached = flight.to_vec();
    attached.extend(["--attach", "kills"]);
    let child = bench.command(DIGITAL, &attached).spawn().unwrap();
    let joined = std::thread::spawn({
        let told = told.to_owned();
        // The whole flight, and then its end.
        move || wait_within_or(child, Duration::from_secs(10) + NOTICE_MAKING, &told)
    });
    let server = server.take().unwrap();
    let (served, _) = wait_within_or(server, Duration::from_secs(20), told);
    let ended = Instant::now();
    let (output, _) = joined.join().unwrap();
    let code = output.status.code();
    if served.status.code().is_none() {
        assert!(
            ended.elapsed() < NOTICE_MAKING,
            "{told}: the digital side ended after {:?}: {}",
            ended.elapsed(),
            stderr(&output)
        );
        // 2: it was there no longer when the digital side wanted to join.
        assert!(
            [Some(PARTNER_FAILED), Some(0), Some(2)].contains(&code),
            "{told}: exit {code:?}: {}",
            stderr(&output)
        );
    } else {
        assert!(
            served.status.success() && code == Some(0),
            "{told}: {}{}",
            stderr(&served),
            stderr(&output)
        );
    }
    let known = of_sessions(bench);
    let left = left(bench, &known);
    if !left.is_empty() {
        assert!(code != Some(PARTNER_FAILED), "{told}: left by a survivor: {left:?}");
        swept(bench, &known, told);
    }
}

fn kills_at_calls(count: u64) {
    if strace().is_none() {
        return;
    }
    set_child_subreaper(Some(rustix::process::getpid())).unwrap();
    let mut chance = Chance(asked("KILLS_SEED", 0x0DDB_1A5E));
    let bench = BenchTop::alone();
    let calls = [true, false].map(|digital| counted(&bench, digital));
    assert!(calls.iter().all(|c| c.len() > 8), "{calls:?}");
    for n in 0..count {
        let digital = n % 2 == 0;
        let known = &calls[usize::from(!digital)];
        let (call, made) = known[chance.below(known.len() as u64) as usize];
        let nth = 1 + chance.below(made);
        let victim = if digital { "digital" } else { "analog" };
        let told = format!("{victim} side killed at its {call} {nth} of {made}");
        let log = bench.runs().with_extension("strace");
        flight_under_strace(&bench, &log, Some((call, nth)), digital, &told);
        let _ = std::fs::remove_dir_all(bench.runs());
    }
    bench.assert_clean();
}

#[test]
fn kills_at_chosen_system_calls() {
    kills_at_calls(20);
}

#[test]
#[ignore = "a soak test"]
fn many_kills_at_chosen_system_calls() {
    kills_at_calls(asked("KILLS", 1000));
}
