//! The circle test: two integrators closed through the digital side.

use super::{Measure, curve, hold, outcome::Outcome};
use crate::lab::{
    bench::Bench,
    feedback::CircleSetting,
    theory::{feedback_loop::FeedbackLoop, growth_per_cycle, hold::Hold},
};
use desk::failure::Failure;
use desk::{
    progress::Progress,
    report::{
        Heading, Table,
        plot::{Axis, Compared, LineChart, Series, measured_vs_theory},
    },
};
use interface::Tick;

/// Measured growth and exact map may differ by this, relative.
const LIMIT: f64 = 1e-6;

/// Settings of [`super::Experiment::Circle`], whose text is the help.
#[derive(clap::Args)]
pub struct Circle {
    /// Samples per cycle, at least 6
    #[arg(long, value_delimiter = ',', default_value = "10,20,40,100,200,400", value_name = "N")]
    samples_per_cycle: Vec<u32>,
    /// Latencies in frames, 0 to 1
    #[arg(long, value_delimiter = ',', default_value = "0,0.25,0.5,1", value_name = "FRAMES")]
    latency: Vec<f64>,
    /// Reconstruction of the DAC: zero-order, extrapolating, interpolating
    #[arg(long, value_delimiter = ',', value_parser = hold,
          default_value = "zero-order,extrapolating,interpolating", value_name = "HOLD")]
    hold: Vec<Hold>,
    /// Frame period; only its product with the frequency matters
    #[arg(long, default_value = "10ms", value_name = "TIME")]
    frame: Tick,
}

impl Circle {
    fn settings(&self) -> Vec<CircleSetting> {
        let mut all = Vec::new();
        for hold in &self.hold {
            for latency_frames in &self.latency {
                for samples_per_cycle in &self.samples_per_cycle {
                    all.push(CircleSetting {
                        samples_per_cycle: *samples_per_cycle,
                        frame_s: self.frame.secs(),
                        latency_frames: *latency_frames,
                        hold: *hold,
                    });
                }
            }
        }
        all
    }

    /// |growth − 1| of the exact map against samples per cycle.
    fn curve(&self, hold: Hold, latency_frames: f64) -> (Vec<f64>, Vec<f64>) {
        let least = self.samples_per_cycle.iter().min().copied().unwrap_or(10);
        let most = self.samples_per_cycle.iter().max().copied().unwrap_or(400);
        let frame = self.frame.secs();
        curve::ratios(f64::from(least), f64::from(most), curve::POINTS)
            .filter_map(|n| {
                let omega = std::f64::consts::TAU / (n * frame);
                let theory = FeedbackLoop::circle(omega, hold, frame, latency_frames * frame);
                let growth = growth_per_cycle(theory.exact_root().ok()?);
                Some((n, (growth - 1.0).abs()))
            })
            .unzip()
    }
}

impl Measure for Circle {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "circle",
            "lab/circle.toml",
            "Circle test",
            "Two integrators closed through ADC, digital side and DAC. Without an interface the \
             amplitude never changes; its growth over one cycle is what the interface does.",
        );
        outcome.set("frame", self.frame.to_string());
        let settings = self.settings();
        let mut table = Table::new(vec![
            Heading::new("hold", ""),
            Heading::new("latency", "frames"),
            Heading::new("samples per cycle", ""),
            Heading::new("growth measured", "").digits(9),
            Heading::new("growth exact", "").digits(9),
            Heading::new("growth first order", "").digits(6),
            Heading::new("measured/exact - 1", "").digits(2),
            Heading::new("first order/exact - 1", "").digits(2),
        ]);
        let mut rows = Vec::new();
        let mut progress = Progress::new(settings.len() as u64, "settings");
        for setting in &settings {
            let row = bench.circle(setting)?;
            table.row([
                row.hold.into(),
                row.latency_frames.into(),
                f64::from(row.samples_per_cycle).into(),
                row.growth_measured.into(),
                row.growth_exact.into(),
                row.growth_first_order.into(),
                row.error_exact.into(),
                row.error_first_order.into(),
            ]);
            rows.push(row);
            progress.at(rows.len() as u64);
        }
        progress.done();
        let worst = rows.iter().map(|r| r.error_exact.abs()).fold(0.0, f64::max);
        outcome.check(
            worst < LIMIT,
            format!("growth equals the exact discrete map within {LIMIT:e}: worst {worst:.1e}, relative, of {} settings", rows.len()),
        );
        outcome.table("circle", "Growth of the amplitude over one cycle.", table);

        let of = |hold: Hold, latency: f64| {
            rows.iter().filter(move |r| r.hold == hold.name() && r.latency_frames == latency)
        };
        for (id, latency) in ["growth-first-latency", "growth-last-latency"]
            .into_iter()
            .zip(curve::ends(&self.latency))
        {
            let compared: Vec<Compared> = self
                .hold
                .iter()
                .map(|hold| Compared {
                    name: hold.name().to_owned(),
                    theory: self.curve(*hold, latency),
                    measured: of(*hold, latency)
                        .map(|r| {
                            let growth = (r.growth_measured - 1.0).abs();
                            (f64::from(r.samples_per_cycle), growth)
                        })
                        .unzip(),
                })
                .collect();
            let title = format!("Growth per cycle at a latency of {latency} frames");
            let chart = measured_vs_theory(
                &title,
                Axis::new("samples per cycle", "").log(),
                Axis::new("|growth per cycle − 1|", "").log(),
                &compared,
            );
            outcome.chart(id, "Lines: exact discrete map. Markers: runs on the machine.", chart);
        }
        let errors: Vec<Series> = self
            .hold
            .iter()
            .flat_map(|hold| curve::ends(&self.latency).into_iter().map(move |l| (*hold, l)))
            .map(|(hold, latency)| {
                let (x, y): (Vec<f64>, Vec<f64>) = of(hold, latency)
                    .map(|r| (f64::from(r.samples_per_cycle), r.error_first_order.abs()))
                    .unzip();
                Series::line(format!("{}, {latency} frames", hold.name()), &x, &y)
            })
            .collect();
        outcome.chart(
            "first-order-error",
            "What the first-order formula exp(πωτ_e) is wrong by: it is a formula for many samples a cycle.",
            LineChart::new(
                "Error of the first-order formula",
                Axis::new("samples per cycle", "").log(),
                Axis::new("|first order/exact − 1|", "").log(),
                errors,
            ),
        );
        Ok(outcome)
    }
}
