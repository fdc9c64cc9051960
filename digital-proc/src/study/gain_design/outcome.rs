//! The whole design, step after step, and what it came to for people and machines.

use super::{
    criteria,
    design::{Design, EFFORT, design},
    evaluate::{PointQuality, evaluate, points, worst},
    merge::merge,
    schedule::{as_toml, charts},
    search::Effort,
    verdict::{Level, designed_section, fewest_accepted, none_accepted, reduced_sections},
};
use crate::{
    linkage::console::Console,
    study::{fault::StudyFault, long_period::run::LongPeriodPlan, short_period::machine::Bench},
};
use desk::{
    outcome::{Figure, Outcome},
    report::{Cell, Column, Heading, Table},
};
use interface::profile::Profile;
use vehicle::{ScheduleData, Vehicle};

/// What was designed.
#[derive(Clone, Debug, PartialEq)]
pub struct Designed {
    /// Interval by interval.
    pub design: Design,
    /// With fewer and fewer switchings, the designed schedule first.
    pub levels: Vec<Level>,
    /// Trial flights flown.
    pub flights: usize,
    /// The vehicle's own schedule with fewer switchings at the trajectory points.
    pub shipped_reduced: Vec<PointQuality>,
}

/// Designs, merges and evaluates; `told` is given a line of each on the way.
pub fn run(
    console: &mut Console<'_>,
    profile: &Profile,
    vehicle: &Vehicle,
    evaluations: usize,
    mut told: impl FnMut(String),
) -> Result<Designed, StudyFault> {
    let (points, lacking) = points(vehicle)?;
    for reason in lacking {
        told(format!("not judged: {reason}"));
    }
    let bench = Bench::pitch(console, profile)?;
    let effort = Effort { evaluations, ..EFFORT };
    let design = design(console, &bench, vehicle, effort, |i, of, interval| {
        let [from, to] = interval.judged_s;
        told(format!(
            "interval {i} of {of}, {from}–{to} s: cost {:.2} -> {:.2} in {} evaluations",
            interval.first_cost, interval.cost, interval.evaluations
        ));
    })?;
    let plan = LongPeriodPlan::new(Vec::new(), profile.clone());
    let merging = merge(console, vehicle, &plan, &design.schedule, |level, flights| {
        told(format!(
            "{} switchings: {:.1} kPa deg after {flights} flights",
            level.schedule.switch_time_s.len() - 1,
            level.max_q_alpha_padeg / 1e3
        ));
    })?;
    let bench = Bench::pitch(console, profile)?;
    let mut at_points = |data: &ScheduleData| evaluate(console, &bench, vehicle, &points, data);
    let mut levels = Vec::with_capacity(merging.levels.len());
    for trial in merging.levels {
        let points = at_points(&trial.schedule)?;
        levels.push(Level { trial, points });
    }
    let shipped_reduced = at_points(&vehicle.data().gains_reduced)?;
    Ok(Designed { design, levels, flights: merging.flights, shipped_reduced })
}

impl Designed {
    /// The designed schedules as sections of a vehicle file.
    pub fn sections(&self) -> String {
        format!("{}\n{}", designed_section(&self.levels), reduced_sections(&self.levels))
    }

    /// What `design-gains` came to. A design that leads to no accepted schedule has failed.
    pub fn outcome(&self, vehicle: &Vehicle) -> Outcome {
        let data = vehicle.data();
        let (end_s, shipped) = (data.mass.burn_time_s, data.gains.schedule());
        let mut out = Outcome::new(
            "Design of the gain schedules",
            "Gains improved run by run on the patched pitch loop; then fewer switchings, accepted by flights and re-evaluated.",
        );
        out.results.add("runs", "Runs", self.design.runs as f64, 6, "", "of the pitch loop");
        out.results.add("flights", "Trial flights", self.flights as f64, 6, "", "to burn-out");
        out.section("Criteria").table(
            "criteria",
            "Allowances of the design. The cost of a loop is the sum of measures over allowances, and ten times what exceeds one.",
            criteria::table(),
        );
        let designed = [("designed here", &self.design.schedule), ("shipped", &shipped)];
        out.section("Designed schedule")
            .figure(Figure::new(
                "designed",
                "Gain schedules designed from the short-period model (after the paper's figure 7).",
                charts(&designed, end_s),
            ))
            .table("design", "Designed gains at both ends of each interval.", self.intervals())
            .words(designed_section(&self.levels))
            .words(as_toml("gains", "shipped", &shipped));
        let mut fewest = vec![("shipped", &data.gains_reduced)];
        if let Some(level) = self.levels.last() {
            fewest.insert(0, ("merged here", &level.trial.schedule));
        }
        out.section("Fewer switchings")
            .figure(Figure::new(
                "reduced",
                "Schedules with fewer switchings, from long-period flights (after the paper's figure 8).",
                charts(&fewest, end_s),
            ))
            .table(
                "merging",
                "Mergers accepted by long-period flights, and what the short-period model says of them.",
                self.merging(),
            )
            .words(reduced_sections(&self.levels))
            .words(as_toml("gains_reduced", "shipped", &data.gains_reduced));
        let levels =
            self.levels.iter().map(|l| (format!("{} switchings", l.switchings()), &l.points));
        let shipped_points = ("shipped".to_owned(), &self.shipped_reduced);
        out.section("Re-evaluation")
            .table(
                "shipped_reduced",
                "The shipped schedule with fewer switchings at the trajectory points; accepted are 25 % overshoot and 5 % residual.",
                at_points([shipped_points.clone()]),
            )
            .long_table(
                "points",
                "Every schedule at the trajectory points.",
                at_points(levels.chain([shipped_points])),
            )
            .long_table("schedules", "Every schedule.", self.schedules(vehicle));
        if let Some(worst) = worst(&self.shipped_reduced).filter(|w| !w.accepted()) {
            let overshoot = worst.quality.overshoot;
            out.remarks.push(format!(
                "The shipped reduced schedule overshoots most at {} ({} s): {}.",
                worst.point,
                worst.time_s,
                overshoot.map_or("it diverges".to_owned(), |v| format!("{:.0} %", 100.0 * v))
            ));
        }
        if fewest_accepted(&self.levels).is_none() {
            out.refused.push(none_accepted(&self.levels));
            out.refused.push("allow more evaluations of each interval: --evaluations N".to_owned());
        }
        out
    }

