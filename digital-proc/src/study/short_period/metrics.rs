//! Measures of a response: overshoot, settling, residual oscillation, bending
//! envelope, saturation.
//!
//! All work on uniformly sampled columns. A measure whose window holds too few
//! samples, or that meets a non-finite sample, is `None`: it is never guessed.

/// The greatest of some differences, none of them negative; NaN where one is.
pub fn worst_of(differences: impl IntoIterator<Item = f64>) -> f64 {
    differences.into_iter().fold(0.0, |m: f64, v| if v > m || v.is_nan() { v } else { m })
}

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
    pub(super) fn indices(&self, sample_s: f64, len: usize) -> std::ops::Range<usize> {
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
pub fn overshoot(column: &[f64], step: f64) -> Option<f64> {
    if step == 0.0 || column.is_empty() || column.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let greatest = column.iter().map(|v| v / step).fold(0.0_f64, f64::max);
    Some((greatest - 1.0).max(0.0))
}

/// Instant from which the column stays within `band` of `target` to the end, the
/// crossing interpolated linearly between its samples; `None` if it does not at the end.
pub fn settling_s(column: &[f64], sample_s: f64, target: f64, band: f64) -> Option<f64> {
    let distance = |v: f64| (v - target).abs();
    let inside = |v: &f64| distance(*v) <= band;
    if !column.last().is_some_and(inside) {
        return None;
    }
    let Some(last) = column.iter().rposition(|v| !inside(v)) else {
        return Some(0.0);
    };
    let (outside, next) = (distance(column[last]), distance(column[last + 1]));
    let part = if outside.is_finite() { (outside - band) / (outside - next) } else { 1.0 };
    Some((last as f64 + part) * sample_s)
}

/// Peak-to-peak value in a window after removing the least-squares parabola.
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
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| (low.min(r), high.max(r)));
    Some(high - low)
}

/// Deviation from the moving average over one period centred on each instant.
///
/// The average is that of the piecewise-linear column, and is taken only where the
/// whole period lies inside the record: shape `[samples]`, `None` elsewhere. A sine
/// of that period passes unchanged, a steady trend is removed.
pub fn oscillating_part(column: &[f64], sample_s: f64, period_s: f64) -> Vec<Option<f64>> {
    let half = period_s / 2.0 / sample_s;
    if !half.is_finite() || half <= 0.0 {
        return vec![None; column.len()];
    }
    let reach = half.ceil() as usize;
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
    (0..column.len())
        .map(|i| {
            if i < reach || i + reach >= column.len() {
                return None;
            }
            let mean = (integral_to(i as f64 + half) - integral_to(i as f64 - half)) / (2.0 * half);
            Some(column[i] - mean).filter(|d| d.is_finite())
        })
        .collect()
}

/// Largest |x − moving average over one period| in a window.
pub fn envelope(column: &[f64], sample_s: f64, period_s: f64, window: Window) -> Option<f64> {
    let range = window.indices(sample_s, column.len());
    if column[range.clone()].iter().any(|v| !v.is_finite()) {
        return None;
    }
    oscillating_part(column, sample_s, period_s)[range]
        .iter()
        .flatten()
        .map(|d| d.abs())
        .reduce(f64::max)
}

/// Natural frequency (rad/s) and damping ratio of a decaying or growing oscillation.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Oscillation {
    /// Natural frequency, rad/s.
    pub frequency_radps: f64,
    /// Damping ratio, negative where it grows.
    pub damping: f64,
}

/// Measures an oscillation of roughly `period_s` in a window: the frequency from its
/// zero crossings, the decay from a straight line through the logarithms of its
/// half-wave peaks (each by the parabola through its three highest samples).
///
/// `None` with fewer than four half-waves.
pub fn oscillation(
    column: &[f64],
    sample_s: f64,
    period_s: f64,
    window: Window,
) -> Option<Oscillation> {
    const HALF_WAVES: usize = 4;
    let part = oscillating_part(column, sample_s, period_s);
    let range = window.indices(sample_s, column.len());
    let first = range.start;
    let values: Vec<f64> = part[range].iter().copied().collect::<Option<_>>()?;
    let mut crossings = Vec::new();
    for (i, pair) in values.windows(2).enumerate() {
        if (pair[0] < 0.0) != (pair[1] < 0.0) {
            crossings.push((first + i) as f64 + pair[0] / (pair[0] - pair[1]));
        }
    }
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for ends in crossings.windows(2) {
        let (from, to) = (ends[0].ceil() as usize - first, ends[1] as usize - first);
        let highest = (from..=to.min(values.len() - 1))
            .max_by(|&a, &b| values[a].abs().total_cmp(&values[b].abs()))?;
        if highest == 0 || highest + 1 >= values.len() {
            continue;
        }
        let (before, top, after) =
            (values[highest - 1].abs(), values[highest].abs(), values[highest + 1].abs());
        let curvature = before - 2.0 * top + after;
        let rise =
            if curvature < 0.0 { -(before - after).powi(2) / (8.0 * curvature) } else { 0.0 };
        peaks.push((
            (ends[0] + ends[1]) / 2.0 * sample_s,
            libm::log((top + rise).max(f64::MIN_POSITIVE)),
        ));
    }
    if peaks.len() < HALF_WAVES {
        return None;
    }
    let damped_radps = std::f64::consts::PI * (crossings.len() - 1) as f64
        / ((crossings[crossings.len() - 1] - crossings[0]) * sample_s);
    let decay = -slope(&peaks);
    let frequency = libm::hypot(decay, damped_radps);
    Some(Oscillation { frequency_radps: frequency, damping: decay / frequency })
}

