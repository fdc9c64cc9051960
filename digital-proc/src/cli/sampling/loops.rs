//! Loops closed through the digital side: circle, root, and the paper's figure 1.

use super::{Measure, hold, outcome::Outcome};
use crate::{
    cli::Failure,
    progress::Progress,
    report::{
        Cell, Heading, Table,
        plot::{Axis, HeatCell, HeatMap, LineChart, Pair, Series, measured_vs_theory},
    },
    sampling::{
        alpha::AlphaSetting,
        bench::Bench,
        feedback::{CircleSetting, Compensation, RootSetting},
        theory::{
            alpha::{Correction, Delivery, Scheme, drift_error},
            damping_ratio,
            feedback_loop::FeedbackLoop,
            growth_per_cycle,
            hold::Hold,
        },
    },
};
use interface::Tick;

/// Measured growth and exact map may differ by this, relative.
const CIRCLE_LIMIT: f64 = 1e-6;
/// Measured and exact damping may differ by this; frequencies, relative.
const ROOT_LIMIT: f64 = 1e-4;
/// Points of a theoretical curve.
const CURVE_POINTS: u32 = 60;

/// `count` values from `low` to `high` in equal ratios.
fn ratios(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> {
    let last = f64::from(count.max(2) - 1);
    (0..count.max(2)).map(move |i| low * (high / low).powf(f64::from(i) / last))
}

/// Settings of [`super::Experiment::Circle`], whose text is the help.
#[derive(clap::Args)]
pub struct Circle {
    /// Samples per cycle, at least 6
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "10,20,40,100,200,400",
        value_name = "N"
    )]
    samples_per_cycle: Vec<u32>,
    /// Latencies in frames, 0 to 1
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0,0.25,0.5,1",
        value_name = "FRAMES"
    )]
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
        ratios(f64::from(least), f64::from(most), CURVE_POINTS)
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
            worst < CIRCLE_LIMIT,
            format!("growth equals the exact discrete map within {CIRCLE_LIMIT:e}: worst {worst:.1e}, relative, of {} settings", rows.len()),
        );
        outcome.table("circle", "Growth of the amplitude over one cycle.", table);

        let of = |hold: Hold, latency: f64| {
            rows.iter()
                .filter(move |r| r.hold == hold.name() && r.latency_frames == latency)
        };
        for (id, latency) in ["growth-first-latency", "growth-last-latency"]
            .into_iter()
            .zip(ends(&self.latency))
        {
            let lines: Vec<_> = self.hold.iter().map(|h| self.curve(*h, latency)).collect();
            let points: Vec<(Vec<f64>, Vec<f64>)> = self
                .hold
                .iter()
                .map(|h| {
                    of(*h, latency)
                        .map(|r| {
                            (
                                f64::from(r.samples_per_cycle),
                                (r.growth_measured - 1.0).abs(),
                            )
                        })
                        .unzip()
                })
                .collect();
            let pairs: Vec<Pair<'_>> = self
                .hold
                .iter()
                .zip(lines.iter().zip(&points))
                .map(|(hold, (line, point))| Pair {
                    name: hold.name(),
                    theory: (&line.0, &line.1),
                    measured: (&point.0, &point.1),
                })
                .collect();
            let title = format!("Growth per cycle at a latency of {latency} frames");
            let chart = measured_vs_theory(
                &title,
                Axis::new("samples per cycle", "").log(),
                Axis::new("|growth per cycle − 1|", "").log(),
                &pairs,
            );
            outcome.chart(
                id,
                "Lines: exact discrete map. Markers: runs on the machine.",
                chart,
            );
        }
        let errors: Vec<Series> = self
            .hold
            .iter()
            .flat_map(|hold| ends(&self.latency).into_iter().map(move |l| (*hold, l)))
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

/// First and last, or the one.
fn ends(values: &[f64]) -> Vec<f64> {
    match values {
        [] => Vec::new(),
        [one] => vec![*one],
        [first, .., last] => vec![*first, *last],
    }
}

/// Settings of [`super::Experiment::Root`], whose text is the help.
#[derive(clap::Args)]
pub struct Root {
    /// Natural frequency omega0, rad/s
    #[arg(long, default_value_t = 3.0, value_name = "RAD/S")]
    omega: f64,
    /// Damping ratio without an interface, 0 to below 1
    #[arg(long, default_value_t = 0.3, value_name = "ZETA")]
    zeta: f64,
    /// Frame periods
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "20ms,50ms,100ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// Latencies in frames, 0 to 1
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0,0.5,1",
        value_name = "FRAMES"
    )]
    latency: Vec<f64>,
}

