//! Two real processes: one computes for long, dies while it makes a file, shares the only core.
//! Kills, stops and many sessions at once are met with the real binaries in `tests/system`.
//!
//! The partner is this test binary again, in the role of the ignored test `partner` or `server`.

use crate::battery::{
    assert_nothing_left, assert_samples, load, patience, samples, serve, spec, updates,
};
use interface::{
    Side,
    control::{Clock, Request},
    frame::RunState,
    link::{
        AnalogPort, DigitalFrames, DigitalPort, LinkFault, Patience, shm::ShmAnalog,
        shm::ShmDigital,
    },
    session::{Session, SessionError},
};
use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

const BASE: &str = "LINK_TEST_BASE";
const NAME: &str = "LINK_TEST_NAME";
/// Bytes; beyond them the partner dies.
const LONGEST_FILE: &str = "LINK_TEST_LONGEST_FILE";
/// Within this time either side must have noticed the other's death.
const NOTICE: Duration = Duration::from_secs(1);

/// Starts this binary in another role. Killed and reaped when dropped.
struct Role(Child);

impl Role {
    fn start(role: &str, base: &Path, name: &str) -> Role {
        Role::start_with(role, base, name, None)
    }

    fn start_with(role: &str, base: &Path, name: &str, longest_file: Option<u64>) -> Role {
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", &format!("processes::{role}"), "--ignored", "--nocapture"])
            .env(BASE, base)
            .env(NAME, name)
            .envs(longest_file.map(|bytes| (LONGEST_FILE, bytes.to_string())))
            .stdout(Stdio::null())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        Role(child)
    }

    fn pid(&self) -> u32 {
        self.0.id()
    }
}

impl Drop for Role {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A base that is not there yet, in a folder that goes with the test.
fn fresh_base() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let base = dir.path().join("base");
    (dir, base)
}

/// A session of a base, and a partner that is starting.
fn meet(base: &Path) -> (Session, Role) {
    let session = Session::create_in(base, Side::Digital, None).unwrap();
    let child = Role::start("partner", base, session.name());
    (session, child)
}

fn told() -> Option<(PathBuf, String)> {
    Some((std::env::var_os(BASE)?.into(), std::env::var(NAME).ok()?))
}

/// Serves frames until the partner ends or dies; what it says then is its exit code.
fn analog_life(port: &mut impl AnalogPort) -> Result<(), LinkFault> {
    while serve(port)? {
        for n in 0.. {
            port.send_samples(&samples(n, RunState::Operate))?;
            if port.await_updates(n)?.mode_command() == interface::frame::ModeCommand::End {
                port.send_samples(&samples(n + 1, RunState::Ended))?;
                break;
            }
        }
    }
    Ok(())
}

/// Ends this process by a signal when it makes a file longer than told.
fn limit_files() {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let Ok(limit) = std::env::var(LONGEST_FILE) else {
        return;
    };
    let to = |bytes| Rlimit { current: Some(bytes), maximum: Some(bytes) };
    setrlimit(Resource::Core, to(0)).unwrap();
    setrlimit(Resource::Fsize, to(limit.parse().unwrap())).unwrap();
}

/// The analog side of most tests here.
#[test]
#[ignore = "a role that other tests start as a process"]
fn partner() {
    let Some((base, name)) = told() else { return };
    let session = match Session::join_in(&base, Side::Analog, &name) {
        Ok(session) => session,
        Err(SessionError::Deserted { .. } | SessionError::Unknown { .. }) => return,
        Err(error) => panic!("{error}"),
    };
    limit_files();
    let life = ShmAnalog::open(&session, None, &patience()).and_then(|mut p| analog_life(&mut p));
    drop(session);
    if let Err(fault) = life {
        assert!(fault.to_string().starts_with("digital-proc is gone"), "{fault}");
    }
}

fn digital_life(port: &mut impl DigitalFrames, frames: u64) -> Result<(), LinkFault> {
    load(port)?;
    port.request(&Request::Operate(spec(Clock::LockStep)))?;
    for n in 0..frames {
        let got = port.await_samples(n)?;
        assert_samples(&got, &samples(n, RunState::Operate));
        let mut answer = updates(&got);
        if n + 1 == frames {
            answer.mode = interface::frame::ModeCommand::End as u32;
        }
        port.send_updates(&answer)?;
    }
    port.await_samples(frames)?;
    port.request(&Request::Bye)?;
    Ok(())
}

/// A whole session with a child.
fn fly(base: &Path, frames: u64) {
    let (session, mut child) = meet(base);
    let mut port = ShmDigital::open(&session, Some(child.pid()), &patience()).unwrap();
    digital_life(&mut port, frames).unwrap();
    drop(port);
    assert!(child.0.wait().unwrap().success());
}

#[test]
fn two_processes_share_one_core() {
    let (_dir, base) = fresh_base();
    // The child inherits this thread's mask, and both then run on one core.
    let base = &base;
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let all = rustix::thread::sched_getaffinity(None).unwrap();
            let mut one = rustix::thread::CpuSet::new();
            let core = (0..rustix::thread::CpuSet::MAX_CPU).find(|c| all.is_set(*c)).unwrap();
            one.set(core);
            rustix::thread::sched_setaffinity(None, &one).unwrap();
            let start = Instant::now();
            fly(base, 2000);
            // Two pure spinners on one core take 8 ms a round trip, 16 s in all.
            assert!(start.elapsed() < Duration::from_secs(8), "{:?}", start.elapsed());
        });
    });
    assert!(!base.exists());
}

