//! The engine against analytic solutions.

#![allow(clippy::unwrap_used)]

mod common;

use analog_proc::block::dac::DacPiece;
use analog_proc::block::logic::Edge;
use analog_proc::fault::RunFault;
use analog_proc::net::{
    BlockId, Expected, Input, Kind, Level, Method, NetId, OverloadPolicy, Span, Wave,
};
use analog_proc::simulation::Simulation;
use common::{Patch, integrator};
use interface::Tick;

fn tick(s: f64) -> Tick {
    Tick::from_secs(s).unwrap()
}

fn edges(simulation: &mut Simulation) -> Vec<Edge> {
    let mut out = Vec::new();
    simulation.take_edges(&mut out);
    out
}

fn assert_close(found: f64, expected: f64, relative: f64, what: &str) {
    let error = (found - expected).abs() / expected.abs();
    assert!(
        error <= relative,
        "{what}: {found} instead of {expected}, relative error {error:e}"
    );
}

fn oscillator(method: Method) -> Patch {
    let mut patch = Patch::with(method);
    patch.add("x", integrator(1.0), &["v"]);
    patch.add("v", integrator(0.0), &["-4 * x"]);
    patch
}

#[test]
fn oscillator_and_decay_keep_eight_digits() {
    // 1e-8 relative is the claim for default settings, over ten cycles.
    let mut simulation = oscillator(Method::DormandPrince).simulation();
    let (x, v) = (NetId(0), NetId(1));
    simulation.advance_to(tick(31.0)).unwrap();
    let amplitude = (simulation.net(x).powi(2) + (simulation.net(v) / 2.0).powi(2)).sqrt();
    assert_close(amplitude, 1.0, 1e-8, "amplitude");
    assert!((simulation.net(x) - 62.0_f64.cos()).abs() < 1e-8);

    let mut patch = Patch::new();
    patch.add("y", integrator(3.0), &["-0.7 * y"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(5.0)).unwrap();
    assert_close(
        simulation.net(NetId(0)),
        3.0 * (-3.5_f64).exp(),
        1e-8,
        "decay",
    );
}

/// Ball of height h and speed v that keeps `e` of its speed.
fn ball(e: f64) -> Patch {
    let mut patch = Patch::new();
    patch.add("g", Kind::Constant { value: -9.81 }, &[]);
    patch.add("h", integrator(1.0), &["v"]);
    let v = NetId(2);
    let contact = NetId(3);
    patch.add(
        "v",
        Kind::Integrator {
            ic: 0.0,
            limits: None,
            operate: None,
            reset: Some(contact),
            reset_to: Some(Input {
                net: v,
                coefficient: -e,
                span: Span::default(),
            }),
        },
        &["g"],
    );
    patch.add(
        "contact",
        Kind::Comparator {
            threshold: 0.0,
            hysteresis: 0.0,
        },
        &["-1 * h"],
    );
    patch.add("floor", Kind::Interrupt { line: 7 }, &["contact"]);
    patch
}

#[test]
fn ball_bounces_at_the_analytic_times() {
    let mut simulation = ball(0.8).simulation();
    simulation.advance_to(tick(3.9)).unwrap();
    let bounces: Vec<f64> = edges(&mut simulation)
        .iter()
        .filter(|e| e.rising && e.line == 7)
        .map(|e| e.t_s)
        .collect();
    // First contact at √(2h/g); each flight lasts 2·e^n·√(2h/g).
    let first_s = (2.0_f64 / 9.81).sqrt();
    let mut expected_s = first_s;
    assert_eq!(bounces.len(), 14);
    for (n, bounce_s) in bounces.iter().enumerate() {
        assert_close(*bounce_s, expected_s, 1e-8, "bounce");
        expected_s += 2.0 * 0.8_f64.powi(n as i32 + 1) * first_s;
    }
}

#[test]
fn accumulating_bounces_end_in_a_fault_that_names_the_contact() {
    let mut simulation = ball(0.8).simulation();
    // Bounces accumulate at √(2h/g)·(1 + e)/(1 − e) = 4.06 s.
    let limit_s = (2.0_f64 / 9.81).sqrt() * 9.0;
    match simulation.advance_to(tick(6.0)) {
        Err(RunFault::Chatter { t_s, block, .. }) => {
            assert_eq!(block, "contact");
            // Remaining flights at the resolution of the state: √(2·1e-12/g)·9 ≈ 4e-6.
            assert!(
                (t_s - limit_s).abs() < 1e-5,
                "chatter at {t_s}, accumulation at {limit_s}"
            );
        }
        other => panic!("{other:?}"),
    }
    // The fault stands.
    assert!(simulation.advance_to(tick(7.0)).is_err());
    simulation.reset().unwrap();
    assert!(simulation.advance_to(tick(1.0)).is_ok());
}

#[test]
fn relay_switches_at_the_analytic_times() {
    // Triangle between the points −1 and 1 with slopes ∓2: every 1 s.
    let mut patch = Patch::new();
    let relay = Kind::Relay {
        points: [-1.0, 1.0],
        outputs: [2.0, -2.0],
        initially_on: false,
    };
    patch.add("x", integrator(0.0), &["r"]);
    patch.add("r", relay, &["x"]);
    patch.add(
        "on",
        Kind::Comparator {
            threshold: 0.0,
            hysteresis: 0.0,
        },
        &["-1 * r"],
    );
    patch.add("line", Kind::Interrupt { line: 1 }, &["on"]);
    // An exponential one beside it: dy/dt = s − y, s = ±2 between ∓1: period 2·ln 3.
    let relay = Kind::Relay {
        points: [-1.0, 1.0],
        outputs: [2.0, -2.0],
        initially_on: false,
    };
    patch.add("y", integrator(0.0), &["s", "-1 * y"]);
    patch.add("s", relay, &["y"]);
    patch.add(
        "up",
        Kind::Comparator {
            threshold: 0.0,
            hysteresis: 0.0,
        },
        &["s"],
    );
    patch.add("other", Kind::Interrupt { line: 2 }, &["up"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(20.2)).unwrap();
    let all = edges(&mut simulation);
    let triangle: Vec<f64> = all.iter().filter(|e| e.line == 1).map(|e| e.t_s).collect();
    assert_eq!(triangle.len(), 20);
    for (n, t_s) in triangle.iter().enumerate() {
        assert_close(*t_s, 0.5 + n as f64, 1e-8, "triangle");
    }
    let exponential: Vec<f64> = all.iter().filter(|e| e.line == 2).map(|e| e.t_s).collect();
    assert!(exponential.len() > 15);
    for (n, t_s) in exponential.iter().enumerate() {
        // From 0 to 1 under s = 2: ln 2; then ln 3 each way.
        assert_close(
            *t_s,
            2.0_f64.ln() + n as f64 * 3.0_f64.ln(),
            1e-8,
            "exponential",
        );
    }
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
            patch.add("cy", Kind::Multiplier, &["c", "y"]);
        }
        let h_s = 3.0 / f64::from(n);
        patch.integration.step_s = h_s;
        patch.integration.max_step_s = h_s;
        // So loose that every step, the first one too, is the greatest step.
        patch.integration.rtol = 1e3;
        patch.integration.atol = 1e3;
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
        assert!(
            (measured - order).abs() < 0.2,
            "{method:?}: order {measured}"
        );
    }
}

