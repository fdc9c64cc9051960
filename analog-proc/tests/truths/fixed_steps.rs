//! Fixed steps that do not resolve their signals end with a remark; those that do, without.

use crate::bench::Bench;
use engine::remark::Remark;

/// The error told of by the remark on `block`, if there is one; no other is made.
fn told(bench: &Bench, block: &str) -> Option<f64> {
    let remarks = bench.simulation.remarks();
    assert!(remarks.len() <= 1, "{remarks:?}");
    match remarks.first() {
        None => None,
        Some(Remark::Coarse { block: found, error, .. }) => {
            assert_eq!(found, block);
            Some(*error)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_pulse_narrower_than_the_steps_is_told_of() {
    // ∫ 1/(1 + u²) du over a pulse of a millisecond, as a quotient and as powers of a cosine, whose
    // 256th has the area C(256, 128)/2^256.
    let quotient = r#"
        u = { kind = "summer", in = ["1000 * t", "-501.7 * one"] }
        square = { kind = "square", in = ["u"] }
        sum = { kind = "summer", in = ["one", "square"] }
        p = { kind = "divider", in = ["1000 * one", "sum"] }
    "#;
    let bend = r#"
        u = { kind = "summer", in = ["t", "-0.5017 * one"] }
        turn = { kind = "gain", in = ["u"], k = 200 }
        square = { kind = "square", in = ["turn"] }
        sum = { kind = "summer", in = ["one", "square"] }
        p = { kind = "divider", in = ["200 * one", "sum"] }
    "#;
    let area = |rate: f64| (0.4983 * rate).atan() + (0.5017 * rate).atan();
    for (pulse, truth, method, step_s) in [
        (quotient, area(1000.0), "runge-kutta-4", 0.01),
        (quotient, area(1000.0), "euler", 0.01),
        (bend, area(200.0), "runge-kutta-4", 0.02),
    ] {
        let blocks = format!(
            "one = {{ kind = \"constant\", value = 1.0 }}\nt = {{ kind = \"time\" }}\nx = {{ kind = \"integrator\", in = [\"p\"] }}\n{pulse}"
        );
        let run = |method: &str, step_s: f64| {
            let mut bench =
                Bench::with(&format!("method = \"{method}\"\nstep = {step_s:?}"), &blocks);
            bench.run(1.0);
            bench
        };
        let bench = run(method, step_s);
        let error = (bench.net("x") - truth).abs();
        assert!(error > 5e-3 * truth, "{method}: {error:e} is no example");
        let found = told(&bench, "x");
        let found = found.unwrap_or_else(|| panic!("{method}: silent at an error of {error:e}"));
        assert!(found > 0.05 * error && found < 20.0 * error, "{method}: {found:e}, {error:e}");
        // Steps of a fiftieth of the pulse.
        let bench = run("runge-kutta-4", 2e-5);
        assert_eq!(told(&bench, "x"), None);
        assert!((bench.net("x") - truth).abs() < 1e-6 * truth);
    }
}

#[test]
fn steps_that_resolve_an_oscillation_are_silent() {
    // Ten turns of a radian a second. Runge and Kutta's error grows by h⁴/120 a radian, Euler's
    // by h/2.
    for (method, step_s, is_told) in [
        ("runge-kutta-4", 1e-3, false),
        ("runge-kutta-4", 0.1, false),
        ("runge-kutta-4", 1.0, true),
        ("euler", 1e-5, false),
        ("euler", 1e-2, true),
        ("dormand-prince", 1.0, false),
        ("sdirk4", 1.0, false),
    ] {
        let mut bench = Bench::with(
            &format!("method = \"{method}\"\nstep = {step_s:?}"),
            r#"
            x = { kind = "integrator", in = ["v"] }
            v = { kind = "integrator", in = ["-1 * x"], ic = 1.0 }
            "#,
        );
        bench.run(20.0 * std::f64::consts::PI);
        let remarks = bench.simulation.remarks();
        assert_eq!(!remarks.is_empty(), is_told, "{method}, {step_s} s: {remarks:?}");
    }
}

#[test]
fn what_jumps_between_steps_is_no_error_of_theirs() {
    // Every edge of the square ends a step; its integral is a triangle, without error.
    for method in ["runge-kutta-4", "euler"] {
        let mut bench = Bench::with(
            &format!("method = \"{method}\"\nstep = 0.01"),
            r#"
            s = { kind = "signal-generator", wave = "square", frequency = 3.7 }
            x = { kind = "integrator", in = ["s"] }
            size = { kind = "abs", in = ["x"] }
            y = { kind = "integrator", in = ["s", "-1 * y"] }
            "#,
        );
        bench.run(10.0);
        let remarks = bench.simulation.remarks();
        assert_eq!(remarks.is_empty(), method != "euler", "{method}: {remarks:?}");
    }
}