#[test]
fn a_computing_partner_may_take_its_time_up_to_a_limit() {
    let (_dir, base) = fresh_base();
    for (busy_limit, patient) in [(60, true), (0, false)] {
        let (session, child) = meet(&base);
        let patience = Patience {
            // The partner answers after 1.5 s of computing.
            silence: Duration::from_millis(500),
            busy_limit: Duration::from_secs(busy_limit),
            ..Patience::default()
        };
        let mut port = ShmDigital::open(&session, Some(child.pid()), &patience).unwrap();
        let answer = port.request(&Request::Read(vec!["busy".into()]));
        assert_eq!(answer.is_ok(), patient, "{answer:?}");
        drop((port, child));
    }
}

#[test]
fn a_partner_that_dies_between_making_and_filling_a_file_holds_up_nobody() {
    // The connections and data of an analog side have 9,958 bytes to 178 KB; each limit lets
    // another one fail at the moment that it has a name and no length.
    for longest in [5_000, 50_000, 90_000, 150_000] {
        for _ in 0..3 {
            let (_dir, base) = fresh_base();
            let session = Session::create_in(&base, Side::Digital, None).unwrap();
            let prefix = session.prefix().to_owned();
            let mut child = Role::start_with("partner", &base, session.name(), Some(longest));
            let started = Instant::now();
            let opened = ShmDigital::open(&session, Some(child.pid()), &patience())
                .and_then(|mut port| digital_life(&mut port, u64::MAX));
            // Start-up included.
            let took = started.elapsed();
            let ended = child.0.wait().unwrap();
            let fault = opened.unwrap_err().to_string();
            assert!(fault.starts_with("analog-proc is gone (last frame "), "{longest}: {fault}");
            assert!(!ended.success() && took < 3 * NOTICE, "{longest}: {took:?}");
            drop((session, child));
            assert_nothing_left(&base, &prefix);
        }
    }
}

/// An analog side that waits for somebody to join.
#[test]
#[ignore = "a role that other tests start as a process"]
fn server() {
    let Some((base, name)) = told() else { return };
    let session = Session::create_in(&base, Side::Analog, Some(&name)).unwrap();
    let _ = ShmAnalog::open(&session, None, &patience());
}

/// Shared-memory files of a session that end like this.
fn shared(prefix: &str, end: &str) -> Vec<PathBuf> {
    let files = std::fs::read_dir("/dev/shm").unwrap().flatten();
    let named = files.filter(|e| {
        let name = e.file_name().into_string().unwrap();
        name.starts_with(prefix) && name.ends_with(end)
    });
    named.map(|e| e.path()).collect()
}

#[test]
fn a_half_made_service_holds_up_nobody() {
    let (_dir, base) = fresh_base();
    let server = Role::start("server", &base, "lab");
    let started = Instant::now();
    let prefix = loop {
        assert!(started.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(5));
        let Ok(prefix) = std::fs::read_to_string(base.join("lab.session/prefix")) else {
            continue;
        };
        // The control service is the last; its data follow.
        if shared(&prefix, ".dynamic").len() == 3 && shared(&prefix, "__0.data").len() == 1 {
            break prefix;
        }
    };
    // What a process leaves that is killed between making and filling: a name without bytes.
    // The server keeps its own mapping.
    for file in shared(&prefix, ".dynamic") {
        std::fs::remove_file(&file).unwrap();
        std::fs::write(&file, "").unwrap();
    }
    let hasty = Patience { arrival: Some(Duration::from_millis(300)), ..patience() };
    let join = || Session::join_in(&base, Side::Digital, "lab").unwrap();
    let started = Instant::now();
    let fault = ShmDigital::open(&join(), None, &hasty).unwrap_err();
    assert!(matches!(fault, LinkFault::Transport { .. }), "{fault}");
    assert!(started.elapsed() < 3 * NOTICE);

    let session = join();
    let killer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        drop(server);
        Instant::now()
    });
    let fault = ShmDigital::open(&session, None, &patience()).unwrap_err();
    let noticed = killer.join().unwrap().elapsed();
    assert!(matches!(fault, LinkFault::PartnerDied { side: "analog-proc", .. }), "{fault}");
    assert!(noticed < 3 * NOTICE, "{noticed:?}");
    assert_nothing_left(&base, &prefix);
}

#[test]
fn all_shared_memory_is_private() {
    use std::os::unix::fs::PermissionsExt;
    let (_dir, base) = fresh_base();
    let (session, child) = meet(&base);
    let mut port = ShmDigital::open(&session, Some(child.pid()), &patience()).unwrap();
    port.request(&Request::StaticCheck).unwrap();
    let mut files = 0;
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(session.prefix()) {
            let mode = entry.metadata().unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0, "{:?} has mode {mode:o}", entry.file_name());
            files += 1;
        }
    }
    assert!(files > 5, "{files} files of the session were found");
    port.request(&Request::Bye).unwrap();
}
