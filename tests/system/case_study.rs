//! The case study on the machine: its claims hold, and can be made to fail; a user's own
//! files run through, and mistakes in them are told with their place.

use crate::{
    bench_top::{BenchTop, DIGITAL, expect},
    golden,
};
use analog_proc::session::serve::serve;
use desk::claim::{Claim, Verdict};
use digital_proc::{
    console::Console,
    launch::{AnalogEntry, LinkChoice, Started},
    study::short_period::{
        bench::Occurrence,
        claims::{self, FTC_GAIN_LOST, NORMAL, TVC_FAST, TVC_SLOW},
        machine::{self, Answers, Patches},
        outcome::Outcome,
        plan::Plan,
        reference,
        response::Response,
        study_file::{SHIPPED_TEXT, Study},
    },
};
use interface::profile::Profile;
use std::path::Path;
use vehicle::Vehicle;

/// Runs a plan on both sides of a memory link.
fn answers(plan: &Plan, patches: &Patches) -> Answers {
    let mut started =
        Started::new(&LinkChoice::Memory, AnalogEntry { serve }, std::sync::Arc::default())
            .unwrap();
    let mut console = Console::new(started.port());
    let answers = machine::run(&mut console, plan, patches, &Profile::ideal(), |_| {}).unwrap();
    console.bye().unwrap();
    answers
}

/// The shipped study with only some conditions, to save time.
fn plan(conditions: &[&str]) -> Plan {
    let mut study = Study::shipped().unwrap();
    study.conditions.retain(|c| conditions.contains(&c.name.as_str()));
    Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap()
}

fn judged(plan: &Plan, patches: &Patches) -> Vec<Claim> {
    claims::judge(&Outcome::new(plan.clone(), answers(plan, patches)))
}

fn failing(claims: &[Claim]) -> Vec<String> {
    claims.iter().filter(|c| c.verdict == Verdict::Fails).map(|c| c.id.to_string()).collect()
}

#[test]
fn every_short_period_claim_holds_on_the_machine() {
    let plan = plan(&[NORMAL, FTC_GAIN_LOST, TVC_SLOW, TVC_FAST]);
    let claims = judged(&plan, &Patches::shipped());
    assert_eq!(claims.len(), 10);
    for claim in &claims {
        assert!(claim.holds(), "{claim:?}");
    }
}

/// Greatest difference of a channel over its greatest value.
fn worst<const N: usize>(a: &Response<N>, b: &Response<N>, channel: usize) -> f64 {
    let pairs = || a.channel(channel).iter().zip(b.channel(channel));
    let scale = pairs().fold(0.0_f64, |s, (x, y)| s.max(x.abs()).max(y.abs()));
    let difference = pairs().fold(0.0_f64, |d, (x, y)| d.max((x - y).abs()));
    if difference == 0.0 { 0.0 } else { difference / scale }
}

#[test]
fn the_machine_follows_the_second_formulation_run_by_run() {
    let plan = plan(&[NORMAL, FTC_GAIN_LOST]);
    let answers = answers(&plan, &Patches::shipped());
    assert!(answers.remarks.is_empty(), "{:?}", answers.remarks);
    let expected = reference::answer(&plan, 5e-4);
    let mut greatest = (0.0, String::new());
    let mut compare = |what: String, difference: f64| {
        if difference > greatest.0 {
            greatest = (difference, what);
        }
    };
    for (n, (a, b)) in answers.pitch.iter().zip(&expected.pitch).enumerate() {
        assert_eq!(a.len(), b.len());
        for c in 0..10 {
            compare(format!("pitch run {n}, channel {c}"), worst(a, b, c));
        }
    }
    for (n, (a, b)) in answers.yaw_roll.iter().zip(&expected.yaw_roll).enumerate() {
        assert_eq!(a.len(), b.len());
        for c in 0..12 {
            compare(format!("yaw-roll run {n}, channel {c}"), worst(a, b, c));
        }
    }
    println!("greatest difference {greatest:?} of full range");
    // The reference locates no corners: one inside a step of 0.5 ms misplaces the slope of
    // a tip, 100 deg/s at most, for up to half of it: 0.025 deg of 10 deg of travel, which
    // the loop then works off. Smooth parts differ by less (rtol 1e-7, RK4 at 0.5 ms).
    assert!(greatest.0 < 2.5e-3, "{greatest:?}");
}

