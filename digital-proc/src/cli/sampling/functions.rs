//! Function generation and systems of axes.

use super::{Measure, outcome::Outcome};
use crate::lab::{
    axes::{Axes, AxesRow, AxesSetting},
    bench::Bench,
    function_generation::{FunctionRow, FunctionSetting, Way},
};
use desk::failure::Failure;
use desk::report::{
    Heading, Table,
    plot::{Axis, Compared, LineChart, Series, measured_vs_theory},
};
use interface::Tick;

/// Lag of all-digital generation may depart from theory by this, degrees.
const DIGITAL_LAG_LIMIT_DEG: f64 = 0.2;
/// Lag of hybrid generation may be this, degrees.
const HYBRID_LAG_LIMIT_DEG: f64 = 0.01;
/// The body axes' error is at least so many times that of flight-path axes.
const AXES_RATIO: f64 = 10.0;

/// Settings of [`super::Experiment::FunctionGeneration`], whose text is the help.
#[derive(clap::Args)]
pub struct FunctionGeneration {
    /// Frames in one cycle of alpha
    #[arg(long, value_delimiter = ',', default_value = "20,39,80,160", value_name = "N")]
    frames_per_cycle: Vec<u32>,
    /// Sampling period
    #[arg(long, default_value = "20ms", value_name = "TIME")]
    frame: Tick,
    /// Latency in frames, 0 to 1
    #[arg(long, default_value_t = 1.0, value_name = "FRAMES")]
    latency: f64,
    /// Cycles correlated
    #[arg(long, default_value_t = 8, value_name = "N")]
    cycles: u32,
}

fn way_name(way: Way) -> &'static str {
    match way {
        Way::AllDigital => "all-digital",
        Way::Hybrid => "hybrid",
        Way::LocalCell => "local cell",
    }
}

impl Measure for FunctionGeneration {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "function-generation",
            "lab/function-generation.toml",
            "All-digital and hybrid function generation",
            "One function of α and M generated in three ways at once. All-digital generation delays α; \
             Rubin's hybrid one delays only the slow M.",
        );
        outcome.set("frame", self.frame.to_string());
        outcome.set("latency-frames", self.latency);
        let mut table = Table::new(vec![
            Heading::new("way", ""),
            Heading::new("omega", "rad/s"),
            Heading::new("period", "s"),
            Heading::new("lag measured", "deg").digits(5),
            Heading::new("lag theory", "deg").digits(5),
            Heading::new("rms error measured", "%").digits(4),
            Heading::new("rms error theory", "%").digits(4),
        ]);
        let mut rows: Vec<FunctionRow> = Vec::new();
        for frames_per_cycle in &self.frames_per_cycle {
            let setting = FunctionSetting {
                frames_per_cycle: *frames_per_cycle,
                frame_s: self.frame.secs(),
                latency_frames: self.latency,
                cycles: self.cycles,
                ..FunctionSetting::standard()
            };
            rows.extend(bench.function(&setting)?);
        }
        for row in &rows {
            table.row([
                way_name(row.way).into(),
                row.omega_rad_s.into(),
                row.frame_s.into(),
                row.lag_measured_deg.into(),
                row.lag_theory_deg.into(),
                row.rms_measured_percent.into(),
                row.rms_theory_percent.map_or_else(|| "".into(), Into::into),
            ]);
        }
        let of = |way: Way| rows.iter().filter(move |r| r.way == way);
        let digital = of(Way::AllDigital)
            .map(|r| (r.lag_measured_deg - r.lag_theory_deg).abs())
            .fold(0.0, f64::max);
        let hybrid = of(Way::Hybrid).map(|r| r.lag_measured_deg.abs()).fold(0.0, f64::max);
        outcome.check(
            digital < DIGITAL_LAG_LIMIT_DEG,
            format!("the all-digital lag is ω(T/2 + delay) within {DIGITAL_LAG_LIMIT_DEG}°: worst {digital:.4}°"),
        );
        outcome.check(
            hybrid < HYBRID_LAG_LIMIT_DEG,
            format!("the hybrid lag is under {HYBRID_LAG_LIMIT_DEG}°: worst {hybrid:.5}°"),
        );
        outcome.table(
            "function-generation",
            "Lag behind the exact function, and rms error.",
            table,
        );
        type Quantity = fn(&FunctionRow) -> f64;
        let compared = |theory: Quantity, measured: Quantity| {
            [Way::AllDigital, Way::Hybrid, Way::LocalCell].map(|way| {
                let mut compared = Compared::new(way_name(way));
                for row in of(way) {
                    compared.push(row.omega_rad_s, theory(row), measured(row));
                }
                compared
            })
        };
        let frequency = || Axis::new("frequency of α", "rad/s");
        outcome.chart(
            "lag",
            "Lag behind the exact function, from correlators over whole cycles.",
            measured_vs_theory(
                "Lag",
                frequency(),
                Axis::new("lag", "°"),
                &compared(|r| r.lag_theory_deg, |r| r.lag_measured_deg),
            ),
        );
        outcome.chart(
            "rms",
            "RMS error over the RMS of the function. For the local cell no closed formula is drawn: its error comes from late changes of the cell.",
            measured_vs_theory(
                "RMS error",
                frequency(),
                Axis::new("rms error", "%").log(),
                &compared(
                    |r| r.rms_theory_percent.unwrap_or(f64::NAN),
                    |r| r.rms_measured_percent,
                ),
            ),
        );
        Ok(outcome)
    }
}

