//! The linear model of a patch against derivatives and transfer functions in closed form.

use crate::bench::{Bench, close, tick};
use analog_proc::patch::{bundle_from_path, compile};
use engine::{fault::RunFault, linear::Linear};
use nalgebra::Complex;
use std::path::Path;

fn linear(bench: &Bench, inputs: &[&str], outputs: &[&str]) -> Result<Linear, RunFault> {
    let nets = |names: &[&str]| names.iter().map(|name| bench.id(name)).collect::<Vec<_>>();
    bench.simulation.linearise(&nets(inputs), &nets(outputs))
}

/// The rate servo from its gust to what its gyro feels, by block algebra.
fn felt_of_gust(omega: f64) -> Complex<f64> {
    let s = Complex::new(0.0, omega);
    let real = |x: f64| Complex::new(x, 0.0);
    let gyro = real(150.0 * 150.0) / (s * s + s * (1.4 * 150.0) + 150.0 * 150.0);
    let actuator = real(20.0) / (s + 20.0);
    let fin = gyro * actuator * 0.4;
    let mode = s * 40.0 / (s * s + s * (0.01 * 25.0) + 625.0);
    real(1.0) / (s * (real(1.0) + fin * 8.0 / s + fin * mode * 0.02))
}

#[test]
fn the_shipped_servo_has_the_response_of_its_transfer_function() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../patch-files/rate-servo.toml"));
    let mut bench = Bench::of(compile(&bundle_from_path(path).unwrap(), &[]).unwrap());
    // At rest, and where it swings within its limits: it is linear there.
    for until_s in [0.0, 1.9] {
        bench.simulation.advance_to(tick(until_s)).unwrap();
        let model = linear(&bench, &["gust"], &["felt"]).unwrap();
        for step in 0..=400 {
            let omega = 0.1 * 10f64.powf(f64::from(step) / 100.0);
            let (found, truth) = (model.response(0, 0, omega), felt_of_gust(omega));
            assert!((found - truth).norm() < 1e-10 * truth.norm(), "{omega}: {found} {truth}");
        }
    }
    // Opened at the actuator's command: the loop's own transfer function.
    let open = linear(&bench, &["demand"], &["demand"]).unwrap();
    assert_eq!(open.d[(0, 0)], 1.0, "an input is what it is");
    let through = linear(&bench, &["demand"], &["fin.position"]).unwrap().response(0, 0, 5.0);
    let truth = Complex::new(20.0, 0.0) / Complex::new(20.0, 5.0);
    assert!((through - truth).norm() < 1e-12);
}

#[test]
fn every_operation_has_its_derivative() {
    let bench = Bench::new(
        r#"
        x = { kind = "integrator", in = ["y"], ic = 0.7 }
        y = { kind = "integrator", in = ["-1 * x"], ic = -0.4 }
        product = { kind = "multiplier", in = ["2 * x", "y"] }
        quotient = { kind = "divider", in = ["x", "3 * y"] }
        root = { kind = "square-root", in = ["x"] }
        sine = { kind = "sine", in = ["3 * x", "y"] }
        angle = { kind = "arctangent", in = ["y", "-1 * x"] }
        within = { kind = "limiter", in = ["x"], limit = 0.8 }
        beyond = { kind = "limiter", in = ["2 * x"], limit = 0.8 }
        dead = { kind = "dead-zone", in = ["y"], width = 0.1 }
        t = { kind = "time" }
        timed = { kind = "multiplier", in = ["x", "t"] }
        wave = { kind = "signal-generator", wave = "sine", amplitude = 1.0, frequency = 1e6 }
        "#,
    );
    let names = [
        "product", "quotient", "root", "sine", "angle", "within", "beyond", "dead", "timed", "wave",
    ];
    let model = linear(&bench, &[], &names).unwrap();
    let (x, y) = (0.7_f64, -0.4_f64);
    let slope = (3.0 * x + y).cos();
    let square = x * x + y * y;
    let truth = [
        (2.0 * y, 2.0 * x),
        (1.0 / (3.0 * y), -x / (3.0 * y * y)),
        (0.5 / x.sqrt(), 0.0),
        (3.0 * slope, slope),
        (y / square, -x / square),
        (1.0, 0.0),
        (0.0, 0.0),
        (0.0, 1.0),
        (0.0, 0.0),
        (0.0, 0.0),
    ];
    for ((i, name), (by_x, by_y)) in names.iter().enumerate().zip(truth) {
        for (found, truth) in [(model.c[(i, 0)], by_x), (model.c[(i, 1)], by_y)] {
            assert!((found - truth).abs() <= 1e-14 * truth.abs(), "{name}: {found} for {truth}");
        }
    }
    assert_eq!(model.a.as_slice(), [0.0, -1.0, 1.0, 0.0], "column by column");
    let roots = model.roots();
    close(roots[0].im, 1.0, 1e-15, "the oscillator's root");
}