#[test]
fn dead_zone_is_odd_and_limiter_corners_are_exact() {
    let mut patch = Patch::new();
    patch.add("t", Kind::Time, &[]);
    let sine = |phase_rad: f64| Kind::Generator {
        wave: Wave::Sine,
        amplitude: 2.0,
        offset: 0.0,
        frequency_hz: 1.0,
        phase_rad,
        start_s: 0.0,
    };
    patch.add("s", sine(0.0), &[]);
    let zone = Kind::DeadZone {
        width: Level::Fixed(0.5),
    };
    let up = patch.add("up", zone.clone(), &["s"]);
    let down = patch.add("down", zone, &["-1 * s"]);
    let limiter = Kind::Limiter {
        low: Level::Fixed(-1.0),
        high: Level::Fixed(1.0),
    };
    let limited = patch.add("limited", limiter, &["s"]);
    patch.add("area", integrator(0.0), &["limited"]);
    patch.add(
        "full",
        Kind::Comparator {
            threshold: 0.999_999_999_999,
            hysteresis: 0.0,
        },
        &["limited"],
    );
    patch.add("line", Kind::Interrupt { line: 0 }, &["full"]);
    let mut simulation = patch.simulation();
    let mut worst: f64 = 0.0;
    let mut seen = 0;
    simulation
        .advance_recording(
            tick(1.0),
            tick(0.001),
            &[up, down, limited, NetId(1)],
            |_, v| {
                worst = worst.max((v[0] + v[1]).abs());
                let expected = v[3].clamp(-1.0, 1.0);
                worst = worst.max((v[2] - expected).abs());
                seen += 1;
            },
        )
        .unwrap();
    assert_eq!(seen, 1000);
    // Band of a corner: 4 units in the last place of 1.
    assert!(worst <= 1e-15, "{worst:e}");
    // 2·sin(2πt) reaches 1 at t = 1/12.
    let first = edges(&mut simulation)[0];
    assert_close(first.t_s, 1.0 / 12.0, 1e-11, "corner");
    // ∫ over the half period: of the limited sine, 2·(2 − √3)/(2π) + 1/3.
    simulation.reset().unwrap();
    simulation.advance_to(tick(0.5)).unwrap();
    let expected = 2.0 * (1.0 - 0.75_f64.sqrt()) * 2.0 / std::f64::consts::TAU + 1.0 / 3.0;
    assert_close(simulation.net(patch.id("area")), expected, 1e-9, "area");
}

