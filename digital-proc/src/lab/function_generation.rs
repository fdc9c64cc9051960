//! All-digital multivariable function generation against Rubin's hybrid one.
//!
//! `C(α, M)` is wanted while α oscillates and M drifts. Three ways, at once in one run of
//! `lab/function-generation.toml`, beside the exact function on the analog side:
//! * *all-digital*: α by ADC 0, bilinear look-up, DAC 0: α itself is late, by τ + T/2;
//! * *hybrid* (Rubin): `C = Σ c_i(M) h_i(α)` with analog hat functions h_i on fixed breakpoints and
//!   ordinates c_i(M) in DCUs: only the slow M is late, α is not sampled at all;
//! * *local cell*: `C = a_j + s_j α` in the cell j that comparators report on sense lines, a_j on
//!   DAC 1 and s_j on DCU [`SLOPE`]: exact in the cell, late only at its borders.
//!
//! Phases are taken by correlators in the patch (sine and cosine products integrated over whole
//! periods), so that the images of the staircase play no part.

use super::{
    identify::{angle_difference_rad, correlated_phase_rad},
    theory::noise::staircase_rms,
    *,
};
use interface::frame::{Samples, Updates};

/// Lag of all-digital generation may depart from theory by this, degrees: the function is not a
/// line, and its slope by cells makes the lag depart from that of its argument.
const DIGITAL_LAG_LIMIT_DEG: f64 = 0.2;
/// Lag of hybrid generation may be this, degrees.
const HYBRID_LAG_LIMIT_DEG: f64 = 0.01;

/// Breakpoints of α, rad; the same stand in the patch.
const ALPHA_RAD: [f64; 7] = [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3];
/// Breakpoints of M; the same stand in the patch.
const MACH: [f64; 3] = [0.8, 1.2, 1.6];
/// Ordinates, `[alpha][mach]`: a pitching-moment-like curve that stiffens with incidence and
/// changes through the transonic range. Made up for the experiment; the same stand in the patch.
const VALUES: [f64; 21] = [
    0.98, 1.22, 0.86, //
    0.56, 0.72, 0.50, //
    0.24, 0.32, 0.22, //
    0.00, 0.00, 0.00, //
    -0.24, -0.32, -0.22, //
    -0.56, -0.72, -0.50, //
    -0.98, -1.22, -0.86,
];
/// DCU of the first ordinate.
const FIRST_ORDINATE: usize = 0;
/// DCU of the local cell's slope.
const SLOPE: usize = 16;
/// Amplitude of α, rad, within the table.
const AMPLITUDE_RAD: f64 = 0.25;
/// M at the start, and its rate, 1/s.
const MACH_START: f64 = 0.9;
const MACH_RATE_PER_S: f64 = 0.01;
/// What the correlators hold at the end, of the exact function and of each way:
/// `∫y sin ωt dt`, `∫y cos ωt dt`, `∫(y − C)² dt` (of the exact function `∫C² dt`).
const NETS: &[&str] = &[
    "exact_sine",
    "exact_cosine",
    "exact_square",
    "all_digital_sine",
    "all_digital_cosine",
    "all_digital_square",
    "hybrid_sine",
    "hybrid_cosine",
    "hybrid_square",
    "local_sine",
    "local_cosine",
    "local_square",
];
/// The ways, in the order of the nets.
const WAYS: [&str; 3] = ["all-digital", "hybrid", "local cell"];

/// All-digital, hybrid and local-cell function generation: lag and error
///
/// One function C(alpha, M) generated three ways at once, beside the exact analog one.
///
/// All-digital: alpha sampled, two-dimensional table look-up, DAC; alpha itself is late. Hybrid
/// (Rubin): fixed analog hat functions of alpha weighted by ordinates of M in digital coefficients;
/// only the slow M is late. Local cell: level and slope of the present cell, chosen by comparators.
/// Lag and rms error are taken by correlators on the analog side, against frequency and period.
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

/// Lag behind the exact function, deg, and rms error over the rms of C, percent.
#[derive(Clone, Copy)]
struct Row {
    way: &'static str,
    omega_rad_s: f64,
    frame_s: f64,
    lag: f64,
    lag_theory: f64,
    rms: f64,
    /// None for the local cell, whose error comes from late changes of the cell.
    rms_theory: Option<f64>,
}

/// `z(x, y)` by bilinear interpolation, `z` row-major `[x][y]`. Beyond the ends the end values hold,
/// as in the analog function generators, so that both sides mean the same function.
struct Table2<'a> {
    x: &'a [f64],
    y: &'a [f64],
    z: &'a [f64],
}

