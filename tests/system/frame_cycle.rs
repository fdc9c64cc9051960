//! The frame cycle against its definition, on a patch whose answer is known.
//!
//! An integrator of a DAC: x' = d. The digital side sets d = n + 1 in frame n,
//! so x(t) is a sum of rectangles that depends on every transfer instant.

use crate::bench_top::{bundle, with_console};
use digital_proc::linkage::console::ConsoleFault;
use interface::{
    Tick,
    control::{ChannelKind, Clock, RunSpec},
    frame::{ModeCommand, Samples, Updates},
    hold::HoldKind,
    profile::{Profile, Provenance, Sourced},
};

const PATCH: &str = r#"
[blocks]
d  = { kind = "dac", channel = 0 }
x  = { kind = "integrator", in = ["d"] }
a0 = { kind = "adc", channel = 0, in = ["x"] }
a1 = { kind = "adc", channel = 1, in = ["t"] }
a2 = { kind = "adc", channel = 2, in = ["t"] }
t  = { kind = "time" }
half  = { kind = "comparator", in = ["x"], threshold = 0.25 }
edge  = { kind = "interrupt", line = 3, in = ["half"] }
level = { kind = "sense", line = 1, in = ["half"] }
"#;

pub const T: Tick = Tick(100_000_000);

pub fn spec(latency: Tick, skew: Tick, stop: Tick) -> RunSpec {
    RunSpec { frame: T, latency, skew, stop, from_ic: true, clock: Clock::LockStep }
}

/// Runs the patch with d = n + 1 in frame n; returns all samples.
fn run(spec: &RunSpec, profile: Profile, mode: impl Fn(u64) -> ModeCommand) -> Vec<Samples> {
    let mut all = Vec::new();
    with_console(|console| {
        console.load(bundle(PATCH), Vec::new(), profile).unwrap();
        let channel = console.channel(ChannelKind::Dac, "d").unwrap();
        let mut law = |samples: &Samples, updates: &mut Updates| {
            all.push(*samples);
            updates.set_dac(channel, (samples.frame + 1) as f64);
            updates.mode = mode(samples.frame) as u32;
        };
        console.run(spec, &mut law).unwrap();
    });
    all
}

/// On an ideal machine, always on.
fn operate(latency: Tick, skew: Tick, stop: Tick) -> Vec<Samples> {
    run(&spec(latency, skew, stop), Profile::ideal(), |_| ModeCommand::Continue)
}

/// x(t) when the transfer of frame n is at t_n + τ.
fn expected(t_s: f64, latency_s: f64) -> f64 {
    (0..100).map(|n| (t_s - (f64::from(n) * 0.1 + latency_s)).max(0.0)).sum()
}

#[test]
fn transfers_take_effect_at_the_latency_and_after_the_sample() {
    for latency in [Tick(0), Tick(1), Tick(30_000_000), Tick(99_999_999), T] {
        // The stop is no multiple of the frame.
        let samples = operate(latency, Tick(0), Tick(1_050_000_000));
        assert_eq!(samples.len(), 12);
        assert_eq!(samples[11].tick, Tick(1_050_000_000));
        for s in &samples {
            let wanted = expected(s.tick.secs(), latency.secs());
            // A sum of ten rectangles by a method that is exact for them: rounding alone.
            let (at, found) = (s.tick, s.adc[0]);
            assert!((found - wanted).abs() < 1e-12, "τ {latency} at {at}: {found} {wanted}");
        }
    }
}

#[test]
fn skewed_channels_are_held_one_after_another() {
    let skew = Tick(10_000_000);
    for s in operate(T, skew, Tick(500_000_000)).iter().take(5) {
        for (channel, delay) in [(1, 1), (2, 2)] {
            let wanted = (s.tick + skew * delay).secs();
            assert!((s.adc[channel] - wanted).abs() < 1e-15, "channel {channel} at {}", s.tick);
        }
    }
}