#[test]
fn transport_delay_shifts_a_sine() {
    let mut patch = Patch::new();
    patch.integration.rtol = 1e-9;
    patch.add("x", integrator(0.0), &["v"]);
    patch.add("v", integrator(2.0), &["-4 * x"]);
    let delayed = patch.add(
        "delayed",
        Kind::TransportDelay {
            delay: 0.3,
            initial: -5.0,
        },
        &["x"],
    );
    let mut simulation = patch.simulation();
    let mut worst: f64 = 0.0;
    simulation
        .advance_recording(tick(6.0), tick(0.01), &[delayed], |t_s, v| {
            let expected = if t_s < 0.3 {
                -5.0
            } else {
                (2.0 * (t_s - 0.3)).sin()
            };
            if (t_s - 0.3).abs() > 1e-9 {
                worst = worst.max((v[0] - expected).abs());
            }
        })
        .unwrap();
    // Dense output is one order below the error control at 1e-9, and steps are near 0.05 s:
    // the quartic's remainder (ωh)⁵/5!/… is below 1e-7.
    assert!(worst < 1e-7, "{worst:e}");
}

#[test]
fn delayed_feedback_follows_the_method_of_steps() {
    // dy/dt = −y(t − 1), y = 1 before: y(1) = 0, y(2) = −1/2, y(3) = −1/6.
    let mut patch = Patch::new();
    patch.add("y", integrator(1.0), &["-1 * d"]);
    patch.add(
        "d",
        Kind::TransportDelay {
            delay: 1.0,
            initial: 1.0,
        },
        &["y"],
    );
    let mut simulation = patch.simulation();
    for (t_s, y) in [(1.0, 0.0), (2.0, -0.5), (3.0, -1.0 / 6.0)] {
        simulation.advance_to(tick(t_s)).unwrap();
        // Piecewise polynomials of degree ≤ 3 are exact but for rounding and breakpoints.
        assert!(
            (simulation.net(NetId(0)) - y).abs() < 1e-12,
            "{}",
            simulation.net(NetId(0))
        );
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
            assert_close(simulation.net(NetId(i as u32)), expected, relative, "node");
        }
    }
}