const TABLE: Table2<'static> = Table2 { x: &ALPHA_RAD, y: &MACH, z: &VALUES };

/// Cell and weight in which `at` lies: value = (1 − w) yᵢ + w yᵢ₊₁.
fn locate(x: &[f64], at: f64) -> (usize, f64) {
    let i = x.partition_point(|b| *b <= at).clamp(1, x.len() - 1) - 1;
    (i, ((at - x[i]) / (x[i + 1] - x[i])).clamp(0.0, 1.0))
}

impl Table2<'_> {
    /// Ordinate at breakpoint `i` of x, for `y`: the c_i(M) of hybrid function generation.
    fn ordinate(&self, i: usize, y: f64) -> f64 {
        let (j, w) = locate(self.y, y);
        let row = &self.z[i * self.y.len()..(i + 1) * self.y.len()];
        row[j] + w * (row[j + 1] - row[j])
    }

    fn value(&self, x: f64, y: f64) -> f64 {
        let (i, w) = locate(self.x, x);
        let (a, b) = (self.ordinate(i, y), self.ordinate(i + 1, y));
        a + w * (b - a)
    }
}

fn mach(t_s: f64) -> f64 {
    MACH_START + MACH_RATE_PER_S * t_s
}

/// Frame n of all three ways. Bit i of the sense lines is 1 when α is above interior breakpoint i.
fn step(frame_s: f64, samples: &Samples, updates: &mut Updates) {
    let mach = mach(samples.frame as f64 * frame_s);
    updates.set_dac(0, TABLE.value(samples.adc[0], mach));
    for i in 0..ALPHA_RAD.len() {
        updates.set_dcu(FIRST_ORDINATE + i, TABLE.ordinate(i, mach));
    }
    let interior = (1_u64 << (ALPHA_RAD.len() - 2)) - 1;
    let cell = (samples.sense & interior).count_ones() as usize;
    let (low, high) = (TABLE.ordinate(cell, mach), TABLE.ordinate(cell + 1, mach));
    let slope = (high - low) / (ALPHA_RAD[cell + 1] - ALPHA_RAD[cell]);
    updates.set_dcu(SLOPE, slope);
    updates.set_dac(1, low - slope * ALPHA_RAD[cell]);
}

impl FunctionGeneration {
    /// One frequency, all ways. The correlators open one period in.
    fn run(&self, machine: &mut impl Machine, per_cycle: u32) -> Result<[Row; 3], LabError> {
        require("frames per cycle", f64::from(per_cycle), per_cycle >= 4, "at least 4")?;
        require("the cycles", f64::from(self.cycles), self.cycles >= 1, "at least 1")?;
        require_latency(self.latency)?;
        let frame_s = self.frame.secs();
        let start_s = f64::from(per_cycle) * frame_s;
        let stop_s = (f64::from(self.cycles) + 1.0) * start_s;
        let end = mach(stop_s);
        require("M at the end", end, (MACH[0]..=MACH[2]).contains(&end), "within the table")?;
        let omega_rad_s = TAU / (f64::from(per_cycle) * frame_s);
        let plan = RunPlan {
            params: vec![
                ("frequency", omega_rad_s / TAU),
                ("amplitude", AMPLITUDE_RAD),
                ("mach_start", MACH_START),
                ("mach_rate", MACH_RATE_PER_S),
                ("start", start_s),
            ],
            read: NETS,
            ..RunPlan::new("lab/function-generation.toml", frame_s, self.latency * frame_s, stop_s)?
        };
        let sums = machine.run(&plan, &mut |s, updates| step(frame_s, s, updates))?;
        let phase = |i: usize| correlated_phase_rad(sums[i], sums[i + 1]);
        let late = omega_rad_s * ((self.latency + 0.5) * frame_s);
        let theory = [
            (late, Some(2.0 * libm::sin(late / 2.0))),
            (0.0, Some(self.staircase_ratio(omega_rad_s, start_s))),
            (0.0, None),
        ];
        Ok(std::array::from_fn(|k| {
            let (lag, rms) = theory[k];
            let first = 3 * (k + 1);
            Row {
                way: WAYS[k],
                omega_rad_s,
                frame_s,
                lag: angle_difference_rad(phase(0), phase(first)).to_degrees(),
                lag_theory: lag.to_degrees(),
                rms: 100.0 * (sums[first + 2] / sums[2]).sqrt(),
                rms_theory: rms.map(|r| 100.0 * r),
            }
        }))
    }

