//! How a flight kept to the wall clock: counts, latencies, and every overrun.

use crate::flight::pacing::{Late, Pacing, quantile};
use desk::report::plot::{Axis, Histogram, Size, histogram};
use desk::report::{Heading, Table};
use desk::report::{Numbering, Section};
use interface::Tick;
use maud::html;
use std::fmt::Write as _;

/// Overruns listed on the terminal; the summary has all of them.
const LISTED_ON_TERMINAL: usize = 10;
/// Overruns listed on a page.
const LISTED_ON_PAGE: usize = 1_000;
/// Bins of the histogram: eight or more a decade over the usual five.
const BINS: usize = 40;
/// Columns of bars on the terminal.
const BAR: usize = 40;

fn microseconds(tick: Tick) -> f64 {
    tick.0 as f64 / 1e3
}

/// The frames overrun, in words.
fn counted(pacing: &Pacing) -> String {
    let (frames, overrun) = (pacing.frames(), pacing.frames_overrun());
    let percent = 100.0 * overrun as f64 / frames.max(1) as f64;
    format!(
        "{overrun} of {frames} frames overran ({percent:.3} %): updates not in effect when the next samples were due"
    )
}

/// Median, 99 % and maximum of these times, in words.
fn quantiles(times: &[Tick]) -> String {
    let of = |part| quantile(times, part).map_or(0.0, microseconds);
    format!("median {:.0} us, 99 % within {:.0} us, at most {:.0} us", of(0.5), of(0.99), of(1.0))
}

/// How long updates took.
fn latencies(pacing: &Pacing) -> String {
    let times = quantiles(pacing.latencies());
    format!("latency from sample to transfer: {times}")
}

/// How late samples went out.
fn jitter(pacing: &Pacing) -> String {
    let (margin, late) = pacing.jitter();
    let times = quantiles(pacing.lateness());
    format!("samples behind the clock: {times}; {late} by more than {margin}, a tenth of a frame")
}

/// For a terminal: counts, a histogram by thirds of a decade, the first overruns.
pub fn pacing_text(pacing: &Pacing) -> String {
    let mut text = format!("{}\n{}\n{}\n", counted(pacing), jitter(pacing), latencies(pacing));
    // Bin k holds latencies from 10^(k/3) to 10^((k+1)/3) µs; shorter ones are in the first.
    let mut counts = std::collections::BTreeMap::<i32, usize>::new();
    for latency in pacing.latencies() {
        let bin = (3.0 * libm::log10(microseconds(*latency).max(1.0))).floor() as i32;
        *counts.entry(bin).or_default() += 1;
    }
    let most = counts.values().copied().max().unwrap_or(1);
    if let (Some((&first, _)), Some((&last, _))) =
        (counts.first_key_value(), counts.last_key_value())
    {
        for bin in first..=last {
            let count = counts.get(&bin).copied().unwrap_or(0);
            let edge = |k: i32| libm::pow(10.0, f64::from(k) / 3.0);
            // A single frame shows too.
            let bar = "#".repeat((count * BAR).div_ceil(most));
            // Writing to a String cannot fail.
            let line =
                format!("  {:>8.0} to {:>8.0} us {count:>7} {bar}", edge(bin), edge(bin + 1));
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }
    let overruns = pacing.overruns();
    for overrun in overruns.iter().take(LISTED_ON_TERMINAL) {
        let _ = writeln!(text, "  overrun: {overrun}");
    }
    if overruns.len() > LISTED_ON_TERMINAL {
        let more = overruns.len() - LISTED_ON_TERMINAL;
        let _ = writeln!(text, "  and {more} more, all listed in summary.json");
    }
    text
}

/// The same as a section of a page.
pub fn pacing_section(pacing: &Pacing) -> Section {
    let mut numbering = Numbering::new();
    let values = pacing.latencies().iter().map(|t| microseconds(*t).max(1.0));
    let chart = histogram(&Histogram {
        title: String::new(),
        x: Axis::new("Latency from sample to transfer", "µs").log(),
        values: values.collect(),
        bins: BINS,
        log_counts: true,
        size: Size::FULL,
    });
    let figure = numbering.figure(
        "latency",
        "How long updates took to come back, by the wall clock.",
        chart,
    );
    let mut table = Table::new(vec![
        Heading::new("Frame", ""),
        Heading::new("What was late", ""),
        Heading::new("By", "µs"),
    ]);
    for overrun in pacing.overruns().iter().take(LISTED_ON_PAGE) {
        let (what, by) = match overrun.late {
            Late::Samples(by) => ("samples", Some(by)),
            Late::Updates(by) => ("updates", by),
        };
        let by = by.map_or("not there before the stop".to_owned(), |by| {
            format!("{:.0}", microseconds(by))
        });
        table.row([overrun.frame.to_string().as_str().into(), what.into(), by.as_str().into()]);
    }
    let more = pacing.overruns().len().saturating_sub(LISTED_ON_PAGE);
    Section::new(
        "Pacing by the wall clock",
        html! {
            p { (counted(pacing)) "; " (latencies(pacing)) "; " (jitter(pacing)) "." }
            (figure)
            @if pacing.overruns().is_empty() {
                p { "No frame overran." }
            } @else {
                (table.markup())
            }
            @if more > 0 { p { (more) " more are listed in summary.json." } }
        },
    )
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
        let text = pacing_text(&pacing);
        for word in [
            "20 of 40 frames overran (50.000 %)",
            "median 70 us",
            "20 by more than 100us",
            "frame 1: samples 1200us late",
            "and 10 more",
        ] {
            assert!(text.contains(word), "{word}\n{text}");
        }
        let page = pacing_section(&pacing).body.into_string();
        assert_eq!(page.matches("samples</td>").count(), 20, "{page}");
        assert!(page.contains("<svg"));
    }
}
