//! Each kind of block against its formula or analytic solution.
//!
//! Memoryless blocks are compared with their formulas to the rounding of the few operations
//! in them.

use crate::{Bench, close};
use engine::element::dac::DacPiece;

/// Rounding of a dozen operations on values up to eight.
const ROUNDING: f64 = 12.0 * 8.0 * f64::EPSILON;

#[test]
fn resolvers_turn_either_way_about_one_angle() {
    let blocks = r#"
        t = { kind = "time" }
        two = { kind = "constant", value = 2.0 }
        forth = { kind = "resolver", in = ["t", "two", "3 * t"] }
        back = { kind = "resolver", in = ["forth.x", "forth.y", "-3 * t"] }
    "#;
    // Argument 3t up to 6: its rounding, 6 ulp, turns a vector of length 2.9.
    Bench::new(blocks)
        .follows("forth.x", 2.0, ROUNDING, |t| t * (3.0 * t).cos() - 2.0 * (3.0 * t).sin());
    Bench::new(blocks)
        .follows("forth.y", 2.0, ROUNDING, |t| t * (3.0 * t).sin() + 2.0 * (3.0 * t).cos());
    Bench::new(blocks).follows("back.x", 2.0, ROUNDING, |t| t);
    Bench::new(blocks).follows("back.y", 2.0, ROUNDING, |_| 2.0);
}

#[test]
fn two_variable_function_is_bilinear_and_flat_beyond_its_table() {
    // The table holds x·y, which bilinear interpolation reproduces.
    let blocks = r#"
        t = { kind = "time" }
        one = { kind = "constant", value = 1.0 }
        v = { kind = "summer", in = ["2 * one", "-t"] }
        z = { kind = "function-2d", in = ["1.5 * t", "v"], x = [0.5, 1.0, 2.5], y = [-0.5, 0.5, 1.5], z = [[-0.25, 0.25, 0.75], [-0.5, 0.5, 1.5], [-1.25, 1.25, 3.75]] }
    "#;
    Bench::new(blocks)
        .follows("z", 3.0, ROUNDING, |t| (1.5 * t).clamp(0.5, 2.5) * (2.0 - t).clamp(-0.5, 1.5));
}

#[test]
fn levels_given_by_nets_move_the_corners() {
    let blocks = r#"
        t = { kind = "time" }
        one = { kind = "constant", value = 1.0 }
        u = { kind = "signal-generator", wave = "sine", amplitude = 2.0, frequency = 0.5 }
        w = { kind = "summer", in = ["0.2 * one", "0.3 * t"] }
        zone = { kind = "dead-zone", in = ["u"], width = "w" }
        limited = { kind = "limiter", in = ["u"], limit = "w" }
        fixed_zone = { kind = "dead-zone", in = ["u"], width = 0.7 }
        fixed = { kind = "limiter", in = ["u"], limits = [-0.5, 1.2] }
    "#;
    let u = |t: f64| 2.0 * (std::f64::consts::TAU * (0.5 * t)).sin();
    let w = |t: f64| 0.2 + 0.3 * t;
    Bench::new(blocks)
        .follows("zone", 3.0, ROUNDING, |t| u(t).signum() * (u(t).abs() - w(t)).max(0.0));
    Bench::new(blocks).follows("limited", 3.0, ROUNDING, |t| u(t).clamp(-w(t), w(t)));
    Bench::new(blocks)
        .follows("fixed_zone", 3.0, ROUNDING, |t| u(t).signum() * (u(t).abs() - 0.7).max(0.0));
    Bench::new(blocks).follows("fixed", 3.0, ROUNDING, |t| u(t).clamp(-0.5, 1.2));
}