    /// RMS of `(∂C/∂M) Ṁ (t − t_held)` over the RMS of C, at the mean M.
    fn staircase_ratio(&self, omega_rad_s: f64, start_s: f64) -> f64 {
        let window = f64::from(self.cycles) * start_s;
        let n = 2000;
        let (mut slope, mut level) = (0.0, 0.0);
        for i in 0..n {
            let part = (f64::from(i) + 0.5) / f64::from(n);
            let t = start_s + part * window;
            let alpha = AMPLITUDE_RAD * libm::sin(omega_rad_s * t);
            let (m, d) = (mach(t), 1e-6);
            slope += ((TABLE.value(alpha, m + d) - TABLE.value(alpha, m - d)) / (2.0 * d)).powi(2);
            level += TABLE.value(alpha, m).powi(2);
        }
        let frame_s = self.frame.secs();
        let held = staircase_rms(MACH_RATE_PER_S, frame_s, self.latency * frame_s);
        held * (slope / level).sqrt()
    }
}

impl Experiment for FunctionGeneration {
    const NAME: &'static str = "function-generation";
    const TITLE: &'static str = "All-digital and hybrid function generation";
    const LEAD: &'static str = "One function of α and M generated in three ways at once. All-digital \
        generation delays α; Rubin's hybrid one delays only the slow M.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("frame", self.frame.to_string());
        outcome.set("latency-frames", self.latency);
        let rows = bench.each(&self.frames_per_cycle, |bench, n| self.run(bench, *n))?.concat();
        let of = |way: &'static str| rows.iter().filter(move |r| r.way == way);
        let digital = worst(of(WAYS[0]).map(|r| r.lag - r.lag_theory));
        outcome.check(
            "all-digital",
            format!("the all-digital lag is ω(T/2 + delay) within {DIGITAL_LAG_LIMIT_DEG}°: worst {digital:.4}°"),
            digital < DIGITAL_LAG_LIMIT_DEG,
        );
        let hybrid = worst(of(WAYS[1]).map(|r| r.lag));
        outcome.check(
            "hybrid",
            format!("the hybrid lag is under {HYBRID_LAG_LIMIT_DEG}°: worst {hybrid:.5}°"),
            hybrid < HYBRID_LAG_LIMIT_DEG,
        );
        let columns = [
            Column::new("way", "", |r: &Row| r.way.into()),
            Column::new("omega", "rad/s", |r| r.omega_rad_s.into()),
            Column::new("period", "s", |r| r.frame_s.into()),
            Column::of("lag measured", "deg", 5, |r| r.lag.into()),
            Column::of("lag theory", "deg", 5, |r| r.lag_theory.into()),
            Column::new("rms error measured", "%", |r| r.rms.into()),
            Column::new("rms error theory", "%", |r| r.rms_theory.into()),
        ];
        let caption = "Lag behind the exact function, and rms error.";
        let table = Table::of(&columns, &rows);
        outcome.section("Numbers").table("function-generation", caption, table);
        let chart = |title: &str, y: Axis, at: fn(&Row) -> (f64, f64, f64)| {
            let compared = WAYS.map(|way| Compared::of(way, of(way).map(at)));
            measured_vs_theory(title, Axis::new("frequency of α", "rad/s"), y, &compared)
        };
        let lag = chart("Lag", Axis::new("lag", "°"), |r| (r.omega_rad_s, r.lag_theory, r.lag));
        let rms = chart("RMS error", Axis::new("rms error", "%").log(), |r| {
            (r.omega_rad_s, r.rms_theory.unwrap_or(f64::NAN), r.rms)
        });
        let figures = outcome.section("Figures");
        let caption = "Lag behind the exact function, from correlators over whole cycles.";
        let figures = figures.chart("lag", caption, &lag);
        let caption = "RMS error over the RMS of the function. For the local cell no closed formula is drawn: its error comes from late changes of the cell.";
        figures.chart("rms", caption, &rms);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_is_exact_for_a_bilinear_function() {
        let f = |x: f64, y: f64| 1.0 + 2.0 * x - y + 0.5 * x * y;
        let (x, y) = (vec![-1.0, 0.5, 2.0], vec![0.0, 3.0]);
        let z: Vec<f64> = x.iter().flat_map(|a| y.iter().map(move |b| f(*a, *b))).collect();
        let t = Table2 { x: &x, y: &y, z: &z };
        for (a, b) in [(-1.0, 0.0), (0.0, 1.0), (0.5, 3.0), (1.7, 2.2), (2.0, 3.0)] {
            // Rounding of a handful of operations on numbers below 10.
            assert!((t.value(a, b) - f(a, b)).abs() < 1e-14);
        }
        assert_eq!(t.value(9.0, 9.0), t.value(2.0, 3.0));
    }
}
