//! How often each value came: latencies, overruns, dispersions.

use maud::{Markup, html};

use super::axis::Axis;
use super::chart::Size;
use super::frame::frame;
use super::pen::Px;

/// The histogram of those of `values` that are finite, in 1 to 200 bins: on a logarithmic axis they
/// have equal ratios. Counts stand on a logarithmic scale, to show rare long waits.
pub fn histogram(x: &Axis, values: impl Iterator<Item = f64>, bins: usize) -> Markup {
    let mapped: Vec<f64> = values.filter_map(|v| x.map(v)).collect();
    let x = x.fit(mapped.iter().copied(), 8, 0.0);
    let bins = bins.clamp(1, 200);
    let mut counts = vec![0_u64; bins];
    for value in &mapped {
        let share = (value - x.low) / (x.high - x.low);
        // The upper end belongs to the last bin; values outside a given range to none.
        if (0.0..=1.0).contains(&share) {
            counts[((share * bins as f64) as usize).min(bins - 1)] += 1;
        }
    }
    let highest = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    // Half a count is the foot of a bar, so that one count shows.
    let counting = Axis::new("Count", "").log().range(0.5, highest * 1.5);
    let y = counting.fit(std::iter::empty(), 6, 0.0);
    let width = (x.high - x.low) / bins as f64;
    frame("", Size::FULL, (&x, &y), &[], |area| {
        html! {
            @for (bin, &count) in counts.iter().enumerate() {
                @if let Some(height) = counting.map(count as f64).filter(|_| count > 0) {
                    @let (from, top) = area.at(x.low + width * bin as f64, height);
                    @let (to, foot) = area.at(x.low + width * (bin + 1) as f64, y.low);
                    // A hair of air between bars keeps them apart in print.
                    rect.b0 x=(Px(from + 0.4)) y=(Px(top)) width=(Px(to - from - 0.8)) height=(Px(foot - top)) {}
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_filled_bin_has_a_bar() {
        let svg = histogram(&Axis::new("Latency", "µs"), [0.0, 0.1, 5.0, 10.0].into_iter(), 10)
            .into_string();
        assert_eq!(svg.matches("class=\"b0\"").count(), 3);
    }
}
