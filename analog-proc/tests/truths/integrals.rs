//! Integrals of what is not zero for short moments only.

use crate::bench::Bench;
use crate::roots::{bisect, integral};
use crate::{TAU, close};

const SINE_OF_TIME: &str = "t = { kind = \"time\" }\ns = { kind = \"sine\", in = [\"6.283185307179586 * t\"] }\none = { kind = \"constant\", value = 1.0 }\nzero = { kind = \"constant\" , value = 0.0 }\n";

fn run(blocks: &str, until_s: f64) -> f64 {
    Bench::new(&format!("{SINE_OF_TIME}{blocks}")).run(until_s).net("x")
}

#[test]
fn limiter_of_a_sixteenth_power() {
    let blocks = r#"
        g = { kind = "signal-generator", wave = "sine", phase = 0.3 }
        g2 = { kind = "square", in = ["g"] }
        g4 = { kind = "square", in = ["g2"] }
        g8 = { kind = "square", in = ["g4"] }
        g16 = { kind = "square", in = ["g8"] }
        one = { kind = "constant", value = 1.0 }
        y = { kind = "limiter", in = ["g16", "-0.9 * one"], limits = [0, 1] }
        x = { kind = "integrator", in = ["y"] }
    "#;
    let found = Bench::new(blocks).run(1000.0).net("x");
    // Two thousand bumps between the angles at which the power is 0.9.
    let edge = 0.9_f64.powf(1.0 / 16.0).asin();
    let bump = integral(|a| a.sin().powi(16) - 0.9, edge, std::f64::consts::PI - edge, 8);
    // A step errs by 1e-10 of the value: some ten steps a bump, were all to err alike.
    close(found, 2000.0 * bump / TAU, 1e-7, "integral");
}

#[test]
fn switch_closed_for_a_seventieth_of_the_time() {
    let blocks = r#"
        g = { kind = "signal-generator", wave = "sine", phase = 0.3 }
        one = { kind = "constant", value = 1.0 }
        zero = { kind = "constant", value = 0.0 }
        p = { kind = "comparator", in = ["g"], threshold = 0.999 }
        y = { kind = "switch", in = ["one", "zero"], control = "p" }
        x = { kind = "integrator", in = ["y"] }
    "#;
    let found = Bench::new(blocks).run(100.0).net("x");
    close(found, 100.0 * 2.0 * 0.999_f64.acos() / TAU, 1e-8, "integral");
}

/// ∫ (sin a − 0.9) da over the moment in which it is positive.
fn bump() -> f64 {
    let edge = 0.9_f64.asin();
    2.0 * edge.cos() - 0.9 * (std::f64::consts::PI - 2.0 * edge)
}

#[test]
fn rectified_sine_of_time() {
    let blocks = "y = { kind = \"limiter\", in = [\"s\", \"-0.9 * one\"], limits = [0, 1] }\nx = { kind = \"integrator\", in = [\"y\"] }";
    close(run(blocks, 10.0), 10.0 * bump() / TAU, 1e-8, "integral");
}

#[test]
fn integrator_leaves_its_stop_once_a_period() {
    let blocks = "y = { kind = \"integrator\", in = [\"s\", \"-0.9 * one\"], limits = [0, 1] }\nx = { kind = \"integrator\", in = [\"y\"] }";
    // In angle: off the stop at asin 0.9, y = (cos e − cos a − 0.9 (a − e)) / 2π until it is zero again.
    let edge = 0.9_f64.asin();
    let y = |a: f64| (edge.cos() - a.cos() - 0.9 * (a - edge)) / TAU;
    let back = bisect(|a| -y(a), std::f64::consts::PI - edge, 4.0);
    let area = integral(y, edge, back, 16) / TAU;
    close(run(blocks, 10.0), 10.0 * area, 1e-8, "integral off the stop");
}

#[test]
fn gated_integrator_runs_for_a_third_of_the_time() {
    let blocks = "p = { kind = \"comparator\", in = [\"s\"], threshold = 0.5 }\nx = { kind = \"integrator\", in = [\"one\"], operate = \"p\" }";
    close(run(blocks, 100.0), 100.0 / 3.0, 1e-8, "gated time");
    // At 0.9999 the gate is open for 4.5 ms a second.
    let blocks = blocks.replace("0.5", "0.9999");
    close(run(&blocks, 100.0), 100.0 * 2.0 * 0.9999_f64.acos() / TAU, 1e-8, "gated time");
}

#[test]
fn extremes_and_dead_zones_of_a_sine_of_time() {
    // max(s, 0.95) and the dead zone's tip: both only for the moments above 0.95.
    let edge = 0.95_f64.asin();
    let width = std::f64::consts::PI - 2.0 * edge;
    let tip = (2.0 * edge.cos() - 0.95 * width) / TAU;
    let blocks = "level = { kind = \"constant\", value = 0.95 }\ny = { kind = \"max\", in = [\"s\", \"level\"] }\nx = { kind = \"integrator\", in = [\"y\"] }";
    close(run(blocks, 10.0), 9.5 + 10.0 * tip, 1e-8, "greater of two");
    let blocks = "y = { kind = \"dead-zone\", in = [\"s\"], width = 0.95 }\nz = { kind = \"abs\", in = [\"y\"] }\nx = { kind = \"integrator\", in = [\"z\"] }";
    close(run(blocks, 10.0), 20.0 * tip, 1e-8, "dead zone");
    let blocks = "y = { kind = \"function\", in = [\"s\"], x = [-1, 0.95, 1], y = [0, 0, 1] }\nx = { kind = \"integrator\", in = [\"y\"] }";
    close(run(blocks, 10.0), 10.0 * tip / 0.05, 1e-8, "function");
    let blocks = "y = { kind = \"relay\", in = [\"s\"], points = [0.9, 0.95], outputs = [0, 1] }\nx = { kind = \"integrator\", in = [\"y\"] }";
    // On from rising through 0.95 to falling through 0.9.
    let on = std::f64::consts::PI - 0.9_f64.asin() - edge;
    close(run(blocks, 10.0), 10.0 * on / TAU, 1e-8, "relay");
}

#[test]
fn track_and_store_keep_the_value_of_the_instant() {
    // Tracks while the sine is above 0.999, keeps the 0.999 at which it ended.
    let blocks = "p = { kind = \"comparator\", in = [\"s\"], threshold = 0.999 }\ny = { kind = \"track-store\", in = [\"s\"], track = \"p\" }\nx = { kind = \"integrator\", in = [\"y\"] }";
    let edge = 0.999_f64.asin();
    let width = std::f64::consts::PI - 2.0 * edge;
    // One period: tracked, 0.999 otherwise; before the first, zero.
    let tracked = 2.0 * edge.cos() / TAU;
    let stored = 0.999 * (1.0 - width / TAU);
    let first = 0.999 * (edge / TAU);
    // Ten seconds end on a stored stretch and lack the first one.
    let truth = 10.0 * (tracked + stored) - first;
    close(run(blocks, 10.0), truth, 1e-8, "stored");
}
