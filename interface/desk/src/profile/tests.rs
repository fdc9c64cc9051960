use super::*;
use interface::{converter::Converter, profile::DEFAULT_OVERLOAD_LEVEL};
use proptest::prelude::*;
use std::collections::BTreeMap;

#[test]
fn built_ins_read() {
    for (name, _) in BUILT_IN {
        let profile = load(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(profile.name, name);
    }
    assert_eq!(load("ideal").unwrap(), Profile::ideal());
}

#[test]
fn the_ad4_has_its_counts() {
    let ad4 = load("ad4").unwrap();
    assert_eq!(ad4.available(BlockClass::Integrator), Some(60));
    assert_eq!(ad4.available(BlockClass::Dac), Some(20));
    assert_eq!(ad4.available(BlockClass::Comparator), None);
    assert_eq!(ad4.reference_v.as_ref().unwrap().value, 100.0);
    assert_eq!(ad4.adc.conversion.as_ref().unwrap().status, Provenance::Memory);
    let needed = BTreeMap::from([
        (BlockClass::Integrator, 61),
        (BlockClass::Multiplier, 16),
        (BlockClass::Dac, 10),
        (BlockClass::Mdac, 11),
    ]);
    let shortfalls = ad4.shortfalls(&needed);
    let table: Vec<_> = shortfalls.iter().map(|s| (s.class.key(), s.needed, s.available)).collect();
    // 10 plain and 11 multiplying DACs are 21 of 20.
    assert_eq!(table, [("integrators", 61, 60), ("dacs", 21, 20)]);
}

#[test]
fn the_stages_of_a_profile() {
    let ad4 = load("ad4").unwrap();
    // 14 bits on ±100: q = 100 / 2^13.
    let adc = ad4.adc_converter(Some(100.0)).unwrap();
    assert_eq!(adc.lsb(), Some(100.0 / 8192.0));
    assert!(ad4.adc_converter(None).is_err());
    assert_eq!(Profile::ideal().adc_converter(None).unwrap(), Converter::ideal());
    assert_eq!(Profile::ideal().overload_level(), DEFAULT_OVERLOAD_LEVEL);
    assert_eq!(Profile::ideal().total_latency(64), Tick::ZERO);
    let paper = load("paper-class").unwrap();
    assert_eq!(paper.total_latency(1), Tick(1_000_000));
    assert_eq!(paper.latency_within(1, Tick(2_000_000)), (Tick(1_000_000), None));
    assert_eq!(paper.latency_within(1, Tick(300_000)), (Tick(300_000), Some(Tick(1_000_000))));
}

#[test]
fn every_fault_is_told_with_its_line() {
    let text = r#"
name = 5
[machine]
reference-v = { value = -1.0, status = "verified", source = "s" }
overlod-level = 1.1
[counts]
integrators = { value = 1.5, status = "heard", source = "s" }
[adc]
bits = { value = 99, status = "memory", source = "" }
skew = { value = 3, status = "memory", source = "s" }
[dcu]
bits = { value = 14, status = "memory", source = "s" }
[timing]
compute = { value = "1 fortnight", status = "memory" }
[dac]
hold = 0
"#;
    let error = parse("mine.toml", text).unwrap_err();
    let mut lines: Vec<usize> = error.0.iter().map(|f| f.place.unwrap().0).collect();
    lines.dedup();
    assert_eq!(lines, [2, 4, 5, 7, 9, 10, 12, 14, 16], "{error}");
    assert_eq!(error.0.len(), 12, "{error}");
    let shown = error.to_string();
    let told =
        "mine.toml:5:1: unknown key `overlod-level` in [machine]; did you mean `overload-level`?";
    assert!(shown.contains(told), "{shown}");
}

#[test]
fn a_name_that_is_no_file_is_answered_with_those_there_are() {
    assert!(load("no/such/file.toml").unwrap_err().to_string().contains("paper-class"));
}

proptest! {
    /// A line replaced by anything is refused or accepted.
    #[test]
    fn no_damaged_profile_panics(line in 0_usize..200, with in "\\PC{0,40}") {
        let mut lines: Vec<&str> = BUILT_IN[2].1.lines().collect();
        let at = line % lines.len();
        lines[at] = &with;
        if let Err(error) = parse("x", &lines.join("\n")) {
            prop_assert!(!error.0.is_empty() && !error.to_string().is_empty());
        }
    }
}
