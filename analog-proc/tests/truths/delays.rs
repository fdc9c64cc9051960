//! Transport delays of signals that no integrator smooths, and what watches their outputs.

use crate::TAU;
use crate::bench::Bench;
use crate::roots::bisect;

#[test]
fn a_generators_sine_comes_out_unharmed() {
    for (frequency, delay_s) in [(1.0, 0.25), (1.0, 2.0), (5.0, 0.1), (3.0, 1.7), (0.2, 3.0)] {
        let mut bench = Bench::new(&format!(
            "s = {{ kind = \"signal-generator\", wave = \"sine\", frequency = {frequency:?}, phase = 0.3 }}\nd = {{ kind = \"transport-delay\", in = [\"s\"], delay = {delay_s:?} }}"
        ));
        let truth = |t: f64| {
            // At the very instant at which the past begins, the row shows what follows.
            if t < delay_s - 1e-9 { 0.0 } else { (TAU * frequency * (t - delay_s) + 0.3).sin() }
        };
        let worst = bench.worst("d", 10.0, 1e-3, truth);
        assert!(worst.0 <= 1e-9, "{frequency} Hz by {delay_s} s: {:e} at {} s", worst.0, worst.1);
    }
}

#[test]
fn a_sine_of_time_comes_out_unharmed() {
    let mut bench = Bench::new(
        "t = { kind = \"time\" }\ns = { kind = \"sine\", in = [\"6.283185307179586 * t\"] }\nd = { kind = \"transport-delay\", in = [\"s\"], delay = 5.0 }",
    );
    let worst =
        bench.worst("d", 12.0, 1e-3, |t| if t < 5.0 { 0.0 } else { (TAU * (t - 5.0)).sin() });
    assert!(worst.0 <= 1e-9, "{:e} at {} s", worst.0, worst.1);
}

#[test]
fn a_delayed_sine_is_counted_at_its_peaks() {
    for threshold in [0.9, 0.99, 0.9999] {
        let mut bench = Bench::new(&format!(
            "s = {{ kind = \"signal-generator\", wave = \"sine\", phase = 0.3 }}\nd = {{ kind = \"transport-delay\", in = [\"s\"], delay = 0.37 }}\np = {{ kind = \"comparator\", in = [\"d\"], threshold = {threshold:?} }}\nn = {{ kind = \"counter\", in = [\"p\"] }}"
        ));
        assert_eq!(bench.run(100.37).net("n"), 100.0, "threshold {threshold}");
    }
}

#[test]
fn a_comparator_watches_a_loop_of_one_delay() {
    // y = s + y(t − 0.3)/2: each pass adds s(t − 0.3 k)/2^k, from t = 0.3 k on.
    let mut bench = Bench::new(
        r#"
        s = { kind = "signal-generator", wave = "sine", frequency = 1.3, phase = 0.3 }
        y = { kind = "summer", in = ["s", "0.5 * d"] }
        d = { kind = "transport-delay", in = ["y"], delay = 0.3 }
        p = { kind = "comparator", in = ["d"], threshold = 0.7 }
        line = { kind = "interrupt", in = ["p"], line = 1 }
    "#,
    );
    // The passes that have begun, on the side of the present instant.
    let d = |t: f64, begun: i32| {
        (1..=begun)
            .map(|k| 0.5_f64.powi(k - 1) * (TAU * 1.3 * (t - 0.3 * f64::from(k)) + 0.3).sin())
            .sum::<f64>()
    };
    let mut rises = Vec::new();
    let mut high = false;
    for stretch in 0..20 {
        let (from, to) = (0.3 * f64::from(stretch), 0.3 * f64::from(stretch + 1));
        // A thousandth of a stretch moves d by less than 0.005; nothing comes as near to
        // the level without crossing it (checked below).
        let mut before = from;
        for i in 0..=1000 {
            let t = from + (to - from) * f64::from(i) / 1000.0;
            let value = d(t, stretch) - 0.7;
            if (value > 0.0) != high {
                high = !high;
                if high {
                    let at = if i == 0 { from } else { bisect(|t| d(t, stretch) - 0.7, before, t) };
                    rises.push(at);
                }
            }
            before = t;
        }
    }
    bench.run(6.0);
    let found = bench.edges(1, true);
    assert_eq!(found.len(), rises.len(), "{found:?} instead of {rises:?}");
    for (found, truth) in found.iter().zip(&rises) {
        assert!((found - truth).abs() < 1e-8, "{found} instead of {truth}");
    }
}

