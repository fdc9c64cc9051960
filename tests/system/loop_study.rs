//! `sampling loop` as a user runs it: a damping is right or refused.

use crate::bench_top::{BenchTop, DIGITAL, expect};
use nalgebra::Complex;
use serde_json::Value;

/// Motor θ' = w, τ w' = K u − w with K = 2, τ = 0.15 s; u = 6 e − 0.2 w of the samples.
const PATCH: &str = r#"
[params]
start = 0.5
[blocks]
ref = { kind = "signal-generator", wave = "step", amplitude = 0.5, start = "start" }
w = { kind = "lag", in = ["u"], tau = 0.15, gain = 2.0, max = 20.0 }
theta = { kind = "integrator", in = ["w"], max = 2.0 }
err = { kind = "summer", in = ["ref", "-theta"], max = 2.0 }
err_adc = { kind = "adc", in = ["err"], channel = 0, max = 1.0 }
w_adc = { kind = "adc", in = ["w"], channel = 1, max = 8.0 }
u = { kind = "dac", channel = 0, max = 4.0 }
"#;
const STUDY: &str = r#"
patch = "motor.toml"
stop = "6s"
measure = "err_adc"
from = "0.5s"
[params]
start = 0.5
[sweep]
frame = ["7ms", "10ms", "20ms"]
latency = [0.0, 1.0]
bits = [0]
[[law]]
kind = "gain-matrix"
inputs = ["err_adc", "w_adc"]
outputs = ["u"]
gain = [[6.0, -0.2]]
"#;

/// What is left of the characteristic equation det(zI − Φ) + z^−l k adj(zI − Φ) Γ = 0 at a root
/// told as ζ and ω; Φ, Γ of the motor over a frame with u held, l frames of latency.
fn left_of_the_characteristic_equation(row: &Value) -> f64 {
    let number = |key: &str| row[key].as_f64().unwrap();
    let (t, late) = (number("frame_s"), number("latency_s") / number("frame_s"));
    let (zeta, omega) = (number("zeta"), number("omega_rad_s"));
    let (tau, gain, k_err, k_w) = (0.15, 2.0, 6.0, 0.2);
    let decay = f64::exp(-t / tau);
    let travel = tau * (1.0 - decay);
    let (b_theta, b_w) = (gain * (t - travel), gain * (1.0 - decay));
    let root = Complex::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
    let z = (root * t).exp();
    let feedback = (z - decay) * b_theta * k_err + travel * b_w * k_err + (z - 1.0) * b_w * k_w;
    ((z - 1.0) * (z - decay) + feedback / z.powf(late)).norm()
}

struct Lab {
    top: BenchTop,
}

impl Lab {
    fn new() -> Lab {
        Lab { top: BenchTop::new() }
    }

