//! Each kind of block against its formula or analytic solution.
//!
//! Default settings claim 1e-8 relative of integrated results. Memoryless blocks are
//! compared with their formulas to the rounding of the few operations in them.

#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

mod common;

use analog_proc::order::Ordered;
use analog_proc::patch::compile;
use common::{close, tick};
use engine::element::dac::DacPiece;
use engine::id::NetId;
use engine::simulation::Simulation;
use interface::control::PatchBundle;

struct Bench {
    ordered: Ordered,
    simulation: Simulation,
}

fn bench(blocks: &str) -> Bench {
    let bundle = PatchBundle {
        root: "test.toml".into(),
        files: vec![("test.toml".into(), format!("[blocks]\n{blocks}"))],
    };
    let ordered = compile(&bundle, &[]).unwrap_or_else(|faults| panic!("{}", faults.render()));
    let simulation = ordered.simulation().unwrap();
    Bench { ordered, simulation }
}

impl Bench {
    fn id(&self, name: &str) -> NetId {
        let nets = &self.ordered.netlist.nets;
        NetId(nets.iter().position(|net| net.name == name).unwrap() as u32)
    }

    fn advance(&mut self, s: f64) {
        self.simulation.advance_to(tick(s)).unwrap();
    }

    fn net(&self, name: &str) -> f64 {
        self.simulation.net(self.id(name))
    }

    /// Nets at every hundredth of a second up to `stop_s`.
    fn record(&mut self, names: &[&str], stop_s: f64) -> Vec<(f64, Vec<f64>)> {
        let nets: Vec<NetId> = names.iter().map(|name| self.id(name)).collect();
        let mut rows = Vec::new();
        self.simulation
            .advance_recording(tick(stop_s), tick(0.01), &nets, |t_s, values| {
                rows.push((t_s, values.to_vec()));
            })
            .unwrap();
        assert_eq!(rows.len(), (stop_s * 100.0).round() as usize);
        rows
    }

    /// Compares a net with `truth(t)` at every hundredth of a second.
    fn follows(&mut self, name: &str, stop_s: f64, limit: f64, truth: impl Fn(f64) -> f64) {
        let worst = self
            .record(&[name], stop_s)
            .into_iter()
            .map(|(t_s, values)| ((values[0] - truth(t_s)).abs(), t_s))
            .fold((0.0, 0.0), |w, d| if d.0 > w.0 { d } else { w });
        assert!(worst.0 <= limit, "{name}: {:e} at {} s", worst.0, worst.1);
        assert!(self.net(name).is_finite());
    }

    fn edges(&mut self) -> Vec<(bool, f64)> {
        let mut edges = Vec::new();
        self.simulation.take_edges(&mut edges);
        edges.iter().map(|e| (e.rising, e.t_s)).collect()
    }
}

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
    bench(blocks)
        .follows("forth.x", 2.0, ROUNDING, |t| t * (3.0 * t).cos() - 2.0 * (3.0 * t).sin());
    bench(blocks)
        .follows("forth.y", 2.0, ROUNDING, |t| t * (3.0 * t).sin() + 2.0 * (3.0 * t).cos());
    bench(blocks).follows("back.x", 2.0, ROUNDING, |t| t);
    bench(blocks).follows("back.y", 2.0, ROUNDING, |_| 2.0);
}

