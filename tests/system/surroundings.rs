//! Where the machine runs: other users, busy programs, little room, odd paths.

use crate::bench_top::{BenchTop, Busy, DIGITAL, expect, stderr, until, wait_within};
use std::{
    io::Write,
    os::unix::process::CommandExt,
    path::PathBuf,
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

/// Some user that is not the one who runs the tests.
const STRANGER: u32 = 12_346;

/// Says why a test did not test anything, past the harness, which keeps quiet about passes.
fn skip(why: &str) {
    let _ = writeln!(std::io::stderr(), "\nSKIPPED: {why}\n");
}

fn is_root() -> bool {
    rustix::process::getuid().is_root()
}

/// A shell of another user; killed and reaped when dropped.
struct Stranger(Child);

impl Stranger {
    fn does(script: &str) -> Stranger {
        let mut shell = Command::new("sh");
        shell.args(["-c", script]).uid(STRANGER).gid(STRANGER);
        shell.current_dir("/").stdin(Stdio::null());
        Stranger(shell.stdout(Stdio::piped()).spawn().unwrap())
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn another_user_can_neither_read_nor_damage_a_session() {
    if !is_root() {
        return skip("only root can play another user");
    }
    let bench = BenchTop::new();
    let serve = bench.serve("lab");
    let prefix = until("the session's memory", Duration::from_secs(10), || {
        let prefix = std::fs::read_to_string(bench.base().join("lab.session/prefix")).ok()?;
        let files = std::fs::read_dir("/dev/shm").unwrap().flatten();
        let ours = files.filter(|f| f.file_name().to_string_lossy().starts_with(&prefix));
        (ours.count() > 6).then_some(prefix)
    });
    let mut stranger = Stranger::does(&format!(
        "for f in /dev/shm/{prefix}*; do
            cat \"$f\" > /dev/null && echo \"read $f\"
            (echo x >> \"$f\") && echo \"wrote $f\"
            (: > \"$f\") && echo \"truncated $f\"
            rm -f \"$f\" && echo \"removed $f\"
            mv \"$f\" \"$f.x\" && echo \"renamed $f\"
        done 2> /dev/null
        ls {base} 2> /dev/null && echo 'saw the base'
        exit 0",
        base = bench.base().display()
    ));
    let mut told = String::new();
    let out = stranger.0.stdout.as_mut().unwrap();
    std::io::Read::read_to_string(out, &mut told).unwrap();
    assert_eq!(told, "");
    expect(&mut bench.fly(&["--until", "1s", "--attach", "lab"]), 0);
    assert!(wait_within(serve, Duration::from_secs(10)).0.status.success());
    bench.assert_clean();
}

#[test]
fn a_user_who_truncates_whatever_appears_stalls_no_session() {
    if !is_root() {
        return skip("only root can play another user");
    }
    let bench = BenchTop::new();
    let _stranger = Stranger::does(
        "while :; do for f in /dev/shm/hybrid*; do [ -e \"$f\" ] && : > \"$f\"; done; done 2> /dev/null",
    );
    for _ in 0..10 {
        expect(&mut bench.fly(&["--until", "1s"]), 0);
    }
    bench.assert_clean();
}

#[test]
fn too_little_shared_memory_is_refused_before_it_is_used() {
    if !is_root() {
        return skip("only root can mount a small /dev/shm");
    }
    let bench = BenchTop::new();
    let runs = bench.runs();
    let fly = |size: &str| {
        let script = format!(
            "mount -t tmpfs -o size={size} tmpfs /dev/shm && exec {DIGITAL} fly --until 1s --out {}",
            runs.display()
        );
        bench.command("unshare", &["-m", "sh", "-c", &script])
    };
    if !fly("8m").output().is_ok_and(|o| o.status.success()) {
        return skip("no private mounts here");
    }
    for size in ["4k", "64k", "256k", "1m"] {
        let refused = expect(&mut fly(size), 2);
        let text = stderr(&refused);
        assert!(
            text.contains("/dev/shm has ") && text.contains("a session needs 2048 KiB"),
            "{text}"
        );
    }
    bench.assert_clean();
}

#[test]
fn a_base_path_at_its_limit_works_and_an_odd_one_is_refused_by_name() {
    let bench = BenchTop::new();
    let inside = bench.base();
    let inside = inside.parent().unwrap();
    // A session that finds its own name leaves 77 bytes to the base.
    let longest = inside.join("x".repeat(77 - inside.as_os_str().len() - 1));
    expect(bench.fly(&["--until", "1s"]).env("HYBRID_BASE", &longest), 0);
    assert!(!longest.exists());
    let bases: [PathBuf; 2] = [inside.join("x".repeat(125)), inside.join("é")];
    for base in bases {
        let mut fly = bench.fly(&["--until", "1s"]);
        let refused = expect(fly.env("HYBRID_BASE", &base), 2);
        let text = stderr(&refused);
        assert!(text.contains("HYBRID_BASE") && text.contains("at most 77 bytes"), "{text}");
        assert!(!base.exists());
    }
}

#[test]
fn a_flight_beside_busy_programs_takes_its_share_and_little_more() {
    let bench = BenchTop::alone();
    for link in [&[][..], &["--link", "memory"]] {
        let fly = || {
            let started = Instant::now();
            expect(&mut bench.fly(link), 0);
            started.elapsed()
        };
        let least = |n: usize| (0..n).map(|_| fly()).min().unwrap();
        let idle = least(5);
        let busy = Busy::programs(2 * std::thread::available_parallelism().unwrap().get());
        let beside = least(3);
        drop(busy);
        // Its fair share makes three times as long; where each frame costs a yield to a
        // stranger it is a hundred times. Not below what one delayed start may take.
        let most = 10 * idle.max(Duration::from_millis(50));
        assert!(beside < most, "idle {idle:?}, beside busy programs {beside:?}");
    }
    bench.assert_clean();
}
