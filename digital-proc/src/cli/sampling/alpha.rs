//! The paper's figure 1: the angle of attack sampled, or from redundant integrators.

use super::{
    Measure,
    curve::{self, ROOT_LIMIT},
    outcome::Outcome,
};
use crate::lab::{
    alpha::AlphaSetting,
    bench::Bench,
    theory::{
        alpha::{Correction, Delivery, Scheme, drift_error},
        damping_ratio,
    },
};
use desk::failure::Failure;
use desk::report::{
    Cell, Heading, Table,
    plot::{Axis, Compared, HeatCell, HeatMap, LineChart, Series, measured_vs_theory},
};
use interface::Tick;

/// Settings of [`super::Experiment::Alpha`], whose text is the help.
#[derive(clap::Args)]
pub struct Alpha {
    /// Frequencies of the loop, rad/s
    #[arg(long, value_delimiter = ',', default_value = "2,4,6", value_name = "RAD/S")]
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
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.2,0.5", value_name = "K")]
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
    /// With `fast` frames in one slow period and a correction gain.
    fn redundant(&self, fast: u32, gain: f64) -> Scheme {
        Scheme::Redundant {
            slow_frames: fast,
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
                .map(|k| (format!("redundant, K = {k}"), self.redundant(self.fast, *k))),
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
                    run_cell(row.stable_measured),
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
            "The root nearest to the continuous loop's, from runs and from the monodromy matrix; the greatest |z| is that of all roots, those of the correction included.",
            table,
        );
        outcome.chart(
            "histories",
            "The same loop from the same displacement; what differs is how the angle reaches the tables.",
            histories_chart(&histories, last_omega),
        );
        if let Some(omega) = last_omega {
            self.damping(bench, &mut outcome, omega)?;
            self.stable_region(bench, &mut outcome, omega)?;
        }
        self.drifts(bench, &mut outcome)?;
        Ok(outcome)
    }
}

/// How a run came out, in a table.
fn run_cell(stable: bool) -> Cell {
    if stable { "stable" } else { "unstable" }.into()
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
        format!("Angle after a displacement, ω = {} rad/s", omega.unwrap_or(f64::NAN)),
        Axis::new("time", "s"),
        Axis::new("angle / angle at the start", ""),
        series,
    )
}

impl Alpha {
    /// Damping over slow periods, for each scheme.
    fn damping(
        &self,
        bench: &mut Bench<'_, '_>,
        outcome: &mut Outcome,
        omega: f64,
    ) -> Result<(), Failure> {
        let mut drawn = Vec::new();
        for (name, scheme) in self.schemes() {
            let mut compared = Compared {
                theory: (2..=curve::POINTS)
                    .filter_map(|i| {
                        let slow = 0.2 * f64::from(i) / f64::from(curve::POINTS);
                        let setting = self.setting(omega, scheme, slow).ok()?;
                        let root = setting.loop_.exact_root().ok()?;
                        Some((slow * 1e3, damping_ratio(root)))
                    })
                    .unzip(),
                ..Compared::new(name)
            };
            for slow in [0.02, 0.05, 0.1, 0.15, 0.2] {
                let (row, _) = bench.alpha(&self.setting(omega, scheme, slow)?)?;
                compared.measured.0.push(slow * 1e3);
                compared.measured.1.push(row.zeta_measured);
            }
            drawn.push(compared);
        }
        let chart = measured_vs_theory(
            &format!("Damping of the loop of {omega} rad/s"),
            Axis::new("slow period", "ms"),
            Axis::new("damping ratio ζ", ""),
            &drawn,
        )
        .limit(0.0, "stability");
        outcome.chart("damping", "Lines: monodromy matrix. Markers: runs on the machine.", chart);
        Ok(())
    }

    /// Where the loop is stable: the map over slow and fast periods.
    fn stable_region(
        &self,
        bench: &mut Bench<'_, '_>,
        outcome: &mut Outcome,
        omega: f64,
    ) -> Result<(), Failure> {
        let gain =
            if self.gain.contains(&0.2) { 0.2 } else { self.gain.first().copied().unwrap_or(0.2) };
        let slow_axis = [0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2];
        let mut table = Table::new(vec![
            Heading::new("scheme", ""),
            Heading::new("slow period", "s"),
            Heading::new("fast period", "s"),
            Heading::new("run", ""),
            Heading::new("greatest |z|", "").digits(5),
        ]);
        let mut schemes = vec![("conventional".to_owned(), Scheme::Conventional)];
        schemes.extend([1, 2, 5, 10, 20].map(|fast| {
            let name = format!("redundant, {fast} fast frames");
            (name, self.redundant(fast, gain))
        }));
        let mut matrix = Vec::new();
        let mut right = true;
        for (name, scheme) in &schemes {
            let mut cells = Vec::new();
            for slow in slow_axis {
                let setting = self.setting(omega, *scheme, slow)?;
                let (row, _) = bench.alpha(&setting)?;
                right &= row.stable_measured == (row.spectral_radius < 1.0);
                table.row([
                    name.as_str().into(),
                    slow.into(),
                    setting.loop_.frame_s.into(),
                    run_cell(row.stable_measured),
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
        outcome.check(right, "the stable region of the sweep is that of the monodromy matrix");
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
                rows: schemes.into_iter().map(|(name, _)| name).collect(),
                columns: slow_axis.iter().map(|s| format!("{} ms", s * 1e3)).collect(),
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
            let mut setting =
                self.setting(2.0, self.redundant(self.fast, *gain), self.slow.secs())?;
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
            format!("Error that a drift of {} deg/s of the analog integrator leaves.", self.drift),
            table,
        );
        Ok(())
    }
}
