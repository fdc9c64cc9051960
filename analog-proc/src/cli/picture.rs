//! The page of a run: time histories, phase planes, extremes.

use super::find_net;
use crate::order::Ordered;
use desk::{
    failure::Failure,
    outcome::Outcome,
    report::{
        Column, Table,
        plot::{Axis, LineChart, Series},
    },
    run_dir::thin::Rows,
};
use interface::Tick;
use serde::{Deserialize, Serialize};

/// Rows kept of a run, however long: more than a picture has pixels.
const MOST_ROWS: usize = 40_000;

/// What is drawn of a run, and its rows so far.
#[derive(Clone, Serialize, Deserialize)]
pub struct Picture {
    /// Names of the nets whose values come, in that order.
    names: Vec<String>,
    plot: Vec<usize>,
    xy: Vec<(usize, usize)>,
    rows: Rows,
    extremes: Vec<Extremes>,
}

/// Least and greatest value of a net, and when.
#[derive(Clone, Serialize, Deserialize)]
struct Extremes {
    name: String,
    full_scale: Option<f64>,
    least: (f64, f64),
    greatest: (f64, f64),
    last: f64,
}

impl Picture {
    /// Of the nets `plot` over time and of the pairs `xy`, written `x:y`; all of the `recorded`
    /// ones over time where neither is asked for. Adds to `recorded` what it draws besides.
    pub fn new(
        ordered: &Ordered,
        recorded: &mut Vec<String>,
        plot: &[String],
        xy: &[String],
    ) -> Result<Picture, Failure> {
        let mut place = |name: &str| -> Result<usize, Failure> {
            find_net(ordered, name)?;
            Ok(recorded.iter().position(|known| known == name).unwrap_or_else(|| {
                recorded.push(name.to_owned());
                recorded.len() - 1
            }))
        };
        let plotted = plot.iter().map(|name| place(name)).collect::<Result<Vec<_>, _>>()?;
        let pair = |pair: &String| match pair.split_once(':') {
            Some((x, y)) => Ok((place(x)?, place(y)?)),
            None => Err(Failure::input(format!("--xy {pair}: write two nets, x:y"))),
        };
        let xy = xy.iter().map(pair).collect::<Result<Vec<_>, _>>()?;
        let all = plot.is_empty() && xy.is_empty();
        let plot = if all { (0..recorded.len()).collect() } else { plotted };
        let netlist = &ordered.netlist;
        let full_scale = |name: &str| {
            let net = netlist.nets.iter().find(|net| net.name == name)?;
            netlist.blocks[net.driver.index()].max
        };
        let extremes = recorded.iter().map(|name| Extremes {
            name: name.clone(),
            full_scale: full_scale(name),
            least: (f64::INFINITY, 0.0),
            greatest: (f64::NEG_INFINITY, 0.0),
            last: f64::NAN,
        });
        let (extremes, rows) = (extremes.collect(), Rows::new(recorded.len(), MOST_ROWS));
        Ok(Picture { names: recorded.clone(), plot, xy, rows, extremes })
    }

    /// Takes in the nets' values at `time_s`.
    pub fn row(&mut self, time_s: f64, values: &[f64]) {
        for (of, value) in self.extremes.iter_mut().zip(values) {
            of.last = *value;
            if *value < of.least.0 {
                of.least = (*value, time_s);
            }
            if *value > of.greatest.0 {
                of.greatest = (*value, time_s);
            }
        }
        let tick = Tick::from_secs(time_s).unwrap_or_default().0;
        let columns: Vec<&[f64]> = values.chunks(1).collect();
        self.rows.push(&[tick], &columns);
    }

    /// Fills the page's sections.
    pub fn fill(&self, outcome: &mut Outcome) {
        let columns: [Column<Extremes>; 7] = [
            Column::new("Net", "", |e| e.name.as_str().into()),
            Column::of("Least", "", 6, |e| e.least.0.into()),
            Column::of("at", "s", 6, |e| e.least.1.into()),
            Column::of("Greatest", "", 6, |e| e.greatest.0.into()),
            Column::of("then", "s", 6, |e| e.greatest.1.into()),
            Column::of("Last", "", 6, |e| e.last.into()),
            Column::of("Use of full scale", "%", 3, |e| {
                let most = e.least.0.abs().max(e.greatest.0.abs());
                e.full_scale.map(|max| 100.0 * most / max.abs()).into()
            }),
        ];
        let time_s: Vec<f64> = self.rows.ticks.iter().map(|tick| Tick(*tick).secs()).collect();
        let over_time = |k: usize| {
            let (name, values) = (self.names[k].as_str(), &self.rows.values[k]);
            let series = vec![Series::line(name, &time_s, values)];
            LineChart::new(name, Axis::new("Time", "s"), Axis::new(name, ""), series)
        };
        if !self.plot.is_empty() {
            let mut section = outcome.section("Time histories");
            for &k in &self.plot {
                let name = &self.names[k];
                section =
                    section.chart(name.as_str(), format!("`{name}` over time."), &over_time(k));
            }
        }
        if !self.xy.is_empty() {
            let mut section = outcome.section("Phase planes");
            for &(x, y) in &self.xy {
                let [x_name, y_name] = [x, y].map(|k| self.names[k].as_str());
                let series = vec![Series::line(y_name, &self.rows.values[x], &self.rows.values[y])];
                let axes = (Axis::new(x_name, ""), Axis::new(y_name, ""));
                let chart =
                    LineChart::new(format!("{y_name} over {x_name}"), axes.0, axes.1, series);
                let caption = format!("`{y_name}` over `{x_name}`.");
                section = section.chart(format!("{x_name}-{y_name}"), caption, &chart);
            }
        }
        outcome.section("Extremes").table(
            "extremes",
            "Extremes of the recorded rows.",
            Table::of(&columns, &self.extremes),
        );
    }
}
