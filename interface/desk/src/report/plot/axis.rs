//! An axis: what it is labelled, how far it reaches, where its ticks stand.

use super::super::format::superscript;
use super::drawable;

/// How an axis maps values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Equal steps for equal ratios; values that are not positive leave gaps.
    Log,
}

/// What the caller says of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity, in words.
    pub label: String,
    /// Its unit; empty when dimensionless.
    pub unit: String,
    pub scale: Scale,
    /// Lower and upper end; found from the data when absent or not usable.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis that fits its data.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Axis {
        Axis { label: label.into(), unit: unit.into(), scale: Scale::Linear, range: None }
    }

    pub fn log(mut self) -> Axis {
        self.scale = Scale::Log;
        self
    }

    /// The same, from `low` to `high` whatever the data.
    pub fn range(mut self, low: f64, high: f64) -> Axis {
        self.range = Some((low, high));
        self
    }

    /// A value in the coordinate that is drawn linearly; `None` leaves a gap.
    pub(super) fn map(&self, value: f64) -> Option<f64> {
        let value = drawable(value)?;
        match self.scale {
            Scale::Linear => Some(value),
            Scale::Log => (value >= 1e-150).then(|| libm::log10(value)),
        }
    }

    /// Settles range and ticks for mapped data; `about` is the number of ticks aimed at and
    /// `pad` the share of the span left free at each end.
    pub(super) fn fit(
        &self,
        mapped: impl Iterator<Item = f64>,
        about: usize,
        pad: f64,
    ) -> FittedAxis {
        let given = self
            .range
            .and_then(|(low, high)| self.map(low).zip(self.map(high)))
            .filter(|(low, high)| high - low > shortest_span(*low, *high));
        let (low, high) = given.unwrap_or_else(|| {
            let (low, high) = mapped.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            let empty = low > high;
            let (low, high) = if empty { (0.0, 1.0) } else { (low, high) };
            let size = low.abs().max(high.abs());
            if high - low <= shortest_span(low, high) {
                let half = match self.scale {
                    Scale::Log => 0.5,
                    Scale::Linear if size < 1e-140 => 1.0,
                    Scale::Linear => size * 0.1,
                };
                return (low - half, high + half);
            }
            let room = (high - low) * pad;
            if self.scale == Scale::Linear && pad > 0.0 {
                // A scale that nearly reaches zero is honest only if it shows zero.
                if low >= 0.0 && low <= 0.3 * high {
                    return (0.0, high + room);
                }
                if high <= 0.0 && high >= 0.3 * low {
                    return (low - room, 0.0);
                }
            }
            (low - room, high + room)
        });
        match self.scale {
            Scale::Linear => self.linear(low, high, about),
            Scale::Log => self.logarithmic(low, high, about),
        }
    }

    fn linear(&self, low: f64, high: f64, about: usize) -> FittedAxis {
        let step = nice_step((high - low) / about.max(2) as f64);
        // Room for rounding: an end that is a tick up to 1e-9 of a step counts as one.
        let first = (low / step - 1e-9).ceil();
        let count = ((high / step + 1e-9).floor() - first).clamp(0.0, 50.0) as usize;
        let ticks: Vec<f64> = (0..=count).map(|n| (first + n as f64) * step).collect();
        let largest = low.abs().max(high.abs());
        let exponent = if (1e-2..1e5).contains(&largest) {
            0
        } else {
            3 * (libm::log10(largest) / 3.0).floor() as i32
        };
        let unit_step = step / 10f64.powi(exponent);
        let decimals = (-(libm::log10(unit_step) + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        let labels = ticks
            .iter()
            .map(|tick| {
                let text = format!("{:.decimals$}", tick / 10f64.powi(exponent) + 0.0);
                // A tick at zero may carry the sign of a rounding.
                if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
                    text.trim_start_matches('-').to_owned()
                } else {
                    text.replace('-', "−")
                }
            })
            .collect();
        let title = self.title(exponent);
        FittedAxis {
            low,
            high,
            ticks,
            labels,
            minor: Vec::new(),
            title,
            scale: self.scale,
            exponent,
        }
    }

    fn logarithmic(&self, low: f64, high: f64, about: usize) -> FittedAxis {
        let stride = ((high - low) / about.max(2) as f64).ceil().max(1.0) as i32;
        let decades = (low - 1e-9).floor() as i32..=(high + 1e-9).ceil() as i32;
        let inside = |v: &f64| *v >= low - 1e-9 && *v <= high + 1e-9;
        let (mut ticks, mut labels, mut minor) = (Vec::new(), Vec::new(), Vec::new());
        // Below two decades the steps 2 and 5 are labelled; below a third of one, tenths.
        let between: &[f64] = match high - low {
            span if span < 0.35 => {
                &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
            }
            span if span < 2.05 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        for decade in decades {
            if stride == 1 {
                for factor in between {
                    let at = f64::from(decade) + libm::log10(*factor);
                    if inside(&at) {
                        ticks.push(at);
                        labels.push(decade_label(decade, *factor));
                    }
                }
                for factor in 2..10 {
                    let at = f64::from(decade) + libm::log10(f64::from(factor));
                    if inside(&at) {
                        minor.push(at);
                    }
                }
            } else if decade.rem_euclid(stride) == 0 && inside(&f64::from(decade)) {
                ticks.push(f64::from(decade));
                labels.push(decade_label(decade, 1.0));
            }
        }
        let title = self.title(0);
        FittedAxis { low, high, ticks, labels, minor, title, scale: self.scale, exponent: 0 }
    }

    /// `Altitude (km)`; a common power of ten of the labels goes with the unit.
    fn title(&self, exponent: i32) -> String {
        let unit = match (exponent, self.unit.as_str()) {
            (0, "") => return self.label.clone(),
            (0, unit) => unit.to_owned(),
            (e, unit) => format!("10{} {unit}", superscript(e)).trim_end().to_owned(),
        };
        if self.label.is_empty() { unit } else { format!("{} ({unit})", self.label) }
    }
}

/// An axis with its range and ticks settled, in mapped coordinates.
pub(super) struct FittedAxis {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) ticks: Vec<f64>,
    pub(super) labels: Vec<String>,
    pub(super) minor: Vec<f64>,
    pub(super) title: String,
    scale: Scale,
    /// The power of ten that stands with the unit.
    exponent: i32,
}