#[test]
fn what_has_no_linear_model_is_refused_by_name() {
    let delayed = Bench::new(
        r#"
        x = { kind = "integrator", in = ["-1 * late"], ic = 1.0 }
        late = { kind = "transport-delay", in = ["x"], delay = 0.1 }
        "#,
    );
    let fault = linear(&delayed, &[], &[]).unwrap_err();
    assert!(matches!(&fault, RunFault::Delayed { block } if block == "late"), "{fault}");
    // Opened behind the delay there is nothing to refuse.
    assert!(linear(&delayed, &["late"], &["x"]).is_ok());
    for (kind, inputs) in [("square-root", r#""x""#), ("arctangent", r#""x", "2 * x""#)] {
        let at_zero = Bench::new(&format!(
            "x = {{ kind = \"integrator\", in = [\"one\"] }}\none = {{ kind = \"constant\", value = 1.0 }}\nroot = {{ kind = \"{kind}\", in = [{inputs}] }}\ny = {{ kind = \"integrator\", in = [\"root\"] }}"
        ));
        let fault = linear(&at_zero, &[], &[]).unwrap_err();
        assert!(
            matches!(&fault, RunFault::NoSlope { block, .. } if block == "y"),
            "{kind}: {fault}"
        );
    }
}

/// Units may be far apart, and integrators stand in series: neither costs a digit.
#[test]
fn roots_are_those_of_the_patch_whatever_its_units() {
    // (s+1)(s+2)(s+3) + 4 = 0 with the loop gain in two factors of 5e17 and 1e-17.
    let bench = Bench::new(
        r#"
        n = { kind = "integrator", in = ["-5e17 * t", "-1 * n"] }
        t = { kind = "integrator", in = ["1e-17 * p", "-2 * t"] }
        p = { kind = "integrator", in = ["0.8 * n", "-3 * p"] }
        w = { kind = "integrator", in = ["v"] }
        v = { kind = "integrator", in = ["n"] }
        "#,
    );
    let roots = linear(&bench, &[], &[]).unwrap().roots();
    assert_eq!((roots[0], roots[1]), (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0)));
    for s in &roots[2..] {
        let left = (s + 1.0) * (s + 2.0) * (s + 3.0) + 4.0;
        assert!(left.norm() < 1e-12, "{s}: {left}");
    }
    let empty = Bench::new(
        r#"
        a = { kind = "constant", value = 3.0 }
        square = { kind = "square", in = ["a"] }
        "#,
    );
    let model = linear(&empty, &["a"], &["square"]).unwrap();
    assert_eq!(model.response(0, 0, 1.0), Complex::new(6.0, 0.0));
}

#[test]
fn a_corner_has_two_slopes_and_is_refused() {
    let mut bench = Bench::new(
        r#"
        one = { kind = "constant", value = 1.0 }
        y = { kind = "integrator", in = ["one", "f"], ic = 0.0 }
        f = { kind = "function", in = ["y"], x = [-1, 0, 1], y = [-3, 0, -1] }
        "#,
    );
    let fault = linear(&bench, &[], &[]).unwrap_err();
    assert!(matches!(&fault, RunFault::OnCorner { block, .. } if block == "f"), "{fault}");
    bench.run(1e-6);
    assert_eq!(linear(&bench, &[], &[]).unwrap().a[(0, 0)], -1.0);
}
