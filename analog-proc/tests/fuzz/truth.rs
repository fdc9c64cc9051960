//! Random patches whose events are known exactly: a comparator, a limiter and a delay watch a
//! sum of sines and a polynomial of time, patched in any of the ways that there are.
//!
//! The level is drawn close to one of the sum's extremes. Where a shift of it by 1e-8 of the
//! sum's size changes the count, the patch leaves the count open.

use crate::bench::{Bench, ordered};
use crate::random::Random;
use crate::roots::{Root, Smooth, integral, roots};
use std::f64::consts::{PI, TAU};

/// The claim of the default settings.
const CLAIM: f64 = 1e-8;

struct Wave {
    amplitude: f64,
    rate: f64,
    phase: f64,
}

/// A sum of sines and a cubic.
struct Signal {
    waves: Vec<Wave>,
    cubic: [f64; 4],
}

impl Signal {
    fn at(&self, t: f64) -> f64 {
        let waves = self.waves.iter().map(|w| w.amplitude * libm::sin(w.rate * t + w.phase));
        let [a, b, c, d] = self.cubic;
        waves.sum::<f64>() + a + t * (b + t * (c + t * d))
    }

    fn slope(&self, t: f64) -> f64 {
        let rates = |w: &Wave| w.amplitude * w.rate * libm::cos(w.rate * t + w.phase);
        let [_, b, c, d] = self.cubic;
        self.waves.iter().map(rates).sum::<f64>() + b + t * (2.0 * c + t * 3.0 * d)
    }

    /// All crossings of a level; `None` where they cannot be told.
    fn crossings(&self, level: f64, until_s: f64) -> Option<Vec<Root>> {
        let sum = |power: i32| {
            let waves = self.waves.iter().map(|w| w.amplitude.abs() * w.rate.powi(power));
            waves.sum::<f64>()
        };
        let [_, b, c, d] = self.cubic.map(f64::abs);
        let t = until_s;
        let f = Smooth {
            value: |t| self.at(t) - level,
            slope: |t| self.slope(t),
            greatest_slope: sum(1) + b + t * (2.0 * c + t * 3.0 * d),
            greatest_bend: sum(2) + 2.0 * c + 6.0 * t * d,
        };
        roots(&f, 0.0, until_s)
    }

    fn size(&self, until_s: f64) -> f64 {
        (0..200).map(|i| self.at(until_s * f64::from(i) / 200.0).abs()).fold(0.1, f64::max)
    }
}

/// Rises, time above, and integral above a level.
#[derive(Clone, Copy, Debug)]
struct Above {
    count: f64,
    duty_s: f64,
    area: f64,
    /// Seconds that the instants move where the signal moves by one.
    looseness: f64,
}

fn above(signal: &Signal, level: f64, until_s: f64) -> Option<Above> {
    let crossings = signal.crossings(level, until_s)?;
    let mut found = Above {
        count: crossings.iter().filter(|r| r.rises).count() as f64,
        duty_s: 0.0,
        area: 0.0,
        looseness: crossings.iter().map(|r| 1.0 / signal.slope(r.t_s).abs()).sum(),
    };
    let mut since = (signal.at(0.0) > level).then_some(0.0);
    let fastest = signal.waves.iter().map(|w| w.rate).fold(1.0, f64::max);
    let mut add = |a: f64, b: f64| {
        found.duty_s += b - a;
        let parts = 1 + ((b - a) * fastest * 2.0) as usize;
        found.area += integral(|t| signal.at(t) - level, a, b, parts);
    };
    for root in &crossings {
        match (root.rises, since) {
            (true, None) => since = Some(root.t_s),
            (false, Some(from)) => {
                add(from, root.t_s);
                since = None;
            }
            _ => return None,
        }
    }
    if let Some(from) = since {
        add(from, until_s);
    }
    Some(found)
}

/// The lines that drive `u`.
fn lines(signal: &Signal, random: &mut Random) -> String {
    let mut text =
        String::from("one = { kind = \"constant\", value = 1.0 }\nt = { kind = \"time\" }\n");
    let mut sum = Vec::new();
    for (i, Wave { amplitude, rate, phase }) in signal.waves.iter().enumerate() {
        match random.below(4) {
            0 => {
                let frequency = rate / TAU;
                text += &format!(
                    "s{i} = {{ kind = \"signal-generator\", wave = \"sine\", frequency = {frequency:?}, phase = {phase:?} }}\n"
                );
            }
            1 => {
                text += &format!(
                    "s{i} = {{ kind = \"sine\", in = [\"{rate:?} * t\", \"{phase:?} * one\"] }}\n"
                );
            }
            2 => {
                text += &format!(
                    "a{i} = {{ kind = \"integrator\", in = [\"{rate:?} * one\"], ic = {phase:?} }}\ns{i} = {{ kind = \"sine\", in = [\"a{i}\"] }}\n"
                );
            }
            _ => {
                let (s, c) = libm::sincos(*phase);
                text += &format!(
                    "s{i} = {{ kind = \"integrator\", in = [\"{rate:?} * c{i}\"], ic = {s:?} }}\nc{i} = {{ kind = \"integrator\", in = [\"-{rate:?} * s{i}\"], ic = {c:?} }}\n"
                );
            }
        }
        sum.push(format!("\"{amplitude:?} * s{i}\""));
    }
    let [a, b, c, d] = signal.cubic;
    if signal.cubic != [0.0; 4] {
        text += &format!(
            "d2 = {{ kind = \"integrator\", in = [\"{:?} * one\"], ic = {:?} }}\nd1 = {{ kind = \"integrator\", in = [\"d2\"], ic = {b:?} }}\nd0 = {{ kind = \"integrator\", in = [\"d1\"], ic = {a:?} }}\n",
            6.0 * d,
            2.0 * c
        );
        sum.push("\"d0\"".into());
    }
    text + &format!("u = {{ kind = \"summer\", in = [{}] }}\n", sum.join(", "))
}