#[test]
fn arctangent_covers_four_quadrants_and_its_jump_is_located() {
    let mut bench = bench(
        r#"
        c = { kind = "integrator", in = ["-s"], ic = 1.0 }
        s = { kind = "integrator", in = ["c"] }
        angle = { kind = "arctangent", in = ["s", "c"] }
        area = { kind = "integrator", in = ["angle"] }
    "#,
    );
    let pi = std::f64::consts::PI;
    // t up to π, then t − 2π; the phase of the oscillator is good to the tolerance.
    bench.follows("angle", 4.0, 1e-8, |t| if t < pi { t } else { t - 2.0 * pi });
    let beyond = 4.0 - 2.0 * pi;
    let area = 0.5 * pi * pi + 0.5 * (beyond * beyond - pi * pi);
    close(bench.net("area"), area, 1e-8, "area");
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
    bench(blocks)
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
    bench(blocks).follows("zone", 3.0, ROUNDING, |t| u(t).signum() * (u(t).abs() - w(t)).max(0.0));
    bench(blocks).follows("limited", 3.0, ROUNDING, |t| u(t).clamp(-w(t), w(t)));
    bench(blocks)
        .follows("fixed_zone", 3.0, ROUNDING, |t| u(t).signum() * (u(t).abs() - 0.7).max(0.0));
    bench(blocks).follows("fixed", 3.0, ROUNDING, |t| u(t).clamp(-0.5, 1.2));
}

#[test]
fn digital_function_follows_its_ordinates() {
    let mut bench = bench(
        r#"
        t = { kind = "time" }
        f = { kind = "digital-function", in = ["t"], x = [0.0, 1.0, 3.0], first-channel = 4, initial = [1.0, 2.0, 0.0] }
        area = { kind = "integrator", in = ["f"] }
    "#,
    );
    bench.advance(0.5);
    close(bench.net("f"), 1.5, 1e-15, "between the first two");
    bench.simulation.set_dcu(5, 4.0);
    bench.simulation.apply().unwrap();
    close(bench.net("f"), 2.5, 1e-15, "with the new ordinate");
    bench.advance(2.0);
    close(bench.net("f"), 2.0, 1e-15, "on the falling piece");
    bench.advance(4.0);
    assert_eq!(bench.net("f"), 0.0);
    // Trapezia: (1 + 1.5)/4 + (2.5 + 4)/4 + 4.
    close(bench.net("area"), 0.625 + 1.625 + 4.0, 1e-9, "area");
}

#[test]
fn track_store_keeps_what_it_had() {
    let mut bench = bench(
        r#"
        t = { kind = "time" }
        late = { kind = "comparator", in = ["t"], threshold = 1.0 }
        track = { kind = "not", in = ["late"] }
        y = { kind = "track-store", in = ["2 * t"], track = "track", ic = 9.0 }
    "#,
    );
    bench.advance(0.75);
    assert_eq!(bench.net("y"), 1.5);
    bench.advance(2.0);
    // The instant is located to two units in the last place of 1.
    close(bench.net("y"), 2.0, 4.0 * f64::EPSILON, "stored");
}

