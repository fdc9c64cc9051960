//! A user's own loop.

use super::{Measure, outcome::Outcome};
use crate::{
    console::ConsoleFault,
    lab::{
        bench::{Bench, BenchFault},
        loop_study::{self, LoopRow, Remark},
    },
};
use desk::failure::Failure;
use desk::{
    bundle::bundle_from_path,
    progress::Progress,
    report::{
        Cell, Heading, Table,
        plot::{Axis, LineChart, Series},
    },
};
use std::path::PathBuf;

/// Settings of [`super::Experiment::Loop`], whose text is the help.
#[derive(clap::Args)]
pub struct Loop {
    /// The study
    #[arg(value_name = "STUDY.toml")]
    study: PathBuf,
}

impl Measure for Loop {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let study = loop_study::load(&self.study).map_err(Failure::input)?;
        let folder = self.study.parent().unwrap_or(std::path::Path::new(""));
        let bundle = bundle_from_path(&folder.join(study.patch()))
            .map_err(|fault| Failure::input(study.patch_fault(fault.to_string())))?;
        let mut outcome = Outcome::new(
            "loop",
            study.patch(),
            study.title.clone(),
            "The least damped mode of the measured record over frame period, latency and bits.",
        );
        outcome.set("study", study.text());
        let mut table = Table::new(vec![
            Heading::new("frame", "s"),
            Heading::new("latency", "s"),
            Heading::new("bits", ""),
            Heading::new("zeta", ""),
            Heading::new("omega", "rad/s"),
            Heading::new("growth per cycle", "").digits(5),
            Heading::new("last tenth / first tenth", "").digits(3),
            Heading::new("fit", "").digits(2),
            Heading::new("remark", ""),
        ]);
        let mut rows: Vec<LoopRow> = Vec::new();
        let mut progress = Progress::new(study.cases.len() as u64, "cases");
        for case in &study.cases {
            let row = bench.study_case(&study, &bundle, case).map_err(|fault| match fault {
                BenchFault::Lab(_)
                | BenchFault::Console(ConsoleFault::Refused(_) | ConsoleFault::RunFault { .. }) => {
                    Failure::input(study.case_fault(case, &fault))
                }
                other => other.into(),
            })?;
            let remarks: Vec<String> = row.remarks.iter().map(ToString::to_string).collect();
            table.row([
                row.frame_s.into(),
                row.latency_s.into(),
                row.bits.map_or_else(|| Cell::from("ideal"), |b| f64::from(b).into()),
                row.zeta.into(),
                row.omega_rad_s.into(),
                row.growth_per_cycle.into(),
                row.last_over_first.into(),
                row.fit.into(),
                remarks.join("; ").into(),
            ]);
            for explanation in row.remarks.iter().filter_map(Remark::explanation) {
                if !outcome.remarks.contains(&explanation) {
                    outcome.remarks.push(explanation);
                }
            }
            rows.push(row);
            progress.at(rows.len() as u64);
        }
        progress.done();
        outcome.table("loop", "Least damped oscillatory mode of each case; fit is what the modes leave of the record.", table);
        let mut kinds: Vec<(f64, Option<u32>)> = Vec::new();
        for row in &rows {
            let kind = (share(row), row.bits);
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        let series = |value: fn(&LoopRow) -> Option<f64>| -> Vec<Series> {
            kinds
                .iter()
                .map(|kind| {
                    let (x, y): (Vec<f64>, Vec<f64>) = rows
                        .iter()
                        .filter(|r| (share(r), r.bits) == *kind)
                        .map(|r| (r.frame_s * 1e3, value(r).unwrap_or(f64::NAN)))
                        .unzip();
                    let bits = kind.1.map_or("ideal".to_owned(), |b| format!("{b} bits"));
                    Series::line(format!("latency {} frames, {bits}", kind.0), &x, &y)
                        .draw(desk::report::plot::Draw::LineAndMarkers)
                })
                .collect()
        };
        outcome.chart(
            "damping",
            "Damping ratio of the least damped oscillatory mode; below zero the loop is unstable. Cases without a value are left out.",
            LineChart::new(
                "Damping",
                Axis::new("frame", "ms"),
                Axis::new("damping ratio ζ", ""),
                series(|r| r.zeta),
            )
            .limit(0.0, "stability"),
        );
        outcome.chart(
            "frequency",
            "Its frequency.",
            LineChart::new(
                "Frequency",
                Axis::new("frame", "ms"),
                Axis::new("frequency", "rad/s"),
                series(|r| r.omega_rad_s),
            ),
        );
        Ok(outcome)
    }
}

/// Latency in frames, to a thousandth.
fn share(row: &LoopRow) -> f64 {
    (1e3 * row.latency_s / row.frame_s).round() / 1e3
}