#[test]
fn digital_function_follows_its_ordinates() {
    let mut bench = Bench::new(
        r#"
        t = { kind = "time" }
        f = { kind = "digital-function", in = ["t"], x = [0.0, 1.0, 3.0], first-channel = 4, initial = [1.0, 2.0, 0.0] }
        area = { kind = "integrator", in = ["f"] }
    "#,
    );
    bench.run(0.5);
    close(bench.net("f"), 1.5, 1e-15, "between the first two");
    bench.simulation.set_dcu(5, 4.0);
    bench.simulation.apply().unwrap();
    close(bench.net("f"), 2.5, 1e-15, "with the new ordinate");
    bench.run(2.0);
    close(bench.net("f"), 2.0, 1e-15, "on the falling piece");
    bench.run(4.0);
    assert_eq!(bench.net("f"), 0.0);
    // Trapezia: (1 + 1.5)/4 + (2.5 + 4)/4 + 4.
    close(bench.net("area"), 0.625 + 1.625 + 4.0, 1e-9, "area");
}

#[test]
fn switch_and_flip_flop_act_at_their_instants() {
    let mut bench = Bench::new(
        r#"
        t = { kind = "time" }
        one_past = { kind = "comparator", in = ["t"], threshold = 1.0 }
        two_past = { kind = "comparator", in = ["t"], threshold = 2.0 }
        q = { kind = "flip-flop", in = ["one_past", "two_past"] }
        line = { kind = "interrupt", in = ["q"], line = 0 }
        u = { kind = "switch", control = "q", in = ["t", "-2 * t"] }
        y = { kind = "integrator", in = ["u"] }
    "#,
    );
    bench.run(3.0);
    let edges = bench.all_edges();
    // Reset prevails while set is still up.
    assert_eq!(edges.len(), 2);
    assert!(edges[0].rising && (edges[0].t_s - 1.0).abs() <= 2.0 * f64::EPSILON);
    assert!(!edges[1].rising && (edges[1].t_s - 2.0).abs() <= 4.0 * f64::EPSILON);
    // −1 up to 1, + 1.5 up to 2, − 5 up to 3.
    close(bench.net("y"), -4.5, 1e-9, "integral");
}

#[test]
fn counters_count_rising_edges_until_reset_and_pulses_have_their_width() {
    let mut bench = Bench::new(
        r#"
        t = { kind = "time" }
        w = { kind = "signal-generator", wave = "square", frequency = 2.0, start = 0.25 }
        clock = { kind = "comparator", in = ["w"] }
        late = { kind = "comparator", in = ["t"], threshold = 2.5 }
        n = { kind = "counter", in = ["clock", "late"] }
        ring = { kind = "counter", in = ["clock"], modulo = 3 }
        pulse = { kind = "one-shot", in = ["late"], width = 0.125 }
        line = { kind = "interrupt", in = ["pulse"], line = 2 }
        sense = { kind = "sense", in = ["pulse"], line = 5 }
        one = { kind = "constant", value = 1.0 }
        on = { kind = "integrator", in = ["one"], operate = "pulse" }
    "#,
    );
    // Edges at 0.25, 0.75, 1.25, 1.75, 2.25.
    bench.run(2.4);
    assert_eq!((bench.net("n"), bench.net("ring")), (5.0, 2.0));
    assert!(bench.run(2.6).simulation.sense(5));
    assert!(!bench.run(3.0).simulation.sense(5));
    assert_eq!((bench.net("n"), bench.net("ring")), (0.0, 0.0));
    let edges = bench.all_edges();
    assert_eq!(edges.len(), 2);
    // One pulse, as long as its width to the resolution of time.
    assert!((edges[1].t_s - edges[0].t_s - 0.125).abs() <= 4.0 * f64::EPSILON);
    assert!((bench.net("on") - 0.125).abs() < 1e-14);
}

/// Lags of a kind against the solutions of their equations.
#[test]
fn followers_answer_steps_and_ramps() {
    let follows = |y: &str, until_s, limit, truth: fn(f64) -> f64| {
        let blocks = format!(
            "three = {{ kind = \"constant\", value = 3.0 }}\nt = {{ kind = \"time\" }}\ny = {{ {y} }}"
        );
        Bench::new(&blocks).follows("y", until_s, limit, truth);
    };
    let lag = "kind = \"lag\", in = [\"three\"], tau = 0.5, gain = 2.0, ic = 1.0";
    follows(lag, 3.0, 6e-8, |t| 6.0 - 5.0 * (-2.0 * t).exp());
    // The rate falls below its limit where 3 − y = 2·0.01, at t = 1.49.
    let slews = "kind = \"rate-limiter\", in = [\"three\"], rate = 2.0, tau = 0.01";
    follows(slews, 1.6, 3e-8, |t| {
        if t <= 1.49 { 2.0 * t } else { 3.0 - 0.02 * (-(t - 1.49) / 0.01).exp() }
    });
    // Half its width behind: τ·dy/dt = t − ½ − y from t = ½ on.
    let backlash = "kind = \"backlash\", in = [\"t\"], width = 1.0, tau = 0.05";
    follows(backlash, 2.0, 2e-8, |t| {
        let s = (t - 0.5).max(0.0);
        s - 0.05 * (1.0 - (-s / 0.05).exp())
    });
}

