//! Arctangents of vectors that turn, also quickly and close to their origin.

use crate::TAU;
use crate::bench::{Bench, tick};
use crate::roots::bisect;
use engine::fault::RunFault;
use std::f64::consts::PI;

/// In (−π, π], and right where it is not within a rounding of the jump.
fn right(found: f64, y: f64, x: f64, what: &str) {
    assert!(found > -PI - 1e-9 && found <= PI + 1e-9, "{what}: {found}");
    let truth = y.atan2(x);
    let error = (found - truth).abs();
    assert!(error < 1e-6 || (TAU - error).abs() < 1e-6, "{what}: {found} instead of {truth}");
}

#[test]
fn a_turning_vector_stays_within_half_a_turn() {
    for frequency in [0.3, 7.0, 150.0] {
        let mut bench = Bench::new(&format!(
            "t = {{ kind = \"time\" }}\ns = {{ kind = \"sine\", in = [\"{w:?} * t\"] }}\nc = {{ kind = \"cosine\", in = [\"{w:?} * t\"] }}\nangle = {{ kind = \"arctangent\", in = [\"s\", \"c\"] }}\nx = {{ kind = \"integrator\", in = [\"angle\"] }}\nlevel = {{ kind = \"comparator\", in = [\"angle\"], threshold = 3.0 }}\nn = {{ kind = \"counter\", in = [\"level\"] }}",
            w = TAU * frequency
        ));
        let angle = bench.id("angle");
        bench
            .simulation
            .advance_recording(tick(4.1), tick(0.000_7), &[angle], |t, row| {
                let turn = TAU * frequency * t;
                right(row[0], turn.sin(), turn.cos(), &format!("{frequency} Hz at {t} s"));
            })
            .unwrap();
        let turns = (frequency * 4.1).floor();
        let rest = TAU * (frequency * 4.1 - turns);
        assert_eq!(bench.net("n"), turns + f64::from(rest > 3.0), "{frequency} Hz");
        let over = |a: f64| {
            if a <= PI { 0.5 * a * a } else { 0.5 * PI * PI + 0.5 * ((a - TAU).powi(2) - PI * PI) }
        };
        let truth = over(rest) / (TAU * frequency);
        let found = bench.net("x");
        assert!((found - truth).abs() < 1e-7, "{found} instead of {truth}");
    }
}

#[test]
fn a_vector_passes_near_the_origin() {
    // (t − 1, h): from π to 0 within some h seconds.
    for h in [1e-1, 1e-3, 1e-6] {
        for (side, sign) in [("", 1.0), ("-", -1.0)] {
            let mut bench = Bench::new(&format!(
                "one = {{ kind = \"constant\", value = 1.0 }}\nx = {{ kind = \"integrator\", in = [\"one\"], ic = -1.0 }}\nangle = {{ kind = \"arctangent\", in = [\"{side}{h:?} * one\", \"x\"] }}\narea = {{ kind = \"integrator\", in = [\"angle\"] }}\np = {{ kind = \"comparator\", in = [\"angle\"], threshold = {level:?} }}\nline = {{ kind = \"interrupt\", in = [\"p\"], line = 1 }}",
                level = 0.5 * sign
            ));
            bench.run(1.7);
            right(bench.net("angle"), sign * h, 0.7, "angle");
            // ∫ atan2(h, u) du = u atan2(h, u) + h/2 ln(u² + h²).
            let part = |u: f64| u * h.atan2(u) + 0.5 * h * (u * u + h * h).ln();
            let truth = sign * (part(0.7) - part(-1.0));
            let found = bench.net("area");
            assert!(
                (found - truth).abs() < 1e-8 * truth.abs(),
                "h = {h}: {found} instead of {truth}"
            );
            let passed = 1.0 + bisect(|u| 0.5 - h.atan2(u), -1.0, 0.7);
            let edges = bench.edges(1, sign < 0.0);
            assert_eq!(edges.len(), 1, "h = {h}");
            assert!((edges[0] - passed).abs() < 1e-9, "h = {h}: {edges:?}, {passed}");
        }
    }
}

