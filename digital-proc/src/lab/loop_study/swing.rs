//! A swing that goes on: limit cycle, undamped loop or periodic input, by amplitude and period.
//!
//! Looks at the second half of a record alone; whether what came before was a decay is not its
//! business.

/// A sustained swing about a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// Half of peak to peak, in the units of the record.
    pub amplitude: f64,
    /// Mean period, s.
    pub period_s: f64,
}

/// Upward crossings that are three whole periods apart.
const CROSSINGS: usize = 4;
/// Band about the mean, as a share of the amplitude, that must be left before a crossing counts.
const BAND: f64 = 0.25;
/// Amplitudes of the two halves, and periods, may differ by this share. A swing of 10 samples a
/// period has its peaks cut by up to 5 % where no sample meets them.
const ALIKE: f64 = 0.05;
/// Amplitudes below this share of the record's own range are rounding.
const ROUNDING: f64 = 1e-6;

impl Swing {
    /// The swing at the end of `record`, if it neither dies nor grows there.
    pub(super) fn of(record: &[f64], period_s: f64) -> Option<Swing> {
        let tail = &record[record.len() / 2..];
        let (low, high) = range(tail);
        let amplitude = (high - low) / 2.0;
        let (least, greatest) = range(record);
        if amplitude <= ROUNDING * (greatest - least) {
            return None;
        }
        let up = crossings(tail, (high + low) / 2.0, BAND * amplitude);
        if up.len() < CROSSINGS {
            return None;
        }
        let (first, last) = (up[0], up[up.len() - 1]);
        let mean = (last - first) as f64 / (up.len() - 1) as f64;
        // An instant is known to a frame.
        let regular = |w: &[usize]| ((w[1] - w[0]) as f64 - mean).abs() <= ALIKE * mean + 1.0;
        let middle = up[up.len() / 2];
        let half = |part: &[f64]| {
            let (low, high) = range(part);
            (high - low) / 2.0
        };
        let (before, after) = (half(&tail[first..=middle]), half(&tail[middle..=last]));
        let alike = (before - after).abs() <= ALIKE * amplitude;
        (alike && up.windows(2).all(regular))
            .then_some(Swing { amplitude, period_s: mean * period_s })
    }
}

fn range(part: &[f64]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    part.iter().fold(start, |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Samples at which the record comes from below the band about `mean` to above it.
fn crossings(part: &[f64], mean: f64, band: f64) -> Vec<usize> {
    let mut up = Vec::new();
    let mut below = false;
    for (n, v) in part.iter().enumerate() {
        if *v < mean - band {
            below = true;
        } else if below && *v > mean + band {
            below = false;
            up.push(n);
        }
    }
    up
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 600 frames of 10 ms of a wave of 0.5 s with the given growth a frame.
    fn wave(growth: f64) -> Vec<f64> {
        (0..600)
            .map(|n| {
                let n = f64::from(n);
                (growth * n).exp() * (std::f64::consts::TAU * n / 50.0).sin() + 3.0
            })
            .collect()
    }

    #[test]
    fn a_swing_that_goes_on_is_measured_and_a_decay_is_none() {
        let swing = Swing::of(&wave(0.0), 0.01).unwrap();
        // 50 samples a period: a peak is missed by at most 1 - cos(pi/50) = 0.2 %.
        assert!((swing.amplitude - 1.0).abs() < 2e-3, "{swing:?}");
        assert!((swing.period_s - 0.5).abs() < 1e-12, "{swing:?}");
        // One in a thousand a frame is 5 % a period.
        assert_eq!(Swing::of(&wave(-1e-3), 0.01), None);
        assert_eq!(Swing::of(&wave(1e-3), 0.01), None);
        assert_eq!(Swing::of(&[0.0; 90], 0.01), None);
        let settled: Vec<f64> = (0..600).map(|n| (-0.1 * f64::from(n)).exp()).collect();
        assert_eq!(Swing::of(&settled, 0.01), None);
    }
}
