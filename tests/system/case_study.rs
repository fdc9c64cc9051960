//! The case study on the machine: it follows the second formulation, by which its claims are seen
//! to fail where they should (`study/short_period/claims.rs`), and its claims hold; a user's own
//! files run through, and mistakes in them are told with their place.

use crate::{
    bench_top::{BenchTop, DIGITAL, assert_self_contained, expect, with_console},
    golden, json,
};
use digital_proc::study::short_period::{
    claims::{FTC_GAIN_LOST, NORMAL},
    machine::{self, Patches},
    plan::Plan,
    reference,
    results::{Occurrence, Results},
    study_file::{SHIPPED_TEXT, Study},
};
use interface::profile::Profile;
use std::{collections::BTreeMap, path::Path};
use vehicle::Vehicle;

/// Runs a plan on both sides of a memory link.
fn answers(plan: &Plan, patches: &Patches) -> Results {
    let profile = Profile::ideal();
    with_console(|console| machine::run(console, plan, patches, &profile, |_| {}).unwrap())
}

/// The shipped study with only some conditions, to save time.
fn plan(conditions: &[&str]) -> Plan {
    let mut study = Study::shipped().unwrap();
    study.conditions.retain(|c| conditions.contains(&c.name.as_str()));
    Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap()
}

/// Greatest difference of a channel over its greatest value.
fn worst(a: &[f64], b: &[f64]) -> f64 {
    let pairs = || a.iter().zip(b);
    let scale = pairs().fold(0.0_f64, |s, (x, y)| s.max(x.abs()).max(y.abs()));
    let difference = pairs().fold(0.0_f64, |d, (x, y)| d.max((x - y).abs()));
    if difference == 0.0 { 0.0 } else { difference / scale }
}

#[test]
fn the_machine_follows_the_second_formulation_run_by_run() {
    follows(&plan(&[NORMAL, FTC_GAIN_LOST]));
}

#[test]
fn with_three_bending_modes_too() {
    let text = SHIPPED_TEXT.replace("[pitch]\n", "[pitch]\nmodes = 3\n");
    let mut study = Study::from_toml("three-modes.toml", &text).unwrap();
    study.conditions.retain(|c| c.name == NORMAL);
    let plan = Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap();
    let answers = follows(&plan);
    // Runs that stay linear agree with the eigenvalues of the larger loop.
    let (linear, disagree) = answers.linear();
    assert!(linear > 0 && disagree == 0, "{disagree} of {linear}");
}

/// Runs a plan on the machine and holds it against the second formulation.
fn follows(plan: &Plan) -> Results {
    let answers = answers(plan, &Patches::with_modes(plan.modes));
    let expected = reference::answer(plan, 5e-4);
    let mut greatest = (0.0, String::new());
    for (a, b) in answers.runs.iter().zip(&expected.runs) {
        assert!(a.seen.is_empty(), "{}: {:?}", a.name, a.seen);
        assert_eq!((&a.name, a.response.len()), (&b.name, b.response.len()));
        for ((channel, x), (_, y)) in a.response.columns().zip(b.response.columns()) {
            let difference = worst(x, y);
            if difference > greatest.0 {
                greatest = (difference, format!("{} {}", a.name, channel.adc));
            }
        }
    }
    println!("greatest difference {greatest:?} of full range");
    // The reference locates no corners: one inside a step of 0.5 ms misplaces the slope of
    // a tip, 100 deg/s at most, for up to half of it: 0.025 deg of 10 deg of travel, which
    // the loop then works off. Smooth parts differ by less (rtol 1e-7, RK4 at 0.5 ms).
    assert!(greatest.0 < 2.5e-3, "{greatest:?}");
    answers
}

/// A run that diverges ends without the study, and the next one starts afresh.
#[test]
fn a_run_that_the_machine_stops_does_not_end_the_session() {
    let mut plan = plan(&[NORMAL]);
    plan.cases.truncate(3);
    let sound = answers(&plan, &Patches::shipped());
    // An undamped servo of the wrong sign: e-folding in 10 ms, beyond any number in 12 s.
    plan.cases[1].settings.plane.filter_pole = -100.0;
    let spoilt = answers(&plan, &Patches::shipped());
    let response = |of: &Results, n: usize| of.runs[n].response.clone();
    assert_eq!(response(&spoilt, 0), response(&sound, 0));
    assert_eq!(response(&spoilt, 2), response(&sound, 2));
    assert!(response(&spoilt, 1).len() < response(&sound, 1).len());
    let seen: Vec<_> = spoilt.runs.iter().map(|run| run.seen.as_slice()).collect();
    assert!(matches!(seen.as_slice(), [[], [Occurrence::Stopped { .. }], []]), "{seen:?}");
}

