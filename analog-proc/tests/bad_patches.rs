//! Every file in `patch-files/bad/` yields the faults that its first lines name, at their
//! lines, with a remedy; and every kind of fault has such a file.
#![allow(clippy::unwrap_used)]

use analog_proc::check::against_profile;
use analog_proc::patch::{PatchFault, PatchFaults, bundle_from_path, compile};
use desk::faults::FileFault;
use interface::profile::Profile;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// `(code, file, line)`.
type Expectation = (String, String, usize);

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../patch-files/bad");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    paths
}

/// Reads `# expect: CODE line N` and `# expect: CODE line N of FILE`.
fn expectations(path: &Path) -> Vec<Expectation> {
    let bytes = std::fs::read(path).unwrap();
    let own = path.file_name().unwrap().to_string_lossy().into_owned();
    String::from_utf8_lossy(&bytes)
        .lines()
        .filter_map(|line| line.strip_prefix("# expect: "))
        .map(|rest| {
            let words: Vec<&str> = rest.split_whitespace().collect();
            let file = words.get(4).map_or(own.clone(), |f| (*f).to_owned());
            (words[0].to_owned(), file, words[2].parse().unwrap())
        })
        .collect()
}

/// Reads `# profile: NAME`; without it the machine has no limits.
fn profile(path: &Path) -> Profile {
    let text = std::fs::read_to_string(path).unwrap();
    let name = text.lines().find_map(|l| l.strip_prefix("# profile: "));
    desk::profile::load(name.unwrap_or("ideal").trim()).unwrap()
}

fn faults_of(path: &Path) -> PatchFaults {
    match bundle_from_path(path) {
        Err(faults) => faults,
        Ok(bundle) => match compile(&bundle, &[]) {
            Err(faults) => faults,
            Ok(ordered) => against_profile(&ordered, &profile(path))
                .expect_err(&format!("{} compiles", path.display())),
        },
    }
}

fn found(records: &[FileFault]) -> Vec<Expectation> {
    records
        .iter()
        .map(|r| (r.code.unwrap().to_owned(), r.file.clone(), r.place.unwrap().0))
        .collect()
}

#[test]
fn each_file_yields_the_faults_that_it_names() {
    let mut wrong = Vec::new();
    for path in files() {
        let mut expected = expectations(&path);
        assert!(!expected.is_empty(), "{} names no fault", path.display());
        let faults = faults_of(&path);
        let mut found = found(&faults.to_list());
        expected.sort();
        found.sort();
        if expected != found {
            wrong.push(format!(
                "{}\n  expected {expected:?}\n  found    {found:?}\n{}",
                path.display(),
                faults.render()
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn each_kind_of_fault_has_its_file() {
    let names: BTreeSet<String> = files()
        .iter()
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    for code in PatchFault::CODES {
        assert!(names.contains(*code), "no patch-files/bad/{code}.toml");
        let path = files().into_iter().find(|p| p.file_stem().unwrap() == *code);
        let expected = expectations(&path.unwrap());
        assert!(expected.iter().any(|(c, _, _)| c == code), "{code}.toml does not show {code}");
    }
}

#[test]
fn each_fault_shows_its_line_and_a_remedy() {
    for path in files() {
        let faults = faults_of(&path);
        let text = faults.render();
        for record in faults.to_list() {
            assert!(
                record.remedy.len() > 10,
                "{}: `{}` has no remedy",
                path.display(),
                record.fault
            );
            assert!(text.contains(record.code.unwrap()), "{text}");
            let place = format!("{}:{}", record.file, record.place.unwrap().0);
            assert!(text.contains(&place), "{place} is not shown:\n{text}");
        }
    }
}

#[test]
fn an_algebraic_loop_is_shown_as_the_whole_cycle() {
    let path = files().into_iter().find(|p| p.ends_with("algebraic-loop.toml")).unwrap();
    let record = faults_of(&path).to_list().remove(0);
    assert!(record.fault.contains("error → scaled → output → error"), "{}", record.fault);
    for edge in ["error → scaled", "scaled → output", "output → error"] {
        assert!(record.remedy.contains(edge), "{}", record.remedy);
    }
    assert!(record.remedy.contains("integrator"), "{}", record.remedy);
}

#[test]
fn overrides_are_checked_like_the_file() {
    let bundle = interface::control::PatchBundle {
        root: "p.toml".into(),
        files: vec![(
            "p.toml".into(),
            "[params]\nk = 1.0\n[blocks]\nx = { kind = \"constant\", value = \"k\" }\n".into(),
        )],
    };
    let compiled = compile(&bundle, &[("k".into(), 2.5)]).unwrap();
    assert_eq!(compiled.netlist.params, [("k".to_owned(), 2.5)]);
    let codes = |params: &[(String, f64)]| -> Vec<&str> {
        let faults = compile(&bundle, params).unwrap_err();
        faults.faults().iter().map(PatchFault::code_name).collect()
    };
    assert_eq!(codes(&[("q".into(), 1.0)]), ["unknown-param"]);
    assert_eq!(codes(&[("k".into(), f64::NAN)]), ["not-finite"]);
}
