//! What must end a run does so at its first instant.

use crate::TAU;
use crate::bench::Bench;
use engine::fault::RunFault;

#[test]
fn a_pole_of_a_secant_of_time_ends_the_run() {
    let read = "\nx = { kind = \"integrator\", in = [\"q\"] }";
    for reader in ["", read] {
        let mut bench = Bench::new(&format!(
            "t = {{ kind = \"time\" }}\none = {{ kind = \"constant\", value = 1.0 }}\nc = {{ kind = \"cosine\", in = [\"10 * t\"] }}\nq = {{ kind = \"divider\", in = [\"one\", \"c\"] }}{reader}"
        ));
        match bench.try_run(20.0) {
            Err(RunFault::DividedByZero { block, t_s }) => {
                assert_eq!(block, "q");
                assert!((t_s - TAU / 40.0).abs() < 1e-8, "at {t_s} s");
            }
            // Its integral may be found to be singular just before.
            Err(RunFault::StepUnderflow { t_s, .. } | RunFault::NonFinite { t_s, .. })
                if !reader.is_empty() =>
            {
                assert!((t_s - TAU / 40.0).abs() < 1e-6, "at {t_s} s");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn what_dips_below_zero_for_a_moment_ends_the_run() {
    // sin(2πt) + 0.9999 is negative for 4.5 ms a second; 1 − 4t is from 0.25 s on.
    let dip_s = 0.5 + 0.9999_f64.asin() / TAU;
    let sources = r#"
        one = { kind = "constant", value = 1.0 }
        t = { kind = "time" }
        g = { kind = "signal-generator", wave = "sine" }
        s = { kind = "sine", in = ["6.283185307179586 * t"] }
    "#;
    for (sum, truth, within) in [
        ("\"g\", \"0.9999 * one\"", dip_s, 1e-9),
        ("\"s\", \"0.9999 * one\"", dip_s, 1e-9),
        ("\"one\", \"-4 * t\"", 0.25, 1e-12),
    ] {
        let d = format!("d = {{ kind = \"summer\", in = [{sum}] }}");
        for reader in [
            "q = { kind = \"divider\", in = [\"one\", \"d\"] }",
            "q = { kind = \"square-root\", in = [\"d\"] }",
        ] {
            match Bench::new(&format!("{sources}\n{d}\n{reader}")).try_run(20.0) {
                Err(
                    RunFault::DividedByZero { block, t_s } | RunFault::NegativeRoot { block, t_s },
                ) => {
                    assert_eq!(block, "q");
                    assert!((t_s - truth).abs() < within, "{t_s} instead of {truth}");
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn a_divisor_is_not_called_zero_where_it_runs_away() {
    // One and a square, which a delayed square makes run away: never below one. A run that cannot
    // be followed is not ended by a division by zero.
    let mut bench = Bench::new(
        r#"
        one = { kind = "constant", value = 1.0 }
        s = { kind = "signal-generator", wave = "sine", amplitude = -1.4766970724479402, frequency = 1.6619462959399327, phase = 3.118201558696021 }
        square = { kind = "square", in = ["2 * late"] }
        late = { kind = "transport-delay", in = ["-1 * square", "s"], delay = 0.11558361129282581, initial = -0.26008533401735 }
        divisor = { kind = "summer", in = ["one", "square"] }
        q = { kind = "divider", in = ["one", "divisor"] }
        "#,
    );
    match bench.try_run(1.3) {
        Err(RunFault::TooQuick { block, t_s } | RunFault::NotFollowed { block, t_s }) => {
            assert_eq!(block, "q");
            assert!(t_s > 0.9, "at {t_s} s");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_overload_of_a_sine_of_time_stops_the_run() {
    // The level is 110 % of `max`.
    let time = "t = { kind = \"time\" }\ns = { kind = \"sine\", in = [\"6.283185307179586 * t\"], max = MAX }";
    let generator = "s = { kind = \"signal-generator\", wave = \"sine\", max = MAX }";
    let cases: [(f64, &str); 3] = [(0.9 / 1.1, time), (0.9, time), (0.999 / 1.1, generator)];
    for (max, sources) in cases {
        let blocks = sources.replace("MAX", &format!("{max:?}"));
        let mut bench = Bench::with("overload = \"stop\"", &blocks);
        let advance = bench.try_run(20.0).unwrap();
        let latched = advance.stopped_by.expect("stopped");
        let truth = (1.1 * max).asin() / TAU;
        let t_s = latched.t_s;
        assert!((t_s - truth).abs() < 1e-9, "{t_s} instead of {truth}");
        assert!((latched.value - 1.1 * max).abs() < 1e-9, "{latched:?}");
    }
}

#[test]
fn switchings_whose_number_is_left_to_rounding_end_the_run() {
    // Each reset lets the threshold be met sooner, by a factor, until there is no time between.
    let shrinking = r#"
        one = { kind = "constant", value = 1.0 }
        fall = { kind = "integrator", in = ["-1 * one"] }
        late = { kind = "transport-delay", in = ["0.1946758165732183 * fall"], delay = 0.4790764180619553, initial = -0.0917370746607078 }
        on = { kind = "comparator", in = ["-1 * late", "1.5058516028045046 * y"], threshold = 0.20463082559532775 }
        x = { kind = "integrator", in = ["-1 * slope"], reset = "on" }
        slope = { kind = "cosine", in = ["y"] }
        y = { kind = "integrator", in = ["-1 * x", "-3.238832001437266 * y"] }
        n = { kind = "counter", in = ["on"] }
    "#;
    // Or they begin without time between, and grow.
    let growing = r#"
        t = { kind = "time" }
        y = { kind = "integrator", in = ["held", "-2.613171079507003 * y"], ic = 0.45305364395006276, reset = "on" }
        on = { kind = "comparator", in = ["1.0196587914014568 * x", "-1.5053359033152183 * y"], threshold = -0.7724618199247687 }
        held = { kind = "track-store", in = ["-1.2556651175835998 * t"], track = "on", ic = -0.3308111500322455 }
        x = { kind = "integrator", in = ["-1.578116011910719 * t", "-0.8761467331091723 * x"], ic = 0.4053826386429229, limits = [-0.12672699376924818, 0.7797300858410373] }
        n = { kind = "counter", in = ["on"] }
    "#;
    for (blocks, near_s) in [(shrinking, 1.22146), (growing, 0.69004)] {
        match Bench::new(blocks).try_run(3.0) {
            Err(RunFault::Chatter { block, t_s, .. }) => {
                assert_eq!(block, "on");
                assert!((t_s - near_s).abs() < 1e-5, "at {t_s} s");
            }
            other => panic!("{other:?}"),
        }
    }
}
