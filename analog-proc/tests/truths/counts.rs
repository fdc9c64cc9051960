//! Counters behind comparators that see sines for short moments.

use crate::TAU;
use crate::bench::Bench;
use crate::roots::{Smooth, roots};

/// Counts of `sin(2π f t + phase) > threshold` by `source`, a line that drives `s`.
fn count(source: &str, threshold: f64, until_s: f64) -> f64 {
    let blocks = format!(
        "{source}\np = {{ kind = \"comparator\", in = [\"s\"], threshold = {threshold:?} }}\nn = {{ kind = \"counter\", in = [\"p\"] }}"
    );
    let mut bench = Bench::new(&blocks);
    bench.run(until_s).net("n")
}

fn generator(frequency: f64, phase: f64) -> String {
    format!(
        "s = {{ kind = \"signal-generator\", wave = \"sine\", frequency = {frequency:?}, phase = {phase:?} }}"
    )
}

#[test]
fn every_peak_of_a_generator_is_counted_over_a_thousand_seconds() {
    for threshold in [0.999, 0.9999, 0.99999, 0.999_999] {
        let found = count(&generator(1.0, 0.3), threshold, 1000.0);
        assert_eq!(found, 1000.0, "threshold {threshold}");
    }
}

#[test]
fn the_count_does_not_depend_on_the_phase() {
    // Where the run begins above the threshold (phase 0.1 + π/2, 0.995 of the peak) it also
    // ends above it, so that a hundred periods hold a hundred rises at any phase.
    for threshold in [0.8, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995, 0.999] {
        let counts: Vec<f64> = (0..12)
            .map(|k| {
                let phase = 0.1 + f64::from(k) * TAU / 12.0;
                count(&generator(1.0, phase), threshold, 100.0)
            })
            .collect();
        assert_eq!(counts, [100.0; 12], "threshold {threshold}");
    }
}

#[test]
fn two_generators_meet_as_often_as_they_do() {
    // Bounds: 2π·1.6182 and (2π)²(1 + 0.6182²).
    let truth = |level: f64| {
        let f = Smooth {
            value: |t: f64| (TAU * t).sin() + (TAU * 0.6182 * t).sin() - level,
            slope: |t: f64| TAU * ((TAU * t).cos() + 0.6182 * (TAU * 0.6182 * t).cos()),
            greatest_slope: TAU * 1.6182,
            greatest_bend: TAU * TAU * (1.0 + 0.6182 * 0.6182),
        };
        let all = roots(&f, 1e-6, 1000.0).unwrap();
        all.iter().filter(|r| r.rises).count() as f64
    };
    for level in [0.5, 1.9, 1.99, 1.999] {
        let source = "a = { kind = \"signal-generator\", wave = \"sine\" }\nb = { kind = \"signal-generator\", wave = \"sine\", frequency = 0.6182 }\ns = { kind = \"summer\", in = [\"a\", \"b\"] }";
        assert_eq!(count(source, level, 1000.0), truth(level), "level {level}");
    }
}

#[test]
fn a_sine_of_time_or_of_an_integrated_phase_is_counted_at_any_frequency() {
    for frequency in [1.0, 10.0, 100.0, 1000.0] {
        let w = TAU * frequency;
        let time =
            format!("t = {{ kind = \"time\" }}\ns = {{ kind = \"sine\", in = [\"{w:?} * t\"] }}");
        let phase = format!(
            "w = {{ kind = \"constant\", value = {w:?} }}\nangle = {{ kind = \"integrator\", in = [\"w\"] }}\ns = {{ kind = \"sine\", in = [\"angle\"] }}"
        );
        for source in [time, phase].iter().take(if frequency > 100.0 { 1 } else { 2 }) {
            for threshold in [0.5, 0.999] {
                let found = count(source, threshold, 10.0);
                assert_eq!(found, 10.0 * frequency, "{source}: {frequency} Hz above {threshold}");
            }
        }
    }
}

#[test]
fn a_swept_oscillator_is_counted() {
    // Angle 2π(t + 2 t²) reaches 2π·210 in 10 s: 210 rises above any level in reach.
    let source = format!(
        "one = {{ kind = \"constant\", value = 1.0 }}\nw = {{ kind = \"integrator\", in = [\"{:?} * one\"], ic = {TAU:?} }}\nangle = {{ kind = \"integrator\", in = [\"w\"] }}\ns = {{ kind = \"cosine\", in = [\"angle\"] }}",
        4.0 * TAU
    );
    // A cosine begins above its level and ends there.
    assert_eq!(count(&source, 0.99, 10.0), 210.0);
}