fn compensation_name(compensation: Compensation) -> &'static str {
    match compensation {
        Compensation::None => "none",
        Compensation::HalfFrame => "half-frame prediction",
        Compensation::ExtrapolatingDac => "extrapolating DAC",
        Compensation::Lead => "lead",
    }
}

impl Root {
    fn setting(&self, frame_s: f64, latency: f64, compensation: Compensation) -> RootSetting {
        RootSetting {
            omega0_rad_s: self.omega,
            zeta: self.zeta,
            frame_s,
            latency_frames: latency,
            compensation,
        }
    }
}

impl Measure for Root {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let mut outcome = Outcome::new(
            "root",
            "lab/root.toml",
            "Root of a sampled second-order loop",
            "Damping and frequency of a loop whose stiffness passes the digital side, from runs on \
             the machine, from the exact sampled-data eigenvalues and by Howe's first-order shift.",
        );
        outcome.set("omega-rad-s", self.omega);
        outcome.set("zeta", self.zeta);
        let mut table = Table::new(vec![
            Heading::new("compensation", ""),
            Heading::new("latency", "frames"),
            Heading::new("frame", "s"),
            Heading::new("zeta measured", "").digits(6),
            Heading::new("zeta exact", "").digits(6),
            Heading::new("zeta first order", "").digits(4),
            Heading::new("omega measured", "rad/s").digits(6),
            Heading::new("omega exact", "rad/s").digits(6),
            Heading::new("omega first order", "rad/s").digits(4),
        ]);
        let mut rows = Vec::new();
        let total = Compensation::ALL.len() * self.latency.len() * self.frame.len();
        let mut progress = Progress::new(total as u64, "settings");
        for compensation in Compensation::ALL {
            for latency in &self.latency {
                for frame in &self.frame {
                    let row = bench.root(&self.setting(frame.secs(), *latency, compensation))?;
                    table.row([
                        compensation_name(compensation).into(),
                        (*latency).into(),
                        frame.secs().into(),
                        row.zeta_measured.into(),
                        row.zeta_exact.into(),
                        row.zeta_first_order.into(),
                        row.omega_measured_rad_s.into(),
                        row.omega_exact_rad_s.into(),
                        row.omega_first_order_rad_s.into(),
                    ]);
                    rows.push(row);
                    progress.at(rows.len() as u64);
                }
            }
        }
        progress.done();
        let zeta = rows
            .iter()
            .map(|r| (r.zeta_measured - r.zeta_exact).abs())
            .fold(0.0, f64::max);
        let omega = rows
            .iter()
            .map(|r| (r.omega_measured_rad_s / r.omega_exact_rad_s - 1.0).abs())
            .fold(0.0, f64::max);
        outcome.check(
            zeta < ROOT_LIMIT && omega < ROOT_LIMIT,
            format!("damping and frequency are those of the exact eigenvalues within {ROOT_LIMIT:e}: worst {zeta:.1e} in zeta, {omega:.1e} relative in omega, of {} settings", rows.len()),
        );
        outcome.table("root", "Damping ratio and frequency.", table);
        let longest = self.frame.iter().map(|f| f.secs()).fold(0.0, f64::max);
        for (id, latency) in ["damping-first-latency", "damping-last-latency"]
            .into_iter()
            .zip(ends(&self.latency))
        {
            let lines: Vec<(Vec<f64>, Vec<f64>)> = Compensation::ALL
                .map(|compensation| {
                    (1..=CURVE_POINTS)
                        .filter_map(|i| {
                            let frame = longest * f64::from(i) / f64::from(CURVE_POINTS);
                            let theory = self.setting(frame, latency, compensation).theory();
                            Some((frame * 1e3, damping_ratio(theory.exact_root().ok()?)))
                        })
                        .unzip()
                })
                .into();
            let points: Vec<(Vec<f64>, Vec<f64>)> = Compensation::ALL
                .map(|compensation| {
                    rows.iter()
                        .filter(|r| {
                            r.setting.compensation == compensation
                                && r.setting.latency_frames == latency
                        })
                        .map(|r| (r.setting.frame_s * 1e3, r.zeta_measured))
                        .unzip()
                })
                .into();
            let pairs: Vec<Pair<'_>> = Compensation::ALL
                .iter()
                .zip(lines.iter().zip(&points))
                .map(|(c, (line, point))| Pair {
                    name: compensation_name(*c),
                    theory: (&line.0, &line.1),
                    measured: (&point.0, &point.1),
                })
                .collect();
            let title = format!("Damping at a latency of {latency} frames");
            let chart = measured_vs_theory(
                &title,
                Axis::new("frame", "ms"),
                Axis::new("damping ratio ζ", ""),
                &pairs,
            )
            .limit(self.zeta, "continuous loop")
            .limit(0.0, "stability");
            outcome.chart(
                id,
                "Lines: exact sampled-data eigenvalues. Markers: runs on the machine.",
                chart,
            );
        }
        Ok(outcome)
    }
}

