//! One series on its way to the page: mapped, cut at gaps, thinned, clipped.

use super::canvas::{Canvas, Role};
use super::decimate;
use super::line_chart::{Draw, LineChart, Series};

/// A series in mapped coordinates, cut at its gaps.
pub(super) struct Curve {
    pub(super) runs: Vec<Vec<(f64, f64)>>,
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

    pub(super) fn draw(&self, canvas: &Canvas<'_>) {
        let mut markers = Vec::new();
        for run in &self.runs {
            let mut points: Vec<(i32, i32)> = if self.ascending {
                let heights: Vec<f64> = run.iter().map(|point| point.1).collect();
                decimate::extremes(&heights)
                    .into_iter()
                    .map(|i| canvas.at(run[i].0, run[i].1))
                    .collect()
            } else {
                let all: Vec<(i32, i32)> = run.iter().map(|p| canvas.at(p.0, p.1)).collect();
                decimate::spaced(&all, 5).into_iter().map(|i| all[i]).collect()
            };
            if matches!(self.draw, Draw::Markers | Draw::LineAndMarkers) {
                markers.extend_from_slice(&points);
            }
            if self.draw == Draw::Step {
                points = held(&points);
            }
            if self.draw != Draw::Markers {
                if let [only] = points[..] {
                    // A lone point between gaps would leave no trace as a line.
                    points = vec![(only.0 - 10, only.1), (only.0 + 10, only.1)];
                }
                for piece in clipped(&points, canvas.area) {
                    canvas.path(piece, Role::Line(self.style));
                }
            }
        }
        let (left, top, right, bottom) = canvas.area;
        for (x, y) in markers {
            if (left..=right).contains(&x) && (top..=bottom).contains(&y) {
                canvas.marker((x, y), self.style);
            }
        }
    }
}

/// The corners of a staircase through `points`.
fn held(points: &[(i32, i32)]) -> Vec<(i32, i32)> {
    let mut corners = Vec::with_capacity(points.len() * 2);
    for (i, &(x, y)) in points.iter().enumerate() {
        if i > 0 {
            corners.push((x, points[i - 1].1));
        }
        corners.push((x, y));
    }
    corners
}

/// The parts of a path inside the area, cut where it crosses the border.
fn clipped(points: &[(i32, i32)], area: (i32, i32, i32, i32)) -> Vec<Vec<(i32, i32)>> {
    let (left, top, right, bottom) = area;
    let inside = |&(x, y): &(i32, i32)| (left..=right).contains(&x) && (top..=bottom).contains(&y);
    if points.iter().all(inside) {
        return vec![points.to_vec()];
    }
    let mut pieces: Vec<Vec<(i32, i32)>> = Vec::new();
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
        // The share of the segment between each pair of parallel borders.
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (start, delta, low, high) in [(from.0, dx, left, right), (from.1, dy, top, bottom)] {
            let (low, high) = (f64::from(low - start), f64::from(high - start));
            if delta == 0.0 {
                if low > 0.0 || high < 0.0 {
                    leave = -1.0;
                }
            } else {
                let (a, b) = (low / delta, high / delta);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        if enter > leave {
            continue;
        }
        let at = |share: f64| {
            (from.0 + (dx * share).round() as i32, from.1 + (dy * share).round() as i32)
        };
        let (start, end) = (at(enter), at(leave));
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&start) => piece.push(end),
            _ => pieces.push(vec![start, end]),
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_cut_at_the_border() {
        let path = [(0, 50), (200, 50), (200, 80), (50, 80)];
        assert_eq!(
            clipped(&path, (10, 0, 100, 100)),
            [vec![(10, 50), (100, 50)], vec![(100, 80), (50, 80)]]
        );
    }
}
