//! How often each value came: latencies, overruns, dispersions.

use maud::{Markup, html};

use super::axis::{Axis, Scale};
use super::chart::Size;
use super::frame::frame;
use super::pen::Px;

/// What a histogram shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Heading inside the figure.
    pub title: String,
    /// The quantity; on a logarithmic axis the bins have equal ratios.
    pub x: Axis,
    /// The sample; values that are not finite are left out.
    pub values: Vec<f64>,
    /// Number of bins, 1 to 200.
    pub bins: usize,
    /// Counts on a logarithmic scale, to show rare long waits.
    pub log_counts: bool,
    /// Size.
    pub size: Size,
}

/// The histogram as SVG.
pub fn histogram(spec: &Histogram) -> Markup {
    let mapped: Vec<f64> = spec.values.iter().filter_map(|&v| spec.x.map(v)).collect();
    let x = spec.x.fit(mapped.iter().copied(), 8, 0.0);
    let bins = spec.bins.clamp(1, 200);
    let mut counts = vec![0_u64; bins];
    for value in &mapped {
        let share = (value - x.low) / (x.high - x.low);
        // The upper end belongs to the last bin; values outside a given range to none.
        if (0.0..=1.0).contains(&share) {
            counts[((share * bins as f64) as usize).min(bins - 1)] += 1;
        }
    }
    let highest = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let counting = Axis {
        scale: if spec.log_counts { Scale::Log } else { Scale::Linear },
        // Half a count is the foot of a logarithmic bar, so that one count shows.
        range: Some(if spec.log_counts { (0.5, highest * 1.5) } else { (0.0, highest * 1.05) }),
        ..Axis::new("Count", "")
    };
    let y = counting.fit(std::iter::empty(), 6, 0.0);
    let width = (x.high - x.low) / bins as f64;
    frame(&spec.title, spec.size, (&x, &y), &[], 0.0, |area| {
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
        let svg = histogram(&Histogram {
            title: "h".to_owned(),
            x: Axis::new("Latency", "µs"),
            values: vec![0.0, 0.1, 5.0, 10.0],
            bins: 10,
            log_counts: false,
            size: Size::HALF,
        });
        assert_eq!(svg.into_string().matches("class=\"b0\"").count(), 3);
    }
}
