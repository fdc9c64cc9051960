//! Two shipped patches of the sort that integrators of equations stumble over, against solutions
//! that go from event to event in closed form.

use crate::bench::Bench;
use crate::roots::bisect;
use crate::{TAU, close};

/// Sought in steps of a hundredth of a radian of the quicker of both sines.
const SCAN_S: f64 = 5e-6;

struct Valve {
    t: f64,
    x: f64,
    left: f64,
    right: f64,
}

impl Valve {
    const MASS: f64 = 1.0 / 2975.2;
    // N/m, m, N.
    const SPRING: f64 = 1488.6;
    const TRAVEL: f64 = 1.016e-3;
    const LEVEL: f64 = 1.0;

    fn force(t: f64, x: f64) -> f64 {
        0.606 + 2.0335 * (250.0 * TAU * t).sin() - Self::SPRING * x
    }

    /// The first zero of `f` after `t`, falling through it; `until` where there is none.
    fn first(t: f64, until: f64, f: impl Fn(f64) -> f64) -> f64 {
        let mut a = t;
        while a < until {
            if f(a + SCAN_S) < 0.0 {
                return bisect(&f, a, a + SCAN_S).min(until);
            }
            a += SCAN_S;
        }
        until
    }

    /// Slides in `direction` from rest, until it rests or stands at a stop.
    fn slide(&mut self, direction: f64, until: f64) {
        // x = c + s sin Ωt + A cos ωτ + B sin ωτ.
        let (w, drive) = ((Self::SPRING / Self::MASS).sqrt(), 250.0 * TAU);
        let c = (0.606 - direction * Self::LEVEL) / Self::SPRING;
        let s = 2.0335 / (Self::SPRING - Self::MASS * drive * drive);
        let (t0, x0) = (self.t, self.x);
        let a = x0 - c - s * (drive * t0).sin();
        let b = -s * drive * (drive * t0).cos() / w;
        let x = |t: f64| {
            let (sin, cos) = (w * (t - t0)).sin_cos();
            c + s * (drive * t).sin() + a * cos + b * sin
        };
        let v = |t: f64| {
            let (sin, cos) = (w * (t - t0)).sin_cos();
            s * drive * (drive * t).cos() - a * w * sin + b * w * cos
        };
        // The speed begins at zero and grows with the square of time.
        let rest = Self::first(t0 + SCAN_S, until, |t| direction * v(t));
        let stop = if direction > 0.0 { Self::TRAVEL } else { 0.0 };
        let contact = Self::first(t0 + SCAN_S, until, |t| direction * (stop - x(t)));
        if contact < rest {
            self.t = contact;
            self.x = stop;
            if direction > 0.0 {
                self.right += 1.0;
            } else {
                self.left += 1.0;
            }
        } else {
            self.t = rest;
            self.x = x(rest);
        }
    }

    fn run(until: f64) -> Valve {
        let mut valve = Valve { t: 0.0, x: 0.0, left: 0.0, right: 0.0 };
        while valve.t < until {
            let x = valve.x;
            let mut away = [until; 2];
            for (away, direction) in away.iter_mut().zip([1.0, -1.0]) {
                let blocked = if direction > 0.0 { x >= Self::TRAVEL } else { x <= 0.0 };
                if !blocked {
                    *away = Self::first(valve.t, until, |t| {
                        Self::LEVEL - direction * Self::force(t, x)
                    });
                }
            }
            valve.t = away[0].min(away[1]);
            if valve.t < until {
                valve.slide(if away[0] < away[1] { 1.0 } else { -1.0 }, until);
            }
        }
        valve
    }
}