impl FittedAxis {
    /// How far along the axis a mapped value stands, 0 at the lower end and 1 at the upper; what
    /// is far outside comes no farther than a browser can draw.
    pub(super) fn share(&self, mapped: f64) -> f64 {
        ((mapped - self.low) / (self.high - self.low)).clamp(-300.0, 300.0)
    }

    /// Lower and upper end for the page's script, in the labels' unit or, after `log`, as
    /// logarithms.
    pub(super) fn ends(&self) -> String {
        let unit = libm::pow(10.0, f64::from(self.exponent));
        let scale = if self.scale == Scale::Log { "log " } else { "" };
        format!("{scale}{:e} {:e}", self.low / unit, self.high / unit)
    }

    /// The longest label, in characters.
    pub(super) fn widest(&self) -> usize {
        self.labels.iter().map(|label| label.chars().count()).max().unwrap_or(1)
    }
}

/// The least of 1, 2, 5 times a power of ten that is not below `raw`.
fn nice_step(raw: f64) -> f64 {
    let power = libm::pow(10.0, libm::log10(raw).floor());
    let factor = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|factor| factor * power >= raw * (1.0 - 1e-9))
        .unwrap_or(10.0);
    factor * power
}

/// A shorter span shows nothing but rounding: ten decimal digits below the values.
fn shortest_span(low: f64, high: f64) -> f64 {
    (low.abs().max(high.abs()) * 1e-10).max(1e-140)
}

fn decade_label(decade: i32, factor: f64) -> String {
    if (-3..=4).contains(&decade) {
        let decimals = (-decade).max(0) as usize + usize::from(factor.fract() != 0.0);
        let decimals = decimals.saturating_sub(usize::from(factor.fract() != 0.0 && decade > 0));
        format!("{:.decimals$}", factor * 10f64.powi(decade))
    } else if factor == 1.0 {
        format!("10{}", superscript(decade))
    } else {
        format!("{factor}·10{}", superscript(decade))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let axis = Axis::new("Time", "s").fit([0.0, 49.0].into_iter(), 8, 0.0);
        assert_eq!(axis.labels, ["0", "10", "20", "30", "40"]);
        assert_eq!(axis.title, "Time (s)");
        let axis = Axis::new("Q", "Pa").fit([0.0, 95_000_000.0].into_iter(), 6, 0.0);
        assert_eq!(axis.labels, ["0", "20", "40", "60", "80"]);
        assert_eq!(axis.title, "Q (10⁶ Pa)");
        assert_eq!(axis.ends(), "0e0 9.5e1");
        let axis = Axis::new("Error", "").log().fit([-6.0, -1.0].into_iter(), 6, 0.0);
        assert_eq!(axis.labels, ["10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1"]);
        assert_eq!(axis.ends(), "log -6e0 -1e0");
    }

    proptest! {
        #[test]
        fn any_range_gives_few_increasing_ticks(low: f64, high: f64, log: bool, fixed: bool) {
            let axis = if log { Axis::new("x", "").log() } else { Axis::new("x", "") };
            let axis = if fixed { axis.range(low, high) } else { axis };
            let fitted = axis.fit([low, high].into_iter().filter_map(|v| axis.map(v)), 7, 0.04);
            prop_assert!(fitted.low < fitted.high);
            prop_assert!((fitted.high - fitted.low).is_finite());
            prop_assert!(fitted.ticks.len() <= 51 && fitted.ticks.len() == fitted.labels.len());
            prop_assert!(fitted.ticks.windows(2).all(|pair| pair[0] < pair[1]));
            if let (false, [first, second, ..]) = (log, &fitted.ticks[..]) {
                let step = format!("{:.6e}", second - first);
                prop_assert!(["1.0", "2.0", "5.0"].iter().any(|nice| step.starts_with(nice)), "{step}");
            }
        }
    }
}