/// The shipped patches with some lines of the plane rewired.
fn rewired(changes: &[(&str, &str)]) -> Patches {
    let mut patches = Patches::shipped();
    for bundle in [&mut patches.pitch, &mut patches.yaw_roll] {
        let plane =
            bundle.files.iter_mut().find(|(name, _)| name == "sub/stage-plane.toml").unwrap();
        for (from, to) in changes {
            assert_eq!(plane.1.matches(from).count(), 1, "{from}");
            plane.1 = plane.1.replace(from, to);
        }
    }
    patches
}

#[test]
fn a_flipped_sign_of_the_damping_makes_the_matching_claims_fail() {
    let normal = plan(&[NORMAL]);
    let rate = rewired(&[("\"-tvc_lead\"", "\"tvc_lead\""), ("\"-fin_lead\"", "\"fin_lead\"")]);
    assert!(failing(&judged(&normal, &rate)).iter().any(|id| id == "P1"));
    let structure = rewired(&[("\"-eta_drag\"", "\"eta_drag\"")]);
    assert!(failing(&judged(&normal, &structure)).iter().any(|id| id == "P5"));
}

/// With the thrust vector always at work its poor lead spoils the normal step, and
/// dedicated allocation loses its advantage.
#[test]
fn without_the_dead_zone_the_matching_claims_fail() {
    let open = rewired(&[("width = \"dead_zone_width\"", "width = 0.0")]);
    assert_eq!(failing(&judged(&plan(&[NORMAL]), &open)), ["P1", "Y4"]);
}

#[test]
fn a_healthy_actuator_does_not_pass_for_a_failed_one() {
    let mut plan = plan(&[TVC_SLOW, TVC_FAST]);
    plan.yaw_roll.clear();
    for case in &mut plan.pitch {
        case.settings.plane.tvc_bandwidth = 10.0;
    }
    assert_eq!(failing(&judged(&plan, &Patches::shipped())), ["P3", "P4"]);
}

/// A run that diverges ends without the study, and the next one starts afresh.
#[test]
fn a_run_that_the_machine_stops_does_not_end_the_session() {
    let mut plan = plan(&[NORMAL]);
    plan.yaw_roll.clear();
    plan.pitch.truncate(3);
    let sound = answers(&plan, &Patches::shipped());
    // An undamped servo of the wrong sign: e-folding in 10 ms, beyond any number in 12 s.
    plan.pitch[1].settings.plane.filter_pole = -100.0;
    let spoilt = answers(&plan, &Patches::shipped());
    assert_eq!(spoilt.pitch[0], sound.pitch[0]);
    assert_eq!(spoilt.pitch[2], sound.pitch[2]);
    assert!(spoilt.pitch[1].len() < sound.pitch[1].len());
    assert!(matches!(
        spoilt.remarks.as_slice(),
        [machine::Remark { run: 1, what: Occurrence::Stopped { .. }, .. }]
    ));
}

/// The three files that hold every number of a run.
fn numbers(directory: &Path) -> Vec<Vec<u8>> {
    ["summary.json", "trace.arrow", "short-period.arrow"]
        .map(|name| std::fs::read(directory.join(name)).unwrap())
        .into()
}