#[test]
fn hold_stops_problem_time_and_end_ends_the_run() {
    let samples =
        run(&spec(Tick(0), Tick(0), Tick(10_000_000_000)), Profile::ideal(), |n| match n {
            3 => ModeCommand::Hold,
            6 => ModeCommand::Operate,
            9 => ModeCommand::End,
            _ => ModeCommand::Continue,
        });
    let times: Vec<f64> = samples.iter().map(|s| s.adc[1]).collect();
    let wanted = [0.0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.3, 0.4, 0.5, 0.6];
    for (got, wanted) in times.iter().zip(wanted) {
        assert!((got - wanted).abs() < 1e-15, "{times:?}");
    }
    let last = samples.last().unwrap();
    assert_eq!((last.frame, last.tick), (10, Tick(900_000_000)));
}

#[test]
fn edges_carry_their_located_times_and_sense_lines_their_level() {
    let samples = operate(Tick(0), Tick(0), Tick(500_000_000));
    let edges: Vec<_> = samples.iter().flat_map(Samples::edges).collect();
    // x = 0.1 at 0.1 s, then slope 2 to 0.3 at 0.2 s: 0.25 is crossed at 0.175 s.
    assert_eq!(edges.len(), 1);
    assert_eq!((edges[0].tick, edges[0].line, edges[0].rising), (Tick(175_000_000), 3, 1));
    let levels: Vec<u64> = samples.iter().map(|s| s.sense).collect();
    assert_eq!(levels, [0, 0, 2, 2, 2, 2]);
}

#[test]
fn transfers_are_told_with_their_instants() {
    let latency = Tick(30_000_000);
    let samples = operate(latency, Tick(0), Tick(400_000_000));
    let told: Vec<(u64, Tick)> =
        samples.iter().flat_map(Samples::transfers).map(|t| (t.frame, t.tick)).collect();
    let wanted: Vec<(u64, Tick)> = (0..4).map(|n| (n, T * n as i64 + latency)).collect();
    assert_eq!(told, wanted);
}

#[test]
fn holds_reconstruct_a_ramp() {
    for (kind, lag_frames) in [(HoldKind::Extrapolating, 0.0), (HoldKind::Interpolating, 1.0)] {
        let mut profile = Profile::ideal();
        profile.dac.hold =
            Some(Sourced { value: kind, status: Provenance::Assumed, source: "test".into() });
        let samples =
            run(&spec(Tick(0), Tick(0), Tick(2_000_000_000)), profile, |_| ModeCommand::Continue);
        // d(t) is the ramp 10 t + 1, late by `lag_frames` frames, so x grows over a
        // frame by its integral; the first frames have no forerunner.
        for pair in samples.windows(2).skip(4) {
            let (a, b) = (pair[0].tick.secs(), pair[1].tick.secs());
            let ramp = |t: f64| 5.0 * t * t + (1.0 - lag_frames) * t;
            let wanted = ramp(b) - ramp(a);
            let grown = pair[1].adc[0] - pair[0].adc[0];
            assert!((grown - wanted).abs() < 1e-12, "{kind:?} at {a}: {grown} {wanted}");
        }
    }
}

pub fn refusal<T: std::fmt::Debug>(answer: Result<T, ConsoleFault>) -> String {
    match answer {
        Err(ConsoleFault::Refused(text)) => text,
        other => panic!("{other:?}"),
    }
}

#[test]
fn impossible_runs_are_refused_with_a_reason() {
    with_console(|console| {
        let mut nothing = |_: &Samples, _: &mut Updates| {};
        let fine = spec(Tick(0), Tick(0), T);
        assert!(refusal(console.run(&fine, &mut nothing)).contains("load"));
        console.load(bundle(PATCH), Vec::new(), Profile::ideal()).unwrap();
        for (bad, word) in [
            (RunSpec { frame: Tick(0), ..fine.clone() }, "frame"),
            (RunSpec { latency: T + Tick(1), ..fine.clone() }, "latency"),
            (RunSpec { skew: Tick(1), ..fine.clone() }, "scan"),
            (RunSpec { stop: Tick(-1), ..fine.clone() }, "stop"),
        ] {
            let text = refusal(console.run(&bad, &mut nothing));
            assert!(text.contains(word), "{text}");
        }
        refusal(console.preset(&console.settings(&[("d", f64::NAN)]).unwrap()));
        refusal(console.set_ics(vec![("d".into(), 1.0)]));
        refusal(console.set_params(vec![("nobody".into(), 1.0)]));
    });
}