/// Settings of [`super::Experiment::Alpha`], whose text is the help.
#[derive(clap::Args)]
pub struct Alpha {
    /// Frequencies of the loop, rad/s
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "2,4,6",
        value_name = "RAD/S"
    )]
    omega: Vec<f64>,
    /// Slow period, in which the digital side integrates alpha
    #[arg(long, default_value = "100ms", value_name = "TIME")]
    slow: Tick,
    /// Fast frames in one slow period
    #[arg(long, default_value_t = 10, value_name = "N")]
    fast: u32,
    /// Latency in frames of the scheme, 0 to 1
    #[arg(long, default_value_t = 1.0, value_name = "FRAMES")]
    latency: f64,
    /// Correction gains K
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0.1,0.2,0.5",
        value_name = "K"
    )]
    gain: Vec<f64>,
    /// When and against what the correction is formed
    #[arg(long, value_enum, default_value = "late-matched")]
    delivery: DeliveryName,
    /// How the correction enters the analog integrator
    #[arg(long, value_enum, default_value = "spread")]
    correction: CorrectionName,
    /// The angle of attack, or the angle of sideslip, which the rate turns the other way
    #[arg(long, value_enum, default_value = "alpha")]
    angle: AngleName,
    /// Drift of the analog integrator, degrees per second
    #[arg(long, default_value_t = 0.05, value_name = "DEG/S")]
    drift: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum DeliveryName {
    /// At once
    Prompt,
    /// One slow frame late, both angles of one instant
    LateMatched,
    /// One slow frame late, against the present analog angle
    LateUnmatched,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum CorrectionName {
    /// Over the whole slow period
    Spread,
    /// Over one fast frame
    Pulse,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum AngleName {
    /// Angle of attack
    Alpha,
    /// Angle of sideslip
    Beta,
}

impl Alpha {
    fn redundant(&self, gain: f64) -> Scheme {
        Scheme::Redundant {
            slow_frames: self.fast,
            gain,
            delivery: match self.delivery {
                DeliveryName::Prompt => Delivery::Prompt,
                DeliveryName::LateMatched => Delivery::LateMatched,
                DeliveryName::LateUnmatched => Delivery::LateUnmatched,
            },
            correction: match self.correction {
                CorrectionName::Spread => Correction::Spread,
                CorrectionName::Pulse => Correction::Pulse,
            },
        }
    }

    fn setting(&self, omega: f64, scheme: Scheme, slow_s: f64) -> Result<AlphaSetting, Failure> {
        let frame_s = match scheme {
            Scheme::Conventional => slow_s,
            Scheme::Redundant { slow_frames, .. } => slow_s / f64::from(slow_frames),
        };
        let mut setting = AlphaSetting::standard(omega, scheme, frame_s, self.latency * frame_s);
        if self.angle == AngleName::Beta {
            setting.loop_.rotation.direction = -1.0;
        }
        // Enough slow samples for the slowest sweep.
        setting.stop_s = setting.stop_s.max(60.0 * slow_s);
        Ok(setting.within_tables()?)
    }

    fn schemes(&self) -> Vec<(String, Scheme)> {
        let mut all = vec![("conventional".to_owned(), Scheme::Conventional)];
        all.extend(
            self.gain
                .iter()
                .map(|k| (format!("redundant, K = {k}"), self.redundant(*k))),
        );
        all
    }
}

impl Measure for Alpha {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        if self.fast == 0 {
            return Err(Failure::input("--fast must be at least 1"));
        }
        let mut outcome = Outcome::new(
            "alpha",
            "lab/alpha-redundant.toml",
            "Angle of attack: conventional sampling and redundant integrators",
            "The paper's figure 1 in numbers. A redundant analog integrator gives the tables an angle \
             that is late by a fast frame only; the digital angle corrects it slowly, at a price.",
        );
        outcome.set("slow", self.slow.to_string());
        outcome.set("fast", i64::from(self.fast));
        outcome.set("latency-frames", self.latency);
        let slow = self.slow.secs();
        let mut table = Table::new(vec![
            Heading::new("scheme", ""),
            Heading::new("omega", "rad/s"),
            Heading::new("zeta measured", "").digits(6),
            Heading::new("zeta exact", "").digits(6),
            Heading::new("zeta first order", "").digits(4),
            Heading::new("zeta continuous", "").digits(4),
            Heading::new("omega measured", "rad/s").digits(6),
            Heading::new("omega exact", "rad/s").digits(6),
            Heading::new("run", ""),
            Heading::new("greatest |z|", "").digits(5),
        ]);
        let (mut zeta, mut omega_error, mut agree) = (0.0_f64, 0.0_f64, true);
        let mut histories = Vec::new();
        let last_omega = self.omega.last().copied();
        for (name, scheme) in self.schemes() {
            for omega in &self.omega {
                let setting = self.setting(*omega, scheme, slow)?;
                let (row, record) = bench.alpha(&setting)?;
                zeta = zeta.max((row.zeta_measured - row.zeta_exact).abs());
                omega_error =
                    omega_error.max((row.omega_measured_rad_s / row.omega_exact_rad_s - 1.0).abs());
                agree &= row.stable_measured == (row.spectral_radius < 1.0);
                table.row([
                    name.as_str().into(),
                    (*omega).into(),
                    row.zeta_measured.into(),
                    row.zeta_exact.into(),
                    row.zeta_first_order.into(),
                    row.zeta_continuous.into(),
                    row.omega_measured_rad_s.into(),
                    row.omega_exact_rad_s.into(),
                    (if row.stable_measured {
                        "stable"
                    } else {
                        "unstable"
                    })
                    .into(),
                    row.spectral_radius.into(),
                ]);
                if Some(*omega) == last_omega {
                    histories.push((name.clone(), setting, record));
                }
            }
        }
        outcome.check(
            zeta < ROOT_LIMIT && omega_error < ROOT_LIMIT,
            format!("damping and frequency are those of the monodromy matrix within {ROOT_LIMIT:e}: worst {zeta:.1e} in zeta, {omega_error:.1e} relative in omega"),
        );
        outcome.check(
            agree,
            "a run decays exactly where the monodromy matrix has its roots inside the unit circle",
        );
        outcome.table(
            "alpha",
            "Roots of the loop, from runs and from the monodromy matrix.",
            table,
        );
        outcome.chart(
            "histories",
            "The same loop from the same displacement; what differs is how the angle reaches the tables.",
            histories_chart(&histories, last_omega),
        );
        self.stability(bench, &mut outcome)?;
        self.drifts(bench, &mut outcome)?;
        Ok(outcome)
    }
}

/// α over its start against time; a record that grows is drawn up to four times its start.
fn histories_chart(
    histories: &[(String, AlphaSetting, Vec<f64>)],
    omega: Option<f64>,
) -> LineChart {
    let series = histories
        .iter()
        .map(|(name, setting, record)| {
            let (x, y): (Vec<f64>, Vec<f64>) = record
                .iter()
                .enumerate()
                .map(|(n, a)| (n as f64 * setting.slow_s(), a / setting.initial_rad))
                .take_while(|(t, y)| *t <= 6.0 && y.abs() <= 4.0)
                .unzip();
            Series::line(name.as_str(), &x, &y)
        })
        .collect();
    LineChart::new(
        format!(
            "Angle after a displacement, ω = {} rad/s",
            omega.unwrap_or(f64::NAN)
        ),
        Axis::new("time", "s"),
        Axis::new("angle / angle at the start", ""),
        series,
    )
}

impl Alpha {
    /// Damping over slow periods, for each scheme, and the map over slow and fast periods.
    fn stability(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        let Some(omega) = self.omega.last().copied() else {
            return Ok(());
        };
        let slows = [0.02, 0.05, 0.1, 0.15, 0.2];
        let schemes = self.schemes();
        let mut drawn = Vec::new();
        for (_, scheme) in &schemes {
            let mut measured = (Vec::new(), Vec::new());
            for slow in slows {
                let (row, _) = bench.alpha(&self.setting(omega, *scheme, slow)?)?;
                measured.0.push(slow * 1e3);
                measured.1.push(row.zeta_measured);
            }
            let theory: (Vec<f64>, Vec<f64>) = (2..=CURVE_POINTS)
                .filter_map(|i| {
                    let slow = 0.2 * f64::from(i) / f64::from(CURVE_POINTS);
                    let setting = self.setting(omega, *scheme, slow).ok()?;
                    let root = setting.loop_.exact_root().ok()?;
                    Some((slow * 1e3, damping_ratio(root)))
                })
                .unzip();
            drawn.push((theory, measured));
        }
        let pairs: Vec<Pair<'_>> = schemes
            .iter()
            .zip(&drawn)
            .map(|((name, _), (theory, measured))| Pair {
                name,
                theory: (&theory.0, &theory.1),
                measured: (&measured.0, &measured.1),
            })
            .collect();
        let chart = measured_vs_theory(
            &format!("Damping of the loop of {omega} rad/s"),
            Axis::new("slow period", "ms"),
            Axis::new("damping ratio ζ", ""),
            &pairs,
        )
        .limit(0.0, "stability");
        outcome.chart(
            "damping",
            "Lines: monodromy matrix. Markers: runs on the machine.",
            chart,
        );

        let fasts = [1_u32, 2, 5, 10, 20];
        let gain = if self.gain.contains(&0.2) {
            0.2
        } else {
            self.gain.first().copied().unwrap_or(0.2)
        };
        let slow_axis = [0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2];
        let mut table = Table::new(vec![
            Heading::new("scheme", ""),
            Heading::new("slow period", "s"),
            Heading::new("fast period", "s"),
            Heading::new("run", ""),
            Heading::new("greatest |z|", "").digits(5),
        ]);
        let mut matrix = Vec::new();
        let mut heads = vec!["conventional".to_owned()];
        heads.extend(fasts.iter().map(|n| format!("redundant, {n} fast frames")));
        let mut right = true;
        for (column, head) in heads.iter().enumerate() {
            let mut cells = Vec::new();
            for slow in slow_axis {
                let scheme = match column {
                    0 => Scheme::Conventional,
                    i => match self.redundant(gain) {
                        Scheme::Redundant {
                            delivery,
                            correction,
                            ..
                        } => Scheme::Redundant {
                            slow_frames: fasts[i - 1],
                            gain,
                            delivery,
                            correction,
                        },
                        other => other,
                    },
                };
                let setting = self.setting(omega, scheme, slow)?;
                let (row, _) = bench.alpha(&setting)?;
                right &= row.stable_measured == (row.spectral_radius < 1.0);
                table.row([
                    head.as_str().into(),
                    slow.into(),
                    setting.loop_.frame_s.into(),
                    (if row.stable_measured {
                        "stable"
                    } else {
                        "unstable"
                    })
                    .into(),
                    row.spectral_radius.into(),
                ]);
                cells.push(HeatCell {
                    value: row.zeta_measured,
                    violated: !row.stable_measured,
                    href: None,
                });
            }
            matrix.push(cells);
        }
        outcome.check(
            right,
            "the stable region of the sweep is that of the monodromy matrix",
        );
        outcome.table(
            "stability",
            format!("Where the loop of {omega} rad/s is stable, K = {gain}."),
            table,
        );
        outcome.matrix(
            "stability-map",
            format!("Damping ratio measured at K = {gain}; cells with a mark diverged."),
            HeatMap {
                quantity: "damping ratio ζ".to_owned(),
                corner: "scheme against slow period".to_owned(),
                rows: heads,
                columns: slow_axis
                    .iter()
                    .map(|s| format!("{} ms", s * 1e3))
                    .collect(),
                cells: matrix,
                scale: None,
                digits: 2,
            },
        );
        Ok(())
    }

    /// What a drift of the analog integrator leaves.
    fn drifts(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        let drift = self.drift.to_radians();
        let mut table = Table::new(vec![
            Heading::new("K", ""),
            Heading::new("error left, measured", "deg").digits(5),
            Heading::new("drift * slow period / K", "deg").digits(5),
            Heading::new("uncorrected after 49 s", "deg").digits(4),
        ]);
        for gain in self.gain.iter().filter(|k| **k > 0.0) {
            // A loop of 2 rad/s, which every K of interest leaves stable.
            let mut setting = self.setting(2.0, self.redundant(*gain), self.slow.secs())?;
            setting.drift_rad_s = drift;
            setting.stop_s = 120.0;
            let (row, _) = bench.alpha(&setting)?;
            let theory = drift_error(drift, self.slow.secs(), *gain);
            table.row([
                Cell::Number(*gain),
                row.error_measured_rad.abs().to_degrees().into(),
                theory.to_degrees().into(),
                (self.drift * 49.0).into(),
            ]);
        }
        outcome.table(
            "drift",
            format!(
                "Error that a drift of {} deg/s of the analog integrator leaves.",
                self.drift
            ),
            table,
        );
        Ok(())
    }
}
