//! One series on its way to the page: mapped, cut at gaps, thinned.

use maud::{Markup, html};

use super::chart::{Draw, LineChart, Series};
use super::decimate;
use super::frame::Area;
use super::pen::{Point, markers, polyline};

/// A series, its points mapped by the axes, cut at its gaps.
pub(super) struct Curve {
    pub(super) runs: Vec<Vec<Point>>,
    draw: Draw,
    pub(super) style: usize,
    ascending: bool,
}

impl Curve {
    pub(super) fn new(chart: &LineChart, series: &Series, style: usize) -> Curve {
        let mut runs = vec![Vec::new()];
        for (&x, &y) in series.x.iter().zip(&series.y) {
            match chart.x.map(x).zip(chart.y.map(y)) {
                Some(point) => {
                    if let Some(run) = runs.last_mut() {
                        run.push(point);
                    }
                }
                None => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        let ascending = runs.iter().flatten().is_sorted_by(|a, b| a.0 <= b.0);
        Curve { runs, draw: series.draw, style, ascending }
    }

    /// A line a run, and all markers.
    pub(super) fn draw(&self, area: &Area<'_>) -> Markup {
        let runs: Vec<Vec<Point>> = self.runs.iter().map(|run| self.thinned(run, area)).collect();
        html! {
            @if self.draw.line() {
                @for run in &runs { (polyline(&format!("l{}", self.style), &self.corners(run))) }
            }
            @if self.draw.marker() {
                (markers(self.style, &runs.concat()))
            }
        }
    }

    /// As many points of a run as a figure can show, where they stand.
    fn thinned(&self, run: &[Point], area: &Area<'_>) -> Vec<Point> {
        let at = |&(x, y): &Point| area.at(x, y);
        if self.ascending {
            let heights: Vec<f64> = run.iter().map(|point| point.1).collect();
            return decimate::extremes(&heights).into_iter().map(|i| at(&run[i])).collect();
        }
        decimate::spaced(&run.iter().map(at).collect::<Vec<_>>(), 0.5)
    }

    /// What a line through a run passes.
    fn corners(&self, run: &[Point]) -> Vec<Point> {
        match run {
            // A lone point between gaps would leave no trace as a line.
            &[(x, y)] => vec![(x - 1.0, y), (x + 1.0, y)],
            [first, ..] if self.draw == Draw::Step => {
                let stairs = run.windows(2).flat_map(|pair| [(pair[1].0, pair[0].1), pair[1]]);
                std::iter::once(*first).chain(stairs).collect()
            }
            _ => run.to_vec(),
        }
    }
}
