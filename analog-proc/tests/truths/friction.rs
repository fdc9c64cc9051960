//! Dry friction under forces that barely exceed it, and a relay loop with dither.

use crate::bench::Bench;
use crate::roots::bisect;
use crate::{TAU, close};

/// Path of a unit mass on a level of one under `force` (period 1 s, odd about its half), 10 s.
fn path(amplitude: f64) -> f64 {
    // Breaks away at asin(1/A), slides until its speed is zero; then the force is below the level.
    let start = (1.0 / amplitude).asin();
    let speed = |a: f64| (amplitude * (start.cos() - a.cos()) - (a - start)) / TAU;
    let rest = bisect(|a| -speed(a), std::f64::consts::PI - start, 4.0);
    let covered = (amplitude * (start.cos() * (rest - start) - (rest.sin() - start.sin()))
        - 0.5 * (rest - start).powi(2))
        / (TAU * TAU);
    20.0 * covered
}

fn mass(force: &str) -> f64 {
    let mut bench = Bench::new(&format!(
        r#"
        {force}
        drag = {{ kind = "dry-friction", in = ["v", "force"], level = 1.0 }}
        v = {{ kind = "integrator", in = ["force", "drag"] }}
        speed = {{ kind = "abs", in = ["v"] }}
        path = {{ kind = "integrator", in = ["speed"] }}
    "#
    ));
    bench.run(10.0).net("path")
}

#[test]
fn a_mass_breaks_away_for_moments() {
    for amplitude in [1.05, 1.0005] {
        let generator = format!(
            "force = {{ kind = \"signal-generator\", wave = \"sine\", amplitude = {amplitude:?} }}"
        );
        let time = format!(
            "t = {{ kind = \"time\" }}\ns = {{ kind = \"sine\", in = [\"{TAU:?} * t\"] }}\nforce = {{ kind = \"gain\", in = [\"s\"], k = {amplitude:?} }}"
        );
        let angle = format!(
            "w = {{ kind = \"constant\", value = {TAU:?} }}\nangle = {{ kind = \"integrator\", in = [\"w\"] }}\ns = {{ kind = \"sine\", in = [\"angle\"] }}\nforce = {{ kind = \"gain\", in = [\"s\"], k = {amplitude:?} }}"
        );
        // Breaking away at 1.0005 the speed is a difference of forces a two-thousandth of
        // their size; an angle adds an error of 1e-10 of 63 rad to its instants.
        for (force, relative) in [(generator, 1e-6), (time, 1e-6), (angle, 1e-5)] {
            close(mass(&force), path(amplitude), relative, &force);
        }
    }
    assert!((path(1.0005) - 5.7e-7).abs() < 1e-8 && (path(1.05) - 5.48e-3).abs() < 1e-5);
}

#[test]
fn a_relay_loop_is_linearised_by_its_dither() {
    // x' = −u, u = ±1 by a relay on x + 0.5 sin(2π·10 t) − 0.3 at ±0.1, from x = 1.
    for dither in [
        "t = { kind = \"time\" }\nd = { kind = \"sine\", in = [\"62.83185307179586 * t\"] }",
        "d = { kind = \"signal-generator\", wave = \"sine\", frequency = 10.0 }",
    ] {
        let mut bench = Bench::new(&format!(
            r#"
            {dither}
            one = {{ kind = "constant", value = 1.0 }}
            u = {{ kind = "relay", in = ["x", "0.5 * d", "-0.3 * one"], points = [-0.1, 0.1], outputs = [-1, 1] }}
            x = {{ kind = "integrator", in = ["-u"], ic = 1.0 }}
        "#
        ));
        // Between switchings x is a straight line, so each instant is a zero of a known function.
        let (mut t, mut x, mut u) = (0.0, 1.0, 1.0);
        while t < 5.0 {
            let e = |s: f64| u * (x - u * (s - t) + 0.5 * (10.0 * TAU * s).sin() - 0.3) + 0.1;
            // Sought in steps of a two-thousandth of a period.
            let mut to = t;
            while to < 5.0 && e(to + 5e-5) >= 0.0 {
                to += 5e-5;
            }
            let end = if to >= 5.0 { 5.0 } else { bisect(e, to, to + 5e-5).min(5.0) };
            x -= u * (end - t);
            t = end;
            u = -u;
        }
        close(bench.run(5.0).net("x"), x, 1e-7, dither);
    }
}
