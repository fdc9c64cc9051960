//! What stands beside the short-period study: gyro location and bending filter, the two forms of
//! the model, offsets in attitude and rate.

use crate::bench_top::{BenchTop, DIGITAL, ask, expect, number, rows, stderr};
use serde_json::Value;

#[test]
fn the_gyro_stands_where_no_mode_is_driven_and_the_filter_gains_margin_for_phase() {
    let top = BenchTop::new();
    let json = ask(&top, "gyro-location", &["machine-damping", "machine-margin"]);
    assert_eq!(rows(&json, "stations").len(), 13);
    for row in rows(&json, "stations") {
        // Those of an independent formulation of the loop with three modes, by their last digit.
        let (second, third) = (number(row, "second_mode"), number(row, "third_mode"));
        assert!((0.0105..0.0205).contains(&second), "{row}");
        assert!((0.009_55..0.010_05).contains(&third), "{row}");
    }
    let tips: Vec<&Value> = rows(&json, "margins")
        .iter()
        .filter(|r| r["opened_at"] == "fin tips" && number(r, "mode") == 1.0)
        .collect();
    assert_eq!(tips.len(), 2 * 9);
    for pair in tips.chunks(2) {
        let [with, without] = [0, 1].map(|i| (pair[i]["filter"].as_str().unwrap(), pair[i]));
        assert_eq!((with.0, without.0), ("in", "out"));
        // A pole at 30 rad/s takes √(1 + (ω/30)²) of a mode at 24 to 34 rad/s: 2.1 to 3.6 dB.
        let gained = number(with.1, "gain_margin_db") - number(without.1, "gain_margin_db");
        assert!((2.0..3.7).contains(&gained), "{gained}: {pair:?}");
        let attitude = |r: &Value| number(r, "phase_margin_of_the_attitude_deg");
        assert!(attitude(with.1) < attitude(without.1), "{pair:?}");
        // |L| above 1, and yet damped: by its phase.
        let by = if number(with.1, "gain_margin_db") > 0.0 { "gain" } else { "phase" };
        assert_eq!(with.1["stabilised_by"], by);
    }
    assert!(tips.iter().any(|r| r["stabilised_by"] == "phase"));
    let mut off = top.command(DIGITAL, &["gyro-location", "--stations", "30"]);
    let told = stderr(&expect(&mut off, 2));
    assert!(told.contains("from 1.5 to 20 m"), "{told}");
    top.assert_clean();
}

#[test]
fn drift_form_and_alpha_form_are_one_model_while_the_gust_is_held() {
    let top = BenchTop::new();
    let json = ask(&top, "short-period forms", &["responses", "eigenvalues"]);
    assert_eq!(rows(&json, "forms").len(), 13);
    for row in rows(&json, "forms") {
        // Where it ends the α form keeps it: α is off by the gust, which is some of its greatest.
        let ended = number(row, "incidence_the_gust_ended_of_its_greatest");
        assert!((0.1..1.0).contains(&ended), "{row}");
    }
    top.assert_clean();
}

#[test]
fn rates_correspond_to_attitudes_and_every_run_is_that_of_the_reference() {
    let top = BenchTop::new();
    let json = ask(&top, "short-period offsets", &["reference"]);
    assert_eq!(rows(&json, "offsets").len(), 9 * 6);
    for row in rows(&json, "offsets") {
        let (yaw, roll) = (number(row, "greatest_yaw_deg"), number(row, "greatest_roll_deg"));
        match row["offset"].as_str().unwrap() {
            // What is not offset stays at rest but for what shares its tips.
            "yaw attitude" | "yaw rate" => assert!(yaw > 0.0 && roll < 1e-9, "{row}"),
            "roll attitude" | "roll rate" => assert!(roll > 0.0 && yaw < 1e-9, "{row}"),
            _ => assert!(yaw > 0.0 && roll > 0.0, "{row}"),
        }
    }
    top.assert_clean();
}

#[test]
fn the_quantities_of_a_study_are_listed() {
    let top = BenchTop::new();
    let output = expect(&mut top.command(DIGITAL, &["list", "quantities", "--json"]), 0);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = rows(&json, "quantities").iter().find(|r| r["name"] == "tip-travel").unwrap();
    assert_eq!((&found["unit"], &found["range"]), (&"deg".into(), &"0 or greater".into()));
}
