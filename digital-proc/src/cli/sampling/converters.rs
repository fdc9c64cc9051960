//! Quantisation noise, multiplexer skew, staircase coefficients.

use super::{Measure, outcome::Outcome};
use crate::lab::{
    bench::Bench,
    converter_error::{CoefficientSetting, QuantisationSetting, SkewSetting},
};
use desk::failure::Failure;
use desk::{
    report::{
        Heading, Table,
        plot::{Axis, Compared, measured_vs_theory},
    },
    run_dir::Seed,
};
use interface::Tick;

/// A measured variance may depart from theory by this, relative.
const VARIANCE_LIMIT: f64 = 0.03;

/// Settings of [`super::Experiment::Noise`], whose text is the help.
#[derive(clap::Args)]
pub struct Noise {
    /// Bits of the DAC, sign included
    #[arg(long, value_delimiter = ',', default_value = "8,10,12,14", value_name = "BITS")]
    bits: Vec<u32>,
    /// Frames; the sampling error of a variance falls with their root
    #[arg(long, default_value_t = 100_001, value_name = "N")]
    frames: u32,
    /// Seed of the random values
    #[arg(long, default_value_t = 1978)]
    seed: u64,
}

impl Measure for Noise {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "noise",
            "lab/quantisation.toml",
            "Quantisation noise",
            "What the rounding of a DAC adds, directly, through an integrator and through a lag.",
        );
        outcome.set("frames", i64::from(self.frames));
        outcome.seeds.insert("values".to_owned(), Seed(self.seed));
        let mut table = Table::new(vec![
            Heading::new("quantity", ""),
            Heading::new("bits", ""),
            Heading::new("variance measured", "").digits(5),
            Heading::new("variance theory", "").digits(5),
            Heading::new("measured/theory - 1", "%").digits(2),
        ]);
        let mut drawn: Vec<Compared> = Vec::new();
        let mut worst = 0.0_f64;
        for bits in &self.bits {
            let setting = QuantisationSetting {
                bits: *bits,
                frames: self.frames,
                ..QuantisationSetting::standard(self.seed)
            };
            for row in bench.quantisation(&setting)? {
                table.row([
                    row.quantity.into(),
                    f64::from(*bits).into(),
                    row.measured.into(),
                    row.theory.into(),
                    (100.0 * row.relative_error).into(),
                ]);
                worst = worst.max(row.relative_error.abs());
                let known = drawn.iter().position(|c| c.name == row.quantity);
                let i = known.unwrap_or_else(|| {
                    drawn.push(Compared::new(row.quantity));
                    drawn.len() - 1
                });
                drawn[i].push(f64::from(*bits), row.theory, row.measured);
            }
        }
        if self.frames >= 100_000 {
            outcome.check(
                worst < VARIANCE_LIMIT,
                format!(
                    "every variance is that of theory within 3 %: worst {:.2} %",
                    100.0 * worst
                ),
            );
        }
        outcome.table("noise", "Variances in squares of the problem unit.", table);
        outcome.chart(
            "variance",
            "Each bit more divides the variance by four.",
            measured_vs_theory(
                "Variance of quantisation noise",
                Axis::new("bits", ""),
                Axis::new("variance", "squared problem units").log(),
                &drawn,
            ),
        );
        Ok(outcome)
    }
}

/// Settings of [`super::Experiment::Skew`], whose text is the help.
#[derive(clap::Args)]
pub struct Skew {
    /// Skews between neighbouring channels
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "10us,20us,50us,100us,200us",
        value_name = "TIME"
    )]
    delta: Vec<Tick>,
    /// Frames in one revolution
    #[arg(long, default_value_t = 128, value_name = "N")]
    frames: u32,
    /// Frame period
    #[arg(long, default_value = "10ms", value_name = "TIME")]
    frame: Tick,
}

