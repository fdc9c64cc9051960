//! The long-period study on the machine: its claims hold, and can fail.

use crate::bench_top::{BenchTop, expect, with_console};
use desk::claim::Verdict;
use digital_proc::study::long_period::{
    claims,
    results::LongPeriodResults,
    run::{LongPeriodPlan, run},
};
use interface::profile::Profile;
use vehicle::{Vehicle, VehicleData, failure_file::FailureFile, flight_mode::FlightScript};

fn modes(names: &[&str]) -> Vec<FlightScript> {
    let file = FailureFile::shipped();
    names.iter().map(|n| file.mode(n).unwrap().clone()).collect()
}

fn study(vehicle: &Vehicle, plan: &LongPeriodPlan) -> LongPeriodResults {
    with_console(|console| run(console, vehicle, plan, |_| {}).unwrap())
}

fn shipped(modes: Vec<FlightScript>) -> LongPeriodPlan {
    LongPeriodPlan::new(modes, Profile::ideal())
}

/// The design case alone, of the modes that decide L1, L2 and L3.
fn short_plan() -> LongPeriodPlan {
    LongPeriodPlan {
        envelope: Vec::new(),
        reversed: false,
        ..shipped(modes(&["normal", "ftc-electronics", "reduced-schedule"]))
    }
}

fn verdict(results: &LongPeriodResults, id: &str) -> Verdict {
    let claims = claims::judge(results);
    let claim = claims.iter().find(|c| c.id == id).unwrap();
    claim.verdict
}

fn changed(change: impl FnOnce(&mut VehicleData)) -> Vehicle {
    let mut data = Vehicle::shipped().unwrap().data().clone();
    change(&mut data);
    Vehicle::from_data(data).unwrap()
}

#[test]
fn a_users_failure_file_flies_and_its_mistakes_are_told() {
    let bench = BenchTop::new();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("mine.toml");
    let good = "[[mode]]\nname = \"late-roll\"\nactions = [{ at-s = 30.0, roll-gain = 0.0 }]\n";
    std::fs::write(&path, good).unwrap();
    let file = path.to_str().unwrap();
    let fly = |mode: &str, code: i32| {
        let args = ["--mode", mode, "--failures", file, "--json", "--design-case"];
        expect(&mut bench.fly(&args), code)
    };
    let flown = fly("late-roll", 0);
    let summary: serde_json::Value = serde_json::from_slice(&flown.stdout).unwrap();
    // Sound, it stays within a tenth of a degree; without control it turns over.
    assert!(summary["results"]["max_roll_deg"].as_f64().unwrap() > 90.0);
    let missed = String::from_utf8(fly("late-rol", 2).stderr).unwrap();
    assert!(missed.contains("late-roll"), "{missed}");
    std::fs::write(&path, good.replace("roll-gain", "rol-gain")).unwrap();
    let refused = String::from_utf8(fly("late-roll", 2).stderr).unwrap();
    assert!(refused.contains("mine.toml:3") && refused.contains("roll-gain"), "{refused}");
    bench.assert_clean();
}

/// Maxima of the reference integration, which shares no code with the machine;
/// the partition's error is first order in 0.1 s: the burn-out altitude is some
/// 20 m off, and Qα moves with the lag of half a frame, 0.1°·95 kPa ≈ 10 kPa deg.
#[test]
fn the_claims_hold_and_the_loads_are_the_references() {
    let vehicle = Vehicle::shipped().unwrap();
    let plan = shipped(FailureFile::shipped().modes.clone());
    let results = study(&vehicle, &plan);
    for id in ["L1", "L2", "L2b", "L3"] {
        assert_eq!(verdict(&results, id), Verdict::Holds, "{id}");
    }
    for (name, kpadeg) in [
        ("normal", 284.7),
        ("roll-lost", 262.2),
        ("tips-dead", 314.3),
        ("ftc-electronics", 516.1),
        ("sequencer-stuck", 279.3),
        ("reduced-schedule", 283.7),
    ] {
        let mode = results.modes.iter().find(|m| m.name == name).unwrap();
        let flown = mode.design.load_kpadeg();
        assert!((flown - kpadeg).abs() < 10.0, "{name}: {flown} {kpadeg}");
    }
    // A reversed wind makes the single violation fail.
    let reversed = results.modes.iter().map(|m| m.reversed.as_ref().unwrap());
    let over = reversed.filter(|flown| flown.exceeds(&results.accept));
    assert!(over.count() > 1);
    // Objective (v): the worst case is among the flights and is carried.
    let (_, _, fuel_kg) = results.worst_fuel().unwrap();
    assert!(fuel_kg > results.nominal.injectant_kg && fuel_kg < results.carried_kg);
}

#[test]
fn repeated_flights_of_one_session_are_bit_identical() {
    let plan = LongPeriodPlan {
        envelope: Vec::new(),
        reversed: false,
        ..shipped([modes(&["normal"]), modes(&["roll-lost"]), modes(&["normal"])].concat())
    };
    let results = study(&Vehicle::shipped().unwrap(), &plan);
    assert_eq!(results.modes[0].design, results.modes[2].design);
    assert_eq!(results.modes[0].history, results.modes[2].history);
    assert_ne!(results.modes[0].design, results.modes[1].design);
}

#[test]
fn without_wind_no_load_is_singled_out() {
    let calm = changed(|d| d.long_period_case.wind_sign = 0.0);
    assert_eq!(verdict(&study(&calm, &short_plan()), "L2"), Verdict::Fails);
}

#[test]
fn in_a_tailwind_more_than_one_mode_exceeds_the_limit() {
    let tail = changed(|d| d.long_period_case.wind_sign = 1.0);
    let plan =
        LongPeriodPlan { modes: modes(&["normal", "roll-lost", "tips-dead"]), ..short_plan() };
    assert_eq!(verdict(&study(&tail, &plan), "L2"), Verdict::Fails);
}

/// One line of the stage patch rewired.
fn rewired(from: &str, to: &str) -> LongPeriodPlan {
    let mut plan = short_plan();
    let text = &mut plan.patch.files[0].1;
    assert!(text.contains(from), "{from}");
    *text = text.replace(from, to);
    plan
}

#[test]
fn rate_feedback_of_the_wrong_sign_breaks_the_trajectory_claims() {
    let vehicle = Vehicle::shipped().unwrap();
    let mut plan = rewired("\"-lead_f_p\"", "\"lead_f_p\"");
    plan.patch.files[0].1 = plan.patch.files[0].1.replace("\"-lead_t_p\"", "\"lead_t_p\"");
    let results = study(&vehicle, &plan);
    assert_eq!(verdict(&results, "L1"), Verdict::Fails);
    assert_eq!(verdict(&results, "L3"), Verdict::Fails);
}

#[test]
fn without_the_dead_zone_the_single_violation_fails() {
    let plan = rewired("width = \"dead_zone\"", "width = 0.0");
    let results = study(&Vehicle::shipped().unwrap(), &plan);
    assert_eq!(verdict(&results, "L2"), Verdict::Fails);
}
