//! The pitch test against an independent formulation's figures and against a beam of elements.

use super::*;
use crate::study::bending_moment::elements::{Elements, bend};
use crate::study::short_period::{
    claims::NORMAL,
    control_loop::Test,
    reference::{self, Grid},
    study_file::{SHIPPED_TEXT, Study},
};
use vehicle::{Vehicle, structure::TEN_STATIONS_M};

/// The disturbed pitch test of the sound vehicle at 32.5 s, with its beam's misalignment at 1.
fn pitch_test() -> (Plan, Case) {
    let text = SHIPPED_TEXT.replace("at = { event = \"max-q\" }", "at = { time-s = 32.5 }");
    let mut study = Study::from_toml("test.toml", &text).unwrap();
    study.conditions.retain(|c| c.name == NORMAL);
    let plan = Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap();
    let at = |c: &&Case| c.test == Test::Disturbed && plan.points[c.point].name == "max-q";
    let case = *plan.cases.iter().find(at).unwrap();
    (plan, case)
}

fn answer(case: &Case, sample_ms: usize) -> Response {
    let sample_s = sample_ms as f64 * 1e-3;
    let samples = 12_000 / sample_ms;
    reference::run(&case.settings, &Grid { samples, sample_s, steps: sample_ms })
}

fn greatest(plan: &Plan, case: &Case, response: &Response) -> BendingMoments<1> {
    moments(plan, case, response).unwrap().unwrap()
}

#[test]
fn the_pitch_test_has_the_moments_of_the_independent_formulation() {
    let (plan, case) = pitch_test();
    let found = greatest(&plan, &case, &answer(&case, 20));
    let whole = found.whole.greatest;
    assert!((whole.moment_nm / 81.0e3 - 1.0).abs() < 0.005, "{whole:?}");
    // Found at the multiples of 20 ms there, and between them here.
    assert!((whole.station_m - 12.1).abs() < 0.051, "{whole:?}");
    assert!((whole.time_s - 1.640).abs() < 0.01, "{whole:?}");
    let quasi_static = found.quasi_static.greatest;
    assert!((quasi_static.moment_nm / 72.3e3 - 1.0).abs() < 0.005, "{quasi_static:?}");
}

/// Cubics between samples of 20 ms, against samples of 1 ms: at every point of the study, in pitch
/// and yaw. Measured: 0.19 % at most, 0.04 % in the pitch test at the greatest dynamic pressure.
#[test]
fn samples_of_twenty_milliseconds_suffice() {
    let mut study = Study::shipped().unwrap();
    study.conditions.retain(|c| c.name == NORMAL);
    let plan = Plan::new(&study, &Vehicle::shipped().unwrap()).unwrap();
    for case in plan.cases.iter().filter(|c| c.test != Test::StepOnly) {
        let [coarse, fine] = [20, 1].map(|ms| greatest(&plan, case, &answer(case, ms)));
        let [coarse, fine] = [coarse, fine].map(|m| m.whole.greatest.moment_nm);
        assert!((coarse / fine - 1.0).abs() < 0.0025, "{:?}: {coarse} for {fine}", case.test);
    }
}

#[test]
fn an_answer_that_is_no_number_has_no_moment() {
    let (plan, case) = pitch_test();
    let mut response = answer(&case, 20);
    response.push([f64::NAN; 10]);
    assert_eq!(moments(&plan, &case, &response), Ok(None));
    assert_eq!(moments(&plan, &case, &Response::new(ControlLoop::Pitch, 0.02)), Ok(None));
}

/// Ours uses the shapes of a uniform beam, the elements those of this one; that, and no more, is
/// what lies between the two: 2.1 % was found independently, 2.5 % is allowed.
#[test]
fn a_beam_of_fifty_elements_bends_alike() {
    let (plan, case) = pitch_test();
    let beam = Elements::new();
    let frequency: Vec<f64> = beam.modes().iter().map(|(w2, _)| w2.max(0.0).sqrt()).collect();
    let first = frequency[2] / case.frozen.bending_frequency_radps;
    assert!(frequency[1] < 0.1 && (first - 1.0).abs() < 0.01, "{frequency:?}");
    // Ratios as found independently; ours are 2.757 and 5.404.
    let ratio = |i: usize| frequency[i] / frequency[2];
    assert!((2.46..2.79).contains(&ratio(3)) && (5.10..5.23).contains(&ratio(4)), "{frequency:?}");

    let response = answer(&case, 1);
    let [alpha, tips, tvc] = channels(ControlLoop::Pitch).map(|adc| response.of(adc));
    let loads: Vec<_> = (0..response.len()).map(|i| [alpha[i], tips[i], tvc[i], 1.0]).collect();
    let largest = bend(&beam, &loads, response.sample_s, 0);
    let ours: Vec<_> = greatest(&plan, &case, &answer(&case, 20)).whole.at_stations().collect();
    for (x, elements) in TEN_STATIONS_M.into_iter().zip(largest) {
        let ours = ours[plan.structure.nearest(x)].moment_nm;
        assert!((ours / elements - 1.0).abs() < 0.025, "{x} m: {ours} for {elements}");
    }
}
