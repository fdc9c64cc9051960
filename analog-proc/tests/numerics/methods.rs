//! Each method of integration against analytic solutions: its order, its tolerance, its steps.

use crate::{Bench, close, oscillator};

#[test]
fn oscillator_and_decay_keep_eight_digits() {
    // 1e-8 relative is the claim for default settings, over ten cycles.
    let mut bench = oscillator("dormand-prince");
    bench.run(31.0);
    let amplitude = (bench.net("x").powi(2) + (bench.net("v") / 2.0).powi(2)).sqrt();
    close(amplitude, 1.0, 1e-8, "amplitude");
    assert!((bench.net("x") - 62.0_f64.cos()).abs() < 1e-8);

    let mut bench = Bench::new(r#"y = { kind = "integrator", in = ["-0.7 * y"], ic = 3.0 }"#);
    close(bench.run(5.0).net("y"), 3.0 * (-3.5_f64).exp(), 1e-8, "decay");
}

/// Slope of log error over log step, at steps forced to one length, over three seconds.
fn measured_order(method: &str, steps: [u32; 2]) -> f64 {
    // s = sin t, c = cos t, and dy/dt = c·y: y = e^{sin t}. The implicit method solves
    // its stages to a part of the tolerance, which is put out of force here; on the
    // linear part alone one iteration solves them but for the Jacobian's 1e-8.
    // `max`: without a stated size, a state at zero is measured by next to nothing.
    let mut blocks = String::from(
        r#"
        s = { kind = "integrator", in = ["c"], max = 3.0 }
        c = { kind = "integrator", in = ["-1 * s"], ic = 1.0, max = 3.0 }
    "#,
    );
    let mut truth = vec![("s", 3.0_f64.sin()), ("c", 3.0_f64.cos())];
    if method != "sdirk4" {
        blocks += r#"
        y = { kind = "integrator", in = ["cy"], ic = 1.0, max = 3.0 }
        cy = { kind = "multiplier", in = ["c", "y"] }
    "#;
        truth.push(("y", 3.0_f64.sin().exp()));
    }
    let errors = steps.map(|n| {
        let h_s = 3.0 / f64::from(n);
        let fixed = matches!(method, "euler" | "runge-kutta-4");
        let step = if fixed { "step" } else { "max-step" };
        // So loose that every step, the first one too, is the greatest step.
        let settings = format!("method = \"{method}\"\n{step} = {h_s:e}\nrtol = 0.1\natol = 1e3");
        let mut bench = Bench::with(&settings, &blocks);
        bench.run(3.0);
        assert_eq!(bench.simulation.statistics().steps, u64::from(n), "{method}");
        truth.iter().map(|(net, value)| (bench.net(net) - value).abs()).sum::<f64>()
    });
    (errors[0] / errors[1]).ln() / (f64::from(steps[1]) / f64::from(steps[0])).ln()
}

#[test]
fn every_method_has_its_order() {
    for (method, order, steps) in [
        ("euler", 1.0, [400, 800]),
        ("runge-kutta-4", 4.0, [40, 80]),
        ("dormand-prince", 5.0, [40, 80]),
        ("sdirk4", 4.0, [40, 80]),
    ] {
        let measured = measured_order(method, steps);
        assert!((measured - order).abs() < 0.2, "{method}: order {measured}");
    }
}

#[test]
fn heat_rod_decays_as_its_semi_discrete_solution() {
    // n nodes, both ends at zero, conductivity over spacing squared k. The sine is an
    // eigenvector: λ = −4k·sin²(π/2(n + 1)).
    let (n, k) = (16, 100.0);
    let half = std::f64::consts::FRAC_PI_2 / f64::from(n + 1);
    let rate = -4.0 * k * half.sin().powi(2);
    let start = |i: i32| (f64::from(i + 1) * 2.0 * half).sin();
    let mut blocks = String::new();
    for i in 0..n {
        let beside = [i - 1, i + 1].into_iter().filter(|j| (0..n).contains(j));
        let inputs: String = beside.map(|j| format!(", \"{k} * u{j}\"")).collect();
        let own = -2.0 * k;
        let ic = start(i);
        blocks += &format!(
            "u{i} = {{ kind = \"integrator\", in = [\"{own} * u{i}\"{inputs}], ic = {ic:?} }}\n"
        );
    }
    for (settings, relative) in [("", 1e-8), ("method = \"sdirk4\"\nrtol = 1e-8", 1e-6)] {
        let mut bench = Bench::with(settings, &blocks);
        bench.run(0.5);
        for i in 0..n {
            let expected = start(i) * (rate * 0.5).exp();
            close(bench.net(&format!("u{i}")), expected, relative, "node");
        }
    }
}

/// x(2000) of Van der Pol's equation, μ = 1000, from (2, 0): the classical method in the
/// coordinates of Liénard, x' = μ(z − x³/3 + x), z' = −x/μ, which no patch uses. The
/// fastest rate is 3000/s, so that 0.1 ms is well inside the stable interval (2.78/3000);
/// twice the step gives the same to 1e-6.
fn van_der_pol_by_runge_kutta() -> f64 {
    let run = |h: f64, steps: u32| {
        let f = |[x, z]: [f64; 2]| [1000.0 * (z - x * x * x / 3.0 + x), -x / 1000.0];
        let ahead = |y: [f64; 2], k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
        // v = 0 at x = 2: z = x³/3 − x.
        let mut y = [2.0, 8.0 / 3.0 - 2.0];
        for _ in 0..steps {
            let k1 = f(y);
            let k2 = f(ahead(y, k1, 0.5 * h));
            let k3 = f(ahead(y, k2, 0.5 * h));
            let k4 = f(ahead(y, k3, h));
            for i in 0..2 {
                y[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
            }
        }
        y[0]
    };
    let (fine, coarse) = (run(1e-4, 20_000_000), run(2e-4, 10_000_000));
    assert!((fine - coarse).abs() < 1e-6, "{fine} and {coarse}");
    fine
}

#[test]
fn stiff_oscillator_needs_few_steps() {
    // Van der Pol, μ = 1000: jumps of width 1/μ² every 807 s of slow motion.
    let mut bench = Bench::with(
        "method = \"sdirk4\"\nrtol = 1e-6\natol = 1e-8",
        r#"
        x = { kind = "integrator", in = ["v"], ic = 2.0 }
        v = { kind = "integrator", in = ["1000 * v", "-1000 * x2v", "-1 * x"] }
        x2v = { kind = "multiplier", in = ["x", "x", "v"] }
    "#,
    );
    bench.run(2000.0);
    // One tolerance a step, all of one sign, over a thousand steps.
    close(bench.net("x"), van_der_pol_by_runge_kutta(), 1e-3, "x(2000)");
    assert!(bench.simulation.statistics().steps < 4000, "{:?}", bench.simulation.statistics());
}
