//! The analog side of a session as its partner meets it, over a link in memory.
//!
//! What cannot be done is refused as a whole; what a converter or a coefficient
//! unit cannot represent is held at its end and said.

#![allow(clippy::unwrap_used)]

use analog_proc::session::serve::serve;
use interface::{
    Tick,
    control::{Clock, PatchBundle, Reply, Request, RunSpec},
    frame::{RunState, Samples, Updates},
    link::{DigitalFrames, DigitalPort, LinkFault, memory},
    profile::{Profile, Provenance, Sourced},
};
use std::thread::JoinHandle;

const T: Tick = Tick(100_000_000);

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

struct Session {
    port: memory::MemoryDigital,
    analog: JoinHandle<Result<(), LinkFault>>,
}

impl Session {
    fn load(profile: Profile) -> Session {
        let (mut analog, port) = memory::pair();
        let analog = std::thread::spawn(move || serve(&mut analog));
        let mut session = Session { port, analog };
        let bundle = PatchBundle { root: "p".into(), files: vec![("p".into(), PATCH.into())] };
        let reply = session.request(Request::Load { bundle, params: Vec::new(), profile });
        assert!(matches!(reply, Reply::Loaded { .. }), "{reply:?}");
        session
    }

    fn request(&mut self, request: Request) -> Reply {
        self.port.request(&request).unwrap()
    }

    fn does(&mut self, request: Request) {
        assert_eq!(self.request(request), Reply::Done);
    }

    fn refuses(&mut self, request: Request) -> String {
        match self.request(request) {
            Reply::Refused(text) => text,
            other => panic!("{other:?}"),
        }
    }

    /// Three frames from the initial condition, without an update.
    fn run(&mut self) -> Vec<Samples> {
        self.does(Request::Operate(spec(Tick::ZERO)));
        let mut all = Vec::new();
        for frame in 0.. {
            let samples = self.port.await_samples(frame).unwrap();
            all.push(samples);
            if samples.run_state() != RunState::Operate {
                break;
            }
            let updates = Updates::new(frame, samples.tick);
            self.port.send_updates(&updates).unwrap();
        }
        assert_eq!(all.len(), 3);
        assert_eq!(all[2].run_state(), RunState::Ended);
        all
    }

    /// DAC, coefficient and both integrators where a run starts.
    fn start(&mut self) -> [f64; 4] {
        let first = self.run()[0];
        [0, 1, 2, 3].map(|channel| first.adc[channel])
    }

    fn bye(mut self) {
        self.does(Request::Bye);
        self.analog.join().unwrap().unwrap();
    }
}

fn spec(skew: Tick) -> RunSpec {
    RunSpec {
        frame: T,
        latency: Tick::ZERO,
        skew,
        stop: T * 2,
        from_ic: true,
        clock: Clock::LockStep,
    }
}

/// Settings of `d` and `c`, and of a DAC that is not there.
fn preset(values: &[(&str, f64)]) -> Request {
    let mut updates = Updates::new(0, Tick::ZERO);
    for &(name, value) in values {
        match name {
            "d" => updates.set_dac(3, value),
            "c" => updates.set_dcu(70, value),
            _ => updates.set_dac(9, value),
        }
    }
    Request::Preset(updates)
}

fn values(values: &[(&str, f64)]) -> Vec<(String, f64)> {
    values.iter().map(|(n, v)| ((*n).into(), *v)).collect()
}

fn assumed<T>(value: T) -> Option<Sourced<T>> {
    Some(Sourced { value, status: Provenance::Assumed, source: "for this test".into() })
}

/// DACs of 12 bits, coefficient units of 14 bits and range 1.
fn limited() -> Profile {
    let mut profile = Profile::ideal();
    profile.dac.bits = assumed(12);
    profile.dcu.bits = assumed(14);
    profile.dcu.range = assumed(1.0);
    profile
}

#[test]
fn a_run_that_starts_beyond_a_range_says_so_in_its_first_frame() {
    let mut session = Session::load(limited());
    let flags = |s: &Samples| (s.dac_saturated, s.dcu_saturated);
    let nothing = (0, [0, 0]);
    session.does(preset(&[("c", 1.5), ("d", -12.0)]));
    // Twice: what stands beyond a range is told in every run that starts from it.
    for _ in 0..2 {
        let samples = session.run();
        assert_eq!(flags(&samples[0]), (1 << 3, [0, 1 << (70 - 64)]));
        assert_eq!(&samples[0].adc[..2], [-10.0, 1.0]);
        assert_eq!(flags(&samples[1]), nothing);
        assert_eq!(flags(&samples[2]), nothing);
    }
    // What was put right before the run is forgotten.
    session.does(preset(&[("c", 0.75), ("d", 5.0)]));
    let samples = session.run();
    assert!(samples.iter().all(|s| flags(s) == nothing));
    assert_eq!(&samples[0].adc[..2], [5.0, 0.75]);
    session.bye();
}

#[test]
fn a_refused_request_changes_nothing() {
    let mut session = Session::load(Profile::ideal());
    let ics = |v: &[(&str, f64)]| Request::SetIcs(values(v));
    session.does(ics(&[("x", 4.0)]));
    session.does(preset(&[("d", 0.5)]));
    let before = [0.5, 0.5, 4.0, 3.0];
    assert_eq!(session.start(), before);
    for (request, word) in [
        // Later entries that cannot be.
        (ics(&[("x", 5.0), ("nobody", 1.0)]), "nobody"),
        (ics(&[("x", 5.0), ("z", f64::NAN)]), "`z`"),
        (preset(&[("d", 1.0), ("c", 0.75), ("nobody", 1.0)]), "channel"),
        (preset(&[("d", 1.0), ("c", f64::INFINITY)]), "DCU 70"),
        // Each can be set, but not together with the patch: `r` is 1/x and `q` is 1/c.
        (ics(&[("z", 5.0), ("x", 0.0)]), "`r`"),
        (preset(&[("d", 1.0), ("c", 0.0)]), "`q`"),
    ] {
        let text = session.refuses(request.clone());
        assert!(text.contains(word), "{request:?}: {text}");
        assert_eq!(session.start(), before, "{request:?}");
        // What a pot-set carries over is what was in force.
        session.does(Request::SetParams(Vec::new()));
        assert_eq!(session.start(), before, "{request:?} and a pot-set");
    }
    // The last of several values for one name counts.
    session.does(ics(&[("x", 5.0), ("z", 6.0), ("x", 7.0)]));
    session.does(preset(&[("c", 0.25), ("d", 2.0)]));
    assert_eq!(session.start(), [2.0, 0.25, 7.0, 6.0]);
    session.bye();
}

#[test]
fn a_scan_beyond_all_ticks_is_refused() {
    let mut session = Session::load(Profile::ideal());
    // Four channels, three skews: the first two times three wrap to negative scans.
    let wrapping = Tick(i64::MAX / 3 + 1);
    let minus_one = Tick(0x5555_5555_5555_5555);
    for skew in [wrapping, minus_one, Tick(i64::MAX), Tick(i64::MIN)] {
        let text = session.refuses(Request::Operate(spec(skew)));
        assert!(text.contains("scan"), "skew {skew}: {text}");
    }
    session.run();
    session.bye();
}
