//! The noise of rounding: directly, through an integrator and through a lag.
//!
//! The run sends seeded values that the law knows exactly through a DAC of limited bits and
//! reads back the DAC, an integrator and a lag driven by it: what is left after the law's
//! own exact solution is the noise.

use super::{theory::noise, *};
use desk::{claim::Verdict, run_dir::Seed};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A measured variance may depart from theory by this, relative, with the frames to tell: the
/// sampling error of the variance of 1e5 uniform values is √(0.8/N) = 0.3 %, of overlapping sums
/// of four about 0.7 %, of a lag (correlation e^−½) 0.7 %.
const VARIANCE_LIMIT: f64 = 0.03;
const FRAMES_TO_TELL: u32 = 100_000;
/// ± full scale of the DAC, problem units.
const FULL_SCALE: f64 = 10.0;
const FRAME_S: f64 = 0.01;
/// Corner a of the lag, rad/s: 0.5/T.
const CORNER_RAD_S: f64 = 50.0;
/// Frames between the readings of the integrator's growth.
const SPAN: usize = 4;

/// Quantisation noise itself, through an integrator and through a lag
///
/// A DAC of few bits driven with seeded random values that the digital side knows exactly.
///
/// What is read back beyond the exact solution is noise: q^2/12 itself, q^2/12 T t through an
/// integrator, and q^2/12 (1 - e)/(1 + e), e = exp(-a T), through a lag.
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

/// One variance, squares of the problem unit.
#[derive(Clone, Copy)]
struct Row {
    quantity: &'static str,
    bits: u32,
    measured: f64,
    theory: f64,
}

impl Row {
    fn error(&self) -> f64 {
        self.measured / self.theory - 1.0
    }
}

impl Noise {
    /// DAC 0 drives; ADC 0 reads it, ADC 1 its integral, ADC 2 its lag.
    fn run(&self, machine: &mut impl Machine, bits: u32) -> Result<[Row; 3], LabError> {
        require("the bits", f64::from(bits), (2..=24).contains(&bits), "2 to 24")?;
        let frames = f64::from(self.frames);
        require("the frames", frames, frames > 10.0 * SPAN as f64, "above ten spans of 4")?;
        let plan = RunPlan {
            params: vec![("full_scale", FULL_SCALE), ("tau", 1.0 / CORNER_RAD_S)],
            dac_bits: Some(bits),
            ..RunPlan::new("lab/quantisation.toml", FRAME_S, 0.0, frames * FRAME_S)?
        };
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let decay = libm::exp(-CORNER_RAD_S * FRAME_S);
        let mut sent = None;
        let mut exact = [0.0; 3];
        let mut noise = [Vec::new(), Vec::new(), Vec::new()];
        machine.run(&plan, &mut |samples, updates| {
            if let Some(sent) = sent {
                exact[0] = sent;
                exact[1] += sent * FRAME_S;
                exact[2] = decay * exact[2] + (1.0 - decay) * sent;
                for ((noise, read), exact) in noise.iter_mut().zip(samples.adc).zip(exact) {
                    noise.push(read - exact);
                }
            }
            // 0.9 of full scale: no code saturates, and thousands are crossed at each step.
            let reach = 0.9 * FULL_SCALE;
            let value = random.random_range(-reach..reach);
            updates.set_dac(0, value);
            sent = Some(value);
        })?;
        let [direct, integral, lag] = noise;
        let growth: Vec<f64> = integral.windows(SPAN + 1).map(|w| w[SPAN] - w[0]).collect();
        // The lag needs about 20/(aT) frames to become stationary.
        let settle = (20.0 / (CORNER_RAD_S * FRAME_S)).ceil() as usize;
        let settled = lag.get(settle..).unwrap_or_default();
        let step = noise::quantum(bits, FULL_SCALE);
        let row = |quantity, values: &[f64], theory| Row {
            quantity,
            bits,
            measured: variance(values),
            theory,
        };
        Ok([
            row("rounding error", &direct, noise::quantisation_variance(step)),
            row(
                "integral over the span",
                &growth,
                noise::integrator_variance(step, FRAME_S, SPAN as f64 * FRAME_S),
            ),
            row("lag", settled, noise::lag_variance(step, FRAME_S, CORNER_RAD_S)),
        ])
    }
}

/// Mean square about the mean.
fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}

impl Experiment for Noise {
    const NAME: &'static str = "noise";
    const TITLE: &'static str = "Quantisation noise";
    const LEAD: &'static str =
        "What the rounding of a DAC adds, directly, through an integrator and through a lag.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("frames", i64::from(self.frames));
        outcome.seeds.insert("values".to_owned(), Seed(self.seed));
        let rows = bench.each(&self.bits, |bench, bits| self.run(bench, *bits))?;
        let rows = rows.concat();
        let off = worst(rows.iter().map(Row::error));
        outcome.check(
            "variance",
            format!("every variance is that of theory within 3 %: worst {:.2} %", 100.0 * off),
            off < VARIANCE_LIMIT,
        );
        if let Some(claim) = outcome.claims.last_mut().filter(|_| self.frames < FRAMES_TO_TELL) {
            claim.verdict = Verdict::NotJudged;
            claim.remark = Some(format!(
                "the sampling error of {} frames is not small against 3 %; give --frames {FRAMES_TO_TELL} or more",
                self.frames
            ));
        }
        let columns = [
            Column::new("quantity", "", |r: &Row| r.quantity.into()),
            Column::new("bits", "", |r| f64::from(r.bits).into()),
            Column::of("variance measured", "", 5, |r| r.measured.into()),
            Column::of("variance theory", "", 5, |r| r.theory.into()),
            Column::of("measured/theory - 1", "%", 2, |r| (100.0 * r.error()).into()),
        ];
        let caption = "Variances in squares of the problem unit.";
        outcome.section("Numbers").table("noise", caption, Table::of(&columns, &rows));
        let compared: Vec<Compared> = rows
            .iter()
            .take(3)
            .map(|of| {
                let same = rows.iter().filter(|r| r.quantity == of.quantity);
                let points = same.map(|r| (f64::from(r.bits), r.theory, r.measured));
                Compared::of(of.quantity, points)
            })
            .collect();
        let chart = measured_vs_theory(
            "Variance of quantisation noise",
            Axis::new("bits", ""),
            Axis::new("variance", "squared problem units").log(),
            &compared,
        );
        let caption = "Each bit more divides the variance by four.";
        outcome.section("Figures").chart("variance", caption, &chart);
        Ok(())
    }
}
