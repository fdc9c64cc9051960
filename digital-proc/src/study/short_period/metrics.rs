//! Measures of a response: overshoot, settling, residual oscillation, bending
//! envelope, saturation.
//!
//! All work on uniformly sampled columns. A measure whose window holds too few
//! samples, or that meets a non-finite sample, is `None`: it is never guessed.

/// A window of problem time, s, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(from = "[f64; 2]")]
pub struct Window {
    /// First instant, s.
    pub from_s: f64,
    /// Last instant, s.
    pub to_s: f64,
}

impl From<[f64; 2]> for Window {
    fn from([from_s, to_s]: [f64; 2]) -> Self {
        Window { from_s, to_s }
    }
}

impl Window {
    /// Sample indices in the window; samples a rounding error outside count as in.
    fn indices(&self, sample_s: f64, len: usize) -> std::ops::Range<usize> {
        // A thousandth of a sample: far above rounding, far below a sample.
        const SLACK: f64 = 1e-3;
        let first = (self.from_s / sample_s - SLACK).ceil().max(0.0) as usize;
        let last = (self.to_s / sample_s + SLACK).floor();
        if last < 0.0 {
            return 0..0;
        }
        first.min(len)..(last as usize + 1).min(len).max(first.min(len))
    }
}

/// Greatest excess of a step response over the step, as a fraction of the step;
/// 0 if it never exceeds it. `None` for a step of 0.
#[must_use]
pub fn overshoot(column: &[f64], step: f64) -> Option<f64> {
    if step == 0.0 || column.is_empty() || column.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let greatest = column.iter().map(|v| v / step).fold(0.0_f64, f64::max);
    Some((greatest - 1.0).max(0.0))
}

/// First instant from which the column stays within `band` of `target` to the end;
/// `None` if it does not at the end.
#[must_use]
pub fn settling_s(column: &[f64], sample_s: f64, target: f64, band: f64) -> Option<f64> {
    let inside = |v: &f64| (v - target).abs() <= band;
    if !column.last().is_some_and(inside) {
        return None;
    }
    let last_outside = column.iter().rposition(|v| !inside(v));
    Some(last_outside.map_or(0.0, |i| (i + 1) as f64 * sample_s))
}

/// Peak-to-peak value in a window after removing the least-squares parabola.
#[must_use]
pub fn detrended_peak_to_peak(column: &[f64], sample_s: f64, window: Window) -> Option<f64> {
    let range = window.indices(sample_s, column.len());
    let values = &column[range];
    if values.len() < 4 || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    // Legendre-like basis on [−1, 1], orthogonalised by the normal equations of
    // three unknowns; scaling keeps them well conditioned.
    let n = values.len();
    let u = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (i, value) in values.iter().enumerate() {
        let basis = nalgebra::Vector3::new(1.0, u(i), u(i) * u(i));
        normal += basis * basis.transpose();
        right += basis * *value;
    }
    let trend = normal.cholesky()?.solve(&right);
    let (low, high) = values
        .iter()
        .enumerate()
        .map(|(i, v)| v - trend[0] - trend[1] * u(i) - trend[2] * u(i) * u(i))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| {
            (low.min(r), high.max(r))
        });
    Some(high - low)
}

/// Largest |x − moving average over one period| in a window.
///
/// The average runs over the period centred on each instant (trapezoidal rule, ends
/// weighted by the part of a sample they cover) and is taken only where the whole
/// period lies inside the record.
#[must_use]
pub fn envelope(column: &[f64], sample_s: f64, period_s: f64, window: Window) -> Option<f64> {
    let half = period_s / 2.0 / sample_s;
    let reach = half.ceil() as usize;
    if !half.is_finite() || half <= 0.0 {
        return None;
    }
    // Cumulative trapezoidal integral in samples, so that an average is two look-ups.
    let mut integral = Vec::with_capacity(column.len());
    let mut sum = 0.0;
    for (i, value) in column.iter().enumerate() {
        if i > 0 {
            sum += (value + column[i - 1]) / 2.0;
        }
        integral.push(sum);
    }
    let integral_to = |x: f64| {
        let i = x.floor() as usize;
        let part = x - i as f64;
        match column.get(i + 1) {
            Some(next) => integral[i] + part * (column[i] + part / 2.0 * (next - column[i])),
            None => integral[i],
        }
    };
    let range = window.indices(sample_s, column.len());
    let mut greatest: Option<f64> = None;
    for i in range {
        if i < reach || i + reach >= column.len() {
            continue;
        }
        let mean = (integral_to(i as f64 + half) - integral_to(i as f64 - half)) / (2.0 * half);
        let deviation = (column[i] - mean).abs();
        if !deviation.is_finite() {
            return None;
        }
        greatest = Some(greatest.map_or(deviation, |g: f64| g.max(deviation)));
    }
    greatest
}

/// Longest unbroken time for which `condition` holds at the samples, s.
///
/// A single sample counts as one interval.
#[must_use]
pub fn longest_run_s(len: usize, sample_s: f64, condition: impl Fn(usize) -> bool) -> f64 {
    let mut longest = 0_usize;
    let mut present = 0_usize;
    for i in 0..len {
        present = if condition(i) { present + 1 } else { 0 };
        longest = longest.max(present);
    }
    longest as f64 * sample_s
}

/// Total time for which |x| is at least `level`, s.
#[must_use]
pub fn time_beyond_s(column: &[f64], sample_s: f64, level: f64) -> f64 {
    column.iter().filter(|v| v.abs() >= level).count() as f64 * sample_s
}

/// First instant at which |x| exceeds `level`, s.
#[must_use]
pub fn first_beyond_s(column: &[f64], sample_s: f64, level: f64) -> Option<f64> {
    column
        .iter()
        .position(|v| v.abs() > level)
        .map(|i| i as f64 * sample_s)
}