#[test]
fn a_comparator_watches_delayed_feedback() {
    // x' = −1.5 x(t − 1) from x = 1: polynomials by the method of steps, Σ (−1.5)^k (t − k + 1)^k / k!.
    let x = |t: f64| {
        let mut sum = 0.0;
        let mut term = 1.0;
        for k in 0..=(t.floor() as i32 + 1) {
            if k > 0 {
                term *= -1.5 / f64::from(k);
            }
            sum += term * (t - f64::from(k) + 1.0).max(0.0).powi(k);
        }
        sum
    };
    let mut bench = Bench::new(
        r#"
        x = { kind = "integrator", in = ["-1.5 * d"], ic = 1.0 }
        d = { kind = "transport-delay", in = ["x"], delay = 1.0, initial = 1.0 }
        p = { kind = "comparator", in = ["d"] }
        line = { kind = "interrupt", in = ["p"], line = 1 }
        n = { kind = "counter", in = ["p"] }
    "#,
    );
    // Polynomials of degree three at most are exact but for rounding and breakpoints.
    let worst = bench.worst("x", 3.0, 1e-2, x);
    assert!(worst.0 <= 1e-12, "{:e} at {} s", worst.0, worst.1);
    let worst = bench.worst("x", 12.0, 1e-2, x);
    // Alternating sums lose five digits by t = 12.
    assert!(worst.0 <= 1e-8, "{:e} at {} s", worst.0, worst.1);
    let mut rises = Vec::new();
    for i in 1..=11_000 {
        let (a, b) = (f64::from(i - 1) * 1e-3, f64::from(i) * 1e-3);
        if x(a) <= 0.0 && x(b) > 0.0 {
            rises.push(bisect(x, a, b) + 1.0);
        }
    }
    let found = bench.edges(1, true);
    assert_eq!(found.len(), rises.len(), "{found:?} instead of {rises:?}");
    for (found, truth) in found.iter().zip(&rises) {
        assert!((found - truth).abs() < 1e-7, "{found} instead of {truth}");
    }
}

#[test]
fn a_jump_inside_a_delay_comes_out_as_a_jump() {
    // A pulse of 1 ms, twenty times delayed in a chain: its area survives each.
    let mut blocks = String::from(
        "s = { kind = \"signal-generator\", wave = \"sine\", phase = 0.3 }\np = { kind = \"comparator\", in = [\"s\"], threshold = 0.999995 }\none = { kind = \"constant\", value = 1.0 }\nzero = { kind = \"constant\", value = 0.0 }\nd0 = { kind = \"switch\", in = [\"one\", \"zero\"], control = \"p\" }\n",
    );
    for i in 1..=8 {
        blocks += &format!(
            "d{i} = {{ kind = \"transport-delay\", in = [\"d{}\"], delay = 0.31 }}\n",
            i - 1
        );
    }
    blocks += "x = { kind = \"integrator\", in = [\"d8\"] }\n";
    let found = Bench::new(&blocks).run(10.0 + 8.0 * 0.31).net("x");
    let truth = 10.0 * 2.0 * 0.999_995_f64.acos() / TAU;
    crate::close(found, truth, 1e-8, "area of ten delayed pulses");
}

#[test]
fn what_a_search_looked_at_is_no_event_of_a_delay_line() {
    // Three lines of incommensurable delays behind squares and a sine, one of them compared.
    let mut bench = Bench::new(
        r#"
        s0 = { kind = "signal-generator", wave = "square", frequency = 1.6594, amplitude = 0.796512 }
        x0 = { kind = "integrator", in = ["s0"] }
        d0 = { kind = "transport-delay", in = ["x0"], delay = 0.511 }
        c0 = { kind = "comparator", in = ["d0"], threshold = 0.18688321942331032 }
        s1 = { kind = "signal-generator", wave = "square", frequency = 7.4522 }
        s2 = { kind = "signal-generator", wave = "square", frequency = 0.3263, amplitude = 0.075049 }
        x2 = { kind = "integrator", in = ["s2"] }
        d2 = { kind = "transport-delay", in = ["x2"], delay = 0.01707 }
        s3 = { kind = "signal-generator", wave = "sine", frequency = 0.1696, phase = 4.1122 }
        d3 = { kind = "transport-delay", in = ["s3"], delay = 0.186 }
    "#,
    );
    bench.run(5.0);
    // Some hundred edges, each followed through every line and five times round.
    let events = bench.simulation.statistics().events;
    assert!(events < 20_000, "{events} events");
}