/// Slope of the least-squares line through points of at least two abscissae.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (cross, square) = points.iter().fold((0.0, 0.0), |(cross, square), p| {
        (cross + (p.0 - x) * (p.1 - y), square + (p.0 - x) * (p.0 - x))
    });
    cross / square
}

/// Longest unbroken time for which `condition` holds at the samples, s.
///
/// A single sample counts as one interval.
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
pub fn time_beyond_s(column: &[f64], sample_s: f64, level: f64) -> f64 {
    column.iter().filter(|v| v.abs() >= level).count() as f64 * sample_s
}

/// First instant at which |x| exceeds `level`, linear between the samples, s.
pub fn first_beyond_s(column: &[f64], sample_s: f64, level: f64) -> Option<f64> {
    let i = column.iter().position(|v| v.abs() > level)?;
    let Some(before) = i.checked_sub(1).map(|k| column[k].abs()) else { return Some(0.0) };
    let part = (level - before) / (column[i].abs() - before);
    Some((i as f64 - 1.0 + part) * sample_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_S: f64 = 0.01;

    fn sampled(f: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..=1200).map(|i| f(f64::from(i) * SAMPLE_S)).collect()
    }

    #[test]
    fn overshoot_of_the_second_order_step_is_the_textbook_one() {
        let (omega, zeta) = (2.0, 0.4_f64);
        let root = (1.0 - zeta * zeta).sqrt();
        let y = sampled(|t| {
            let phase = omega * root * t;
            -3.0 * (1.0 - (-zeta * omega * t).exp() * (phase.cos() + zeta / root * phase.sin()))
        });
        let expected = (-std::f64::consts::PI * zeta / root).exp();
        // The nearest sample is up to half an interval off the peak: the loss is at most
        // ½·ω²·(5 ms)²·exp(…) < 2e-5 of the step.
        assert!((overshoot(&y, -3.0).unwrap() - expected).abs() < 2e-5);
        assert_eq!(overshoot(&y, 0.0), None);
        assert_eq!(overshoot(&sampled(|_| 0.4), 1.0), Some(0.0));
        assert_eq!(overshoot(&[0.0, f64::NAN], 1.0), None);
    }

    #[test]
    fn a_parabola_leaves_no_residual_and_a_sine_its_double_amplitude() {
        let window = Window { from_s: 5.0, to_s: 10.0 };
        let parabola = |t: f64| 0.3 - 0.2 * t + 0.05 * t * t;
        // Values up to 3.3: some ten roundings of normal equations well conditioned on [−1, 1].
        let left = detrended_peak_to_peak(&sampled(parabola), SAMPLE_S, window).unwrap();
        assert!(left < 1e-12, "{left}");
        let sine = sampled(|t| parabola(t) + 0.01 * (10.0 * t).sin());
        let found = detrended_peak_to_peak(&sine, SAMPLE_S, window).unwrap();
        // The parabola takes up a part of n = 8 cycles: at the ends at most 3/(πn) of the
        // amplitude by its slope and 15/(πn)² by its curvature, 0.14 in all.
        assert!((found / 0.02 - 1.0).abs() < 0.14, "{found}");
        assert_eq!(
            detrended_peak_to_peak(&sine, SAMPLE_S, Window { from_s: 20.0, to_s: 30.0 }),
            None
        );
    }

    #[test]
    fn settling_is_the_last_entry_into_the_band() {
        let decay = sampled(|t| 1.0 + (-t).exp());
        // Linear interpolation of exp over h: error at most h²/8 in value, /0.1 in time.
        let found = settling_s(&decay, SAMPLE_S, 1.0, 0.1).unwrap();
        assert!((found - 10.0_f64.ln()).abs() < 2e-5, "{found}");
        assert_eq!(settling_s(&decay, SAMPLE_S, 2.0, 0.1), None);
        assert_eq!(settling_s(&decay, SAMPLE_S, 1.0, 5.0), Some(0.0));
    }

    #[test]
    fn the_envelope_of_a_decaying_mode_falls_with_its_damping() {
        let (omega, zeta) = (25.0, 0.02);
        let period = std::f64::consts::TAU / omega;
        let mode = sampled(|t| 0.3 + 0.1 * t + (-zeta * omega * t).exp() * (omega * t).cos());
        let at = |from_s, to_s| envelope(&mode, SAMPLE_S, period, Window { from_s, to_s }).unwrap();
        let ratio = at(5.0, 6.5) / at(1.0, 2.5);
        // A peak is missed by at most half a sample: 1 − cos(ω·5 ms) = 0.8 %, at either
        // end, and by the decay over one half period at most: 6 %, the same at both.
        let expected = (-zeta * omega * 4.0_f64).exp();
        assert!((ratio / expected - 1.0).abs() < 0.07, "{ratio} {expected}");

        let found =
            oscillation(&mode, SAMPLE_S, period, Window { from_s: 1.0, to_s: 6.0 }).unwrap();
        // Zero crossings and parabolic peaks at 25 samples a cycle are good to 1e-3 and
        // to about 1 % of the decay.
        assert!((found.frequency_radps / omega - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found.damping / zeta - 1.0).abs() < 0.02, "{found:?}");
        assert_eq!(oscillation(&mode, SAMPLE_S, period, Window { from_s: 1.0, to_s: 1.1 }), None);
    }

    #[test]
    fn runs_and_first_excesses_are_counted_in_samples() {
        let square = [0.0, 2.0, 2.0, 2.0, 0.0, -2.0, 0.0];
        assert_eq!(longest_run_s(7, 0.5, |i| square[i] > 1.0), 1.5);
        assert_eq!(time_beyond_s(&square, 0.5, 2.0), 2.0);
        assert_eq!(first_beyond_s(&square, 0.5, 1.0), Some(0.25));
        assert_eq!(first_beyond_s(&square, 0.5, 2.0), None);
    }
}
