//! A resolver pair whose channels are held one after the other: sine and cosine of one turning
//! angle pass a multiplexer, and the angle formed of both is wrong by ωδ sin²θ.

use super::{identify::angle_difference_rad, plan::tick, theory::noise, *};

/// Multiplexer skew on a resolver pair
///
/// Sine and cosine of one angle read through a multiplexer, the cosine one skew later.
///
/// The angle computed from them is too great by omega delta sin^2(angle): omega delta / 2 on average.
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

/// Errors of the angle over four revolutions, rad.
struct Row {
    skew_s: f64,
    /// ωδ.
    omega_delta: f64,
    mean: f64,
    greatest: f64,
    /// Greatest difference from ωδ sin²θ.
    worst_difference: f64,
}

impl Row {
    fn mean_theory(&self) -> f64 {
        self.omega_delta / 2.0
    }
}

impl Skew {
    /// Reads sine (ADC 0) and cosine (ADC 1, δ later) of θ = ωt.
    fn run(&self, machine: &mut impl Machine, skew_s: f64) -> Result<Row, LabError> {
        require("the frames", f64::from(self.frames), self.frames >= 1, "at least 1")?;
        let frame_s = self.frame.secs();
        let omega = TAU / (f64::from(self.frames) * frame_s);
        let stop_s = 4.0 * f64::from(self.frames) * frame_s;
        let mut plan = RunPlan {
            params: vec![("frequency", omega / TAU)],
            ..RunPlan::new("lab/skew.toml", frame_s, skew_s, stop_s)?
        };
        plan.spec.skew = tick("the skew", skew_s)?;
        let (mut errors, mut differences) = (Vec::new(), Vec::new());
        machine.run(&plan, &mut |samples, _| {
            let theta = omega * (samples.frame as f64 * frame_s);
            let read = libm::atan2(samples.adc[0], samples.adc[1]);
            let error = angle_difference_rad(read, theta);
            differences.push(error - noise::resolver_skew_error_rad(omega, skew_s, theta));
            errors.push(error);
        })?;
        Ok(Row {
            skew_s,
            omega_delta: omega * skew_s,
            mean: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
            greatest: errors.iter().copied().fold(0.0, f64::max),
            worst_difference: worst(differences),
        })
    }
}

impl Experiment for Skew {
    const NAME: &'static str = "skew";
    const TITLE: &'static str = "Multiplexer skew on a resolver pair";
    const LEAD: &'static str = "Sine and cosine of one turning angle, held one after the other.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("frames", i64::from(self.frames));
        outcome.set("frame", self.frame.to_string());
        let rows = bench.each(&self.delta, |bench, delta| self.run(bench, delta.secs()))?;
        // The formula is of first order: the next term is the square.
        outcome.check(
            "error",
            "the error is ωδ sin²θ at every angle, up to its square",
            rows.iter().all(|r| r.worst_difference < r.omega_delta.powi(2)),
        );
        let columns = [
            Column::new("skew", "us", |r: &Row| (1e6 * r.skew_s).into()),
            Column::of("mean error measured", "deg", 5, |r| r.mean.to_degrees().into()),
            Column::of("omega delta / 2", "deg", 5, |r| r.mean_theory().to_degrees().into()),
            Column::of("greatest error measured", "deg", 5, |r| r.greatest.to_degrees().into()),
            Column::of("omega delta", "deg", 5, |r| r.omega_delta.to_degrees().into()),
            Column::of("worst difference from omega delta sin^2", "deg", 2, |r| {
                r.worst_difference.to_degrees().into()
            }),
        ];
        let caption = "Error of the angle over four revolutions.";
        outcome.section("Numbers").table("skew", caption, Table::of(&columns, &rows));
        let degrees = |skew_s: f64, theory: f64, measured: f64| {
            (1e6 * skew_s, theory.to_degrees(), measured.to_degrees())
        };
        let compared = [
            Compared::of("mean", rows.iter().map(|r| degrees(r.skew_s, r.mean_theory(), r.mean))),
            Compared::of(
                "greatest",
                rows.iter().map(|r| degrees(r.skew_s, r.omega_delta, r.greatest)),
            ),
        ];
        let chart = measured_vs_theory(
            "Angle error by multiplexer skew",
            Axis::new("skew δ", "µs"),
            Axis::new("error of the angle", "°"),
            &compared,
        );
        let caption = "The error grows in proportion to the skew.";
        outcome.section("Figures").chart("error", caption, &chart);
        Ok(())
    }
}
