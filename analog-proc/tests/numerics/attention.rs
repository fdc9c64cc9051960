//! What an attendant is asked and told, and that a recorded value is a number.

use crate::{Bench, oscillator, tick};
use engine::fault::RunFault;
use engine::simulation::{Pulse, Simulation};
use std::ops::ControlFlow;

/// Passes after which an attendant is asked, of a patch of up to four states.
const PASSES: u64 = 4096;

fn pulses(simulation: &mut Simulation, stop_s: f64) -> Vec<Pulse> {
    let mut pulses = Vec::new();
    simulation
        .advance_attended(tick(stop_s), &mut |pulse| {
            pulses.push(*pulse);
            ControlFlow::Continue(())
        })
        .unwrap();
    pulses
}

#[test]
fn an_attendant_is_asked_every_few_thousand_passes_and_alters_nothing() {
    for method in ["dormand-prince", "sdirk4", "runge-kutta-4"] {
        let (mut alone, mut attended) = (oscillator(method), oscillator(method));
        alone.run(1000.0);
        let pulses = pulses(&mut attended.simulation, 1000.0);
        assert_eq!(alone.simulation.statistics(), attended.simulation.statistics());
        for net in ["x", "v"] {
            assert_eq!(alone.net(net).to_bits(), attended.net(net).to_bits());
        }
        let passes: Vec<u64> = pulses.iter().map(|p| p.statistics.evaluations).collect();
        assert!(passes.len() > 5, "{method}: {}", passes.len());
        let gaps = passes.windows(2).map(|w| w[1] - w[0]);
        // Beyond them lies one step: of the implicit method with five stages of ten
        // iterations at most and a Jacobian of two columns, tried a few times.
        let all = std::iter::once(passes[0]).chain(gaps);
        assert!(all.clone().all(|n| (PASSES..PASSES + 300).contains(&n)), "{:?}", all.max());
        assert!(pulses.windows(2).all(|w| w[0].t_s < w[1].t_s));
    }
}

#[test]
fn an_attendant_ends_a_run_and_the_fault_stands() {
    let mut simulation = oscillator("dormand-prince").simulation;
    let mut asked = 0;
    let end = simulation.advance_attended(tick(1000.0), &mut |_| {
        asked += 1;
        if asked < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    let Err(RunFault::Halted { t_s }) = end else { panic!("{end:?}") };
    assert!(asked == 3 && t_s > 0.0 && t_s < 1000.0);
    assert_eq!(simulation.advance_to(tick(1000.0)), Err(RunFault::Halted { t_s }));
    simulation.reset().unwrap();
    simulation.advance_to(tick(1.0)).unwrap();
}

#[test]
fn a_sink_that_has_had_enough_ends_a_run_within_its_step() {
    // Without anything to integrate a step is as long as the whole run.
    let mut bench = Bench::new("c = { kind = \"constant\", value = 1.0 }");
    let net = bench.id("c");
    let mut rows = 0;
    let end = bench.simulation.advance_recording_attended(
        tick(1e6),
        tick(1e-6),
        &[net],
        &mut |_, _| {
            rows += 1;
            if rows < 10 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        },
        &mut |_| ControlFlow::Continue(()),
    );
    assert!(matches!(end, Err(RunFault::Halted { .. })) && rows == 10);
}

/// The median of step times fastest rate over a run.
fn step_rate(mut bench: Bench, stop_s: f64) -> f64 {
    let pulses = pulses(&mut bench.simulation, stop_s);
    let mut rates: Vec<f64> = pulses.iter().filter_map(|p| p.step_rate).collect();
    rates.sort_by(f64::total_cmp);
    rates[rates.len() / 2]
}

#[test]
fn the_step_rate_tells_stability_from_accuracy() {
    // A real pole at −1e5 that follows a slow one. The region of the method ends at −3.31
    // (Hairer and Wanner II, IV.2); the controller keeps the step about there.
    let stiff = Bench::new(
        r#"
        x = { kind = "integrator", in = ["-1e5 * x", "1e5 * y"], ic = 1.0 }
        y = { kind = "integrator", in = ["-1 * y", "one"] }
        one = { kind = "constant", value = 1.0 }
    "#,
    );
    let rate = step_rate(stiff, 1.0);
    assert!((2.8..3.5).contains(&rate), "{rate}");
    // Accuracy: rtol 1e-10 of an oscillation asks for ωh well below one.
    let rate = step_rate(oscillator("dormand-prince"), 1000.0);
    assert!(rate < 0.3, "{rate}");
    let pulses = pulses(&mut oscillator("sdirk4").simulation, 10.0);
    assert!(pulses.iter().all(|p| p.step_rate.is_none()));
}

#[test]
fn a_value_that_overflows_between_two_steps_is_a_fault() {
    // Both ends of the step are finite; their difference is not.
    let mut bench = Bench::new(
        r#"
        x = { kind = "integrator", in = ["slope"], ic = 1.7e308 }
        slope = { kind = "constant", value = -3.4e307 }
    "#,
    );
    let (x, mut rows) = (bench.id("x"), 0);
    let end = bench.simulation.advance_recording(tick(10.0), tick(1.0), &[x], |_, v| {
        assert!(v[0].is_finite());
        rows += 1;
    });
    let Err(RunFault::NonFinite { t_s, block, .. }) = end else {
        panic!("{end:?} after {rows} rows")
    };
    assert!(t_s > 0.0 && t_s < 10.0 && block == "x");
}
