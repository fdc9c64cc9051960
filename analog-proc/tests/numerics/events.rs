//! Switching instants against those of the analytic solution.

use crate::common::{Patch, close, integrator, tick};
use crate::edges;
use analog_proc::block::kind::*;
use analog_proc::net::{Input, Span};
use engine::fault::RunFault;
use engine::id::NetId;

/// Ball of height h and speed v that keeps `e` of its speed.
fn ball(e: f64) -> Patch {
    let mut patch = Patch::new();
    patch.add("g", Kind::Constant(Constant { value: -9.81 }), &[]);
    patch.add("h", integrator(1.0), &["v"]);
    let v = NetId(2);
    let contact = NetId(3);
    patch.add(
        "v",
        Kind::Integrator(Integrator {
            ic: 0.0,
            limits: None,
            operate: None,
            reset: Some(contact),
            reset_to: Some(Input { net: v, coefficient: -e, span: Span::default() }),
        }),
        &["g"],
    );
    patch.add(
        "contact",
        Kind::Comparator(Comparator { threshold: 0.0, hysteresis: 0.0 }),
        &["-1 * h"],
    );
    patch.add("floor", Kind::Interrupt(Interrupt { line: 7 }), &["contact"]);
    patch
}

#[test]
fn ball_bounces_at_the_analytic_times() {
    let mut simulation = ball(0.8).simulation();
    simulation.advance_to(tick(3.9)).unwrap();
    let bounces: Vec<f64> =
        edges(&mut simulation).iter().filter(|e| e.rising && e.line == 7).map(|e| e.t_s).collect();
    // First contact at √(2h/g); each flight lasts 2·e^n·√(2h/g).
    let first_s = (2.0_f64 / 9.81).sqrt();
    let mut expected_s = first_s;
    assert_eq!(bounces.len(), 14);
    for (n, bounce_s) in bounces.iter().enumerate() {
        close(*bounce_s, expected_s, 1e-8, "bounce");
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
            assert!((t_s - limit_s).abs() < 1e-5, "chatter at {t_s}, accumulation at {limit_s}");
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
    let relay =
        Kind::Relay(Relay { points: [-1.0, 1.0], outputs: [2.0, -2.0], initially_on: false });
    patch.add("x", integrator(0.0), &["r"]);
    patch.add("r", relay, &["x"]);
    patch.add("on", Kind::Comparator(Comparator { threshold: 0.0, hysteresis: 0.0 }), &["-1 * r"]);
    patch.add("line", Kind::Interrupt(Interrupt { line: 1 }), &["on"]);
    // An exponential one beside it: dy/dt = s − y, s = ±2 between ∓1: period 2·ln 3.
    let relay =
        Kind::Relay(Relay { points: [-1.0, 1.0], outputs: [2.0, -2.0], initially_on: false });
    patch.add("y", integrator(0.0), &["s", "-1 * y"]);
    patch.add("s", relay, &["y"]);
    patch.add("up", Kind::Comparator(Comparator { threshold: 0.0, hysteresis: 0.0 }), &["s"]);
    patch.add("other", Kind::Interrupt(Interrupt { line: 2 }), &["up"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(20.2)).unwrap();
    let all = edges(&mut simulation);
    let triangle: Vec<f64> = all.iter().filter(|e| e.line == 1).map(|e| e.t_s).collect();
    assert_eq!(triangle.len(), 20);
    for (n, t_s) in triangle.iter().enumerate() {
        close(*t_s, 0.5 + n as f64, 1e-8, "triangle");
    }
    let exponential: Vec<f64> = all.iter().filter(|e| e.line == 2).map(|e| e.t_s).collect();
    assert!(exponential.len() > 15);
    for (n, t_s) in exponential.iter().enumerate() {
        // From 0 to 1 under s = 2: ln 2; then ln 3 each way.
        close(*t_s, 2.0_f64.ln() + n as f64 * 3.0_f64.ln(), 1e-8, "exponential");
    }
}

#[test]
fn mass_on_a_belt_sticks_and_slips() {
    // Spring pulled at speed 1: sticks until k·t = breakaway, then slips.
    let mut patch = Patch::new();
    patch.add("t", Kind::Time(Time), &[]);
    patch.add("x", integrator(0.0), &["v"]);
    patch.add("v", integrator(0.0), &["spring", "friction"]);
    patch.add("spring", Kind::Summer(Summer), &["4 * t", "-4 * x"]);
    let friction = Kind::DryFriction(DryFriction { level: 1.0, breakaway: 2.0 });
    patch.add("friction", friction, &["v", "spring"]);
    let moving = Kind::Comparator(Comparator { threshold: 1e-12, hysteresis: 0.0 });
    patch.add("moving", moving, &["v"]);
    patch.add("line", Kind::Interrupt(Interrupt { line: 0 }), &["moving"]);
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
    close(times[1], 0.5 + slip_s, 1e-8, "stick");
    assert_eq!(simulation.net(NetId(2)) != 0.0, times.len() % 2 == 1);
}
