//! Switching instants against those of the analytic solution.

use crate::{Bench, close};
use engine::fault::RunFault;

/// A ball that keeps 0.8 of its speed.
const BALL: &str = r#"
    g = { kind = "constant", value = -9.81 }
    h = { kind = "integrator", in = ["v"], ic = 1.0 }
    v = { kind = "integrator", in = ["g"], reset = "contact", reset-to = "-0.8 * v" }
    contact = { kind = "comparator", in = ["-1 * h"] }
    floor = { kind = "interrupt", in = ["contact"], line = 7 }
"#;

#[test]
fn ball_bounces_at_the_analytic_times() {
    let bounces = Bench::new(BALL).run(3.9).edges(7, true);
    // First contact at √(2h/g); each flight lasts 2·e^n·√(2h/g).
    let first_s = (2.0_f64 / 9.81).sqrt();
    let mut expected_s = first_s;
    assert_eq!(bounces.len(), 14);
    for (n, bounce_s) in bounces.iter().enumerate() {
        close(*bounce_s, expected_s, 1e-8, "bounce");
        expected_s += 2.0 * 0.8_f64.powi(n as i32 + 1) * first_s;
    }
}

#[test]
fn accumulating_bounces_end_in_a_fault_that_names_the_contact() {
    let mut bench = Bench::new(BALL);
    // Bounces accumulate at √(2h/g)·(1 + e)/(1 − e) = 4.06 s.
    let limit_s = (2.0_f64 / 9.81).sqrt() * 9.0;
    match bench.try_run(6.0) {
        Err(RunFault::Chatter { t_s, block, .. }) => {
            assert_eq!(block, "contact");
            // Remaining flights at the resolution of the state: √(2·1e-12/g)·9 ≈ 4e-6.
            assert!((t_s - limit_s).abs() < 1e-5, "chatter at {t_s}, accumulation at {limit_s}");
        }
        other => panic!("{other:?}"),
    }
    // The fault stands.
    assert!(bench.try_run(7.0).is_err());
    bench.simulation.reset().unwrap();
    bench.run(1.0);
}

#[test]
fn mass_on_a_belt_sticks_and_slips() {
    // Spring pulled at speed 1: sticks until k·t = breakaway, then slips.
    let mut bench = Bench::new(
        r#"
        t = { kind = "time" }
        x = { kind = "integrator", in = ["v"] }
        v = { kind = "integrator", in = ["spring", "friction"] }
        spring = { kind = "summer", in = ["4 * t", "-4 * x"] }
        friction = { kind = "dry-friction", in = ["v", "spring"], level = 1.0, breakaway = 2.0 }
        moving = { kind = "comparator", in = ["v"], threshold = 1e-12 }
        line = { kind = "interrupt", in = ["moving"], line = 0 }
    "#,
    );
    bench.run(0.499);
    assert_eq!((bench.net("x"), bench.net("v")), (0.0, 0.0));
    let times: Vec<f64> = bench.run(6.0).all_edges().iter().map(|e| e.t_s).collect();
    // Slip: v̈ = 4(1 − v) with v = 0, v̇ = 1 at break-away: v = 1 − cos 2s + ½ sin 2s,
    // zero again where tan s = −½·… : 2s = 2π − 2·atan(1/2).
    let slip_s = std::f64::consts::PI - 0.5_f64.atan();
    assert!((times[0] - 0.5).abs() < 1e-10);
    close(times[1], 0.5 + slip_s, 1e-8, "stick");
    assert_eq!(bench.net("v") != 0.0, times.len() % 2 == 1);
}