    /// What `sampling loop` says as JSON.
    fn run(&self, patch: &str, study: &str) -> Value {
        let output = self.command(patch, study, 0);
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn runs(&self) -> Vec<std::path::PathBuf> {
        let mut runs = self.top.run_directories();
        runs.retain(|path| path.is_dir());
        runs
    }

    fn command(&self, patch: &str, study: &str, code: i32) -> std::process::Output {
        self.top.file("motor.toml", patch);
        let file = self.top.file("study.toml", study);
        let mut command = self.top.command(DIGITAL, &["sampling", "loop", "--json"]);
        command.arg(&file).arg("--out").arg(self.top.runs());
        expect(&mut command, code)
    }
}

fn rows(json: &Value) -> &[Value] {
    json["tables"]["loop"].as_array().unwrap()
}

fn remark(row: &Value) -> &str {
    row["remark"].as_str().unwrap()
}

fn assert_refused(json: &Value, word: &str) {
    for row in rows(json) {
        for key in ["zeta", "omega_rad_s", "growth_per_cycle"] {
            assert!(row[key].is_null(), "{row}");
        }
        assert!(remark(row).contains(word), "{row}");
    }
    let explained = json["remarks"].as_array().unwrap();
    let explains = |r: &Value| r.as_str().unwrap().starts_with(word);
    assert!(explained.iter().any(explains), "{explained:?}");
}

#[test]
fn a_servo_with_a_set_point_has_its_poles_or_none() {
    let lab = Lab::new();
    // The root of a record at the integrator's tolerance, 1e-10, times a condition below 1e3;
    // the equation's slope there is below 1.
    let assert_right = |json: &Value| {
        for row in rows(json) {
            let left = left_of_the_characteristic_equation(row);
            assert!(left < 1e-7 && remark(row).is_empty(), "{left} {row}");
            assert!(row["fit"].as_f64().unwrap() < 1e-6, "{row}");
        }
    };
    let json = lab.run(PATCH, STUDY);
    assert_right(&json);
    // The exact figures at 10 ms without latency, to their digits.
    let row = &rows(&json)[2];
    assert!((row["zeta"].as_f64().unwrap() - 0.5024).abs() < 5e-5, "{row}");
    assert!((row["omega_rad_s"].as_f64().unwrap() - 9.000).abs() < 5e-4, "{row}");

    let all = STUDY.replace("from = \"0.5s\"\n", "");
    let json = lab.run(PATCH, &all);
    assert_refused(&json, "not one decay");
    // Nothing happens before the step: there is nothing to compare the last tenth with.
    let late = lab.run(PATCH, &all.replace("start = 0.5", "start = 1.0"));
    for row in rows(&late) {
        assert!(row["last_tenth_first_tenth"].is_null(), "{row}");
    }
    // Changes at 1, 2, 3 … s.
    let square = PATCH.replace("\"step\"", "\"square\", frequency = 0.5");
    let from_rest = all.replace("start = 0.5", "start = 0.0");
    assert_refused(&lab.run(&square, &from_rest), "not one decay");
    let window = "measure = \"err_adc\"\nfrom = \"3s\"\nuntil = \"3.9s\"";
    let windowed = from_rest.replace("measure = \"err_adc\"", window);
    assert_right(&lab.run(&square, &windowed));
    lab.top.assert_clean();
}

#[test]
fn few_bits_saturation_and_limit_cycles_are_told_case_by_case() {
    let lab = Lab::new();
    // A fit of a hundredth at most, a root off by as much of 9 rad/s at the worst of 20 ms: 0.002
    // in z, where the equation's slope is below 1.
    let near = |row: &Value| left_of_the_characteristic_equation(row) < 2e-3;
    for row in rows(&lab.run(PATCH, &STUDY.replace("bits = [0]", "bits = [4, 8, 12]"))) {
        let told = !row["zeta"].is_null();
        assert!(if told { near(row) } else { !remark(row).is_empty() }, "{row}");
        assert!(told || row["bits"].as_f64().unwrap() < 12.0, "{row}");
    }

    // A DAC of 1 where 3 are asked for, with bits; ideal ones have no end.
    let small = PATCH.replace("channel = 0, max = 4.0", "channel = 0, max = 1.0");
    let both = STUDY.replace("bits = [0]", "bits = [0, 12]");
    let json = lab.run(&small, &both);
    // Told case by case, not of the whole.
    let remarks = json["remarks"].as_array().unwrap();
    assert!(remarks.iter().all(|r| !r.as_str().unwrap().contains("DAC u")), "{remarks:?}");
    for row in rows(&json) {
        let ends =
            remark(row).starts_with("saturated until 0.7") || remark(row).contains("until 0.8");
        let coarse = row["bits"].is_number();
        assert_eq!(ends && remark(row).contains("DAC u"), coarse, "{row}");
        assert!(near(row), "{row}");
    }
    let early = both
        .replace("bits = [0, 12]", "bits = [12]")
        .replace(", \"20ms\"", "")
        .replace("from = \"0.5s\"", "from = \"0.5s\"\nuntil = \"0.8s\"");
    assert_refused(&lab.run(&small, &early), "too short");

    // A relay: the loop swings on at a level of its own. Its frequency is where plant and delay,
    // -90° - atan(0.15 w) - w T/2 beside hysteresis, make half a turn: about 2 rad/s to 20 rad/s.
    let relay = PATCH
        .replace("w = { kind = \"lag\", in = [\"u\"]", "r = { kind = \"relay\", in = [\"u\"], points = [-0.1, 0.1], outputs = [-1, 1] }\nw = { kind = \"lag\", in = [\"r\"]");
    for earlier in lab.runs() {
        std::fs::remove_dir_all(earlier).unwrap();
    }
    let json = lab.run(&relay, &STUDY.replace("-0.2", "0.0"));
    assert_refused(&json, "swings on");
    for row in rows(&json) {
        let (_, period) = remark(row).split_once("period ").unwrap();
        let period: f64 = period.trim_end_matches(" s").parse().unwrap();
        assert!((0.3..3.0).contains(&period), "{row}");
    }
    // No value is an empty field, and the run is there all the same.
    let csv = lab.runs().pop().unwrap().join("loop.csv");
    let csv = std::fs::read_to_string(csv).unwrap();
    assert!(csv.lines().nth(1).unwrap().contains("ideal,,,,"), "{csv}");
    lab.top.assert_clean();
}

/// A study of a user's own needs nothing but TOML; its faults name file and line.
#[test]
fn a_study_works_from_toml_alone() {
    let lab = Lab::new();
    let patch = include_str!("../../patch-files/lab/root.toml");
    let study = "title = \"My servo\"\npatch = \"motor.toml\"\nstop = \"10s\"\n\
        measure = \"x_adc\"\nparams = { wn = 3.0 }\n\
        sweep = { frame = [\"50ms\", \"100ms\"], latency = [0.0, 1.0] }\n\
        [[law]]\nkind = \"gain-matrix\"\ninputs = [\"x_adc\"]\noutputs = [\"u\"]\n\
        gain = [[9.0]]\n";
    let json = lab.run(patch, study);
    assert_eq!((rows(&json).len(), &json["title"]), (4, &Value::from("My servo")));
    // One frame of 0.1 s late: the exact damping is 0.0787, a figure of the worked example.
    let zeta = rows(&json)[3]["zeta"].as_f64().unwrap();
    assert!((zeta - 0.0787).abs() < 5e-5, "{zeta}");
    for (good, bad, place) in [
        ("inputs = [\"x_adc\"]", "inputs = [\"x_adk\"]", "study.toml:9:11: the patch has no ADC"),
        ("outputs = [\"u\"]", "outputs = [\"v\"]", "study.toml:10:"),
        ("patch = \"motor.toml\"", "patch = \"none.toml\"", "study.toml:2:"),
    ] {
        let output = lab.command(patch, &study.replace(good, bad), 2);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(place), "{bad}: {text}");
    }
    // Fewer frames than modes can be sought in.
    let short = STUDY.replace("from = \"0.5s\"", "from = \"0.5s\"\nuntil = \"0.6s\"");
    let output = lab.command(PATCH, &short, 2);
    assert!(String::from_utf8_lossy(&output.stderr).contains("18 are needed"));
    lab.top.assert_clean();
}
