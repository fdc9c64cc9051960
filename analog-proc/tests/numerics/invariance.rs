//! What must not change an answer: repetition, recording, frames, HOLD, folding.

use crate::{Bench, close, oscillator, tick};
use engine::element::dac::DacPiece;

#[test]
fn runs_repeat_to_the_bit_and_recording_changes_nothing() {
    for patch in ["lorenz.toml", "bouncing-ball.toml"] {
        let run = |every_s: Option<f64>| {
            let mut bench = Bench::shipped(patch);
            let names: Vec<String> =
                bench.ordered.netlist.nets.iter().map(|net| net.name.clone()).collect();
            match every_s {
                Some(every_s) => drop(bench.record(&[&*names[0]], 3.5, every_s)),
                None => drop(bench.run(3.5)),
            }
            names.iter().map(|net| bench.net(net).to_bits()).collect::<Vec<_>>()
        };
        let first = run(None);
        assert_eq!(first, run(None), "{patch}");
        assert_eq!(first, run(Some(0.1)), "{patch}");
        assert_eq!(first, run(Some(0.000_37)), "{patch}");
    }
}

#[test]
fn frames_do_not_change_the_answer() {
    let mut whole = oscillator("dormand-prince");
    whole.run(5.0);
    let mut framed = oscillator("dormand-prince");
    for n in 1..=50 {
        framed.simulation.apply().unwrap();
        framed.simulation.advance_to(tick(0.1) * n).unwrap();
        assert_eq!(framed.simulation.now_s().to_bits(), (tick(0.1) * n).secs().to_bits());
    }
    // Both within the default tolerance of the truth over two cycles.
    assert!((whole.net("x") - framed.net("x")).abs() < 1e-9);
}

#[test]
fn hold_feeds_nothing_through() {
    let mut bench = Bench::new(
        r#"
        in = { kind = "dac", channel = 3, initial = 1.0 }
        run = { kind = "control", line = 0, initial = true }
        y = { kind = "integrator", in = ["in"], operate = "run" }
    "#,
    );
    bench.run(1.0);
    bench.simulation.set_control(0, false);
    bench.simulation.set_dac(3, DacPiece::held(1e300, 1.0));
    bench.simulation.apply().unwrap();
    let before = bench.net("y");
    assert_eq!(bench.run(2.0).net("y").to_bits(), before.to_bits());
    bench.simulation.hold(true);
    bench.simulation.set_control(0, true);
    bench.simulation.apply().unwrap();
    assert_eq!(bench.try_run(3.0).unwrap().reached, tick(2.0));
    assert_eq!(bench.net("y").to_bits(), before.to_bits());
    close(before, 1.0, 1e-12, "held value");
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
    let mut monitors = "nil = { kind = \"constant\", value = 0.0 }\n".to_owned();
    for (i, net) in ["xy", "sum", "sum_2", "pull", "push", "bent"].iter().enumerate() {
        monitors += &format!("keep_{i} = {{ kind = \"multiplier\", in = [\"{net}\", \"nil\"] }}\n");
        monitors += &format!("held_{i} = {{ kind = \"integrator\", in = [\"keep_{i}\"] }}\n");
    }
    let mut folded = Bench::new(blocks);
    let mut plain = Bench::new(&format!("{blocks}{monitors}"));
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
    folded.run(5.0);
    plain.run(5.0);
    for net in ["x", "y", "xy", "sum", "bent", "push", "inverted"] {
        // Both within the tolerance of one truth; the steps differ by the extra states.
        let difference = (folded.net(net) - plain.net(net)).abs();
        assert!(difference < 1e-8, "{net}: {difference:e}");
    }
}
