//! Patches that were once answered wrongly, made small; each names its cause in its title.
//!
//! The head of a file says when it ends and what its nets then are, by closed forms.

use crate::bench::{Bench, ordered};

/// `# until = 1.5 s` and `# NET = VALUE within TOLERANCE`.
fn expectations(text: &str) -> (f64, Vec<(String, f64, f64)>) {
    let mut until_s = None;
    let mut nets = Vec::new();
    for line in text.lines().filter_map(|l| l.strip_prefix("# ")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["until", "=", s, "s"] => until_s = Some(s.parse().unwrap()),
            [net, "=", value, "within", tolerance] => {
                nets.push((net.to_string(), value.parse().unwrap(), tolerance.parse().unwrap()))
            }
            _ => {}
        }
    }
    (until_s.expect("# until = … s"), nets)
}

#[test]
fn what_was_wrong_once_stays_right() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fuzz/corpus");
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(paths.len() >= 10, "{paths:?}");
    let mut wrong = String::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy();
        let (until_s, nets) = expectations(&text);
        assert!(!nets.is_empty(), "{name} expects nothing");
        let mut bench = Bench::of(ordered(&text).unwrap());
        if let Err(fault) = bench.try_run(until_s) {
            wrong += &format!("{name}: {fault}\n");
            continue;
        }
        for (net, truth, tolerance) in nets {
            let found = bench.net(&net);
            let error = (found - truth).abs();
            if error > tolerance || error.is_nan() {
                wrong += &format!("{name}: {net} = {found} instead of {truth}, {error:.1e}\n");
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}