#[test]
fn switch_and_flip_flop_act_at_their_instants() {
    let mut bench = bench(
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
    bench.advance(3.0);
    let edges = bench.edges();
    // Reset prevails while set is still up.
    assert_eq!(edges.len(), 2);
    assert!(edges[0].0 && (edges[0].1 - 1.0).abs() <= 2.0 * f64::EPSILON);
    assert!(!edges[1].0 && (edges[1].1 - 2.0).abs() <= 4.0 * f64::EPSILON);
    // −1 up to 1, + 1.5 up to 2, − 5 up to 3.
    close(bench.net("y"), -4.5, 1e-9, "integral");
}

#[test]
fn counter_counts_rising_edges_until_reset() {
    let mut bench = bench(
        r#"
        t = { kind = "time" }
        w = { kind = "signal-generator", wave = "square", frequency = 2.0, start = 0.25 }
        clock = { kind = "comparator", in = ["w"] }
        late = { kind = "comparator", in = ["t"], threshold = 2.5 }
        n = { kind = "counter", in = ["clock", "late"] }
        pulse = { kind = "one-shot", in = ["late"], width = 0.125 }
        line = { kind = "interrupt", in = ["pulse"], line = 2 }
    "#,
    );
    // Edges at 0.25, 0.75, 1.25, 1.75, 2.25.
    bench.advance(2.4);
    assert_eq!(bench.net("n"), 5.0);
    bench.advance(3.0);
    assert_eq!(bench.net("n"), 0.0);
    let edges = bench.edges();
    assert_eq!(edges.len(), 2);
    // One pulse, as long as its width to the resolution of time.
    assert!((edges[1].1 - edges[0].1 - 0.125).abs() <= 4.0 * f64::EPSILON);
}

#[test]
fn lag_answers_a_step_exponentially() {
    let blocks = r#"
        three = { kind = "constant", value = 3.0 }
        y = { kind = "lag", in = ["three"], tau = 0.5, gain = 2.0, ic = 1.0 }
    "#;
    bench(blocks).follows("y", 3.0, 6e-8, |t| 6.0 - 5.0 * (-2.0 * t).exp());
}

#[test]
fn rate_limiter_slews_then_settles() {
    let blocks = r#"
        three = { kind = "constant", value = 3.0 }
        y = { kind = "rate-limiter", in = ["three"], rate = 2.0, tau = 0.01 }
    "#;
    // The rate falls below its limit where 3 − y = 2·0.01, at t = 1.49.
    bench(blocks).follows("y", 1.6, 3e-8, |t| {
        if t <= 1.49 { 2.0 * t } else { 3.0 - 0.02 * (-(t - 1.49) / 0.01).exp() }
    });
}

#[test]
fn backlash_follows_half_its_width_behind() {
    let blocks = r#"
        t = { kind = "time" }
        y = { kind = "backlash", in = ["t"], width = 1.0, tau = 0.05 }
    "#;
    // τ·dy/dt = t − ½ − y from t = ½ on.
    bench(blocks).follows("y", 2.0, 2e-8, |t| {
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
        let rows = bench(&blocks).record(&["n"], 100.0);
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
    let mut bench = bench(
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
    bench.advance(1.0);
    assert_eq!(bench.net("y"), 0.0);
    transfer(&mut bench, 2.0, 1.0, 0.1);
    bench.advance(1.05);
    let first = 2.0 - 2.0 * (-0.5_f64).exp();
    close(bench.net("u"), first, 1e-14, "half settled");
    transfer(&mut bench, -1.0, 1.05, 0.1);
    close(bench.net("u"), first, 1e-14, "at the second transfer");
    bench.advance(1.15);
    let second = -1.0 + (first + 1.0) * (-1.0_f64).exp();
    close(bench.net("u"), second, 1e-13, "on the way to the second");
    close(bench.net("k"), 2.0 * second, 1e-13, "multiplying");
    transfer(&mut bench, 0.5, 1.15, 0.0);
    assert_eq!(bench.net("u"), 0.5);
    bench.advance(2.0);
    assert_eq!(bench.net("u"), 0.5);
    // Twice the integrals of the three parts; e^{-t/0.1} leaves 0.1·(1 − e^{-…}) each.
    let one = 2.0 * 0.05 - 0.2 * (1.0 - (-0.5_f64).exp());
    let two = -0.1 + 0.1 * (first + 1.0) * (1.0 - (-1.0_f64).exp());
    close(bench.net("y"), 2.0 * (one + two + 0.85 * 0.5), 1e-8, "integral");
}

#[test]
fn coefficients_act_from_the_instant_they_are_set() {
    let mut bench = bench(
        r#"
        a = { kind = "dcu", channel = 0, in = ["-y"], initial = 0.5 }
        b = { kind = "dcu", channel = 1, in = ["a"], initial = 2.0 }
        y = { kind = "integrator", in = ["b"], ic = 1.0 }
    "#,
    );
    bench.advance(1.0);
    close(bench.net("y"), (-1.0_f64).exp(), 1e-8, "with 0.5 · 2");
    bench.simulation.set_dcu(1, 6.0);
    bench.simulation.apply().unwrap();
    close(bench.net("b"), -3.0 * bench.net("y"), 1e-15, "at once");
    bench.advance(1.5);
    close(bench.net("y"), (-2.5_f64).exp(), 1e-8, "with 0.5 · 6");
    // What has been set outlives a reset.
    bench.simulation.reset().unwrap();
    bench.advance(0.5);
    close(bench.net("y"), (-1.5_f64).exp(), 1e-8, "after a reset");
}

/// One set of equations twice: as a programmer patches it, and with a monitor on every
/// net, so that nothing has a single reader and nothing can be folded into it.
#[test]
fn folding_does_not_change_the_equations() {
    let blocks = r#"
        x = { kind = "integrator", in = ["pull", "-0.3 * xy"], ic = 1.0 }
        y = { kind = "integrator", in = ["push", "bent"], ic = 0.5 }
        gain = { kind = "gain", in = ["x"], k = -1.5 }
        inverted = { kind = "inverter", in = ["gain"] }
        pull = { kind = "summer", in = ["gain", "0.5 * y", "u"] }
        u = { kind = "dcu", channel = 2, in = ["y"], initial = 0.25 }
        xy = { kind = "multiplier", in = ["inverted", "u", "y"] }
        sum = { kind = "summer", in = ["x", "-2 * y"] }
        bent = { kind = "limiter", in = ["sum"], limits = [-0.4, 0.4] }
        push = { kind = "summer", in = ["sum_2"] }
        sum_2 = { kind = "summer", in = ["0.1 * x", "-0.2 * y", "0.3 * gain", "0.1 * inverted", "0.1 * u"] }
    "#;
    let mut monitors = String::new();
    for (i, net) in ["xy", "sum", "sum_2", "pull", "push", "bent"].iter().enumerate() {
        let limited =
            format!("keep_{i} = {{ kind = \"multiplier\", in = [\"{net}\", \"nil\"] }}\n");
        monitors += &limited;
        monitors += &format!("held_{i} = {{ kind = \"integrator\", in = [\"keep_{i}\"] }}\n");
    }
    let mut folded = bench(blocks);
    let nil = "nil = { kind = \"constant\", value = 0.0 }\n";
    let mut plain = bench(&format!("{blocks}{nil}{monitors}"));
    let operations = |bench: &Bench| bench.simulation.machine().operations();
    assert!(operations(&folded) < operations(&plain));
    // Derivatives at the start, by hand: u = 0.125, gain = −1.5, inverted = 1.5.
    let xy = 1.5 * 0.125 * 0.5;
    let x_rate = -1.5 + 0.25 + 0.125 - 0.3 * xy;
    let y_rate = 0.1 - 0.1 - 0.45 + 0.15 + 0.0125;
    for bench in [&folded, &plain] {
        for (net, rate) in [("x", x_rate), ("y", y_rate)] {
            let driver = bench.ordered.netlist.nets[bench.id(net).index()].driver;
            let found = bench.simulation.derivative(driver).unwrap();
            // A dozen roundings of terms up to 1.5.
            assert!((found - rate).abs() < 12.0 * 1.5 * f64::EPSILON, "{net}: {found}");
        }
    }
    folded.advance(5.0);
    plain.advance(5.0);
    for net in ["x", "y", "xy", "sum", "bent", "push", "inverted"] {
        // Both within the tolerance of one truth; the steps differ by the extra states.
        assert!(
            (folded.net(net) - plain.net(net)).abs() < 1e-8,
            "{net}: {} and {}",
            folded.net(net),
            plain.net(net)
        );
    }
}

/// Edges that nobody takes are bounded, and their loss is counted.
#[test]
fn edges_that_nobody_takes_do_not_pile_up() {
    let mut bench = bench(
        r#"
        w = { kind = "signal-generator", wave = "square", frequency = 100000.0 }
        clock = { kind = "comparator", in = ["w"] }
        line = { kind = "interrupt", in = ["clock"], line = 0 }
    "#,
    );
    bench.advance(0.5);
    let lost = bench.simulation.statistics().edges_lost;
    let kept = bench.edges();
    assert!(kept.len() <= 65_536 && lost > 0);
    // Two edges a period from t = 0 on, the first of which is the settled start.
    let made = kept.len() as u64 + lost;
    assert!((99_999..=100_001).contains(&made), "{made} edges");
    let last = kept.last().unwrap().1;
    assert!((last - 0.5).abs() < 1.1e-5, "the latest are kept, up to {last}");
}
