//! What the analog side is asked between runs.
//!
//! What cannot be done is refused as a whole; what a converter or a coefficient
//! unit cannot represent is held at its end and said.

use crate::{
    bench_top::{bundle, with_console},
    frame_cycle::{T, refusal, spec},
};
use digital_proc::linkage::console::{Console, ConsoleFault};
use interface::{
    Tick,
    frame::{RunState, Samples, Updates},
    profile::{Profile, Provenance, Sourced},
};

/// A DAC, a coefficient unit in the second word of flags, an integrator and its reciprocal,
/// each sampled.
const PATCH: &str = r#"
[blocks]
one = { kind = "constant", value = 1.0 }
d = { kind = "dac", channel = 3, initial = 0.25, max = 10.0 }
c = { kind = "dcu", channel = 70, initial = 0.5, in = ["one"] }
x = { kind = "integrator", in = ["0 * one"], ic = 2.0 }
z = { kind = "integrator", in = ["0 * one"], ic = 3.0 }
r = { kind = "divider", in = ["one", "x"] }
q = { kind = "divider", in = ["one", "c"] }
a0 = { kind = "adc", channel = 0, in = ["d"] }
a1 = { kind = "adc", channel = 1, in = ["c"] }
a2 = { kind = "adc", channel = 2, in = ["x"] }
a3 = { kind = "adc", channel = 3, in = ["z"] }
"#;

fn with_patch(profile: Profile, work: impl FnOnce(&mut Console<'_>)) {
    with_console(|console| {
        console.load(bundle(PATCH), Vec::new(), profile).unwrap();
        work(console);
    });
}

/// Three frames from the initial condition, without an update.
fn run(console: &mut Console<'_>) -> Vec<Samples> {
    let mut all = Vec::new();
    let mut law = |samples: &Samples, _: &mut Updates| all.push(*samples);
    console.run(&spec(Tick::ZERO, Tick::ZERO, T * 2), &mut law).unwrap();
    assert_eq!((all.len(), all[2].run_state()), (3, RunState::Ended));
    all
}

/// DAC, coefficient and both integrators where a run starts.
fn start(console: &mut Console<'_>) -> [f64; 4] {
    let first = run(console)[0];
    [0, 1, 2, 3].map(|channel| first.adc[channel])
}

/// Settings of `d` and `c`, and of a DAC that is not there.
fn preset(console: &mut Console<'_>, values: &[(&str, f64)]) -> Result<(), ConsoleFault> {
    let mut updates = Updates::new(0, Tick::ZERO);
    for &(name, value) in values {
        match name {
            "d" => updates.set_dac(3, value),
            "c" => updates.set_dcu(70, value),
            _ => updates.set_dac(9, value),
        }
    }
    console.preset(&updates)
}

fn set_ics(console: &mut Console<'_>, values: &[(&str, f64)]) -> Result<(), ConsoleFault> {
    console.set_ics(values.iter().map(|(name, value)| ((*name).into(), *value)).collect())
}

fn assumed<T>(value: T) -> Option<Sourced<T>> {
    Some(Sourced { value, status: Provenance::Assumed, source: "for this test".into() })
}

#[test]
fn a_run_that_starts_beyond_a_range_says_so_in_its_first_frame() {
    // DACs of 12 bits, coefficient units of 14 bits and range 1.
    let mut limited = Profile::ideal();
    limited.dac.bits = assumed(12);
    limited.dcu.bits = assumed(14);
    limited.dcu.range = assumed(1.0);
    with_patch(limited, |console| {
        let flags = |s: &Samples| (s.dac_saturated, s.dcu_saturated);
        let nothing = (0, [0, 0]);
        preset(console, &[("c", 1.5), ("d", -12.0)]).unwrap();
        // Twice: what stands beyond a range is told in every run that starts from it.
        for _ in 0..2 {
            let samples = run(console);
            assert_eq!(flags(&samples[0]), (1 << 3, [0, 1 << (70 - 64)]));
            assert_eq!(&samples[0].adc[..2], [-10.0, 1.0]);
            assert_eq!(flags(&samples[1]), nothing);
            assert_eq!(flags(&samples[2]), nothing);
        }
        // What was put right before the run is forgotten.
        preset(console, &[("c", 0.75), ("d", 5.0)]).unwrap();
        let samples = run(console);
        assert!(samples.iter().all(|s| flags(s) == nothing));
        assert_eq!(&samples[0].adc[..2], [5.0, 0.75]);
    });
}

#[test]
fn a_refused_request_changes_nothing() {
    type Ask = fn(&mut Console<'_>, &[(&str, f64)]) -> Result<(), ConsoleFault>;
    with_patch(Profile::ideal(), |console| {
        set_ics(console, &[("x", 4.0)]).unwrap();
        preset(console, &[("d", 0.5)]).unwrap();
        let before = [0.5, 0.5, 4.0, 3.0];
        assert_eq!(start(console), before);
        let (ics, preset): (Ask, Ask) = (set_ics, preset);
        for (ask, values, word) in [
            // Later entries that cannot be.
            (ics, &[("x", 5.0), ("nobody", 1.0)][..], "nobody"),
            (ics, &[("x", 5.0), ("z", f64::NAN)], "`z`"),
            (preset, &[("d", 1.0), ("c", 0.75), ("nobody", 1.0)], "channel"),
            (preset, &[("d", 1.0), ("c", f64::INFINITY)], "DCU 70"),
            // Each can be set, but not together with the patch: `r` is 1/x and `q` is 1/c.
            (ics, &[("z", 5.0), ("x", 0.0)], "`r`"),
            (preset, &[("d", 1.0), ("c", 0.0)], "`q`"),
        ] {
            let text = refusal(ask(console, values));
            assert!(text.contains(word), "{values:?}: {text}");
            assert_eq!(start(console), before, "{values:?}");
            // What a pot-set carries over is what was in force.
            console.set_params(Vec::new()).unwrap();
            assert_eq!(start(console), before, "{values:?} and a pot-set");
        }
        // The last of several values for one name counts.
        ics(console, &[("x", 5.0), ("z", 6.0), ("x", 7.0)]).unwrap();
        preset(console, &[("c", 0.25), ("d", 2.0)]).unwrap();
        assert_eq!(start(console), [2.0, 0.25, 7.0, 6.0]);
    });
}

#[test]
fn a_scan_beyond_all_ticks_is_refused() {
    with_patch(Profile::ideal(), |console| {
        // Four channels, three skews: the first two times three wrap to negative scans.
        let wrapping = Tick(i64::MAX / 3 + 1);
        let minus_one = Tick(0x5555_5555_5555_5555);
        for skew in [wrapping, minus_one, Tick(i64::MAX), Tick(i64::MIN)] {
            let mut nothing = |_: &Samples, _: &mut Updates| {};
            let text = refusal(console.run(&spec(Tick::ZERO, skew, T), &mut nothing));
            assert!(text.contains("scan"), "skew {skew}: {text}");
        }
        run(console);
    });
}
