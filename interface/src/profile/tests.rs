use super::*;
use proptest::prelude::*;

#[test]
fn built_ins_read() {
    for name in Profile::BUILT_IN {
        let profile = Profile::load(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(profile.name, name);
    }
    assert_eq!(Profile::load("ideal").unwrap(), Profile::ideal());
}

#[test]
fn the_ad4_has_its_counts() {
    let ad4 = Profile::load("ad4").unwrap();
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
    let ad4 = Profile::load("ad4").unwrap();
    // 14 bits on ±100: q = 100 / 2^13.
    let adc = ad4.adc_converter(Some(100.0)).unwrap();
    assert_eq!(adc.lsb(), Some(100.0 / 8192.0));
    assert!(ad4.adc_converter(None).is_err());
    assert_eq!(Profile::ideal().adc_converter(None).unwrap(), Converter::ideal());
    assert_eq!(Profile::ideal().overload_level(), DEFAULT_OVERLOAD_LEVEL);
    assert_eq!(Profile::ideal().total_latency(64), Tick::ZERO);
    let paper = Profile::load("paper-class").unwrap();
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
    let error = Profile::parse(text, "mine.toml").unwrap_err();
    let mut lines: Vec<usize> = error.faults.iter().map(|f| f.line).collect();
    lines.dedup();
    assert_eq!(lines, [2, 4, 5, 7, 9, 10, 12, 14, 16], "{error}");
    assert_eq!(error.faults.len(), 12, "{error}");
    let shown = error.to_string();
    assert!(shown.contains("mine.toml:5: `overlod-level` means nothing here; use reference-v"));
}

#[test]
fn bad_toml_and_missing_files_are_told() {
    let error = Profile::parse("name = \n[adc\n", "x").unwrap_err();
    assert!(error.faults.iter().any(|f| f.line == 1));
    let error = Profile::load("no/such/file.toml").unwrap_err();
    assert!(error.to_string().contains("paper-class"));
}

#[test]
fn a_profile_travels_by_bincode() {
    for name in Profile::BUILT_IN {
        let profile = Profile::load(name).unwrap();
        let config = bincode::config::standard();
        let bytes = bincode::serde::encode_to_vec(&profile, config).unwrap();
        let (back, used): (Profile, usize) =
            bincode::serde::decode_from_slice(&bytes, config).unwrap();
        assert_eq!((back, used), (profile, bytes.len()));
    }
}

proptest! {
    #[test]
    fn no_text_panics(text in ".*") {
        let _ = Profile::parse(&text, "x");
    }

    #[test]
    fn no_mutation_of_a_profile_panics(at in 0_usize..4000, with in "[\\x00-\\x7f]{0,6}", cut in 0_usize..9) {
        let mut text = built_in("ad4").unwrap().to_owned();
        let floor = |text: &str, mut i: usize| {
            i = i.min(text.len());
            while !text.is_char_boundary(i) { i -= 1; }
            i
        };
        let start = floor(&text, at);
        let end = floor(&text, start + cut).max(start);
        text.replace_range(start..end, &with);
        if let Err(error) = Profile::parse(&text, "x") {
            prop_assert!(!error.faults.is_empty());
            prop_assert!(!error.to_string().is_empty());
        }
    }
}
