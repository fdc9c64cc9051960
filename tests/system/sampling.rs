//! The sampling laboratory as a user runs it: real frames, real converters, against exact theory.
//!
//! Most runs go over the memory link, which gives the same numbers as two processes to the last
//! bit. What an experiment claims it checks itself; here stands that it does, and what is more.

use crate::bench_top::{BenchTop, DIGITAL, ask, expect, number, rows};
use serde_json::Value;
use std::f64::consts::TAU;

/// What `sampling` says as JSON; every check that it names in `checks` holds, and there is no other.
fn measure(top: &BenchTop, args: &str, checks: &[&str]) -> Value {
    ask(top, &format!("sampling {args}"), checks)
}

/// Every experiment at its full settings agrees with its theory.
#[test]
fn measurement_agrees_with_theory() {
    let top = BenchTop::new();
    measure(&top, "circle", &["growth"]);
    measure(&top, "root", &["roots"]);
    measure(&top, "noise", &["variance"]);
    measure(&top, "skew", &["error"]);
    measure(&top, "coefficients", &["error"]);
    let json = measure(&top, "axes", &["launch-ratio", "ratio"]);
    assert_eq!(rows(&json, "axes").len(), 24);
    for row in rows(&json, "axes") {
        let (launch, body) = (row["trajectory"] == "launch", row["axes"] == "body");
        if body || !launch {
            // The steps resolve the wave to ω²T²/24 ≈ 1 %, and lift turns the path back by
            // (X + N)/(Vω) ≈ 1.5 % of it; the steady turn adds 0.014°, the programme as much.
            let ratio = number(row, "rms_error_of_gamma_deg") / number(row, "first_order_deg");
            assert!((ratio - 1.0).abs() < 0.1, "{row}");
        } else if number(row, "step_s") == 0.1 {
            // An independent prototype's, to its last digit: mostly the held programme.
            assert!((number(row, "rms_error_of_gamma_deg") - 0.034).abs() <= 5e-4, "{row}");
        }
        let turning = number(row, "greatest_turning_acceleration_m_s2");
        assert!(if body { turning > 200.0 } else { turning < 3.0 }, "{row}");
        // 0.05 % of 225 m/s² turns 1000 m/s by 0.1° in 20 s; of 2 m/s² by a hundredth of that.
        let by_offset = number(row, "rms_by_the_offset_deg");
        assert!(if body { by_offset > 0.03 } else { (1e-4..3e-3).contains(&by_offset) }, "{row}");
    }
    let args = "function-generation --frames-per-cycle 20,39,100";
    let json = measure(&top, args, &["all-digital", "hybrid"]);
    for row in rows(&json, "function-generation") {
        // 2 sin(φ/2) neglects the images: T²ω²/12 of the mean square, and the harmonics' own lag;
        // the staircase formula takes M's error as independent of where α is: a few percent.
        let within = match row["way"].as_str().unwrap() {
            "all-digital" => 0.2,
            "hybrid" => 0.05,
            _ => continue,
        };
        let ratio =
            number(row, "rms_error_measured_percent") / number(row, "rms_error_theory_percent");
        assert!((ratio - 1.0).abs() < within, "{row}");
    }
    top.assert_clean();
}

/// The paper's figure 1 in numbers: what redundancy buys, and what its correction costs.
#[test]
fn redundant_alpha_is_stable_where_conventional_alpha_is_not() {
    let top = BenchTop::new();
    let checks = ["roots", "stability", "stable-region"];
    let json = measure(&top, "alpha --omega 4,6", &checks);
    for (scheme, run) in [
        ("conventional", "unstable"),
        ("redundant, K = 0.2", "stable"),
        ("redundant, K = 0.5", "unstable"),
    ] {
        let found = rows(&json, "alpha")
            .iter()
            .find(|r| r["scheme"] == scheme && number(r, "omega_rad_s") == 6.0);
        assert_eq!(found.unwrap()["run"], run, "{scheme}");
    }
    for row in rows(&json, "drift") {
        // The drift leaves b T_s/K and no more. Modes have died by |z|^400 < 0.05 of 1 mrad at the
        // start of the tail; their mean over its 400 samples is below 1e-3 of the bound.
        let (left, bound) =
            (number(row, "error_left_measured_deg"), number(row, "drift_slow_period_k_deg"));
        assert!((left / bound - 1.0).abs() < 1e-2, "{row}");
    }
    for rule in [
        "--delivery prompt --correction pulse --angle beta",
        "--delivery late-unmatched --correction spread --angle alpha",
        "--delivery late-matched --correction pulse --angle beta",
    ] {
        measure(&top, &format!("alpha --omega 4 --gain 0.2,0.5 --latency 0.4 {rule}"), &checks);
    }
    top.assert_clean();
}

/// Every stage of the converter chain on the machine is that of the error budget.
#[test]
fn each_stage_of_a_channel_is_that_of_its_budget() {
    let top = BenchTop::new();
    let whole =
        "--hold extrapolating --latency 5ms --skew 300us --aperture 3ms --settling 2ms --lead 0.3";
    for hz in ["1", "7"] {
        for stages in ["--hold interpolating --latency 20ms", whole] {
            let route = "--patch patch-files/long-period.toml --adc adc_phi";
            let args = format!("budget --frequency {hz} {route} {stages}");
            for row in rows(&measure(&top, &args, &["chain"]), "budget") {
                if row["gain_measured"] == "off" {
                    continue;
                }
                let polar = |what: &str| {
                    let phase = number(row, &format!("phase_{what}_deg")) / 360.0 * TAU;
                    let gain = number(row, &format!("gain_{what}"));
                    (gain * phase.cos(), gain * phase.sin())
                };
                let (theory, measured) = (polar("theory"), polar("measured"));
                // Correlators at rtol 1e-10; Gauss quadrature over an aperture of x = 0.26 rad
                // leaves x^6/2e6 < 1e-9; ticks are rounded to 1 ns, 4e-8 rad at 7 Hz, for the looks.
                let apart = (theory.0 - measured.0).hypot(theory.1 - measured.1);
                assert!(apart < 1e-6, "{hz} Hz {row}");
            }
        }
    }
    top.assert_clean();
}