#[test]
fn noise_is_normal_white_and_repeats_by_its_seed() {
    let run = |seed: u64| {
        let blocks =
            format!("n = {{ kind = \"noise\", sigma = 2.0, every = 0.005, seed = {seed} }}\n");
        // Every second value: an instant of recording and one of renewal may differ by
        // a rounding, and then a value would be met twice.
        let rows = Bench::new(&blocks).record(&["n"], 100.0, 0.01);
        rows.into_iter().map(|row| row.1[0]).collect::<Vec<f64>>()
    };
    let x = run(7);
    assert_eq!(x, run(7));
    assert_ne!(x, run(8));
    // Five standard errors each: a sound source fails one seed in a million.
    let n = x.len() as f64;
    let five = 5.0 / n.sqrt();
    let mean = x.iter().sum::<f64>() / n;
    assert!(mean.abs() < 2.0 * five, "mean {mean}");
    let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    // The variance of a normal variance is 2σ⁴/n.
    assert!((variance - 4.0).abs() < 4.0 * 2.0_f64.sqrt() * five, "{variance}");
    let next: f64 = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n * variance);
    assert!(next.abs() < five, "correlation {next}");
    // Of a normal sample 68.27 % lie within σ.
    let within = x.iter().filter(|x| x.abs() < 2.0).count() as f64 / n;
    let deviation = (0.6827_f64 * 0.3173).sqrt() * five;
    assert!((within - 0.6827).abs() < deviation, "{within} within sigma");
}

#[test]
fn settling_converter_starts_from_what_it_had() {
    let mut bench = Bench::new(
        r#"
        u = { kind = "dac", channel = 3 }
        k = { kind = "mdac", channel = 4, in = ["two"] }
        two = { kind = "constant", value = 2.0 }
        y = { kind = "integrator", in = ["k"] }
    "#,
    );
    let transfer = |bench: &mut Bench, value: f64, from_s: f64, settling_s: f64| {
        let piece = DacPiece { value, slope_per_s: 0.0, from_s, settling_s };
        bench.simulation.set_dac(3, piece);
        bench.simulation.set_dac(4, piece);
        bench.simulation.apply().unwrap();
    };
    bench.run(1.0);
    assert_eq!(bench.net("y"), 0.0);
    transfer(&mut bench, 2.0, 1.0, 0.1);
    bench.run(1.05);
    let first = 2.0 - 2.0 * (-0.5_f64).exp();
    close(bench.net("u"), first, 1e-14, "half settled");
    transfer(&mut bench, -1.0, 1.05, 0.1);
    close(bench.net("u"), first, 1e-14, "at the second transfer");
    bench.run(1.15);
    let second = -1.0 + (first + 1.0) * (-1.0_f64).exp();
    close(bench.net("u"), second, 1e-13, "on the way to the second");
    close(bench.net("k"), 2.0 * second, 1e-13, "multiplying");
    transfer(&mut bench, 0.5, 1.15, 0.0);
    assert_eq!(bench.net("u"), 0.5);
    bench.run(2.0);
    assert_eq!(bench.net("u"), 0.5);
    // Twice the integrals of the three parts; e^{-t/0.1} leaves 0.1·(1 − e^{-…}) each.
    let one = 2.0 * 0.05 - 0.2 * (1.0 - (-0.5_f64).exp());
    let two = -0.1 + 0.1 * (first + 1.0) * (1.0 - (-1.0_f64).exp());
    close(bench.net("y"), 2.0 * (one + two + 0.85 * 0.5), 1e-8, "integral");
}