/// The files that hold every number of a run; the summary but for where the run lies.
fn numbers(directory: &Path) -> (serde_json::Value, [Vec<u8>; 2]) {
    let read = |name: &str| std::fs::read(directory.join(name)).unwrap();
    let mut summary: serde_json::Value = serde_json::from_slice(&read("summary.json")).unwrap();
    summary["run"].take();
    (summary, ["trace.arrow", "short-period.arrow"].map(read))
}

#[test]
fn the_whole_case_study_holds_and_both_links_give_its_golden_numbers() {
    let bench = BenchTop::new();
    let runs = bench.runs();
    let run = |link: &str| {
        let out = ["case-study", "--link", link, "--no-sensitivity", "--no-catalogue", "--out"];
        expect(bench.command(DIGITAL, &out).arg(&runs), 0)
    };
    let shm = String::from_utf8(run("shm").stdout).unwrap();
    assert!(shm.contains("8 of 15 claims hold, 7 in part."), "{shm}");
    // Where a claim holds only in part is said.
    for part in ["reversed", "reduced schedule", "burn-out"] {
        assert!(shm.contains(part), "{part}: {shm}");
    }
    let directory = &bench.run_directories()[0];
    let (summary, traces) = numbers(directory);
    run("memory");
    let second = numbers(bench.run_directories().iter().find(|d| *d != directory).unwrap());
    assert!((&summary, &traces) == (&second.0, &second.1), "the memory link differs");
    let tables =
        ["pitch", "yaw_roll", "flights", "pitch_moments", "yaw_roll_moments", "flight_moments"]
            .map(|name| (name, &summary["tables"][name]));
    let parts = [("claims", &summary["claims"])].into_iter().chain(tables);
    let mut found: BTreeMap<_, _> =
        parts.map(|(name, part)| (name.to_owned(), golden::of_json(part))).collect();
    for trace in ["trace.arrow", "short-period.arrow"] {
        found.insert(trace.to_owned(), golden::of_trace(&directory.join(trace)));
    }
    golden::hold("case-study", found);
    let report = assert_self_contained(&directory.join("report.html"));
    for anchor in ["figure-4", "figure-5", "q-alpha", "figure-7", "figure-8", "matrix-residual"] {
        assert!(report.contains(&format!("id=\"{anchor}\"")), "{anchor}");
    }
    bench.assert_clean();
}

/// Every shipped machine reruns the paper: the same verdicts, and what its errors cost beside.
#[test]
fn every_shipped_profile_comes_to_the_same_verdicts() {
    let bench = BenchTop::new();
    let verdicts = |profile: &str| -> Vec<(String, String)> {
        let args = ["case-study", "--link", "memory", "--no-sensitivity", "--json", "--profile"];
        let mut command = bench.command(DIGITAL, &args);
        let output = expect(command.arg(profile).arg("--out").arg(bench.runs()), 0);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let cost = summary["tables"]["profile_cost"].as_array();
        assert_eq!(cost.is_none(), profile == "ideal", "{profile}");
        let claims = summary["claims"].as_array().unwrap();
        let word = |c: &serde_json::Value, key: &str| c[key].as_str().unwrap().to_owned();
        claims.iter().map(|c| (word(c, "id"), word(c, "verdict"))).collect()
    };
    let ideal = verdicts("ideal");
    for profile in ["paper-class", "ad4"] {
        assert_eq!(verdicts(profile), ideal, "{profile}");
    }
    bench.assert_clean();
}

