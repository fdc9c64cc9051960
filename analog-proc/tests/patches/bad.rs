//! Every file in `patch-files/bad/` yields the faults that its first lines name, at their
//! lines, with a remedy; and every kind of fault has such a file.

use crate::{bundle, files, shipped, sound};
use analog_proc::check::against_profile;
use analog_proc::patch::{PatchFault, PatchFaults, bundle_from_path, compile};
use interface::profile::Profile;
use std::path::Path;

/// `(code, file, line)`.
type Expectation = (String, String, usize);

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

#[test]
fn each_file_yields_the_faults_that_it_names_and_shows_place_and_remedy() {
    for path in files("bad") {
        let mut expected = expectations(&path);
        assert!(!expected.is_empty(), "{} names no fault", path.display());
        let faults = faults_of(&path);
        let text = faults.render();
        let mut found = Vec::new();
        for record in faults.to_list() {
            let (code, line) = (record.code.unwrap(), record.place.unwrap().0);
            assert!(record.remedy.len() > 10, "`{}` has no remedy", record.fault);
            let place = format!("{}:{line}", record.file);
            assert!(text.contains(code) && text.contains(&place), "{place} is not shown:\n{text}");
            found.push((code.to_owned(), record.file, line));
        }
        expected.sort();
        found.sort();
        assert_eq!(found, expected, "{}\n{text}", path.display());
    }
}

#[test]
fn each_kind_of_fault_has_its_file() {
    for code in PatchFault::CODES {
        let path = shipped(&format!("bad/{code}.toml"));
        assert!(path.is_file(), "no patch-files/bad/{code}.toml");
        let expected = expectations(&path);
        assert!(expected.iter().any(|(c, _, _)| c == code), "{code}.toml does not show {code}");
    }
}

#[test]
fn an_algebraic_loop_is_shown_as_the_whole_cycle() {
    let record = faults_of(&shipped("bad/algebraic-loop.toml")).to_list().remove(0);
    assert!(record.fault.contains("error → scaled → output → error"), "{}", record.fault);
    for edge in ["error → scaled", "scaled → output", "output → error"] {
        assert!(record.remedy.contains(edge), "{}", record.remedy);
    }
    assert!(record.remedy.contains("integrator"), "{}", record.remedy);
}

#[test]
fn overrides_are_checked_like_the_file() {
    let bundle =
        bundle("[params]\nk = 1.0\n[blocks]\nx = { kind = \"constant\", value = \"k\" }\n");
    let compiled = sound(compile(&bundle, &[("k".into(), 2.5)]));
    assert_eq!(compiled.netlist.params, [("k".to_owned(), 2.5)]);
    let codes = |params: &[(String, f64)]| -> Vec<&str> {
        let faults = compile(&bundle, params).unwrap_err();
        faults.faults().iter().map(PatchFault::code_name).collect()
    };
    assert_eq!(codes(&[("q".into(), 1.0)]), ["unknown-param"]);
    assert_eq!(codes(&[("k".into(), f64::NAN)]), ["not-finite"]);
}
