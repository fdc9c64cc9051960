//! What stops a run or is told of it: each fault with its block and its instant.

use crate::{Bench, OSCILLATOR, bench::ordered, close};
use analog_proc::session::static_check::static_check;
use engine::{
    fault::RunFault,
    integration::{Integration, OverloadPolicy},
};

#[test]
fn undefined_numbers_are_faults() {
    // The language refuses them; so does the engine, whoever fills its program.
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut patch = ordered(&format!("[blocks]\n{OSCILLATOR}")).unwrap();
        patch.netlist.integration = Integration { rtol: bad, ..patch.netlist.integration };
        assert!(matches!(patch.simulation(), Err(RunFault::Setting { .. })));
    }
    // 1e200² is beyond all numbers.
    let text = "[blocks]\nc = { kind = \"constant\", value = 1e200 }\nq = { kind = \"square\", in = [\"c\"] }";
    assert!(matches!(ordered(text).unwrap().simulation(), Err(RunFault::NonFinite { .. })));
    // dy/dt = y² from 1 is infinite at t = 1.
    let mut bench = Bench::new(
        r#"
        y = { kind = "integrator", in = ["q"], ic = 1.0 }
        q = { kind = "square", in = ["y"] }
    "#,
    );
    let fault = bench.try_run(2.0).unwrap_err();
    let is_told = matches!(fault, RunFault::StepUnderflow { .. } | RunFault::NonFinite { .. });
    assert!(is_told, "{fault}");
}

/// d = √(max(1 − t, 0)), the argument cut off in three ways.
#[test]
fn a_guarded_root_goes_on_at_zero() {
    for (stop, guard) in [
        ("", "kind = \"limiter\", in = [\"a\"], limits = [0.0, 10.0]"),
        ("", "kind = \"max\", in = [\"a\", \"zero\"]"),
        (", limits = [0.0, 10.0]", "kind = \"summer\", in = [\"a\"]"),
    ] {
        let mut bench = Bench::new(&format!(
            r#"
            one = {{ kind = "constant", value = 1.0 }}
            zero = {{ kind = "constant", value = 0.0 }}
            a = {{ kind = "integrator", in = ["-1 * one"], ic = 1.0{stop} }}
            p = {{ {guard} }}
            d = {{ kind = "square-root", in = ["p"] }}
            I = {{ kind = "integrator", in = ["d"] }}
        "#
        ));
        for t_s in [0.5, 1.0, 1.5, 4.0] {
            let expected = (1.0_f64 - t_s).max(0.0).sqrt();
            // Rounding of the argument below the tolerance of the state.
            assert!((bench.run(t_s).net("d") - expected).abs() < 1e-6, "d at {t_s}");
        }
        close(bench.net("I"), 2.0 / 3.0, 1e-6, "area");
    }
}

#[test]
fn races_and_chatter_are_faults_not_hangs() {
    // A flip-flop that sets itself when clear and clears itself when set.
    let text = "[blocks]\nq = { kind = \"flip-flop\", in = [\"nq\", \"q\"] }\nnq = { kind = \"not\", in = [\"q\"] }";
    match ordered(text).unwrap().simulation() {
        Err(RunFault::LogicRace { nets, .. }) => assert!(nets.contains(&"q".to_string())),
        other => panic!("{:?}", other.map(|_| ())),
    }
    // Sliding on a relay without hysteresis.
    let mut bench = Bench::new(
        r#"
        x = { kind = "integrator", in = ["r"], ic = 1.0 }
        r = { kind = "relay", in = ["x"], points = [0.0, 0.0], outputs = [1.0, -1.0], initially-on = true }
    "#,
    );
    let end = bench.try_run(2.0);
    let Err(RunFault::Chatter { block, t_s, .. }) = end else { panic!("{end:?}") };
    assert!(block == "r" && (t_s - 1.0).abs() < 1e-6);
}

#[test]
fn overload_is_latched_where_it_happens() {
    // v = −2·sin 2t reaches −1.1 at t = ½·asin(0.55).
    let blocks = OSCILLATOR.replace("[\"-4 * x\"]", "[\"-4 * x\"], max = 1.0");
    for (word, policy) in [
        ("continue", OverloadPolicy::Continue),
        ("hold", OverloadPolicy::Hold),
        ("stop", OverloadPolicy::Stop),
    ] {
        let mut bench = Bench::with(&format!("overload = \"{word}\""), &blocks);
        let advance = bench.try_run(5.0).unwrap();
        let [latched] = bench.simulation.overloads() else { panic!("more than one") };
        assert_eq!(bench.ordered.netlist.blocks[latched.block.index()].name, "v");
        close(latched.t_s, 0.5 * 0.55_f64.asin(), 1e-9, "overload");
        assert_eq!(advance.stopped_by.is_some(), policy != OverloadPolicy::Continue);
        let again = bench.try_run(6.0).unwrap();
        assert_eq!(again.reached == crate::tick(6.0), policy == OverloadPolicy::Continue);
    }
}

#[test]
fn static_check_reports_what_differs() {
    let of = |derivative: f64| {
        let mut bench = Bench::of(
            ordered(&format!(
                "[blocks]\n{OSCILLATOR}\n[expect]\nv = {{ output = 0.0, derivative = {derivative:?} }}\n"
            ))
            .unwrap(),
        );
        let found = static_check(&bench.ordered, &mut bench.simulation).unwrap();
        found.iter().map(|l| (l.what.clone(), l.found, l.agrees)).collect::<Vec<_>>()
    };
    for (derivative, agrees) in [(-4.0, true), (4.0, false)] {
        let wanted = [("output".to_owned(), 0.0, true), ("derivative".to_owned(), -4.0, agrees)];
        assert_eq!(of(derivative), wanted);
    }
}
