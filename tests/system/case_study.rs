//! The case study on the machine: its claims hold, and can be made to fail.

use analog_proc::serve::serve;
use digital_proc::{
    console::Console,
    launch::{AnalogEntry, LinkChoice, Started},
    study::{
        claim::{Claim, Verdict},
        short_period::{
            claims::{self, FTC_GAIN_LOST, NORMAL, TVC_FAST, TVC_SLOW},
            machine::{self, Answers, Patches},
            measure::Results,
            plan::Plan,
            reference,
            response::Response,
            study_file::Study,
        },
    },
    vehicle::Vehicle,
};
use interface::profile::Profile;

/// Runs a plan on both sides of a memory link.
fn answers(plan: &Plan, patches: &Patches) -> Answers {
    let mut started = Started::new(
        &LinkChoice::Memory,
        AnalogEntry { serve },
        std::sync::Arc::default(),
    )
    .unwrap();
    let mut console = Console::new(started.port());
    let answers = machine::run(&mut console, plan, patches, &Profile::ideal(), |_| {}).unwrap();
    console.bye().unwrap();
    answers
}

/// The shipped study with only some conditions, to save time.
fn plan(conditions: &[&str]) -> Plan {
    let mut study = Study::shipped().unwrap();
    study
        .conditions
        .retain(|c| conditions.contains(&c.name.as_str()));
    Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap()
}

fn judged(plan: &Plan, patches: &Patches) -> Vec<Claim> {
    let answers = answers(plan, patches);
    claims::judge(plan, &Results::new(plan, &answers.pitch, &answers.yaw_roll))
}

fn failing(claims: &[Claim]) -> Vec<&'static str> {
    claims
        .iter()
        .filter(|c| c.verdict == Verdict::Fails)
        .map(|c| c.id)
        .collect()
}

#[test]
fn every_short_period_claim_holds_on_the_machine() {
    let plan = plan(&[NORMAL, FTC_GAIN_LOST, TVC_SLOW, TVC_FAST]);
    let started = std::time::Instant::now();
    let claims = judged(&plan, &Patches::shipped());
    println!(
        "{} runs in {:?}",
        plan.pitch.len() + plan.yaw_roll.len(),
        started.elapsed()
    );
    assert_eq!(claims.len(), 10);
    for claim in &claims {
        assert!(claim.holds(), "{claim}");
    }
}

/// Greatest difference of a channel over its greatest value.
fn worst<const N: usize>(a: &Response<N>, b: &Response<N>, channel: usize) -> f64 {
    let pairs = || a.channel(channel).iter().zip(b.channel(channel));
    let scale = pairs().fold(0.0_f64, |s, (x, y)| s.max(x.abs()).max(y.abs()));
    let difference = pairs().fold(0.0_f64, |d, (x, y)| d.max((x - y).abs()));
    if difference == 0.0 {
        0.0
    } else {
        difference / scale
    }
}

#[test]
fn the_machine_follows_the_second_formulation_run_by_run() {
    let plan = plan(&[NORMAL, FTC_GAIN_LOST]);
    let answers = answers(&plan, &Patches::shipped());
    assert!(answers.remarks.is_empty(), "{:?}", answers.remarks);
    let (pitch, yaw_roll) = reference::answer(&plan, 5e-4);
    let mut greatest = (0.0, String::new());
    let mut compare = |what: String, difference: f64| {
        if difference > greatest.0 {
            greatest = (difference, what);
        }
    };
    for (n, (a, b)) in answers.pitch.iter().zip(&pitch).enumerate() {
        assert_eq!(a.len(), b.len());
        for c in 0..10 {
            compare(format!("pitch run {n}, channel {c}"), worst(a, b, c));
        }
    }
    for (n, (a, b)) in answers.yaw_roll.iter().zip(&yaw_roll).enumerate() {
        assert_eq!(a.len(), b.len());
        for c in 0..12 {
            compare(format!("yaw-roll run {n}, channel {c}"), worst(a, b, c));
        }
    }
    println!(
        "greatest difference {:e} of full range: {}",
        greatest.0, greatest.1
    );
    assert!(greatest.0 < 1e-2, "{greatest:?}");
}
