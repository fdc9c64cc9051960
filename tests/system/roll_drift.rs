//! A roll drift that nobody corrects: resolved errors keep pitch out of yaw, unresolved ones do not.

use crate::{
    bench_top::{BenchTop, DIGITAL, assert_self_contained, expect},
    json,
};
use serde_json::Value;

#[test]
fn unresolved_errors_couple_pitch_into_yaw() {
    let bench = BenchTop::new();
    let flown = |link: &str| {
        let args = ["roll-drift", "--json", "--link", link, "--out"];
        let output = expect(bench.command(DIGITAL, &args).arg(bench.runs()), 0);
        json::assert_form("roll-drift", &output.stdout, 0)
    };
    let (mut shm, mut memory) = (flown("shm"), flown("memory"));
    let run = shm["run"].take();
    memory["run"].take();
    assert_eq!(shm, memory);
    let rows = shm["tables"]["roll_drift"].as_array().unwrap();
    let of = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    let (none, resolved, unresolved) = (0, 1, 2);
    // 2° and 0.2°/s over 49 s; the rest is the lag of the roll loop and the fin cant.
    assert!((of(resolved, "roll_at_burn_out_deg") - 11.8).abs() < 0.5, "{rows:?}");
    let change = |row| of(row, "largest_change_of_yaw_deg");
    assert_eq!(change(none), 0.0);
    assert!(change(unresolved) > 2.0 * change(resolved), "{rows:?}");
    for row in [resolved, unresolved] {
        // Half a frame's lag of 0.05 s, of a yaw that moves by a tenth of a degree a second.
        let second = of(row, "second_formulation_largest_change_of_yaw_deg");
        assert!((change(row) - second).abs() < 0.005, "{rows:?}");
    }
    let report = std::path::Path::new(run.as_str().unwrap()).join("report.html");
    assert!(assert_self_contained(&report).contains("second formulation"));
    for beyond in ["91", "nan"] {
        let mut far = bench.command(DIGITAL, &["roll-drift", "--roll", beyond]);
        let said = String::from_utf8(expect(&mut far, 2).stderr).unwrap();
        assert!(said.contains("90 degrees"), "{said}");
    }
    let none: &Value = &shm["claims"];
    assert_eq!(none.as_array().unwrap().len(), 0);
    bench.assert_clean();
}
