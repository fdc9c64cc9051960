//! What a patch does never depends on the order of its lines.
//!
//! At an instant all stores look at the same values: those of before any of them switched.

use crate::bench::Bench;

/// Every order of `lines` after the common ones.
fn orders(lines: &[&str]) -> Vec<Vec<String>> {
    if lines.is_empty() {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let mut rest = lines.to_vec();
        rest.remove(i);
        for mut tail in orders(&rest) {
            tail.insert(0, (*line).to_string());
            all.push(tail);
        }
    }
    all
}

fn same_in_any_order(common: &str, lines: &[&str], until_s: f64, net: &str, truth: f64) {
    for order in orders(lines) {
        let blocks = format!("{common}\n{}\n{}", order.join("\n"), "");
        let found = Bench::new(&blocks).run(until_s).net(net);
        assert!((found - truth).abs() <= 1e-8, "{net} = {found} instead of {truth} in\n{blocks}");
    }
}

const EDGES: &str = "s = { kind = \"signal-generator\", wave = \"sine\", amplitude = 2.0, frequency = 1.3 }\np = { kind = \"comparator\", in = [\"s\"], threshold = 1.0 }\nq = { kind = \"comparator\", in = [\"-s\"], threshold = 1.0 }";

#[test]
fn a_counter_that_its_own_edge_releases_stays_at_zero() {
    // At the edge of p the flip-flop is still set and holds the counter at zero; it falls
    // at the same instant, after the edge. So no edge is ever counted.
    let lines = [
        "f = { kind = \"flip-flop\", in = [\"q\", \"p\"], initial = true }",
        "n = { kind = \"counter\", in = [\"p\", \"f\"] }",
        "x = { kind = \"integrator\", in = [\"n\"] }",
    ];
    same_in_any_order(EDGES, &lines, 4.0, "x", 0.0);
    same_in_any_order(EDGES, &lines, 4.0, "n", 0.0);
}

#[test]
fn counters_clocked_and_cleared_by_one_another_agree() {
    // m counts p until the flip-flop sees two of them; the one-shot starts at the same edge.
    let lines = [
        "m = { kind = \"counter\", in = [\"p\", \"two\"] }",
        "two = { kind = \"comparator\", in = [\"m\"], threshold = 1.5 }",
        "n = { kind = \"counter\", in = [\"two\"] }",
        "x = { kind = \"integrator\", in = [\"n\", \"10 * m\"] }",
    ];
    // Edges of p at (1/12 + k)/1.3 s: m is 1 after each even one, and falls from 2 to 0 at each odd one.
    let edges: Vec<f64> = (0..6).map(|k| (1.0 / 12.0 + f64::from(k)) / 1.3).collect();
    let until = 4.0;
    let ones =
        (edges[1] - edges[0]) + (edges[3] - edges[2]) + (edges[5].min(until) - edges[4].min(until));
    let counts = (until - edges[1]) + (until - edges[3]) + (until - edges[5]).max(0.0);
    same_in_any_order(EDGES, &lines, until, "x", counts + 10.0 * ones);
}

#[test]
fn resets_by_one_another_swap_two_integrators() {
    // Both take the other's value of before the instant.
    let lines = [
        "x = { kind = \"integrator\", in = [\"zero\"], ic = 1.0, reset = \"p\", reset-to = \"y\" }",
        "y = { kind = \"integrator\", in = [\"zero\"], ic = 2.0, reset = \"p\", reset-to = \"x\" }",
        "zero = { kind = \"constant\", value = 0.0 }",
        "z = { kind = \"integrator\", in = [\"x\", \"-3 * y\"] }",
    ];
    // Five rises in 4 s (the sixth at 3.91 s makes six): x alternates 1, 2.
    let edges: Vec<f64> = (0..6).map(|k| (1.0 / 12.0 + f64::from(k)) / 1.3).collect();
    let (mut t, mut x, mut y, mut z) = (0.0, 1.0, 2.0, 0.0);
    for edge in edges.iter().copied().filter(|e| *e < 4.0).chain([4.0]) {
        z += (edge - t) * (x - 3.0 * y);
        t = edge;
        (x, y) = (y, x);
    }
    same_in_any_order(EDGES, &lines, 4.0, "z", z);
}