#[test]
fn an_ellipse_that_all_but_touches_the_origin_turns_once_a_period() {
    // (1.001 cos − 1, 0.05 sin): the centre lies 0.001 outside the origin, which is circled once a turn.
    let mut bench = Bench::new(
        r#"
        s = { kind = "signal-generator", wave = "sine", phase = 0.3 }
        c = { kind = "signal-generator", wave = "sine", phase = 1.8707963267948966 }
        one = { kind = "constant", value = 1.0 }
        u = { kind = "summer", in = ["1.001 * c", "-1 * one"] }
        v = { kind = "gain", in = ["s"], k = 0.05 }
        angle = { kind = "arctangent", in = ["v", "u"] }
        p = { kind = "comparator", in = ["angle"] }
        n = { kind = "counter", in = ["p"] }
        small = { kind = "comparator", in = ["u"] }
        m = { kind = "counter", in = ["small"] }
    "#,
    );
    let angle = bench.id("angle");
    bench
        .simulation
        .advance_recording(tick(100.0), tick(0.0017), &[angle], |t, row| {
            let a = TAU * t + 0.3;
            right(row[0], 0.05 * a.sin(), 1.001 * a.cos() - 1.0, &format!("at {t} s"));
        })
        .unwrap();
    // The upper half is entered once a turn, and u is positive about each turn's start.
    assert_eq!(bench.net("n"), 100.0);
    assert_eq!(bench.net("m"), 100.0);
}

#[test]
fn a_vector_that_leaves_the_origin_has_its_direction_at_once() {
    // Both components start at rest and grow from 0.82 s on; before, the angle is zero.
    let blocks = r#"
        v = { kind = "signal-generator", wave = "ramp", amplitude = -1.3, start = 0.82 }
        angle = { kind = "arctangent", in = ["-1 * v", "-1 * v"] }
        area = { kind = "integrator", in = ["angle"] }
    "#;
    for integration in ["", "method = \"runge-kutta-4\"\nstep = 0.01", "method = \"sdirk4\""] {
        let mut bench = Bench::with(integration, blocks);
        bench.run(2.1);
        let error = (bench.net("area") - PI / 4.0 * (2.1 - 0.82)).abs();
        assert!(error < 1e-12, "{integration}: {error:e}");
    }
}

/// All methods; what happens does so between their fixed steps.
const METHODS: [&str; 4] = [
    "",
    "method = \"sdirk4\"",
    "method = \"runge-kutta-4\"\nstep = 0.01",
    "method = \"euler\"\nstep = 0.01",
];

#[test]
fn an_angle_jumps_where_its_vector_passes_through_the_origin() {
    let t0_s = 0.731_23;
    // Inputs of the arctangent, with the angles before and after; `u` goes through zero at 0.73123 s.
    let fourth = 0.5_f64.atan();
    for (y, x, before, after) in [
        ("u", "2 * u", fourth - PI, fourth),
        ("-1 * u", "-2 * u", fourth, fourth - PI),
        ("u", "-2 * u", -fourth, PI - fourth),
        ("u", "zero", -PI / 2.0, PI / 2.0),
        ("-1 * u", "-1 * zero", PI / 2.0, -PI / 2.0),
        ("zero", "u", PI, 0.0),
        ("-1 * zero", "u", PI, 0.0),
        ("zero", "-1 * u", 0.0, PI),
        ("w", "w", PI / 4.0 - PI, PI / 4.0),
    ] {
        for integration in METHODS {
            let mut bench = Bench::with(
                integration,
                &format!(
                    r#"
                    one = {{ kind = "constant", value = 1.0 }}
                    zero = {{ kind = "constant", value = 0.0 }}
                    u = {{ kind = "integrator", in = ["one"], ic = {:?} }}
                    w = {{ kind = "sine", in = ["u"] }}
                    angle = {{ kind = "arctangent", in = ["{y}", "{x}"] }}
                    area = {{ kind = "integrator", in = ["angle"] }}
                    p = {{ kind = "comparator", in = ["angle"], threshold = 0.1 }}
                    c = {{ kind = "counter", in = ["p"] }}
                    "#,
                    -t0_s
                ),
            );
            let what = format!("{integration} atan2({y}, {x})");
            bench.run(2.0);
            let truth = t0_s * before + (2.0 - t0_s) * after;
            let error = (bench.net("area") - truth).abs();
            assert!(error < 1e-12, "{what}: {error:e}");
            assert_eq!(bench.net("c"), f64::from(after > 0.1), "{what}");
        }
    }
}

