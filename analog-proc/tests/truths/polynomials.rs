//! Chains of integrators of constants: states that every method integrates exactly, in steps
//! as long as it likes, and what watches them.

use crate::bench::Bench;
use crate::close;
use crate::roots::{bisect, integral};

#[test]
fn a_cubic_leaves_and_comes_back_once() {
    let (a, v0, x0, level) = (
        -0.542_124_131_896_757_5,
        0.047_193_175_937_689_57,
        0.084_045_090_074_448_71,
        0.233_617_939_350_929_53,
    );
    let mut bench = Bench::new(&format!(
        r#"
        one = {{ kind = "constant", value = 1.0 }}
        n01 = {{ kind = "integrator", in = ["{a:?} * one"], ic = {v0:?} }}
        n02 = {{ kind = "integrator", in = ["n01"], ic = 0.22 }}
        n03 = {{ kind = "integrator", in = ["n02"], ic = {x0:?} }}
        p = {{ kind = "comparator", in = ["-n03"], threshold = {:?} }}
        line = {{ kind = "interrupt", in = ["p"], line = 1 }}
    "#,
        -level
    ));
    let cubic = |t: f64| x0 + t * (0.22 + t * (0.5 * v0 + t * a / 6.0));
    // Its one maximum, where the parabola of its slope is zero.
    let top = (-v0 - (v0 * v0 - 2.0 * a * 0.22).sqrt()) / a;
    assert!(cubic(top) > level && cubic(3.85) < level);
    let out = bisect(|t| cubic(t) - level, 0.0, top);
    let back = bisect(|t| cubic(t) - level, top, 3.85);
    bench.run(3.85);
    let mut all = Vec::new();
    bench.simulation.take_edges(&mut all);
    let found: Vec<(bool, f64)> = all.iter().map(|e| (e.rising, e.t_s)).collect();
    assert_eq!(found.len(), 2, "{found:?} instead of {out}, {back}");
    assert!(!found[0].0 && (found[0].1 - out).abs() < 1e-9, "{found:?}");
    assert!(found[1].0 && (found[1].1 - back).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_polynomial_of_degree_five_shows_each_of_its_bumps() {
    // T5(t/3) by a chain of five integrators: four extremes of height one within ±3.
    // T5(u) = 16u⁵ − 20u³ + 5u; from u = −1: T = −1, T' = 25, T'' = −200, T''' = 840, T⁗ = −1920, T⁵ = 1920.
    let mut bench = Bench::new(
        r#"
        k = { kind = "constant", value = 1.0 }
        d4 = { kind = "integrator", in = ["1920 * k"], ic = -1920 }
        d3 = { kind = "integrator", in = ["d4"], ic = 840 }
        d2 = { kind = "integrator", in = ["d3"], ic = -200 }
        d1 = { kind = "integrator", in = ["d2"], ic = 25 }
        x = { kind = "integrator", in = ["d1"], ic = -1 }
        high = { kind = "comparator", in = ["x"], threshold = 0.9999 }
        low = { kind = "comparator", in = ["-x"], threshold = 0.9999 }
        n = { kind = "counter", in = ["high"] }
        m = { kind = "counter", in = ["low"] }
    "#,
    );
    // Highs at u = cos(4π/5), cos(2π/5) and the end; lows at the start (no rise), cos(3π/5), cos(π/5).
    bench.run(1.999_999);
    assert_eq!((bench.net("n"), bench.net("m")), (3.0, 2.0));
}

#[test]
fn a_parabola_crosses_a_table_of_two_variables() {
    // a(t) = 1 − 0.98 (t − 1)², b(t) = 0.3 + 0.4 t over 2 s: a passes 0.5 twice and 0.999 for
    // 64 ms about t = 1, b passes 0.5 and 1.
    let mut bench = Bench::new(
        r#"
        k = { kind = "constant", value = 1.0 }
        da = { kind = "integrator", in = ["-1.96 * k"], ic = 1.96 }
        a = { kind = "integrator", in = ["da"], ic = 0.02 }
        b = { kind = "integrator", in = ["0.4 * k"], ic = 0.3 }
        z = { kind = "function-2d", in = ["a", "b"], x = [0, 0.5, 0.999, 1.5], y = [0, 0.5, 1.0], z = [[0, 1, 0], [2, 3, -1], [0, 1, 5], [5000, 7000, -3000]] }
        x = { kind = "integrator", in = ["z"] }
    "#,
    );
    let a = |t: f64| 1.0 - 0.98 * (t - 1.0) * (t - 1.0);
    let b = |t: f64| 0.3 + 0.4 * t;
    let xs = [0.0, 0.5, 0.999, 1.5];
    let ys = [0.0, 0.5, 1.0];
    let zs = [[0.0, 1.0, 0.0], [2.0, 3.0, -1.0], [0.0, 1.0, 5.0], [5000.0, 7000.0, -3000.0]];
    let z = |t: f64| {
        let (a, b) = (a(t).clamp(0.0, 1.5), b(t).clamp(0.0, 1.0));
        let i = if a < 0.5 {
            0
        } else if a < 0.999 {
            1
        } else {
            2
        };
        let j = usize::from(b >= 0.5);
        let (u, v) = ((a - xs[i]) / (xs[i + 1] - xs[i]), (b - ys[j]) / (ys[j + 1] - ys[j]));
        (1.0 - u) * ((1.0 - v) * zs[i][j] + v * zs[i][j + 1])
            + u * ((1.0 - v) * zs[i + 1][j] + v * zs[i + 1][j + 1])
    };
    let (wide, narrow) = ((0.5_f64 / 0.98).sqrt(), (0.001_f64 / 0.98).sqrt());
    let mut corners = [
        0.0,
        1.0 - wide,
        1.0 - narrow,
        1.0 + narrow,
        1.0 + wide,
        (0.5 - 0.3) / 0.4,
        (1.0 - 0.3) / 0.4,
        2.0,
    ];
    corners.sort_by(f64::total_cmp);
    // A polynomial of degree three between corners: the rule is exact.
    let truth: f64 = corners.windows(2).map(|w| integral(z, w[0], w[1], 1)).sum();
    close(bench.run(2.0).net("x"), truth, 1e-8, "integral");
}
