//! Fewer points for the same picture.
//!
//! A figure some seven hundred pixels wide shows no more than the extremes of each of its
//! pixel columns. Points are dropped only where the picture cannot show them; the extremes
//! of every column stay, so that no spike is lost.

use super::pen::Point;

/// Buckets over a series; each keeps first, lowest, highest and last.
const BUCKETS: usize = 200;

/// Indices of the points of `y` to draw, in order, at most `4 · BUCKETS` of them.
pub(super) fn extremes(y: &[f64]) -> Vec<usize> {
    if y.len() <= 4 * BUCKETS {
        return (0..y.len()).collect();
    }
    let mut kept = Vec::with_capacity(4 * BUCKETS);
    for bucket in 0..BUCKETS {
        let (start, end) = (bucket * y.len() / BUCKETS, (bucket + 1) * y.len() / BUCKETS);
        let (mut low, mut high) = (start, start);
        for i in start..end {
            if y[i] < y[low] {
                low = i;
            }
            if y[i] > y[high] {
                high = i;
            }
        }
        let mut four = [start, low, high, end - 1];
        four.sort_unstable();
        for i in four {
            if kept.last() != Some(&i) {
                kept.push(i);
            }
        }
    }
    kept
}

/// For curves that turn back (a phase plane): points at least `tolerance` pixels apart, which is
/// doubled until at most 4000 remain.
pub(super) fn spaced(points: &[Point], mut tolerance: f64) -> Vec<Point> {
    loop {
        let mut kept: Vec<Point> = Vec::new();
        for (i, &(x, y)) in points.iter().enumerate() {
            let far = |last: &Point| (x - last.0).abs().max((y - last.1).abs()) >= tolerance;
            if kept.last().is_none_or(far) || i + 1 == points.len() {
                kept.push((x, y));
            }
        }
        if kept.len() <= 4_000 {
            return kept;
        }
        tolerance *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_spike_survives() {
        let mut y: Vec<f64> = (0..50_000).map(|n| (f64::from(n) * 1e-3).sin()).collect();
        y[31_337] = 9.0;
        y[7] = -9.0;
        let kept = extremes(&y);
        assert!(kept.contains(&31_337) && kept.contains(&7));
        assert!(kept.len() <= 800 && kept.windows(2).all(|w| w[0] < w[1]));
        assert_eq!((kept[0], kept[kept.len() - 1]), (0, 49_999));
    }

    #[test]
    fn a_long_spiral_is_thinned() {
        let points: Vec<Point> = (0..100_000)
            .map(|n| {
                let a = f64::from(n) * 0.01;
                (a.cos() * 300.0, a.sin() * 300.0)
            })
            .collect();
        let kept = spaced(&points, 0.5);
        assert!(kept.len() <= 4_000 && kept.len() > 500);
        assert_eq!((kept[0], kept.last()), (points[0], points.last()));
    }
}