/// Judges the patch of a seed: `Ok(true)` where it leaves nothing open; what is wrong, and the patch.
pub fn judge(seed: u64) -> Result<bool, String> {
    let mut random = Random::new(seed ^ 0x7472_7574_6800);
    let count = random.below(4);
    let until_s = random.decade(1.0, 30.0);
    let mut waves: Vec<Wave> = (0..count)
        .map(|_| Wave {
            amplitude: random.signed(0.2, 1.5),
            rate: TAU * random.decade(0.05, 10.0),
            phase: random.between(-PI, PI),
        })
        .collect();
    let mut cubic = [0.0; 4];
    if waves.is_empty() || random.chance(0.4) {
        for (power, c) in cubic.iter_mut().enumerate() {
            *c = random.signed(0.1, 1.5) / until_s.powi(power as i32) * (1 << power) as f64;
        }
    }
    if waves.len() > 1 && random.chance(0.2) {
        // A resonance of frequencies: the sum is periodic.
        let ratio = 2.0 + random.below(3) as f64;
        waves[1].rate = waves[0].rate * ratio;
        if waves[1].rate > 100.0 {
            waves[1].rate = waves[0].rate / ratio;
        }
    }
    let signal = Signal { waves, cubic };
    let size = signal.size(until_s);
    // An extreme, looked for about a random instant.
    let around = random.between(0.0, until_s);
    let width =
        until_s.min(1.0 / (1.0 + signal.waves.iter().map(|w| w.rate).fold(0.0, f64::max)) * TAU);
    let samples = (0..2000).map(|i| {
        let t = (around + width * f64::from(i) / 2000.0).min(until_s);
        signal.at(t)
    });
    let down = random.chance(0.3);
    let extreme = if down {
        samples.fold(f64::INFINITY, f64::min)
    } else {
        samples.fold(f64::NEG_INFINITY, f64::max)
    };
    let depth = size * random.decade(1e-5, 0.3);
    let level = if down { extreme + depth } else { extreme - depth };
    let delay_s = random.decade(0.03, 1.0) * until_s * 0.9;
    let threshold = format!("{level:?}");
    let text = format!(
        r#"[blocks]
{lines}p = {{ kind = "comparator", in = ["u"], threshold = {threshold} }}
n = {{ kind = "counter", in = ["p"] }}
zero = {{ kind = "constant", value = 0.0 }}
gate = {{ kind = "switch", in = ["one", "zero"], control = "p" }}
duty = {{ kind = "integrator", in = ["gate"] }}
y = {{ kind = "limiter", in = ["u", "{negative:?} * one"], limits = [0.0, {high:?}] }}
area = {{ kind = "integrator", in = ["y"] }}
late = {{ kind = "transport-delay", in = ["u"], delay = {delay_s:?}, initial = {initial:?} }}
q = {{ kind = "comparator", in = ["late"], threshold = {threshold} }}
m = {{ kind = "counter", in = ["q"] }}
stay = {{ kind = "integrator", in = ["one"], operate = "q" }}
"#,
        lines = lines(&signal, &mut random),
        negative = -level,
        high = 10.0 * size + 10.0 * level.abs(),
        initial = level - 1.0,
    );
    let shift = CLAIM * size;
    let all: Option<Vec<(Above, Above)>> = [level, level - shift, level + shift]
        .iter()
        .map(|level| {
            let now = above(&signal, *level, until_s)?;
            let mut late = above(&signal, *level, until_s - delay_s)?;
            // The past begins below the level: where the signal begins above it, that is a rise.
            late.count += f64::from(signal.at(0.0) > *level);
            Some((now, late))
        })
        .collect();
    let Some(all) = all else { return Ok(false) };
    let (now, late) = all[0];
    if all.iter().any(|(a, b)| (a.count, b.count) != (now.count, late.count)) {
        return Ok(false);
    }
    let mut bench = Bench::of(ordered(&text).map_err(|e| format!("{e}\n{text}"))?);
    if let Err(fault) = bench.try_run(until_s) {
        return Err(format!("seed {seed}, until {until_s} s: {fault}\n{text}"));
    }
    let mut wrong = String::new();
    let mut check = |net: &str, truth: f64, tolerance: f64| {
        let found = bench.net(net);
        let error = (found - truth).abs();
        if error > tolerance || error.is_nan() {
            wrong += &format!("# {net} = {found:?} instead of {truth:?}, {error:.1e}\n");
        }
    };
    check("n", now.count, 0.0);
    check("m", late.count, 0.0);
    // Each instant moves with the signal; the integral of what is zero there does not.
    let slack = |above: &Above| shift * above.looseness + CLAIM * above.duty_s + 1e-11;
    check("duty", now.duty_s, slack(&now));
    check("stay", late.duty_s, slack(&late));
    check("area", now.area, CLAIM * size * now.duty_s + 1e-11);
    if wrong.is_empty() {
        Ok(true)
    } else {
        Err(format!("# seed {seed} of truths, until = {until_s:?} s\n{wrong}{text}"))
    }
}
