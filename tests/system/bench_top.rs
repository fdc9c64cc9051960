//! What every system test needs: a private base directory, a place for runs, and
//! the certainty that nothing is left behind.

use analog_proc::session::serve::Server;
use digital_proc::linkage::{
    console::Console,
    launch::{AnalogEntry, LinkChoice, Started},
};
use interface::control::PatchBundle;
use serde_json::Value;
use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard},
    time::{Duration, Instant},
};
use tempfile::TempDir;

/// Shared by the tests that may run beside others, held alone by those that may not.
static MACHINE: RwLock<()> = RwLock::new(());

/// A private base directory for sessions and a directory for runs.
///
/// One a test: a second one of the same thread would wait for the first.
pub struct BenchTop {
    dir: TempDir,
    _machine: Share,
}

/// Held until the test ends.
enum Share {
    Beside(#[expect(dead_code, reason = "a guard")] RwLockReadGuard<'static, ()>),
    Alone(#[expect(dead_code, reason = "a guard")] RwLockWriteGuard<'static, ()>),
}

pub const DIGITAL: &str = env!("CARGO_BIN_EXE_digital-proc");
pub const ANALOG: &str = env!("CARGO_BIN_EXE_analog-proc");

const STIFF_PATCH: &str = r#"
title = "stiff"
[blocks]
s = { kind = "integrator", in = ["c", "0 * u"], ic = 0.0 }
c = { kind = "integrator", in = ["-1 * s"], ic = 1.0 }
x = { kind = "integrator", in = ["-1e13 * x", "1e13 * c"], ic = 1.0 }
a = { kind = "adc", in = ["x"], channel = 0, max = 2.0 }
u = { kind = "dac", channel = 0, max = 2.0 }
"#;

/// In which a side must notice that the other has died, or that it is told to end.
pub const NOTICE: Duration = Duration::from_secs(1);

impl BenchTop {
    pub fn new() -> BenchTop {
        // A test that failed leaves nothing here that others could trip over.
        BenchTop::with(Share::Beside(MACHINE.read().unwrap_or_else(PoisonError::into_inner)))
    }

    /// With no other test's processes beside it, for promises about time.
    pub fn alone() -> BenchTop {
        BenchTop::with(Share::Alone(MACHINE.write().unwrap_or_else(PoisonError::into_inner)))
    }

    fn with(share: Share) -> BenchTop {
        BenchTop { dir: tempfile::tempdir().unwrap(), _machine: share }
    }

    /// Where sessions of this test live.
    pub fn base(&self) -> PathBuf {
        self.dir.path().join("sessions")
    }

    /// Where runs of this test are written.
    pub fn runs(&self) -> PathBuf {
        self.dir.path().join("runs")
    }

    /// A command of either binary in this test's own base.
    pub fn command(&self, binary: &str, args: &[&str]) -> Command {
        let mut command = Command::new(binary);
        command
            .args(args)
            .env("HYBRID_BASE", self.base())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// `digital-proc fly` with its runs in this test's directory.
    pub fn fly(&self, args: &[&str]) -> Command {
        let mut command = self.command(DIGITAL, &["fly"]);
        command.args(args).arg("--out").arg(self.runs());
        command
    }

    /// An analog side that waits in a session of this name.
    pub fn serve(&self, name: &str) -> Child {
        let serve = self.command(ANALOG, &["serve", "--session", name]).spawn().unwrap();
        let root = self.base().join(format!("{name}.session"));
        until("the session", Duration::from_secs(10), || root.is_dir().then_some(()));
        serve
    }

    /// Runs to a good end; the one run directory that the command made, and its output.
    pub fn made(&self, command: &mut Command) -> (PathBuf, Output) {
        let before = self.run_directories();
        let output = expect(command, 0);
        let mut new = self.run_directories();
        new.retain(|d| !before.contains(d));
        assert_eq!(new.len(), 1, "{new:?}");
        (new.remove(0), output)
    }

    /// A file beside the runs.
    pub fn file(&self, name: &str, text: &str) -> PathBuf {
        std::fs::create_dir_all(self.runs()).unwrap();
        let path = self.runs().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// A patch whose frames never end: x follows a cosine at 1e13 a second, 3e12 steps a second.
    pub fn stiff_patch(&self) -> PathBuf {
        self.file("stiff.toml", STIFF_PATCH)
    }

    /// The trace of every run, as it stands in its file.
    pub fn traces(&self) -> Vec<Vec<u8>> {
        let runs = self.run_directories().into_iter();
        runs.map(|run| std::fs::read(run.join("trace.arrow")).unwrap()).collect()
    }

    /// Run directories in the order of their names.
    pub fn run_directories(&self) -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = std::fs::read_dir(self.runs())
            .map_or_else(|_| Vec::new(), |dir| dir.map(|e| e.unwrap().path()).collect());
        found.sort();
        found
    }

    /// Fails when a session directory or shared memory of this base is left.
    pub fn assert_clean(&self) {
        let left: Vec<PathBuf> = std::fs::read_dir(self.base())
            .map_or_else(|_| Vec::new(), |dir| dir.map(|e| e.unwrap().path()).collect());
        assert!(left.is_empty(), "left in the base directory: {left:?}");
    }
}

/// A patch of one file.
pub fn bundle(text: &str) -> PatchBundle {
    PatchBundle { root: "p".into(), files: vec![("p".into(), text.into())] }
}

/// Does `work` at the console of a machine within this thread.
pub fn with_console<T>(work: impl FnOnce(&mut Console<'_>) -> T) -> T {
    let mut started = Started::new(
        &LinkChoice::Memory,
        AnalogEntry { side: || Box::<Server>::default() },
        std::sync::Arc::default(),
    )
    .unwrap();
    let mut console = Console::new(&mut started);
    let done = work(&mut console);
    console.bye().unwrap();
    done
}

/// Runs to the end and fails the test unless it exits with `code`.
pub fn expect(command: &mut Command, code: i32) -> Output {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(code), "{command:?}\n{said}{}", stderr(&output));
    output
}

/// What a process told of its faults.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Programs that do nothing but compute; killed and reaped when dropped.
pub struct Busy(Vec<Child>);

impl Busy {
    pub fn programs(n: usize) -> Busy {
        let spin = || Command::new("sh").args(["-c", "while :; do :; done"]).spawn();
        Busy((0..n).map(|_| spin().unwrap()).collect())
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        for program in &mut self.0 {
            let _ = program.kill();
            let _ = program.wait();
        }
    }
}

/// Waits for a child, at most `limit`; kills it and fails the test beyond that.
pub fn wait_within(mut child: Child, limit: Duration) -> (Output, Duration) {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > limit {
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            panic!("still running after {limit:?}: {}", stderr(&output));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let took = started.elapsed();
    (child.wait_with_output().unwrap(), took)
}

/// Pids of live children of `pid` (zombies excluded).
pub fn children(pid: u32) -> Vec<u32> {
    let text =
        std::fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    text.split_whitespace().map(|p| p.parse().unwrap()).collect()
}

/// The first word of a process' command line.
pub fn argv0(pid: u32) -> String {
    let bytes = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(bytes.split(|b| *b == 0).next().unwrap_or_default()).into_owned()
}

/// Whether a process runs (a zombie does not).
pub fn runs(pid: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| {
        !stat.rsplit(')').next().unwrap_or_default().trim_start().starts_with('Z')
    })
}

/// Polls until `ready` or the limit; fails the test at the limit.
pub fn until<T>(what: &str, limit: Duration, mut ready: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = ready() {
            return found;
        }
        assert!(started.elapsed() < limit, "{what} did not come within {limit:?}");
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// The partner that a digital-proc has started.
pub fn partner_of(child: &Child) -> u32 {
    until("the analog side", Duration::from_secs(5), || {
        children(child.id()).into_iter().find(|p| argv0(*p) == "analog-proc")
    })
}

/// A page refers to nothing outside itself, and its links lead somewhere.
pub fn assert_self_contained(path: &Path) -> String {
    let html = std::fs::read_to_string(path).unwrap();
    for outside in ["http:", "https:", "src=", "import", "url(", "fetch", "<link", "NaN"] {
        assert!(!html.contains(outside), "{outside}");
    }
    for link in html.split("href=\"").skip(1) {
        let target = link.split('"').next().unwrap().strip_prefix('#').unwrap();
        assert!(html.contains(&format!("id=\"{target}\"")), "#{target} leads nowhere");
    }
    html
}

/// Rows of a trace that can be read, whether it was ended or cut off; none before it is begun.
pub fn trace_rows(directory: &Path) -> usize {
    let trace = directory.join("trace.arrow");
    if trace.exists() { desk::run_dir::Trace::read(&trace).unwrap().rows() } else { 0 }
}

pub fn signal(pid: u32, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    // The target may have ended by itself in this very moment.
    let _ = rustix::process::kill_process(pid, signal);
}

/// What a command says as JSON; every check that it names in `checks` holds, and there is no other.
pub fn ask(top: &BenchTop, args: &str, checks: &[&str]) -> Value {
    let mut command = top.command(DIGITAL, &args.split_whitespace().collect::<Vec<_>>());
    command.args(["--json", "--link", "memory", "--out"]).arg(top.runs());
    let json: Value = serde_json::from_slice(&expect(&mut command, 0).stdout).unwrap();
    let claims = json["claims"].as_array().unwrap();
    let ids: Vec<&str> = claims.iter().map(|c| c["id"].as_str().unwrap()).collect();
    assert_eq!(ids, checks, "{args}");
    assert!(claims.iter().all(|c| c["verdict"] == "holds"), "{claims:?}");
    json
}

/// The rows of one of its tables.
pub fn rows<'j>(json: &'j Value, table: &str) -> &'j [Value] {
    json["tables"][table].as_array().unwrap()
}

/// A number of such a row.
pub fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}
