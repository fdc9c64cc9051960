//! The long-period study on the machine: its claims hold, and can fail.

use crate::bench_top::{BenchTop, expect, with_console};
use desk::claim::Verdict;
use digital_proc::study::long_period::{
    claims,
    results::{Departure, LongPeriodResults},
    run::{LongPeriodPlan, run},
};
use interface::profile::Profile;
use vehicle::{
    Vehicle, VehicleData,
    failure_file::FailureFile,
    flight_mode::FlightScript,
    reference::{self, FlightCase},
};

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
    let good = "[[mode]]\nname = \"late-roll\"\nactions = [{ at-s = 30.0, roll-gain = 0.0 }]\n";
    let path = bench.file("mine.toml", good);
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
    bench.file("mine.toml", &good.replace("roll-gain", "rol-gain"));
    let refused = String::from_utf8(fly("late-roll", 2).stderr).unwrap();
    assert!(refused.contains("mine.toml:3") && refused.contains("roll-gain"), "{refused}");
    bench.assert_clean();
}

/// The loads are those of the reference integration, which shares no code with the machine; the
/// partition's error is first order in 0.1 s: Qα moves with the lag of half a frame,
/// 0.1°·95 kPa ≈ 10 kPa deg.
#[test]
fn the_claims_hold_and_the_loads_are_the_references() {
    let vehicle = Vehicle::shipped().unwrap();
    let plan = shipped(FailureFile::shipped().modes.clone());
    let results = study(&vehicle, &plan);
    let expected = [
        ("L1", Verdict::Holds),
        ("L2", Verdict::InPart),
        ("L2b", Verdict::InPart),
        ("L3", Verdict::InPart),
    ];
    for (id, expected) in expected {
        assert_eq!(verdict(&results, id), expected, "{id}");
    }
    // Against the sound vehicle in the same wind an independent formulation has 0.23°, 58 m of
    // altitude and 164 m of range at most, each to half a unit of its last digit.
    let largest = |of: fn(&Departure) -> f64| {
        let departures = results.modes.iter().filter_map(|m| results.departure(&m.design));
        departures.map(|d| of(&d).abs()).fold(0.0, f64::max)
    };
    assert!((largest(|d| d.path_angle_deg) - 0.23).abs() <= 0.005);
    assert!((largest(|d| d.range_km) - 0.164).abs() <= 0.000_5);
    let altitude_m = results.nominal.end.altitude_m;
    assert!((largest(|d| d.altitude_fraction) * altitude_m - 58.0).abs() <= 0.5);
    for (mode, script) in results.modes.iter().zip(&plan.modes) {
        let case = FlightCase::design(&vehicle, script).unwrap();
        let reference = reference::fly(&vehicle, &case, 1000, |_| {}).unwrap();
        let (flown, kpadeg) = (mode.design.load_kpadeg(), reference.max_q_alpha.value / 1e3);
        assert!((flown - kpadeg).abs() < 10.0, "{}: {flown} {kpadeg}", mode.name);
    }
    // A reversed wind makes the single violation fail.
    let reversed = results.modes.iter().map(|m| m.reversed.as_ref().unwrap());
    let over = reversed.filter(|flown| flown.exceeds(&results.accept));
    assert!(over.count() > 1);
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

/// One line or more of the stage patch rewired.
fn rewired(changes: &[(&str, &str)]) -> LongPeriodPlan {
    let mut plan = short_plan();
    let text = &mut plan.patch.files[0].1;
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        *text = text.replace(from, to);
    }
    plan
}

#[test]
fn the_claims_can_fail() {
    let calm = changed(|d| d.long_period_case.wind_sign = 0.0);
    let tail = changed(|d| d.long_period_case.wind_sign = 1.0);
    let sound = Vehicle::shipped().unwrap();
    // Without the tips' electronics 1.5 kN is all there is.
    let weak = changed(|d| d.tvc.force_max_n = 1_500.0);
    let slack = changed(|d| {
        d.gains_reduced.ftc_gain = vec![0.0, 0.2, 0.2];
        d.gains_reduced.tvc_gain_npdeg = vec![4_200.0, 50.0, 50.0];
    });
    let enveloped = LongPeriodPlan { envelope: vec![0.0], ..short_plan() };
    let bare = LongPeriodPlan {
        modes: modes(&["normal", "tips-dead", "ftc-electronics"]),
        ..short_plan()
    };
    let wrong_sign = [("\"-lead_f_p\"", "\"lead_f_p\""), ("\"-lead_t_p\"", "\"lead_t_p\"")];
    let no_dead_zone = [("width = \"dead_zone\"", "width = 0.0")];
    for (what, vehicle, plan, ids) in [
        ("no wind singles a load out", &calm, &short_plan(), &["L2"][..]),
        ("more than one mode exceeds the limit in a tailwind", &tail, &bare, &["L2"]),
        ("rate feedback of the wrong sign", &sound, &rewired(&wrong_sign), &["L1", "L3"]),
        (
            "a thrust vector too weak for a vehicle without tips",
            &weak,
            &short_plan(),
            &["L1", "L2"],
        ),
        ("a reduced schedule with hardly any gain", &slack, &short_plan(), &["L3"]),
        ("no load anywhere in the envelope", &calm, &enveloped, &["L2b"]),
        ("no dead zone", &sound, &rewired(&no_dead_zone), &["L2"]),
    ] {
        let results = study(vehicle, plan);
        for id in ids {
            assert_eq!(verdict(&results, id), Verdict::Fails, "{what}: {id}");
        }
    }
}