/// What may be digital: α can be sampled, the control of the pitch loop cannot at 150 ms.
#[test]
fn digital_control_loses_the_flight_that_analog_control_holds() {
    let top = BenchTop::new();
    let json = measure(&top, "flight --frame 5ms,100ms,150ms,200ms", &[]);
    let flight = |machine: &str, ms: f64| {
        let mut all = rows(&json, "flight").iter();
        all.find(|r| r["machine"] == machine && number(r, "frame_ms") == ms).unwrap()
    };
    let held = |row: &Value| row["flight"] == "held";
    let fine = number(flight("digital control", 5.0), "zeta");
    for machine in ["redundant α", "conventional α", "digital control"] {
        // At 5 ms every machine is the continuous one but for delays of 7.5 ms in a loop of
        // about 3 rad/s: ζ moves by ω τ_e / 2 = 0.01 for each path; twice that, and what is left
        // of identification on a time-varying plant.
        let row = flight(machine, 5.0);
        assert!(held(row) && (number(row, "zeta") - fine).abs() < 0.03, "{row}");
        if machine != "digital control" {
            let row = flight(machine, 100.0);
            assert!(held(row) && number(row, "zeta") > 0.5, "{row}");
            assert!(held(flight(machine, 200.0)));
        }
    }
    let slow = flight("digital control", 100.0);
    // Exact eigenvalues of the pitch loop (tips, gyro, filter) sampled at 100 ms, one frame
    // late: ζ = 0.44 at 20 s, 0.37 at 22.5 s; the answer is looked at from 20 to 25 s. An
    // earlier bound of 0.2 stood for a weak spurious mode that was taken for the loop's.
    assert!((0.32..0.49).contains(&number(slow, "zeta")), "{slow}");
    // The roll loop, sampled so, has |z| = 1.3 and swings within the limits of its tips: it is lost
    // first, and at longer frames, where the answer to the step is no decay, pitch with it.
    assert!(slow["flight"].as_str().unwrap().starts_with("lost in roll at"), "{slow}");
    for ms in [150.0, 200.0] {
        let row = flight("digital control", ms);
        let words = row["flight"].as_str().unwrap();
        assert!(words.starts_with("lost in roll at") && words.contains("lost in pitch"), "{row}");
        assert!(row["zeta"].is_null(), "{row}");
    }
    let way = |name: &str, ms: f64| {
        let mut all = rows(&json, "ways").iter();
        all.find(|r| r["way"] == name && number(r, "frame_ms") == ms).unwrap()
    };
    // Held, α_y is late by up to a step; carried on by its rate and corrected, what turns within a
    // step is left: at 5 ms a tenth, at 100 ms half, since the gust's edges of 30 m pass in 50 ms.
    let late = |name: &str, ms: f64| number(way(name, ms), "greatest_error_of_alpha_y_deg");
    for (ms, part) in [(5.0, 0.15), (100.0, 0.6)] {
        assert!(late("β redundant", ms) < part * late("as shipped", ms), "{ms} ms");
    }
    // RK4 at 100 ms leaves the same in either axes to 1e-4 deg or so; the held attitude is in both.
    let end = |name: &str| number(way(name, 100.0), "path_angle_at_the_end_deg");
    assert!((end("H frame") - end("as shipped")).abs() < 2e-3);
    // A moment from α sampled once a frame is that of the conventional machine.
    let digital = way("moments digital, slow frames", 100.0);
    let conventional = flight("conventional α", 100.0);
    assert!((number(digital, "zeta") - number(conventional, "zeta")).abs() < 0.01, "{digital}");
    top.assert_clean();
}

/// Two processes; record, summary and report of a run, and none where a setting is refused.
#[test]
fn experiments_run_from_the_command_line() {
    let top = BenchTop::new();
    let sampling = |args: &str, code: i32| {
        let mut command = top.command(DIGITAL, &["sampling"]);
        expect(command.args(args.split_whitespace()).arg("--out").arg(top.runs()), code)
    };
    let output = sampling("circle --samples-per-cycle 10", 0);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("✓ holds  growth  growth equals the exact discrete map"), "{text}");
    let directory = top.run_directories().pop().unwrap();
    for file in ["run.toml", "summary.json", "report.html", "circle.csv"] {
        assert!(directory.join(file).is_file(), "{file}");
    }
    // The limit of a check is that of ideal converters.
    sampling("budget --profile ad4 --frequency 2", 0);
    let runs = top.run_directories().len();
    for args in [
        "circle --samples-per-cycle 3",
        "circle --latency 2",
        "circle --hold first-order",
        "budget --frequency 1000",
        "root --zeta 2",
        "alpha --fast 0",
    ] {
        sampling(args, 2);
    }
    assert_eq!(top.run_directories().len(), runs);
    top.assert_clean();
}