#[test]
fn a_vector_that_leaves_downward_has_its_angle_below() {
    // Where it starts, feedback tells its angle: atan(1/2) - π, for ever.
    let truth = |t: f64| (0.5_f64.atan() - PI - 1.0) * t + 0.1 * (26.0 * t).sin() / 26.0;
    for integration in ["", "method = \"sdirk4\"", "method = \"runge-kutta-4\"\nstep = 1e-3"] {
        let mut bench = Bench::with(
            integration,
            r#"
            one = { kind = "constant", value = 1.0 }
            t = { kind = "time" }
            c = { kind = "cosine", in = ["26 * t"] }
            u = { kind = "integrator", in = ["angle", "0.1 * c", "-1 * one"] }
            angle = { kind = "arctangent", in = ["u", "2 * u"] }
            "#,
        );
        let error = (bench.run(1.0).net("u") - truth(1.0)).abs();
        assert!(error < 1e-8, "{integration}: {error:e}");
    }
}

#[test]
fn a_vector_that_starts_from_rest_has_its_direction_at_once() {
    for integration in METHODS {
        let mut bench = Bench::with(
            integration,
            r#"
            one = { kind = "constant", value = 1.0 }
            v = { kind = "integrator", in = ["one"] }
            u = { kind = "integrator", in = ["v"] }
            angle = { kind = "arctangent", in = ["u", "-1 * u"] }
            area = { kind = "integrator", in = ["angle"] }
            "#,
        );
        let error = (bench.run(1.3).net("area") - 1.3 * 0.75 * PI).abs();
        assert!(error < 1e-12, "{integration}: {error:e}");
    }
}

#[test]
fn a_vector_that_is_held_at_its_origin_ends_the_run() {
    // Its angle, 0 or π, drives it back from either side from 0.5 s on.
    for integration in METHODS {
        let mut bench = Bench::with(
            integration,
            r#"
            one = { kind = "constant", value = 1.0 }
            zero = { kind = "constant", value = 0.0 }
            u = { kind = "integrator", in = ["angle", "-1 * one"], ic = 0.5 }
            angle = { kind = "arctangent", in = ["zero", "u"] }
            "#,
        );
        match bench.try_run(2.0) {
            Err(RunFault::Chatter { t_s, block, .. }) => {
                assert_eq!(block, "angle", "{integration}");
                assert!((t_s - 0.5).abs() < 1e-9, "{integration}: {t_s}");
            }
            other => panic!("{integration}: {other:?}"),
        }
    }
}

#[test]
fn a_divisor_that_is_zero_with_a_vector_ends_the_run() {
    for integration in METHODS {
        let mut bench = Bench::with(
            integration,
            r#"
            one = { kind = "constant", value = 1.0 }
            u = { kind = "integrator", in = ["one"], ic = -0.31 }
            angle = { kind = "arctangent", in = ["u", "2 * u"] }
            q = { kind = "divider", in = ["one", "u"] }
            "#,
        );
        match bench.try_run(2.0) {
            Err(RunFault::DividedByZero { t_s, block }) => {
                assert_eq!(block, "q", "{integration}");
                assert!((t_s - 0.31).abs() < 1e-12, "{integration}: {t_s}");
            }
            other => panic!("{integration}: {other:?}"),
        }
    }
}

#[test]
fn logic_sees_the_angle_to_which_a_vector_leaves_its_origin() {
    // (0, y): y = t, |u| or max(u, −u) leaves zero upward, from the start or after it came down to
    // it at 1 s; the angle is never another than a quarter turn. y = u itself jumps once.
    for (y, from, rises) in [
        ("t", 0.0, 0.0),
        ("u", 0.0, 0.0),
        ("u", -1.0, 1.0),
        ("a", 0.0, 0.0),
        ("a", -1.0, 0.0),
        ("m", 0.0, 0.0),
        ("m", -1.0, 0.0),
    ] {
        let mut bench = Bench::new(&format!(
            r#"one = {{ kind = "constant", value = 1.0 }}
zero = {{ kind = "constant", value = 0.0 }}
t = {{ kind = "time" }}
u = {{ kind = "integrator", in = ["one"], ic = {from:?} }}
a = {{ kind = "abs", in = ["u"] }}
m = {{ kind = "max", in = ["u", "-1.0 * u"] }}
angle = {{ kind = "arctangent", in = ["{y}", "zero"] }}
up = {{ kind = "comparator", in = ["angle"], threshold = 0.5 }}
rises = {{ kind = "counter", in = ["up"] }}
down = {{ kind = "comparator", in = ["-1.0 * angle"], threshold = 0.5 }}
falls = {{ kind = "counter", in = ["down"] }}"#
        ));
        bench.run(1.5);
        assert_eq!(bench.net("rises"), rises, "{y} from {from}");
        assert_eq!(bench.net("falls"), 0.0, "{y} from {from}");
        assert_eq!(bench.net("angle"), 0.5 * PI, "{y} from {from}");
    }
}
