//! Blocks with corners, stops or memory, under the engine, against exact answers.

use crate::common::{Patch, close, integrator, tick};
use crate::edges;
use analog_proc::block::kind::*;
use analog_proc::net::Level;
use engine::element::dac::DacPiece;
use engine::id::NetId;

#[test]
fn dead_zone_is_odd_and_limiter_corners_are_exact() {
    let mut patch = Patch::new();
    patch.add("t", Kind::Time(Time), &[]);
    let sine = |phase_rad: f64| {
        Kind::Generator(Generator {
            wave: Wave::Sine,
            amplitude: 2.0,
            offset: 0.0,
            frequency_hz: 1.0,
            phase_rad,
            start_s: 0.0,
        })
    };
    patch.add("s", sine(0.0), &[]);
    let zone = Kind::DeadZone(DeadZone { width: Level::Fixed(0.5) });
    let up = patch.add("up", zone.clone(), &["s"]);
    let down = patch.add("down", zone, &["-1 * s"]);
    let limiter = Kind::Limiter(Limiter { low: Level::Fixed(-1.0), high: Level::Fixed(1.0) });
    let limited = patch.add("limited", limiter, &["s"]);
    patch.add("area", integrator(0.0), &["limited"]);
    patch.add(
        "full",
        Kind::Comparator(Comparator { threshold: 0.999_999_999_999, hysteresis: 0.0 }),
        &["limited"],
    );
    patch.add("line", Kind::Interrupt(Interrupt { line: 0 }), &["full"]);
    let mut simulation = patch.simulation();
    let mut worst: f64 = 0.0;
    let mut seen = 0;
    simulation
        .advance_recording(tick(1.0), tick(0.001), &[up, down, limited, NetId(1)], |_, v| {
            worst = worst.max((v[0] + v[1]).abs());
            let expected = v[3].clamp(-1.0, 1.0);
            worst = worst.max((v[2] - expected).abs());
            seen += 1;
        })
        .unwrap();
    assert_eq!(seen, 1000);
    // Band of a corner: 4 units in the last place of 1.
    assert!(worst <= 1e-15, "{worst:e}");
    // 2·sin(2πt) reaches 1 at t = 1/12.
    let first = edges(&mut simulation)[0];
    close(first.t_s, 1.0 / 12.0, 1e-11, "corner");
    // ∫ over the half period: of the limited sine, 2·(2 − √3)/(2π) + 1/3.
    simulation.reset().unwrap();
    simulation.advance_to(tick(0.5)).unwrap();
    let expected = 2.0 * (1.0 - 0.75_f64.sqrt()) * 2.0 / std::f64::consts::TAU + 1.0 / 3.0;
    close(simulation.net(patch.id("area")), expected, 1e-9, "area");
}

#[test]
fn transport_delay_shifts_a_sine() {
    let mut patch = Patch::new();
    patch.integration.rtol = 1e-9;
    patch.add("x", integrator(0.0), &["v"]);
    patch.add("v", integrator(2.0), &["-4 * x"]);
    let delayed = patch.add(
        "delayed",
        Kind::TransportDelay(TransportDelay { delay: 0.3, initial: -5.0 }),
        &["x"],
    );
    let mut simulation = patch.simulation();
    let mut worst: f64 = 0.0;
    simulation
        .advance_recording(tick(6.0), tick(0.01), &[delayed], |t_s, v| {
            let expected = if t_s < 0.3 { -5.0 } else { (2.0 * (t_s - 0.3)).sin() };
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
    patch.add("d", Kind::TransportDelay(TransportDelay { delay: 1.0, initial: 1.0 }), &["y"]);
    let mut simulation = patch.simulation();
    for (t_s, y) in [(1.0, 0.0), (2.0, -0.5), (3.0, -1.0 / 6.0)] {
        simulation.advance_to(tick(t_s)).unwrap();
        // Piecewise polynomials of degree ≤ 3 are exact but for rounding and breakpoints.
        assert!((simulation.net(NetId(0)) - y).abs() < 1e-12, "{}", simulation.net(NetId(0)));
    }
}

#[test]
fn dac_slopes_and_settling_are_integrated_exactly() {
    let mut patch = Patch::new();
    patch.add("in", Kind::Dac(Dac { channel: 0, initial: 0.0 }), &[]);
    patch.add("y", integrator(0.0), &["in"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(1.0)).unwrap();
    let piece = DacPiece { value: 2.0, slope_per_s: 3.0, from_s: 1.0, settling_s: 0.1 };
    simulation.set_dac(0, piece);
    simulation.apply().unwrap();
    assert_eq!(simulation.net(NetId(0)), 0.0);
    simulation.advance_to(tick(2.0)).unwrap();
    // ∫(2 + 3s − 2e^{−s/0.1}) ds over one second.
    let expected = 2.0 + 1.5 - 0.2 * (1.0 - (-10.0_f64).exp());
    close(simulation.net(NetId(1)), expected, 1e-9, "integral");
}

#[test]
fn limited_integrator_rests_on_its_limit() {
    // dy/dt = cos t between ±0.5: leaves the stop where the input turns, t = π/2.
    let mut patch = Patch::new();
    patch.add("c", integrator(1.0), &["-1 * s"]);
    patch.add("s", integrator(0.0), &["c"]);
    let limits = Some([-0.5, 0.5]);
    let limited = Kind::Integrator(Integrator {
        ic: 0.0,
        limits,
        operate: None,
        reset: None,
        reset_to: None,
    });
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
    let square = Kind::Generator(Generator {
        wave: Wave::Square,
        amplitude: 1.0,
        offset: 0.0,
        frequency_hz: 1.0,
        phase_rad: 0.0,
        start_s: 0.25,
    });
    patch.add("w", square, &[]);
    patch.add("clock", Kind::Comparator(Comparator { threshold: 0.0, hysteresis: 0.0 }), &["w"]);
    let count = patch.add("count", Kind::Counter(Counter { modulo: 3 }), &["clock"]);
    patch.add("pulse", Kind::OneShot(OneShot { width_s: 0.125 }), &["clock"]);
    patch.add("one", Kind::Constant(Constant { value: 1.0 }), &[]);
    patch.add("zero", Kind::Constant(Constant { value: 0.0 }), &[]);
    patch.add("gate", Kind::Switch(Switch { control: NetId(3) }), &["one", "zero"]);
    let on = patch.add("on", integrator(0.0), &["gate"]);
    patch.add("sense", Kind::Sense(Sense { line: 5 }), &["pulse"]);
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
