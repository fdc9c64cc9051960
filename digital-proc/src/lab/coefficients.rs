//! A coefficient that the digital side renews once a period, against the ramp it should follow.

use super::{
    theory::noise::{staircase_mean, staircase_rms},
    *,
};

/// Measured errors and theory may differ by this, relative.
const LIMIT: f64 = 1e-6;

/// Staircase error of a digital coefficient
///
/// A digital coefficient that should follow a ramp and is renewed once a period.
///
/// It is a staircase behind the ramp: late by T/2 + latency on average, with an rms error of
/// rate sqrt(T^2/3 + T latency + latency^2).
#[derive(clap::Args)]
pub struct Coefficients {
    /// Periods of the settings
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "20ms,50ms,100ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// Latency in frames, 0 to 1
    #[arg(long, default_value_t = 0.2, value_name = "FRAMES")]
    latency: f64,
    /// Rate of the ramp, 1/s
    #[arg(long, default_value_t = 0.3, value_name = "1/S")]
    rate: f64,
}

/// Errors of the coefficient: (measured, theory).
struct Row {
    frame_s: f64,
    mean: (f64, f64),
    rms: (f64, f64),
}

impl Coefficients {
    /// 22 periods, of which the first two settle; the patch integrates error and square from there.
    fn run(&self, machine: &mut impl Machine, frame_s: f64) -> Result<Row, LabError> {
        require_latency(self.latency)?;
        let (latency_s, stop_s, start_s) = (self.latency * frame_s, 22.0 * frame_s, 2.0 * frame_s);
        let plan = RunPlan {
            params: vec![("rate", self.rate), ("start", start_s)],
            read: &["error_sum", "square_sum"],
            ..RunPlan::new("lab/coefficient.toml", frame_s, latency_s, stop_s)?
        };
        let sums = machine.run(&plan, &mut |samples, updates| {
            updates.set_dcu(0, self.rate * (samples.frame as f64 * frame_s));
        })?;
        let duration = stop_s - start_s;
        Ok(Row {
            frame_s,
            mean: (sums[0] / duration, staircase_mean(self.rate, frame_s, latency_s)),
            rms: ((sums[1] / duration).sqrt(), staircase_rms(self.rate, frame_s, latency_s)),
        })
    }
}

impl Experiment for Coefficients {
    const NAME: &'static str = "coefficients";
    const TITLE: &'static str = "Staircase of a digital coefficient";
    const LEAD: &'static str = "A coefficient that the digital side renews once a period, against \
        the ramp it should follow.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("latency-frames", self.latency);
        outcome.set("rate-per-s", self.rate);
        let rows = bench.each(&self.frame, |bench, frame| self.run(bench, frame.secs()))?;
        let off = worst(rows.iter().flat_map(|r| [r.mean, r.rms]).map(|(m, t)| m / t - 1.0));
        outcome.check(
            "error",
            format!(
                "mean and rms error are those of theory within {LIMIT:e}: worst {off:.1e}, relative"
            ),
            off < LIMIT,
        );
        let columns = [
            Column::new("period", "s", |r: &Row| r.frame_s.into()),
            Column::of("mean error measured", "", 6, |r| r.mean.0.into()),
            Column::of("mean error theory", "", 6, |r| r.mean.1.into()),
            Column::of("rms error measured", "", 6, |r| r.rms.0.into()),
            Column::of("rms error theory", "", 6, |r| r.rms.1.into()),
        ];
        let caption = "Error of the coefficient over 20 periods.";
        outcome.section("Numbers").table("coefficients", caption, Table::of(&columns, &rows));
        let compared = [
            Compared::of("mean", rows.iter().map(|r| (r.frame_s * 1e3, r.mean.1, r.mean.0))),
            Compared::of("rms", rows.iter().map(|r| (r.frame_s * 1e3, r.rms.1, r.rms.0))),
        ];
        let chart = measured_vs_theory(
            "Staircase error of a coefficient",
            Axis::new("period", "ms"),
            Axis::new("error of the coefficient", ""),
            &compared,
        );
        let caption = "The error is of first order in the period.";
        outcome.section("Figures").chart("error", caption, &chart);
        Ok(())
    }
}
