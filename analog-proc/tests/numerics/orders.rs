//! Each method of integration against analytic solutions: its order, its tolerance, its steps.

use crate::common::{Patch, close, integrator, tick};
use crate::oscillator;
use analog_proc::block::kind::Multiplier;
use analog_proc::net::Kind;
use engine::{id::NetId, integration::Method};

#[test]
fn oscillator_and_decay_keep_eight_digits() {
    // 1e-8 relative is the claim for default settings, over ten cycles.
    let mut simulation = oscillator(Method::DormandPrince).simulation();
    let (x, v) = (NetId(0), NetId(1));
    simulation.advance_to(tick(31.0)).unwrap();
    let amplitude = (simulation.net(x).powi(2) + (simulation.net(v) / 2.0).powi(2)).sqrt();
    close(amplitude, 1.0, 1e-8, "amplitude");
    assert!((simulation.net(x) - 62.0_f64.cos()).abs() < 1e-8);

    let mut patch = Patch::new();
    patch.add("y", integrator(3.0), &["-0.7 * y"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(5.0)).unwrap();
    close(simulation.net(NetId(0)), 3.0 * (-3.5_f64).exp(), 1e-8, "decay");
}

/// Slope of log error over log step, at steps forced to one length, over three seconds.
fn measured_order(method: Method, steps: [u32; 2]) -> f64 {
    let mut errors = [0.0; 2];
    for (error, n) in errors.iter_mut().zip(steps) {
        let mut patch = Patch::with(method);
        // s = sin t, c = cos t, and dy/dt = c·y: y = e^{sin t}. The implicit method solves
        // its stages to a part of the tolerance, which is put out of force here; on the
        // linear part alone one iteration solves them but for the Jacobian's 1e-8.
        patch.add("s", integrator(0.0), &["c"]);
        patch.add("c", integrator(1.0), &["-1 * s"]);
        let linear = method == Method::Sdirk4;
        if !linear {
            patch.add("y", integrator(1.0), &["cy"]);
            patch.add("cy", Kind::Multiplier(Multiplier), &["c", "y"]);
        }
        let h_s = 3.0 / f64::from(n);
        patch.integration.step_s = h_s;
        patch.integration.max_step_s = h_s;
        // So loose that every step, the first one too, is the greatest step.
        patch.integration.rtol = 1e3;
        patch.integration.atol = 1e3;
        // Without a stated size, a state at zero is measured by next to nothing.
        for name in if linear { &["s", "c"][..] } else { &["s", "c", "y"] } {
            patch.max(name, 3.0);
        }
        let mut simulation = patch.simulation();
        simulation.advance_to(tick(3.0)).unwrap();
        assert_eq!(simulation.statistics().steps, u64::from(n), "{method:?}");
        let truth = [3.0_f64.sin(), 3.0_f64.cos(), 3.0_f64.sin().exp()];
        *error = (0..if linear { 2 } else { 3 })
            .map(|i| (simulation.net(NetId(i)) - truth[i as usize]).abs())
            .sum();
    }
    let ratio = f64::from(steps[1]) / f64::from(steps[0]);
    (errors[0] / errors[1]).ln() / ratio.ln()
}

#[test]
fn every_method_has_its_order() {
    for (method, order, steps) in [
        (Method::Euler, 1.0, [400, 800]),
        (Method::RungeKutta4, 4.0, [40, 80]),
        (Method::DormandPrince, 5.0, [40, 80]),
        (Method::Sdirk4, 4.0, [40, 80]),
    ] {
        let measured = measured_order(method, steps);
        assert!((measured - order).abs() < 0.2, "{method:?}: order {measured}");
    }
}

/// Rod of n nodes with both ends at zero, conductivity over spacing squared `k`.
fn rod(n: usize, k: f64, method: Method) -> Patch {
    let mut patch = Patch::with(method);
    for i in 0..n {
        let ic = ((i + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).sin();
        let mut inputs = vec![format!("{} * u{i}", -2.0 * k)];
        if i > 0 {
            inputs.push(format!("{k} * u{}", i - 1));
        }
        if i + 1 < n {
            inputs.push(format!("{k} * u{}", i + 1));
        }
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        patch.add(&format!("u{i}"), integrator(ic), &inputs);
    }
    patch
}

#[test]
fn heat_rod_decays_as_its_semi_discrete_solution() {
    // The sine is an eigenvector: λ = −4k·sin²(π/2(n + 1)).
    let (n, k) = (16, 100.0);
    let half = std::f64::consts::FRAC_PI_2 / 17.0;
    let rate = -4.0 * k * half.sin().powi(2);
    for (method, relative) in [(Method::DormandPrince, 1e-8), (Method::Sdirk4, 1e-6)] {
        let mut patch = rod(n, k, method);
        if method == Method::Sdirk4 {
            patch.integration.rtol = 1e-8;
        }
        let mut simulation = patch.simulation();
        simulation.advance_to(tick(0.5)).unwrap();
        for i in 0..n {
            let start = ((i + 1) as f64 * 2.0 * half).sin();
            let expected = start * (rate * 0.5).exp();
            close(simulation.net(NetId(i as u32)), expected, relative, "node");
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
    let fine = run(1e-4, 20_000_000);
    let coarse = run(2e-4, 10_000_000);
    assert!((fine - coarse).abs() < 1e-6, "{fine} and {coarse}");
    fine
}

#[test]
fn stiff_oscillator_needs_few_steps() {
    // Van der Pol, μ = 1000: jumps of width 1/μ² every 807 s of slow motion.
    let mut patch = Patch::with(Method::Sdirk4);
    patch.integration.rtol = 1e-6;
    patch.integration.atol = 1e-8;
    patch.add("x", integrator(2.0), &["v"]);
    patch.add("v", integrator(0.0), &["1000 * v", "-1000 * x2v", "-1 * x"]);
    patch.add("x2v", Kind::Multiplier(Multiplier), &["x", "x", "v"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(2000.0)).unwrap();
    // One tolerance a step, all of one sign, over a thousand steps.
    close(simulation.net(NetId(0)), van_der_pol_by_runge_kutta(), 1e-3, "x(2000)");
    assert!(simulation.statistics().steps < 4000, "{:?}", simulation.statistics());
}