#[test]
fn mass_on_a_belt_sticks_and_slips() {
    // Spring pulled at speed 1: sticks until k·t = breakaway, then slips.
    let mut patch = Patch::new();
    patch.add("t", Kind::Time, &[]);
    patch.add("x", integrator(0.0), &["v"]);
    patch.add("v", integrator(0.0), &["spring", "friction"]);
    patch.add("spring", Kind::Summer, &["4 * t", "-4 * x"]);
    let friction = Kind::DryFriction {
        level: 1.0,
        breakaway: 2.0,
    };
    patch.add("friction", friction, &["v", "spring"]);
    let moving = Kind::Comparator {
        threshold: 1e-12,
        hysteresis: 0.0,
    };
    patch.add("moving", moving, &["v"]);
    patch.add("line", Kind::Interrupt { line: 0 }, &["moving"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(0.499)).unwrap();
    assert_eq!(simulation.net(NetId(1)), 0.0);
    assert_eq!(simulation.net(NetId(2)), 0.0);
    simulation.advance_to(tick(6.0)).unwrap();
    let times: Vec<f64> = edges(&mut simulation).iter().map(|e| e.t_s).collect();
    // Slip: v̈ = 4(1 − v) with v = 0, v̇ = 1 at break-away: v = 1 − cos 2s + ½ sin 2s,
    // zero again where tan s = −½·… : 2s = 2π − 2·atan(1/2).
    let slip_s = std::f64::consts::PI - 0.5_f64.atan();
    assert!((times[0] - 0.5).abs() < 1e-10);
    assert_close(times[1], 0.5 + slip_s, 1e-8, "stick");
    assert_eq!(simulation.net(NetId(2)) != 0.0, times.len() % 2 == 1);
}

fn lorenz() -> Patch {
    let mut patch = Patch::new();
    patch.add("x", integrator(1.0), &["10 * y", "-10 * x"]);
    patch.add("y", integrator(1.0), &["28 * x", "-1 * y", "-1 * xz"]);
    patch.add("z", integrator(1.0), &["xy", "-2.6666666666666665 * z"]);
    patch.add("xz", Kind::Multiplier, &["x", "z"]);
    patch.add("xy", Kind::Multiplier, &["x", "y"]);
    patch.add(
        "sign",
        Kind::Comparator {
            threshold: 0.0,
            hysteresis: 0.0,
        },
        &["x"],
    );
    patch
}

#[test]
fn runs_repeat_to_the_bit_and_recording_changes_nothing() {
    let run = |every: Option<f64>| {
        let mut simulation = lorenz().simulation();
        match every {
            Some(every) => simulation
                .advance_recording(tick(12.0), tick(every), &[NetId(0)], |_, _| {})
                .unwrap(),
            None => simulation.advance_to(tick(12.0)).unwrap(),
        };
        [0, 1, 2].map(|i| simulation.net(NetId(i)).to_bits())
    };
    let first = run(None);
    assert_eq!(first, run(None));
    assert_eq!(first, run(Some(0.1)));
    assert_eq!(first, run(Some(0.000_37)));
}

#[test]
fn frames_do_not_change_the_answer() {
    let mut whole = oscillator(Method::DormandPrince).simulation();
    whole.advance_to(tick(5.0)).unwrap();
    let mut framed = oscillator(Method::DormandPrince).simulation();
    for n in 1..=50 {
        framed.apply().unwrap();
        framed.advance_to(tick(0.1) * n).unwrap();
        assert_eq!(framed.now_s().to_bits(), (tick(0.1) * n).secs().to_bits());
    }
    // Both within the default tolerance of the truth over two cycles.
    assert!((whole.net(NetId(0)) - framed.net(NetId(0))).abs() < 1e-9);
}

#[test]
fn hold_feeds_nothing_through() {
    let mut patch = Patch::new();
    patch.add(
        "in",
        Kind::Dac {
            channel: 3,
            initial: 1.0,
        },
        &[],
    );
    patch.add(
        "run",
        Kind::Control {
            line: 0,
            initial: true,
        },
        &[],
    );
    let operate = Some(NetId(1));
    let held = Kind::Integrator {
        ic: 0.0,
        limits: None,
        operate,
        reset: None,
        reset_to: None,
    };
    patch.add("y", held, &["in"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(1.0)).unwrap();
    simulation.set_control(0, false);
    simulation.set_dac(3, DacPiece::held(1e300, 1.0));
    simulation.apply().unwrap();
    let before = simulation.net(NetId(2));
    simulation.advance_to(tick(2.0)).unwrap();
    assert_eq!(simulation.net(NetId(2)).to_bits(), before.to_bits());
    simulation.hold(true);
    simulation.set_control(0, true);
    simulation.apply().unwrap();
    let stood = simulation.advance_to(tick(3.0)).unwrap();
    assert_eq!(stood.reached, tick(2.0));
    assert_eq!(simulation.net(NetId(2)).to_bits(), before.to_bits());
    assert_close(before, 1.0, 1e-12, "held value");
}

#[test]
fn dac_slopes_and_settling_are_integrated_exactly() {
    let mut patch = Patch::new();
    patch.add(
        "in",
        Kind::Dac {
            channel: 0,
            initial: 0.0,
        },
        &[],
    );
    patch.add("y", integrator(0.0), &["in"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(1.0)).unwrap();
    let piece = DacPiece {
        value: 2.0,
        slope_per_s: 3.0,
        from_s: 1.0,
        settling_s: 0.1,
    };
    simulation.set_dac(0, piece);
    simulation.apply().unwrap();
    assert_eq!(simulation.net(NetId(0)), 0.0);
    simulation.advance_to(tick(2.0)).unwrap();
    // ∫(2 + 3s − 2e^{−s/0.1}) ds over one second.
    let expected = 2.0 + 1.5 - 0.2 * (1.0 - (-10.0_f64).exp());
    assert_close(simulation.net(NetId(1)), expected, 1e-9, "integral");
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
    patch.add("x2v", Kind::Multiplier, &["x", "x", "v"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(2000.0)).unwrap();
    // One tolerance a step, all of one sign, over a thousand steps.
    assert_close(
        simulation.net(NetId(0)),
        van_der_pol_by_runge_kutta(),
        1e-3,
        "x(2000)",
    );
    assert!(
        simulation.statistics().steps < 4000,
        "{:?}",
        simulation.statistics()
    );
}

#[test]
fn undefined_numbers_are_faults() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut patch = Patch::new();
        patch.add("y", integrator(bad), &["-1 * y"]);
        assert!(matches!(
            Simulation::new(&patch.ordered()),
            Err(RunFault::NonFinite { .. })
        ));
        let mut patch = Patch::new();
        patch.add("c", Kind::Constant { value: bad }, &[]);
        patch.add("y", integrator(0.0), &["c"]);
        assert!(matches!(
            Simulation::new(&patch.ordered()),
            Err(RunFault::NonFinite { .. })
        ));
        let mut patch = oscillator(Method::DormandPrince);
        patch.integration.rtol = bad;
        assert!(matches!(
            Simulation::new(&patch.ordered()),
            Err(RunFault::Setting { .. })
        ));
    }
    // dy/dt = y² from 1 is infinite at t = 1.
    let mut patch = Patch::new();
    patch.add("y", integrator(1.0), &["q"]);
    patch.add("q", Kind::Square, &["y"]);
    let fault = patch.simulation().advance_to(tick(2.0)).unwrap_err();
    assert!(
        matches!(
            fault,
            RunFault::StepUnderflow { .. } | RunFault::NonFinite { .. }
        ),
        "{fault}"
    );
}

#[test]
fn zero_divisors_and_negative_roots_are_located() {
    let mut patch = Patch::new();
    patch.add("t", Kind::Time, &[]);
    patch.add("one", Kind::Constant { value: 1.0 }, &[]);
    patch.add("down", Kind::Summer, &["one", "-4 * t"]);
    patch.add("ratio", Kind::Divider, &["one", "down"]);
    match patch.simulation().advance_to(tick(1.0)).unwrap_err() {
        RunFault::DividedByZero { block, t_s } => {
            assert_eq!(block, "ratio");
            assert!((t_s - 0.25).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
    let mut patch = Patch::new();
    patch.add("t", Kind::Time, &[]);
    patch.add("one", Kind::Constant { value: 1.0 }, &[]);
    patch.add("root", Kind::SquareRoot, &["one", "-4 * t"]);
    match patch.simulation().advance_to(tick(1.0)).unwrap_err() {
        RunFault::NegativeRoot { block, t_s } => {
            assert_eq!(block, "root");
            assert!((t_s - 0.25).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn races_and_chatter_are_faults_not_hangs() {
    // A flip-flop that sets itself when clear and clears itself when set.
    let mut patch = Patch::new();
    patch.add("q", Kind::FlipFlop { initial: false }, &["nq", "q"]);
    patch.add("nq", Kind::Not, &["q"]);
    match Simulation::new(&patch.ordered()) {
        Err(RunFault::LogicRace { nets, .. }) => assert!(nets.contains(&"q".to_string())),
        other => panic!("{:?}", other.map(|_| ())),
    }
    // Sliding on a relay without hysteresis.
    let mut patch = Patch::new();
    patch.add("x", integrator(1.0), &["r"]);
    let relay = Kind::Relay {
        points: [0.0, 0.0],
        outputs: [1.0, -1.0],
        initially_on: true,
    };
    patch.add("r", relay, &["x"]);
    match patch.simulation().advance_to(tick(2.0)) {
        Err(RunFault::Chatter { block, t_s, .. }) => {
            assert_eq!(block, "r");
            assert!((t_s - 1.0).abs() < 1e-6);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn overload_is_latched_where_it_happens() {
    let mut patch = oscillator(Method::DormandPrince);
    // v = −2·sin 2t reaches −1.1 at t = ½·asin(0.55).
    patch.max("v", 1.0);
    for policy in [
        OverloadPolicy::Continue,
        OverloadPolicy::Hold,
        OverloadPolicy::Stop,
    ] {
        patch.integration.overload = policy;
        let mut simulation = patch.simulation();
        let advance = simulation.advance_to(tick(5.0)).unwrap();
        let latched = simulation.overloads()[0];
        assert_eq!(simulation.overloads().len(), 1);
        assert_eq!(latched.block, BlockId(1));
        assert_close(latched.t_s, 0.5 * 0.55_f64.asin(), 1e-9, "overload");
        assert_eq!(
            advance.stopped_by.is_some(),
            policy != OverloadPolicy::Continue
        );
        let again = simulation.advance_to(tick(6.0)).unwrap();
        assert_eq!(
            again.reached == tick(6.0),
            policy == OverloadPolicy::Continue
        );
    }
}

#[test]
fn limited_integrator_rests_on_its_limit() {
    // dy/dt = cos t between ±0.5: leaves the stop where the input turns, t = π/2.
    let mut patch = Patch::new();
    patch.add("c", integrator(1.0), &["-1 * s"]);
    patch.add("s", integrator(0.0), &["c"]);
    let limits = Some([-0.5, 0.5]);
    let limited = Kind::Integrator {
        ic: 0.0,
        limits,
        operate: None,
        reset: None,
        reset_to: None,
    };
    let y = patch.add("y", limited, &["c"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(1.0)).unwrap();
    assert_eq!(simulation.net(y), 0.5);
    simulation.advance_to(tick(2.0)).unwrap();
    assert!((simulation.net(y) - (0.5 + 2.0_f64.sin() - 1.0)).abs() < 1e-9);
}

#[test]
fn logic_counts_and_pulses() {
    let mut patch = Patch::new();
    let square = Kind::Generator {
        wave: Wave::Square,
        amplitude: 1.0,
        offset: 0.0,
        frequency_hz: 1.0,
        phase_rad: 0.0,
        start_s: 0.25,
    };
    patch.add("w", square, &[]);
    patch.add(
        "clock",
        Kind::Comparator {
            threshold: 0.0,
            hysteresis: 0.0,
        },
        &["w"],
    );
    let count = patch.add("count", Kind::Counter { modulo: 3 }, &["clock"]);
    patch.add("pulse", Kind::OneShot { width_s: 0.125 }, &["clock"]);
    patch.add("one", Kind::Constant { value: 1.0 }, &[]);
    patch.add("zero", Kind::Constant { value: 0.0 }, &[]);
    patch.add("gate", Kind::Switch { control: NetId(3) }, &["one", "zero"]);
    let on = patch.add("on", integrator(0.0), &["gate"]);
    patch.add("sense", Kind::Sense { line: 5 }, &["pulse"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(2.3)).unwrap();
    assert!(simulation.sense(5));
    simulation.advance_to(tick(2.4)).unwrap();
    assert!(!simulation.sense(5));
    assert_eq!(simulation.net(count), 0.0);
    // Three pulses of 0.125 s, their edges exact stops.
    assert!((simulation.net(on) - 0.375).abs() < 1e-14);
    simulation.advance_to(tick(3.4)).unwrap();
    assert_eq!(simulation.net(count), 1.0);
}

#[test]
fn static_check_reports_what_differs() {
    let mut simulation = oscillator(Method::DormandPrince).simulation();
    let item = |derivative| Expected {
        net: NetId(1),
        output: Some(0.0),
        derivative: Some(derivative),
        tolerance: 1e-12,
    };
    assert!(simulation.static_check(&[item(-4.0)]).unwrap().is_empty());
    let found = simulation.static_check(&[item(4.0)]).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].derivative, found[0].found), (true, -4.0));
}