/// Settings of [`super::Experiment::Axes`], whose text is the help.
#[derive(clap::Args)]
pub struct AxesOfTranslation {
    /// Digital steps
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "25ms,50ms,100ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// Amplitude of the attitude, degrees
    #[arg(long, default_value_t = 3.0, value_name = "DEG")]
    amplitude: f64,
    /// Frequency of the attitude, rad/s
    #[arg(long, default_value_t = 4.0, value_name = "RAD/S")]
    omega: f64,
    /// Offset of the product that turns the velocity, percent of its full scale
    #[arg(long, default_value_t = 0.05, value_name = "PERCENT")]
    offset: f64,
}

fn axes_name(axes: Axes) -> &'static str {
    match axes {
        Axes::Body => "body",
        Axes::FlightPath => "flight path",
        Axes::H => "H",
    }
}

impl AxesOfTranslation {
    fn setting(&self, frame_s: f64, offset: f64) -> AxesSetting {
        AxesSetting {
            amplitude_rad: self.amplitude.to_radians(),
            omega_rad_s: self.omega,
            offset_of_full_scale: offset,
            ..AxesSetting::standard(frame_s)
        }
    }
}

impl Measure for AxesOfTranslation {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "axes",
            "lab/axes.toml",
            "Axes of the translational equations",
            "The same flight integrated in three systems of axes from the same samples of an \
             oscillating attitude. The products q u of body axes are artificial accelerations, whose \
             error is the attitude's own lag.",
        );
        outcome.set("amplitude-deg", self.amplitude);
        outcome.set("omega-rad-s", self.omega);
        outcome.set("offset-percent", self.offset);
        let mut table = Table::new(vec![
            Heading::new("axes", ""),
            Heading::new("step", "s"),
            Heading::new("rms error of gamma", "deg"),
            Heading::new("first order", "deg"),
            Heading::new("with offset", "deg"),
            Heading::new("greatest turning acceleration", "m/s2"),
            Heading::new("full scale", "m/s2"),
        ]);
        let mut rows: Vec<AxesRow> = Vec::new();
        for frame in &self.frame {
            let ideal = bench.axes(&self.setting(frame.secs(), 0.0))?;
            let offset = bench.axes(&self.setting(frame.secs(), self.offset / 100.0))?;
            for (row, off) in ideal.iter().zip(&offset) {
                table.row([
                    axes_name(row.axes).into(),
                    row.frame_s.into(),
                    row.gamma_error_rms_deg.into(),
                    row.gamma_error_theory_deg.into(),
                    off.gamma_error_rms_deg.into(),
                    row.turning_acceleration_max_m_s2.into(),
                    row.full_scale_m_s2.into(),
                ]);
            }
            rows.extend(ideal);
        }
        outcome.table(
            "axes",
            format!(
                "Error of the flight-path angle over 20 s; `with offset`: the product that turns the velocity is off by {} % of its full scale.",
                self.offset
            ),
            table,
        );
        let compared = Axes::ALL.map(|axes| {
            let mut all: Vec<&AxesRow> = rows.iter().filter(|r| r.axes == axes).collect();
            all.sort_by(|a, b| a.frame_s.total_cmp(&b.frame_s));
            let mut compared = Compared::new(axes_name(axes));
            for row in all {
                compared.push(
                    row.frame_s * 1e3,
                    row.gamma_error_theory_deg,
                    row.gamma_error_rms_deg,
                );
            }
            compared
        });
        let [(steps_ms, body), (_, path), ..] = compared.each_ref().map(|c| &c.measured);
        if let Some(i) = steps_ms.iter().position(|t| (*t - 100.0).abs() < 1e-9) {
            let ratio = body[i] / path[i];
            outcome.check(
                ratio > AXES_RATIO,
                format!("at 100 ms the error in body axes is more than {AXES_RATIO} times that in flight-path axes: {ratio:.1} times"),
            );
        }
        outcome.chart(
            "gamma-error",
            "Lines: first order of the oscillating part. Markers: runs on the machine.",
            measured_vs_theory(
                "Error of the flight-path angle",
                Axis::new("digital step", "ms").log(),
                Axis::new("rms error of γ", "°").log(),
                &compared,
            ),
        );
        let ratio: Vec<f64> = body.iter().zip(path).map(|(b, p)| b / p).collect();
        outcome.chart(
            "ratio",
            "What the choice of axes is worth.",
            LineChart::new(
                "Body axes against flight-path axes",
                Axis::new("digital step", "ms"),
                Axis::new("ratio of rms errors of γ", ""),
                vec![Series::markers("", steps_ms, &ratio)],
            ),
        );
        Ok(outcome)
    }
}
