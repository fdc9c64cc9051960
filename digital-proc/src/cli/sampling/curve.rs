//! Curves of theory, and how near to them a measured root must lie.

/// Points of a curve.
pub const POINTS: u32 = 60;
/// Measured and exact damping may differ by this; frequencies, relative.
pub const ROOT_LIMIT: f64 = 1e-4;

/// `count` values from `low` to `high` in equal ratios.
pub fn ratios(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let last = f64::from(count.max(2) - 1);
    (0..count.max(2)).map(move |i| low * libm::pow(high / low, f64::from(i) / last))
}

/// First and last, or the one.
pub fn ends(values: &[f64]) -> Vec<f64> {
    match values {
        [] => Vec::new(),
        [one] => vec![*one],
        [first, .., last] => vec![*first, *last],
    }
}
