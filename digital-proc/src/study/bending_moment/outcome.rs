//! How tables and figures show bending moments, kN·m.

use super::{BendingMoments, Met, Moments};
use desk::{
    outcome::Figure,
    report::{
        Cell, Heading,
        plot::{Axis, LineChart, Series, Size, line_chart},
    },
};
use vehicle::structure::{STATIONS_PER_M, TEN_STATIONS_M};

/// What the figures show.
pub const EXPLAINED: &str = "Moments are found beside the loop: incidence and forces of every sample load the vehicle as a beam (rods of mass, air on nose, body and fins, control forces, misalignment, relief by its own acceleration), and its first three free-free modes answer to them from rest (mode acceleration). Modes 2 and 3 have the shapes and frequency ratios of a uniform beam: estimates. Positive bends both ends up.";

/// What the greatest moments of a run come to in a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreatestMoment {
    /// With the modes.
    pub whole: Met,
    /// Without them.
    pub quasi_static: Met,
    /// With the modes, at the ten stations, N·m.
    pub at_ten_nm: [f64; 10],
}

impl<const N: usize> From<&BendingMoments<N>> for GreatestMoment {
    fn from(moments: &BendingMoments<N>) -> Self {
        GreatestMoment {
            whole: moments.whole.greatest,
            quasi_static: moments.quasi_static.greatest,
            at_ten_nm: TEN_STATIONS_M.map(|x| {
                // Beyond an end of the vehicle there is none.
                let mut near = moments.whole.at_stations();
                near.find(|met| (met.station_m - x).abs() * STATIONS_PER_M < 0.5)
                    .map_or(0.0, |met| met.moment_nm)
            }),
        }
    }
}

const KNM: &str = "kN·m";

/// Headings of [`GreatestMoment::cells`].
pub fn headings() -> Vec<Heading> {
    let greatest = [
        Heading::new("Greatest", KNM),
        Heading::new("at station", "m"),
        Heading::new("at", "s"),
        Heading::new("Quasi-static", KNM),
        Heading::new("its station", "m"),
        Heading::new("its time", "s"),
    ];
    let ten = TEN_STATIONS_M.iter().map(|x| Heading::new(format!("at {x} m"), KNM).digits(3));
    greatest.into_iter().chain(ten).collect()
}

impl GreatestMoment {
    /// A row's numbers.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        let met = |met: Met| [met.moment_nm / 1e3, met.station_m, met.time_s];
        let greatest = met(self.whole).into_iter().chain(met(self.quasi_static));
        greatest.chain(self.at_ten_nm.map(|m| m / 1e3)).map(Cell::Number)
    }
}

/// The greatest at each station over time.
pub fn envelope<const N: usize>(name: impl Into<String>, moments: &Moments<N>) -> Series {
    Series::of(name, moments.at_stations().map(|met| (met.station_m, met.moment_nm / 1e3)))
}

/// The greatest along the vehicle at each sample.
pub fn history<const N: usize>(name: impl Into<String>, moments: &Moments<N>) -> Series {
    Series::of(name, moments.over_time.iter().map(|(met, _)| (met.time_s, met.moment_nm / 1e3)))
}

/// Curves along the vehicle.
pub fn along(id: impl Into<String>, caption: impl Into<String>, curves: Vec<Series>) -> Figure {
    figure(id, caption, Axis::new("Station", "m"), curves)
}

/// Curves over time.
pub fn over(id: impl Into<String>, caption: impl Into<String>, curves: Vec<Series>) -> Figure {
    figure(id, caption, Axis::new("Time", "s"), curves)
}

fn figure(
    id: impl Into<String>,
    caption: impl Into<String>,
    x: Axis,
    curves: Vec<Series>,
) -> Figure {
    let chart = LineChart::new("", x, Axis::new("Bending moment", KNM), curves);
    Figure::new(id, caption, line_chart(&chart.size(Size::HALF)))
}