impl Measure for Skew {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "skew",
            "lab/skew.toml",
            "Multiplexer skew on a resolver pair",
            "Sine and cosine of one turning angle, held one after the other.",
        );
        outcome.set("frames", i64::from(self.frames));
        outcome.set("frame", self.frame.to_string());
        let mut table = Table::new(vec![
            Heading::new("skew", "us"),
            Heading::new("mean error measured", "deg").digits(5),
            Heading::new("omega delta / 2", "deg").digits(5),
            Heading::new("greatest error measured", "deg").digits(5),
            Heading::new("omega delta", "deg").digits(5),
            Heading::new("worst difference from omega delta sin^2", "deg").digits(2),
        ]);
        let [mut mean, mut greatest] = ["mean", "greatest"].map(Compared::new);
        let mut agree = true;
        for delta in &self.delta {
            let setting = SkewSetting::revolution(self.frames, self.frame.secs(), delta.secs());
            let row = bench.skew(&setting)?;
            table.row([
                (1e6 * row.skew_s).into(),
                row.mean_measured_rad.to_degrees().into(),
                row.mean_theory_rad.to_degrees().into(),
                row.max_measured_rad.to_degrees().into(),
                row.max_theory_rad.to_degrees().into(),
                row.worst_difference_rad.to_degrees().into(),
            ]);
            // The formula is of first order: the next term is the square.
            agree &= row.worst_difference_rad < (setting.omega_rad_s * row.skew_s).powi(2);
            for (compared, theory_rad, measured_rad) in [
                (&mut mean, row.mean_theory_rad, row.mean_measured_rad),
                (&mut greatest, row.max_theory_rad, row.max_measured_rad),
            ] {
                compared.push(1e6 * row.skew_s, theory_rad.to_degrees(), measured_rad.to_degrees());
            }
        }
        outcome.check(agree, "the error is ωδ sin²θ at every angle, up to its square");
        outcome.table("skew", "Error of the angle over four revolutions.", table);
        outcome.chart(
            "error",
            "The error grows in proportion to the skew.",
            measured_vs_theory(
                "Angle error by multiplexer skew",
                Axis::new("skew δ", "µs"),
                Axis::new("error of the angle", "°"),
                &[mean, greatest],
            ),
        );
        Ok(outcome)
    }
}

/// Settings of [`super::Experiment::Coefficients`], whose text is the help.
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

impl Measure for Coefficients {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "coefficients",
            "lab/coefficient.toml",
            "Staircase of a digital coefficient",
            "A coefficient that the digital side renews once a period, against the ramp it should follow.",
        );
        outcome.set("latency-frames", self.latency);
        outcome.set("rate-per-s", self.rate);
        let mut table = Table::new(vec![
            Heading::new("period", "s"),
            Heading::new("mean error measured", "").digits(6),
            Heading::new("mean error theory", "").digits(6),
            Heading::new("rms error measured", "").digits(6),
            Heading::new("rms error theory", "").digits(6),
        ]);
        let [mut mean, mut rms] = ["mean", "rms"].map(Compared::new);
        let mut worst = 0.0_f64;
        for frame in &self.frame {
            let frame_s = frame.secs();
            let row = bench.coefficient(&CoefficientSetting {
                rate_per_s: self.rate,
                frame_s,
                latency_s: self.latency * frame_s,
                stop_s: 22.0 * frame_s,
            })?;
            table.row([
                row.frame_s.into(),
                row.mean_measured.into(),
                row.mean_theory.into(),
                row.rms_measured.into(),
                row.rms_theory.into(),
            ]);
            worst = worst
                .max((row.mean_measured / row.mean_theory - 1.0).abs())
                .max((row.rms_measured / row.rms_theory - 1.0).abs());
            let period_ms = row.frame_s * 1e3;
            mean.push(period_ms, row.mean_theory, row.mean_measured);
            rms.push(period_ms, row.rms_theory, row.rms_measured);
        }
        outcome.check(
            worst < 1e-6,
            format!(
                "mean and rms error are those of theory within 1e-6: worst {worst:.1e}, relative"
            ),
        );
        outcome.table("coefficients", "Error of the coefficient over 20 periods.", table);
        outcome.chart(
            "error",
            "The error is of first order in the period.",
            measured_vs_theory(
                "Staircase error of a coefficient",
                Axis::new("period", "ms"),
                Axis::new("error of the coefficient", ""),
                &[mean, rms],
            ),
        );
        Ok(outcome)
    }
}