#[test]
fn a_valve_hits_its_stops_as_often_as_it_does() {
    for until_s in [0.0333, 0.1017] {
        let truth = Valve::run(until_s);
        let mut bench = Bench::shipped("valve.toml");
        bench.run(until_s);
        let found = (bench.net("left_contacts"), bench.net("right_contacts"));
        assert_eq!(found, (truth.left, truth.right), "{until_s} s");
        assert!(truth.left > 7.0 && truth.right > 7.0, "{found:?}");
        // Resting at a stop it may stand a rounding beyond.
        let error = (bench.net("x") - 1e3 * truth.x).abs();
        assert!(error < 1e-8, "{} mm", bench.net("x"));
    }
}

struct Loop {
    t: f64,
    charge: f64,
    control: f64,
    turns: f64,
    pump: f64,
    edges: f64,
}

impl Loop {
    const FREE: f64 = 158.730_158_730_158_73;
    const SLOPE: f64 = 2.857_142_857_142_857;
    const ZERO: f64 = 0.510_101_1;
    const TAU: f64 = 0.203_522_01;

    /// Charge, control voltage and turns after `s`, the pump standing as it does.
    fn after(&self, s: f64) -> (f64, f64, f64) {
        // The control voltage follows a ramp: as the ramp, late by τ, and a decay.
        let rate = 0.25 * self.pump;
        let level = self.charge + Self::ZERO * self.pump - rate * Self::TAU;
        let rest = self.control - level;
        let decay = (-s / Self::TAU).exp();
        let integral = level * s + 0.5 * rate * s * s + rest * Self::TAU * (1.0 - decay);
        (
            self.charge + rate * s,
            level + rate * s + rest * decay,
            self.turns + Self::FREE * s + Self::SLOPE * integral,
        )
    }

    fn go(&mut self, to: f64) {
        (self.charge, self.control, self.turns) = self.after(to - self.t);
        self.t = to;
    }

    fn run(until: f64, each: impl Fn(f64, f64, f64)) -> Loop {
        let mut this =
            Loop { t: 0.0, charge: 0.0, control: 0.0, turns: -2.0 / TAU, pump: 0.0, edges: 0.0 };
        let (mut references, mut row) = (0.0, 1.0);
        loop {
            let reference = (1.0 / TAU + references) / 160.0;
            let due = this.turns.floor() + 1.0;
            // A turn takes less than 1/100 s.
            let oscillator = if this.edges > 0.0 || this.turns < 0.0 {
                let due = if this.edges == 0.0 { 0.0 } else { due.max(this.edges) };
                this.t + bisect(|s| this.after(s).2 - due, 0.0, 0.02)
            } else {
                f64::INFINITY
            };
            let next = reference.min(oscillator).min(until).min(0.37 * row);
            this.go(next);
            if next >= until {
                return this;
            }
            if next == 0.37 * row {
                each(next, this.charge, this.control);
                row += 1.0;
            } else if next == reference {
                references += 1.0;
                this.pump = f64::min(this.pump + 1.0, 1.0);
            } else {
                // Exactly on the turn, whatever the rounding.
                this.turns = this.edges;
                this.edges += 1.0;
                this.pump = f64::max(this.pump - 1.0, -1.0);
            }
        }
    }
}

#[test]
fn a_phase_locked_loop_slips_and_locks_as_it_does() {
    let rows = std::cell::RefCell::new(Vec::new());
    let truth = Loop::run(20.0, |t, charge, control| {
        rows.borrow_mut().push((t, charge, control));
    });
    let mut bench = Bench::shipped("charge-pump-pll.toml");
    for (t, charge, control) in rows.into_inner() {
        bench.run(t);
        // The states move by the pump's rates with the edges, whose instants are good to 1e-9 s.
        let errors = (bench.net("charge") - charge, bench.net("control") - control);
        assert!(errors.0.abs() < 1e-8 && errors.1.abs() < 1e-7, "{errors:?} at {t} s");
    }
    bench.run(20.0);
    assert_eq!(bench.net("osc_count"), truth.edges);
    assert_eq!(bench.net("ref_count"), 3200.0);
    close(bench.net("control"), truth.control, 1e-7, "control voltage");
    // Locked.
    close(truth.charge, 160.0 / 360.0, 1e-3, "the loop's end");
}