#[test]
fn the_whole_case_study_holds_and_both_links_give_its_golden_numbers() {
    let bench = BenchTop::new();
    let runs = bench.runs();
    let run = |link: &str| {
        let out = ["case-study", "--link", link, "--no-sensitivity", "--out"];
        expect(bench.command(DIGITAL, &out).arg(&runs), 0)
    };
    let shm = String::from_utf8(run("shm").stdout).unwrap();
    assert!(shm.contains("14 of 14 claims hold."), "{shm}");
    // Where a claim holds only in part is said.
    for part in ["reversed", "reduced schedule", "burn-out"] {
        assert!(shm.contains(part), "{part}: {shm}");
    }
    let directory = &bench.run_directories()[0];
    let first = numbers(directory);
    run("memory");
    let second = numbers(bench.run_directories().iter().find(|d| *d != directory).unwrap());
    assert!(first == second, "the memory link differs");
    let summary: serde_json::Value = serde_json::from_slice(&first[0]).unwrap();
    let parts = ["claims", "long_period", "short_period"];
    let found = parts.map(|part| (part.to_owned(), golden::of_json(&summary[part])));
    golden::hold("case-study", found.into());
    let report = std::fs::read_to_string(directory.join("report.html")).unwrap();
    for outside in ["src=", "http:", "https:", "url(", "import("] {
        assert!(!report.contains(outside), "{outside}");
    }
    for anchor in ["figure-4", "figure-5", "q-alpha", "figure-7", "figure-8", "matrix-residual"] {
        assert!(report.contains(&format!("id=\"{anchor}\"")), "{anchor}");
    }
    for link in report.split("href=\"").skip(1) {
        let target = link.split('"').next().unwrap().strip_prefix('#').unwrap();
        assert!(report.contains(&format!("id=\"{target}\"")), "#{target} leads nowhere");
    }
    bench.assert_clean();
}

#[test]
fn a_users_own_study_failures_and_vehicle_run_through() {
    let bench = BenchTop::new();
    std::fs::create_dir_all(bench.runs()).unwrap();
    let file = |name: &str, text: &str| {
        let path = bench.runs().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let head = SHIPPED_TEXT.split("[[point]]").next().unwrap();
    let study = file(
        "own-study.toml",
        &format!(
            "{head}[[point]]\nname = \"mach-two\"\nat = {{ mach = 2.0 }}\n\
             [[condition]]\nname = \"weak-motor\"\nchange = [{{ quantity = \"thrust\", times = 0.9 }}]\n"
        ),
    );
    let failures = file(
        "own-failures.toml",
        "[[mode]]\nname = \"sound\"\npaper = \"nothing fails\"\n\
         [[mode]]\nname = \"late-roll\"\npaper = \"roll control lost at 30 s\"\nactions = [{ at-s = 30.0, roll-gain = 0.0 }]\n",
    );
    let vehicle = file(
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
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["short_period"]["pitch"][0]["run"], "mach-two.weak-motor");
    assert_eq!(summary["long_period"]["modes"][1]["mode"], "late-roll");
    bench.assert_clean();

    let mut alone = bench.command(DIGITAL, &["short-period", "yaw-roll", "--decoupled"]);
    alone.arg("--study").arg(&study).args(["--condition", "weak-motor"]);
    alone.arg("--out").arg(bench.runs().join("out"));
    expect(&mut alone, 0);
}

#[test]
fn mistakes_are_told_with_file_line_and_the_nearest_name() {
    let bench = BenchTop::new();
    std::fs::create_dir_all(bench.runs()).unwrap();
    let bad = bench.runs().join("bad.toml");
    let text = SHIPPED_TEXT.replacen("event = \"max-q\"", "event = \"max-Q\"", 1);
    let line = text[..text.find("max-Q").unwrap()].matches('\n').count() + 1;
    std::fs::write(&bad, text).unwrap();
    let place = format!("bad.toml:{line}:");
    let bad = bad.to_str().unwrap();
    for (args, words) in [
        (vec!["case-study", "--study", bad], [place.as_str(), "did you mean `max-q`?"]),
        (vec!["short-period", "pitch", "--study", bad], [place.as_str(), "max-q"]),
        (vec!["case-study", "--failures", bad], ["bad.toml:", "mode"]),
        (vec!["case-study", "--vehicle", bad], ["bad.toml", ""]),
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