#[test]
fn coefficients_act_from_the_instant_they_are_set() {
    let mut bench = Bench::new(
        r#"
        a = { kind = "dcu", channel = 0, in = ["-y"], initial = 0.5 }
        b = { kind = "dcu", channel = 1, in = ["a"], initial = 2.0 }
        y = { kind = "integrator", in = ["b"], ic = 1.0 }
    "#,
    );
    bench.run(1.0);
    close(bench.net("y"), (-1.0_f64).exp(), 1e-8, "with 0.5 · 2");
    bench.simulation.set_dcu(1, 6.0);
    bench.simulation.apply().unwrap();
    close(bench.net("b"), -3.0 * bench.net("y"), 1e-15, "at once");
    bench.run(1.5);
    close(bench.net("y"), (-2.5_f64).exp(), 1e-8, "with 0.5 · 6");
    // What has been set outlives a reset.
    bench.simulation.reset().unwrap();
    bench.run(0.5);
    close(bench.net("y"), (-1.5_f64).exp(), 1e-8, "after a reset");
}

/// Edges that nobody takes are bounded, and their loss is counted.
#[test]
fn edges_that_nobody_takes_do_not_pile_up() {
    let mut bench = Bench::new(
        r#"
        w = { kind = "signal-generator", wave = "square", frequency = 100000.0 }
        clock = { kind = "comparator", in = ["w"] }
        line = { kind = "interrupt", in = ["clock"], line = 0 }
    "#,
    );
    bench.run(0.5);
    let lost = bench.simulation.statistics().edges_lost;
    let kept = bench.all_edges();
    assert!(kept.len() <= 65_536 && lost > 0);
    // Two edges a period from t = 0 on, the first of which is the settled start.
    let made = kept.len() as u64 + lost;
    assert!((99_999..=100_001).contains(&made), "{made} edges");
    let last = kept.last().unwrap().t_s;
    assert!((last - 0.5).abs() < 1.1e-5, "the latest are kept, up to {last}");
}

#[test]
fn dac_slopes_and_settling_are_integrated_exactly() {
    let mut bench = Bench::new(
        r#"
        in = { kind = "dac", channel = 0 }
        y = { kind = "integrator", in = ["in"] }
    "#,
    );
    bench.run(1.0);
    let piece = DacPiece { value: 2.0, slope_per_s: 3.0, from_s: 1.0, settling_s: 0.1 };
    bench.simulation.set_dac(0, piece);
    bench.simulation.apply().unwrap();
    assert_eq!(bench.net("in"), 0.0);
    // ∫(2 + 3s − 2e^{−s/0.1}) ds over one second.
    let expected = 2.0 + 1.5 - 0.2 * (1.0 - (-10.0_f64).exp());
    close(bench.run(2.0).net("y"), expected, 1e-9, "integral");
}

#[test]
fn limited_integrator_rests_on_its_limit() {
    // dy/dt = cos t between ±0.5: leaves the stop where the input turns, t = π/2.
    let mut bench = Bench::new(
        r#"
        c = { kind = "integrator", in = ["-1 * s"], ic = 1.0 }
        s = { kind = "integrator", in = ["c"] }
        y = { kind = "integrator", in = ["c"], limits = [-0.5, 0.5] }
    "#,
    );
    assert_eq!(bench.run(1.0).net("y"), 0.5);
    assert!((bench.run(2.0).net("y") - (0.5 + 2.0_f64.sin() - 1.0)).abs() < 1e-9);
}

/// A run that is reset on a corner which its signal leaves: what was seen there is of another run.
#[test]
fn a_reset_on_a_corner_begins_anew() {
    let blocks = "\
        one = { kind = \"constant\", value = 1.0 }\n\
        nothing = { kind = \"constant\", value = 0.0 }\n\
        x = { kind = \"integrator\", in = [\"-one\"] }\n\
        m = { kind = \"max\", in = [\"nothing\", \"x\"] }\n";
    let mut bench = Bench::new(blocks);
    for _ in 0..2 {
        bench.simulation.reset().unwrap();
    }
    bench.run(1.0);
    assert_eq!(bench.net("m"), 0.0);
}
