//! What stops a run or is told of it: each fault with its block and its instant.

use crate::common::{Patch, close, integrator, tick};
use crate::oscillator;
use analog_proc::block::kind::*;
use analog_proc::net::{Expected, Level};
use analog_proc::static_check::static_check;
use engine::fault::RunFault;
use engine::{
    id::{BlockId, NetId},
    integration::{Method, OverloadPolicy},
};

#[test]
fn undefined_numbers_are_faults() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut patch = Patch::new();
        patch.add("y", integrator(bad), &["-1 * y"]);
        assert!(matches!(patch.ordered().simulation(), Err(RunFault::NonFinite { .. })));
        let mut patch = Patch::new();
        patch.add("c", Kind::Constant(Constant { value: bad }), &[]);
        patch.add("y", integrator(0.0), &["c"]);
        assert!(matches!(patch.ordered().simulation(), Err(RunFault::NonFinite { .. })));
        let mut patch = oscillator(Method::DormandPrince);
        patch.integration.rtol = bad;
        assert!(matches!(patch.ordered().simulation(), Err(RunFault::Setting { .. })));
    }
    // dy/dt = y² from 1 is infinite at t = 1.
    let mut patch = Patch::new();
    patch.add("y", integrator(1.0), &["q"]);
    patch.add("q", Kind::Square(Square), &["y"]);
    let fault = patch.simulation().advance_to(tick(2.0)).unwrap_err();
    assert!(
        matches!(fault, RunFault::StepUnderflow { .. } | RunFault::NonFinite { .. }),
        "{fault}"
    );
}

#[test]
fn zero_divisors_and_negative_roots_are_located() {
    let mut patch = Patch::new();
    patch.add("t", Kind::Time(Time), &[]);
    patch.add("one", Kind::Constant(Constant { value: 1.0 }), &[]);
    patch.add("down", Kind::Summer(Summer), &["one", "-4 * t"]);
    patch.add("ratio", Kind::Divider(Divider), &["one", "down"]);
    match patch.simulation().advance_to(tick(1.0)).unwrap_err() {
        RunFault::DividedByZero { block, t_s } => {
            assert_eq!(block, "ratio");
            assert!((t_s - 0.25).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
    let mut patch = Patch::new();
    patch.add("t", Kind::Time(Time), &[]);
    patch.add("one", Kind::Constant(Constant { value: 1.0 }), &[]);
    patch.add("root", Kind::SquareRoot(SquareRoot), &["one", "-4 * t"]);
    match patch.simulation().advance_to(tick(1.0)).unwrap_err() {
        RunFault::NegativeRoot { block, t_s } => {
            assert_eq!(block, "root");
            assert!((t_s - 0.25).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
}

/// d = √(max(1 − t, 0)), the argument cut off in three ways.
#[test]
fn a_guarded_root_goes_on_at_zero() {
    let limits = [0.0, 10.0];
    let limiter =
        Kind::Limiter(Limiter { low: Level::Fixed(limits[0]), high: Level::Fixed(limits[1]) });
    let stopped = Kind::Integrator(Integrator {
        ic: 1.0,
        limits: Some(limits),
        operate: None,
        reset: None,
        reset_to: None,
    });
    for (ramp, guard) in [
        (integrator(1.0), limiter),
        (integrator(1.0), Kind::Max(Max)),
        (stopped, Kind::Summer(Summer)),
    ] {
        let mut patch = Patch::new();
        patch.add("one", Kind::Constant(Constant { value: 1.0 }), &[]);
        patch.add("zero", Kind::Constant(Constant { value: 0.0 }), &[]);
        patch.add("a", ramp, &["-1 * one"]);
        let cut = matches!(guard, Kind::Max(Max));
        let inputs: &[&str] = if cut { &["a", "zero"] } else { &["a"] };
        patch.add("p", guard, inputs);
        let d = patch.add("d", Kind::SquareRoot(SquareRoot), &["p"]);
        let area = patch.add("I", integrator(0.0), &["d"]);
        let mut simulation = patch.simulation();
        for t_s in [0.5, 1.0, 1.5, 4.0] {
            simulation.advance_to(tick(t_s)).unwrap();
            let expected = (1.0 - t_s).max(0.0).sqrt();
            // Rounding of the argument below the tolerance of the state.
            assert!((simulation.net(d) - expected).abs() < 1e-6, "d at {t_s}");
        }
        close(simulation.net(area), 2.0 / 3.0, 1e-6, "area");
    }
}

#[test]
fn races_and_chatter_are_faults_not_hangs() {
    // A flip-flop that sets itself when clear and clears itself when set.
    let mut patch = Patch::new();
    patch.add("q", Kind::FlipFlop(FlipFlop { initial: false }), &["nq", "q"]);
    patch.add("nq", Kind::Not(Not), &["q"]);
    match patch.ordered().simulation() {
        Err(RunFault::LogicRace { nets, .. }) => assert!(nets.contains(&"q".to_string())),
        other => panic!("{:?}", other.map(|_| ())),
    }
    // Sliding on a relay without hysteresis.
    let mut patch = Patch::new();
    patch.add("x", integrator(1.0), &["r"]);
    let relay = Kind::Relay(Relay { points: [0.0, 0.0], outputs: [1.0, -1.0], initially_on: true });
    patch.add("r", relay, &["x"]);
    match patch.simulation().advance_to(tick(2.0)) {
        Err(RunFault::Chatter { block, t_s, .. }) => {
            assert_eq!(block, "r");
            assert!((t_s - 1.0).abs() < 1e-6);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn overload_is_latched_where_it_happens() {
    let mut patch = oscillator(Method::DormandPrince);
    // v = −2·sin 2t reaches −1.1 at t = ½·asin(0.55).
    patch.max("v", 1.0);
    for policy in [OverloadPolicy::Continue, OverloadPolicy::Hold, OverloadPolicy::Stop] {
        patch.integration.overload = policy;
        let mut simulation = patch.simulation();
        let advance = simulation.advance_to(tick(5.0)).unwrap();
        let latched = simulation.overloads()[0];
        assert_eq!(simulation.overloads().len(), 1);
        assert_eq!(latched.block, BlockId(1));
        close(latched.t_s, 0.5 * 0.55_f64.asin(), 1e-9, "overload");
        assert_eq!(advance.stopped_by.is_some(), policy != OverloadPolicy::Continue);
        let again = simulation.advance_to(tick(6.0)).unwrap();
        assert_eq!(again.reached == tick(6.0), policy == OverloadPolicy::Continue);
    }
}

#[test]
fn static_check_reports_what_differs() {
    let mut ordered = oscillator(Method::DormandPrince).ordered();
    let mut simulation = ordered.simulation().unwrap();
    let item = |derivative| Expected {
        net: NetId(1),
        output: Some(0.0),
        derivative: Some(derivative),
        tolerance: 1e-12,
    };
    ordered.netlist.expected = vec![item(-4.0), item(4.0)];
    let found = static_check(&ordered, &mut simulation).unwrap();
    let seen: Vec<_> = found.iter().map(|l| (l.what.as_str(), l.found, l.agrees)).collect();
    let wanted = [
        ("output", 0.0, true),
        ("derivative", -4.0, true),
        ("output", 0.0, true),
        ("derivative", -4.0, false),
    ];
    assert_eq!(seen, wanted);
}
