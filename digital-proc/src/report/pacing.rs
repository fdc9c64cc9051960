//! How a flight kept to the wall clock: counts, latencies, and every overrun.

use crate::flight::pacing::{Late, Overrun, Pacing, quantile};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Column, Summary, Table,
        plot::{Axis, histogram},
    },
};
use interface::Tick;
use std::fmt::Write as _;

/// Overruns listed on the terminal; the table has all of them.
const LISTED_ON_TERMINAL: usize = 10;
/// Bins of the histogram: eight or more a decade over the usual five.
const BINS: usize = 40;
/// Columns of bars on the terminal.
const BAR: usize = 40;

fn microseconds(tick: Tick) -> f64 {
    tick.0 as f64 / 1e3
}

/// Adds pacing to the outcome of a flight.
pub fn tell(pacing: &Pacing, outcome: &mut Outcome) {
    add_results(pacing, &mut outcome.results);
    let values = pacing.latencies().iter().map(|t| microseconds(*t).max(1.0));
    let x = Axis::new("Latency from sample to transfer", "µs").log();
    let chart = histogram(&x, values, BINS);
    let caption = "How long updates took to come back, by the wall clock.";
    let section = outcome.section("Pacing by the wall clock");
    let section = section.words(bars(pacing)).figure(Figure::new("latency", caption, chart));
    let columns = [
        Column::new("Frame", "", |o: &Overrun| Cell::Number(o.frame as f64)).digits(17),
        Column::new("What was late", "", |o: &Overrun| match o.late {
            Late::Samples(_) => "samples".into(),
            Late::Updates(_) => "updates; without a time they came after the stop".into(),
        }),
        Column::new("Late by", "µs", |o: &Overrun| match o.late {
            Late::Samples(by) => Cell::Number(microseconds(by)),
            Late::Updates(by) => by.map(microseconds).into(),
        }),
    ];
    let overruns = Table::of(&columns, pacing.overruns());
    section.long_table("overruns", "Frames that overran.", overruns);
}

/// The same for a flight that was lost.
pub fn text(pacing: &Pacing) -> String {
    let mut results = Summary::new();
    add_results(pacing, &mut results);
    results.text() + &bars(pacing)
}

fn add_results(pacing: &Pacing, results: &mut Summary) {
    let (frames, overrun) = (pacing.frames(), pacing.frames_overrun());
    let percent = 100.0 * overrun as f64 / frames.max(1) as f64;
    let due = format!("{percent:.3} %: updates not in effect when the next samples were due");
    results.add("frames", "Frames", frames as f64, 17, "", "");
    results.add("frames_overrun", "Frames overrun", overrun as f64, 17, "", due);
    for (key, label, times) in [
        ("latency", "Sample to transfer", pacing.latencies()),
        ("samples_late", "Samples behind the clock", pacing.lateness()),
    ] {
        for (part, name, words) in [
            (0.5, "median", "median"),
            (0.99, "99_percent", "99 % within"),
            (1.0, "max", "at most"),
        ] {
            let value = quantile(times, part).map_or(f64::NAN, microseconds);
            results.add(
                &format!("{key}_{name}_us"),
                &format!("{label}, {words}"),
                value,
                4,
                "us",
                "",
            );
        }
    }
    let (margin, late) = pacing.jitter();
    let margin = format!("by more than {margin}, a tenth of a frame");
    let key = "samples_beyond_jitter_margin";
    results.add(key, "Samples behind the clock", late as f64, 17, "", margin);
}

/// A histogram of latencies by thirds of a decade, and the first overruns.
fn bars(pacing: &Pacing) -> String {
    let mut text = String::new();
    // Bin k holds latencies from 10^(k/3) to 10^((k+1)/3) µs; shorter ones are in the first.
    let mut counts = std::collections::BTreeMap::<i32, usize>::new();
    for latency in pacing.latencies() {
        let bin = (3.0 * libm::log10(microseconds(*latency).max(1.0))).floor() as i32;
        *counts.entry(bin).or_default() += 1;
    }
    let most = counts.values().copied().max().unwrap_or(1);
    let ends = counts.first_key_value().zip(counts.last_key_value()).map(|(a, b)| (*a.0, *b.0));
    for bin in ends.map_or(0..0, |(first, last)| first..last + 1) {
        let count = counts.get(&bin).copied().unwrap_or(0);
        let edge = |k: i32| libm::pow(10.0, f64::from(k) / 3.0);
        // A single frame shows too.
        let bar = "#".repeat((count * BAR).div_ceil(most));
        let line = format!("  {:>8.0} to {:>8.0} us {count:>7} {bar}", edge(bin), edge(bin + 1));
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let overruns = pacing.overruns();
    for overrun in overruns.iter().take(LISTED_ON_TERMINAL) {
        let _ = writeln!(text, "  overrun: {overrun}");
    }
    if let Some(more) = overruns.len().checked_sub(LISTED_ON_TERMINAL).filter(|n| *n > 0) {
        let _ = writeln!(text, "  and {more} more, all listed in overruns.csv");
    }
    text.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use interface::frame::{RunState, Samples, Transfer};

    #[test]
    fn overruns_and_latencies_are_told() {
        let mut pacing = Pacing::new(Tick(1_000_000));
        for frame in 0..40 {
            let mut samples =
                Samples::new(frame, Tick(1_000_000) * frame as i64, RunState::Operate);
            samples.late = Tick(1_200_000 * i64::from(frame % 2 == 1));
            if let Some(before) = frame.checked_sub(1) {
                let tick = Tick(1_000_000) * before as i64 + Tick(70_000);
                samples.transfers[0] = Transfer { frame: before, tick };
                samples.transfer_count = 1;
            }
            pacing.observe(&samples);
        }
        let mut outcome = Outcome::default();
        tell(&pacing, &mut outcome);
        let text = outcome.text().split_whitespace().collect::<Vec<_>>().join(" ");
        for word in [
            "50.000 %",
            "median 70.00 us",
            "20 by more than 100us",
            "frame 1: samples 1200us late",
            "and 10 more",
        ] {
            assert!(text.contains(word), "{word}\n{text}");
        }
        let json = outcome.json("", None, None);
        assert_eq!(json["tables"]["overruns"].as_array().unwrap().len(), 20);
        assert_eq!(json["results"]["frames_overrun"], 20.0);
    }
}