    /// How each interval's gains came out, a row an end of the interval.
    fn intervals(&self) -> Table {
        let start =
            [("Interval from", "s"), ("judged at", "s"), ("Cost at start", ""), ("Cost", "")];
        let start = start.map(|(label, unit)| Heading::new(label, unit).digits(3));
        let mut table = Table::new(
            start
                .into_iter()
                .chain(criteria::headings())
                .chain([Heading::new("Criteria", "")])
                .collect(),
        );
        for (i, interval) in self.design.intervals.iter().enumerate() {
            for (place, quality) in interval.judged_s.iter().zip(&interval.quality) {
                let from = self.design.schedule.switch_time_s[i];
                let start = [from, *place, interval.first_cost, interval.cost].map(Cell::Number);
                let met: Cell = if quality.met() { "met" } else { "not met" }.into();
                table.row(start.into_iter().chain(quality.cells()).chain([met]));
            }
        }
        table
    }

    /// The mergers with their flights and their re-evaluation.
    fn merging(&self) -> Table {
        let columns: [Column<Level>; 7] = [
            Column::of("Switchings", "", 2, |l| (l.switchings() as f64).into()),
            Column::new("Switch times", "s", |l| {
                let times: Vec<String> =
                    l.trial.schedule.switch_time_s.iter().skip(1).map(f64::to_string).collect();
                times.join(", ").into()
            }),
            Column::new("Largest Qα", "kPa·°", |l| (l.trial.max_q_alpha_padeg / 1e3).into()),
            Column::of("Burn-out departure over accepted", "", 3, |l| l.trial.severity.into()),
            Column::of("Largest overshoot", "%", 3, |l| {
                worst(&l.points).and_then(|w| w.quality.overshoot).map(|v| 100.0 * v).into()
            }),
            Column::new("at", "", |l| worst(&l.points).map_or("", |w| w.point.as_str()).into()),
            Column::new("Short period", "", |l| {
                match l.points.iter().filter(|p| !p.accepted()).count() {
                    0 => "accepted at all points".into(),
                    exceeded => {
                        format!("exceeded at {exceeded} of {} points", l.points.len()).into()
                    }
                }
            }),
        ];
        Table::of(&columns, &self.levels)
    }

    /// Every schedule, a row an interval.
    fn schedules(&self, vehicle: &Vehicle) -> Table {
        type Row<'a> = (&'a str, usize, &'a ScheduleData);
        let columns: [Column<Row<'_>>; 7] = [
            Column::new("Schedule", "", |r| r.0.into()),
            Column::new("from", "s", |r| r.2.switch_time_s[r.1].into()),
            Column::new("K_F", "", |r| r.2.ftc_gain[r.1].into()),
            Column::new("T_F", "s", |r| r.2.ftc_lead_s[r.1].into()),
            Column::new("K_T", "N/deg", |r| r.2.tvc_gain_npdeg[r.1].into()),
            Column::new("T_T", "s", |r| r.2.tvc_lead_s[r.1].into()),
            Column::new("dead zone", "deg", |r| r.2.dead_zone_deg[r.1].into()),
        ];
        let shipped = vehicle.data().gains.schedule();
        let names: Vec<String> =
            self.levels.iter().map(|l| format!("{} switchings", l.switchings())).collect();
        let here = names.iter().zip(&self.levels).map(|(n, l)| (n.as_str(), &l.trial.schedule));
        let all =
            here.chain([("shipped", &shipped), ("shipped reduced", &vehicle.data().gains_reduced)]);
        let rows: Vec<Row<'_>> =
            all.flat_map(|(n, s)| (0..s.switch_time_s.len()).map(move |i| (n, i, s))).collect();
        Table::of(&columns, &rows)
    }
}

/// Schedules judged point by point.
fn at_points<'a>(schedules: impl IntoIterator<Item = (String, &'a Vec<PointQuality>)>) -> Table {
    let start = [("Schedule", ""), ("Point", ""), ("Time", "s")];
    let start = start.map(|(label, unit)| Heading::new(label, unit));
    let mut table = Table::new(
        start.into_iter().chain(criteria::headings()).chain([Heading::new("P1", "")]).collect(),
    );
    for (name, points) in schedules {
        for point in points {
            let start: [Cell; 3] =
                [name.as_str().into(), point.point.as_str().into(), point.time_s.into()];
            let accepted: Cell = if point.accepted() { "accepted" } else { "exceeded" }.into();
            table.row(start.into_iter().chain(point.quality.cells()).chain([accepted]));
        }
    }
    table
}
