//! Signals of any size integrate as well as those of one.

use crate::bench::{Bench, ordered};
use crate::{TAU, close};

#[test]
fn oscillators_of_any_amplitude_keep_seven_digits() {
    for exponent in -15..=15 {
        let amplitude = 10.0_f64.powi(exponent);
        let mut bench = Bench::new(&format!(
            "x = {{ kind = \"integrator\", in = [\"{TAU:?} * v\"], ic = {amplitude:e} }}\nv = {{ kind = \"integrator\", in = [\"-{TAU:?} * x\"] }}"
        ));
        let worst = bench.worst("x", 10.0, 1e-2, |t| amplitude * (TAU * t).cos());
        assert!(
            worst.0 <= 1e-7 * amplitude,
            "amplitude 1e{exponent}: {:e} of it at {} s",
            worst.0 / amplitude,
            worst.1
        );
    }
}

#[test]
fn a_small_signal_beside_a_large_one_keeps_seven_digits() {
    // Driven at 1e-9 from nothing, next to an oscillator of 1e3.
    let mut bench = Bench::new(&format!(
        "x = {{ kind = \"integrator\", in = [\"{TAU:?} * v\"], ic = 1e3 }}\nv = {{ kind = \"integrator\", in = [\"-{TAU:?} * x\"] }}\ny = {{ kind = \"integrator\", in = [\"1e-12 * x\"] }}"
    ));
    let worst = bench.worst("y", 10.0, 1e-2, |t| 1e-9 * (TAU * t).sin() / TAU);
    assert!(worst.0 <= 1e-7 * 1e-9 / TAU, "{:e} at {} s", worst.0, worst.1);
}

#[test]
fn a_decay_is_right_to_a_trillionth_of_its_start() {
    // Errors are measured against the largest value that the state has had.
    let mut bench = Bench::new("x = { kind = \"integrator\", in = [\"-x\"], ic = 1.0 }");
    for t_s in [20.0_f64, 30.0] {
        let found = bench.run(t_s).net("x");
        assert!((found - (-t_s).exp()).abs() <= 1e-12, "{found} at {t_s} s");
    }
}

#[test]
fn a_decay_without_absolute_tolerance_keeps_eight_digits() {
    let text = "[blocks]\nx = { kind = \"integrator\", in = [\"-x\"], ic = 1.0 }\n";
    let mut ordered = ordered(text).unwrap();
    ordered.netlist.integration.atol = 0.0;
    let mut bench = Bench::of(ordered);
    for t_s in [20.0_f64, 30.0, 60.0] {
        close(bench.run(t_s).net("x"), (-t_s).exp(), 1e-8, "decay");
    }
}
