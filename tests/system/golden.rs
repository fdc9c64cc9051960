//! Golden hashes: what flights, laboratory and case study compute, to the last bit.
//!
//! `tests/golden/hashes.toml` has a section a family and a line a golden. Hashed are the
//! names and the bits of the data, never a time of day, a version or a path. No test writes
//! the file unless told to: [`REWRITE`] is the one command, and what it changed is for the
//! commit to explain. `GOLDEN_LINK=shm` joins the two sides by shared memory instead; the
//! hashes are the same, as they are on any processor and any number of cores (`.ci/soak`).

use crate::bench_top::{BenchTop, DIGITAL};
use desk::run_dir::Trace;
use sha2::{Digest, Sha256};
use std::{
    collections::BTreeMap,
    fmt::Write,
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

const FILE: &str = "tests/golden/hashes.toml";
const REWRITE: &str = "GOLDEN=write cargo test --release --test system golden";
const HEAD: &str = "\
# Golden hashes (tests/system/golden.rs): the first 64 bits of the SHA-256 of what was computed.
# They change only in a commit that says why. Written by
#     GOLDEN=write cargo test --release --test system golden
";

type Section = BTreeMap<String, String>;

/// Holds `found` against its section of the file, or writes it there if so told.
pub fn hold(section: &str, found: Section) {
    static WRITING: Mutex<()> = Mutex::new(());
    let _alone = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let text = std::fs::read_to_string(FILE).unwrap_or_default();
    let mut file: BTreeMap<String, Section> = toml::from_str(&text).unwrap();
    let former = file.insert(section.into(), found.clone()).unwrap_or_default();
    let mut differing = String::new();
    for name in former.keys().chain(found.keys().filter(|n| !former.contains_key(*n))) {
        let hash = |of: &Section| of.get(name).map_or("none", String::as_str).to_owned();
        let (was, is) = (hash(&former), hash(&found));
        if was != is {
            writeln!(differing, "  {section}, {name}: golden {was}, now {is}").unwrap();
        }
    }
    if std::env::var_os("GOLDEN").is_some_and(|v| v == "write") {
        println!("{section}: {}", if differing.is_empty() { "unchanged" } else { &differing });
        let new = format!("{HEAD}\n{}", toml::to_string(&file).unwrap());
        std::fs::create_dir_all(Path::new(FILE).parent().unwrap()).unwrap();
        std::fs::write(FILE, new).unwrap();
        return;
    }
    assert!(
        differing.is_empty(),
        "the results differ from the golden ones of {FILE}:\n{differing}\
         If they are meant to, `{REWRITE}` writes them anew, and the commit says why they change."
    );
}

fn hex(hash: Sha256) -> String {
    hash.finalize()[..8].iter().fold(String::new(), |mut hex, byte| {
        write!(hex, "{byte:02x}").unwrap();
        hex
    })
}

/// Names, ticks and bits of a trace.
pub fn of_trace(path: &Path) -> String {
    let trace = Trace::read(path).unwrap();
    assert!(trace.is_complete() && trace.rows() > 0, "{}", path.display());
    let mut hash = Sha256::new();
    trace.ticks().iter().for_each(|tick| hash.update(tick.to_le_bytes()));
    for (n, column) in trace.columns().iter().enumerate() {
        hash.update(format!("{column:?}"));
        for value in trace.values(n).unwrap() {
            hash.update(value.to_bits().to_le_bytes());
        }
    }
    hex(hash)
}

/// A part of a summary, whose numbers are printed so that they read back exactly.
pub fn of_json(part: &serde_json::Value) -> String {
    assert!(!part.is_null());
    hex(Sha256::new_with_prefix(part.to_string()))
}

/// Runs `digital-proc` to a good end and returns the run directory that it made.
fn run(bench: &BenchTop, args: &str) -> PathBuf {
    let link = std::env::var("GOLDEN_LINK").unwrap_or_else(|_| "memory".into());
    let mut command = bench.command(DIGITAL, &args.split(' ').collect::<Vec<_>>());
    bench.made(command.args(["--link", &link, "--out"]).arg(bench.runs())).0
}

#[test]
fn flights_in_all_modes() {
    let bench = BenchTop::new();
    let failures: toml::Table =
        toml::from_str(include_str!("../../digital-proc/data/failures.toml")).unwrap();
    let modes = failures["mode"].as_array().unwrap();
    let mut found = Section::new();
    for mode in modes {
        let mode = mode["name"].as_str().unwrap();
        let run = run(&bench, &format!("fly --mode {mode}"));
        found.insert(mode.into(), of_trace(&run.join("trace.arrow")));
    }
    for (name, args) in [
        ("random wind", "fly --wind ensemble --seed 7"),
        ("ad4, headwind", "fly --profile ad4 --wind headwind"),
    ] {
        let run = run(&bench, args);
        found.insert(name.into(), of_trace(&run.join("trace.arrow")));
    }
    hold("flight", found);
    bench.assert_clean();
}

#[test]
fn every_table_of_the_laboratory() {
    let bench = BenchTop::new();
    let mut found = Section::new();
    // Settings that keep the whole below some seconds.
    for args in [
        "budget",
        "circle",
        "root",
        "alpha --omega 4 --gain 0.2",
        "function-generation",
        "axes",
        "noise --frames 10001",
        "skew",
        "coefficients",
        "flight --frame 20ms,100ms --until 26s",
        "loop patch-files/studies/servo-loop.toml",
    ] {
        let run = run(&bench, &format!("sampling {args}"));
        let experiment = args.split(' ').next().unwrap();
        let before = found.len();
        for entry in std::fs::read_dir(run).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "csv") {
                let name = format!("{experiment} {}", path.file_name().unwrap().display());
                let text = std::fs::read(&path).unwrap();
                found.insert(name, hex(Sha256::new_with_prefix(text)));
            }
        }
        assert!(found.len() > before, "{args} left no table");
    }
    hold("laboratory", found);
    bench.assert_clean();
}
