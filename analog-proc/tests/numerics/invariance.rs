//! What must not change an answer: repetition, recording, frames, HOLD.

use crate::common::{Patch, close, integrator, tick};
use crate::oscillator;
use analog_proc::block::kind::*;
use engine::element::dac::DacPiece;
use engine::{id::NetId, integration::Method};

fn lorenz() -> Patch {
    let mut patch = Patch::new();
    patch.add("x", integrator(1.0), &["10 * y", "-10 * x"]);
    patch.add("y", integrator(1.0), &["28 * x", "-1 * y", "-1 * xz"]);
    patch.add("z", integrator(1.0), &["xy", "-2.6666666666666665 * z"]);
    patch.add("xz", Kind::Multiplier(Multiplier), &["x", "z"]);
    patch.add("xy", Kind::Multiplier(Multiplier), &["x", "y"]);
    patch.add("sign", Kind::Comparator(Comparator { threshold: 0.0, hysteresis: 0.0 }), &["x"]);
    patch
}

#[test]
fn runs_repeat_to_the_bit_and_recording_changes_nothing() {
    let run = |every: Option<f64>| {
        let mut simulation = lorenz().simulation();
        match every {
            Some(every) => simulation
                .advance_recording(tick(12.0), tick(every), &[NetId(0)], |_, _| {})
                .unwrap(),
            None => simulation.advance_to(tick(12.0)).unwrap(),
        };
        [0, 1, 2].map(|i| simulation.net(NetId(i)).to_bits())
    };
    let first = run(None);
    assert_eq!(first, run(None));
    assert_eq!(first, run(Some(0.1)));
    assert_eq!(first, run(Some(0.000_37)));
}

#[test]
fn frames_do_not_change_the_answer() {
    let mut whole = oscillator(Method::DormandPrince).simulation();
    whole.advance_to(tick(5.0)).unwrap();
    let mut framed = oscillator(Method::DormandPrince).simulation();
    for n in 1..=50 {
        framed.apply().unwrap();
        framed.advance_to(tick(0.1) * n).unwrap();
        assert_eq!(framed.now_s().to_bits(), (tick(0.1) * n).secs().to_bits());
    }
    // Both within the default tolerance of the truth over two cycles.
    assert!((whole.net(NetId(0)) - framed.net(NetId(0))).abs() < 1e-9);
}

#[test]
fn hold_feeds_nothing_through() {
    let mut patch = Patch::new();
    patch.add("in", Kind::Dac(Dac { channel: 3, initial: 1.0 }), &[]);
    patch.add("run", Kind::Control(Control { line: 0, initial: true }), &[]);
    let operate = Some(NetId(1));
    let held = Kind::Integrator(Integrator {
        ic: 0.0,
        limits: None,
        operate,
        reset: None,
        reset_to: None,
    });
    patch.add("y", held, &["in"]);
    let mut simulation = patch.simulation();
    simulation.advance_to(tick(1.0)).unwrap();
    simulation.set_control(0, false);
    simulation.set_dac(3, DacPiece::held(1e300, 1.0));
    simulation.apply().unwrap();
    let before = simulation.net(NetId(2));
    simulation.advance_to(tick(2.0)).unwrap();
    assert_eq!(simulation.net(NetId(2)).to_bits(), before.to_bits());
    simulation.hold(true);
    simulation.set_control(0, true);
    simulation.apply().unwrap();
    let stood = simulation.advance_to(tick(3.0)).unwrap();
    assert_eq!(stood.reached, tick(2.0));
    assert_eq!(simulation.net(NetId(2)).to_bits(), before.to_bits());
    close(before, 1.0, 1e-12, "held value");
}
