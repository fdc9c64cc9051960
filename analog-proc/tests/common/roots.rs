//! Zeros of a function of time, none missed: a proof by bounds on its derivatives.
//!
//! An interval holds no zero where the value in its middle exceeds what the first
//! derivative's bound allows over half of it, and at most one where the first derivative
//! cannot change its sign for the second's bound. What is neither is halved, down to
//! rounding: there the function touches its level more closely than doubles can tell.

#![allow(dead_code, reason = "each user takes what it needs")]

/// A function with its first derivative and bounds on the first and second over the range asked for.
pub struct Smooth<F: Fn(f64) -> f64, D: Fn(f64) -> f64> {
    pub value: F,
    pub slope: D,
    pub greatest_slope: f64,
    pub greatest_bend: f64,
}

/// A zero, and whether the function rises through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    pub t_s: f64,
    pub rises: bool,
}

/// All zeros in `(from_s, to_s]`, in order of time; `None` where two cannot be told from none.
pub fn roots<F: Fn(f64) -> f64, D: Fn(f64) -> f64>(
    f: &Smooth<F, D>,
    from_s: f64,
    to_s: f64,
) -> Option<Vec<Root>> {
    let mut found = Vec::new();
    let mut waiting = vec![(from_s, to_s)];
    while let Some((a, b)) = waiting.pop() {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        if (f.value)(middle).abs() > f.greatest_slope * half {
            continue;
        }
        if (f.slope)(middle).abs() > f.greatest_bend * half {
            let (low, high) = ((f.value)(a), (f.value)(b));
            // Half-open: a zero at the lower end belongs to the interval before.
            if (low <= 0.0) != (high <= 0.0) {
                let t_s = bisect(|t| (f.value)(t), a, b);
                found.push(Root { t_s, rises: high > 0.0 });
            }
            continue;
        }
        if half <= 1e-12 * b.abs().max(1e-3) {
            return None;
        }
        waiting.push((middle, b));
        waiting.push((a, middle));
    }
    Some(found)
}

/// The zero of `f` in a bracket, to the last digit.
pub fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let rises = f(b) > 0.0;
    loop {
        let middle = 0.5 * (a + b);
        if !(middle > a && middle < b) {
            return b;
        }
        if (f(middle) > 0.0) == rises {
            b = middle;
        } else {
            a = middle;
        }
    }
}

/// ∫ f over [a, b] by Gauss's rule of five points on each of `parts` parts: exact for degree nine.
pub fn integral(f: impl Fn(f64) -> f64, a: f64, b: f64, parts: usize) -> f64 {
    // Nodes and weights on [−1, 1].
    const RULE: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = 0.5 * (b - a) / parts as f64;
    let mut sum = 0.0;
    for part in 0..parts {
        let middle = a + half * (2 * part + 1) as f64;
        for (node, weight) in RULE {
            sum += weight * f(middle + half * node);
        }
    }
    sum * half
}