#[test]
fn a_users_own_study_failures_and_vehicle_run_through() {
    let bench = BenchTop::new();
    let head = SHIPPED_TEXT.split("[[point]]").next().unwrap();
    let study = bench.file(
        "own-study.toml",
        &format!(
            "{head}[[point]]\nname = \"mach-two\"\nat = {{ mach = 2.0 }}\n\
             [[condition]]\nname = \"weak-motor\"\nchange = [{{ quantity = \"thrust\", times = 0.9 }}]\n"
        ),
    );
    let failures = bench.file(
        "own-failures.toml",
        "[[mode]]\nname = \"sound\"\npaper = \"nothing fails\"\n\
         [[mode]]\nname = \"late-roll\"\npaper = \"roll control lost at 30 s\"\nactions = [{ at-s = 30.0, roll-gain = 0.0 }]\n",
    );
    let vehicle = bench.file(
        "own-vehicle.toml",
        &include_str!("../../digital-proc/data/vehicle.toml")
            .replace("delta_max_deg = 10.0", "delta_max_deg = 12.0"),
    );
    let mut command = bench.command(DIGITAL, &["case-study", "--json", "--no-sensitivity"]);
    command.arg("--study").arg(&study);
    command.arg("--failures").arg(&failures);
    command.arg("--vehicle").arg(&vehicle);
    command.arg("--out").arg(bench.runs().join("out"));
    // The claims about conditions that the file leaves out cannot be judged.
    let output = expect(&mut command, 1);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("P2"), "{said}");
    let summary = json::assert_form("case-study", &output.stdout, 1);
    let tables = &summary["tables"];
    assert_eq!(tables["pitch"][0]["point"], "mach-two");
    assert_eq!(tables["pitch"][0]["condition"], "weak-motor");
    assert_eq!(tables["modes"][1]["mode"], "late-roll");
    bench.assert_clean();

    // The shipped study takes another vehicle at its own switchings and by its own limits.
    let text = include_str!("../../digital-proc/data/vehicle.toml");
    let (before, gains) = text.split_once("[gains] ").unwrap();
    let (_, after) = gains.split_once("K_phi").unwrap();
    let three = "# three switchings\nt_sw = [0.0, 17.0, 30.5, 42.0]\nK_F = [0.0, 8.6, 8.0, 12.5]\nT_F = [0.0, 0.8, 0.72, 0.72]\nK_T = [4.3e3, 6.6e3, 5.6e3, 3.9e3]\nT_T = [0.8, 0.15, 0.17, 0.35]\ne_dz_deg = [0.0, 1.16, 1.25, 0.8]\n";
    let vehicle = bench.file("three.toml", &format!("{before}[gains] {three}K_phi{after}"));
    let mut command = bench.command(DIGITAL, &["case-study", "--json", "--no-sensitivity"]);
    command.args(["--link", "memory"]).arg("--vehicle").arg(&vehicle);
    command.arg("--out").arg(bench.runs().join("out"));
    let output = command.output().unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let pitch = summary["tables"]["pitch"].as_array().unwrap();
    let normal = pitch.iter().filter(|r| r["condition"] == "normal" && r["test"] == "disturbed");
    let points: Vec<&str> = normal.map(|r| r["point"].as_str().unwrap()).collect();
    assert_eq!(
        points[3..],
        ["ftc-switch-in", "transonic", "gain-30.5", "max-q", "gain-42", "burn-out"]
    );
    let claims = summary["claims"].as_array().unwrap();
    assert!(claims.iter().all(|c| c["verdict"] != "not-judged"), "{claims:#?}");

    let mut alone = bench.command(DIGITAL, &["short-period", "yaw-roll", "--decoupled"]);
    alone.arg("--study").arg(&study).args(["--condition", "weak-motor"]);
    alone.arg("--out").arg(bench.runs().join("out"));
    expect(&mut alone, 0);
}

#[test]
fn mistakes_are_told_with_file_line_and_the_nearest_name() {
    let bench = BenchTop::new();
    let text = SHIPPED_TEXT.replacen("event = \"max-q\"", "event = \"max-Q\"", 1);
    let line = text[..text.find("max-Q").unwrap()].matches('\n').count() + 1;
    let bad = bench.file("bad.toml", &text);
    let place = format!("bad.toml:{line}:");
    let bad = bad.to_str().unwrap();
    for (args, words) in [
        (vec!["case-study", "--study", bad], [place.as_str(), "did you mean `max-q`?"]),
        (vec!["short-period", "pitch", "--study", bad], [place.as_str(), "max-q"]),
        (vec!["case-study", "--failures", bad], ["this is a short-period study", "`mode`"]),
        (vec!["case-study", "--vehicle", bad], ["not a vehicle", "short-period pitch --study"]),
        (vec!["sampling", "loop", bad], ["not a loop study", "short-period pitch --study"]),
        (vec!["short-period", "pitch", "--point", "max-Q"], ["no point `max-Q`", "`max-q`"]),
        (
            vec!["short-period", "yaw-roll", "--condition", "tvc-slo"],
            ["no condition `tvc-slo`", "`tvc-slow`"],
        ),
        (vec!["short-period", "yaw-roll", "--point", "vertical-rise"], ["no run", "fin tips"]),
    ] {
        let output = expect(&mut bench.command(DIGITAL, &args), 2);
        let said = String::from_utf8_lossy(&output.stderr);
        for word in words {
            assert!(said.contains(word), "{args:?}: {said}");
        }
    }
    bench.assert_clean();
}
