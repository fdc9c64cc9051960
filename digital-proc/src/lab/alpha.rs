//! The paper's figure 1: the angle of attack sampled, or from redundant integrators.
//!
//! Equations and the reading of the figure are in [`theory::alpha`].
//! Channels: ADC 0 rate, ADC 1 redundant angle; DAC 0 moment, DAC 1 force, DAC 2 correction. The
//! tables end at ±1 rad; the record of a run that diverges ends where the angle leaves them, since
//! beyond there the loop is another one.
//!
//! Long, since it has two laws, three sweeps and their tables.

use super::{
    feedback::check_roots,
    identify,
    theory::{
        Refusal,
        alpha::{AlphaLoop, Correction, Delivery, Rotation, Scheme, drift_error},
    },
    *,
};
use desk::{
    outcome::Figure,
    report::plot::{HeatCell, HeatMap, heat_map},
};
use interface::frame::{Samples, Updates};
use vehicle::table;

/// Where the force and moment tables end, rad.
const TABLE_END_RAD: f64 = 1.0;

/// Angle of attack conventionally sampled against the redundant integrator
///
/// The alpha loop of the rotational equations, alpha' = q - Z alpha, q' = -omega^2 alpha - D q with
/// Z = 0.6 and D = 0.4, closed through a conventionally sampled alpha and through a redundant one.
///
/// Conventional: the digital side samples q, integrates alpha in the slow frame and holds the
/// moment. Redundant (figure 1 of the paper): an analog integrator turns with q, is sampled fast for
/// the tables, and is only corrected slowly by K times the error of the digital alpha. Roots stand
/// beside those of the multi-rate monodromy matrix; a sweep shows where each becomes unstable. The
/// correction has its price: with K = 0.5 one frame late the loop is unstable.
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
    delivery: Delivery,
    /// How the correction enters the analog integrator
    #[arg(long, value_enum, default_value = "spread")]
    correction: Correction,
    /// The angle of attack, or the angle of sideslip, which the rate turns the other way
    #[arg(long, value_enum, default_value = "alpha")]
    angle: Angle,
    /// Drift of the analog integrator, degrees per second
    #[arg(long, default_value_t = 0.05, value_name = "DEG/S")]
    drift: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Angle {
    /// Angle of attack
    Alpha,
    /// Angle of sideslip
    Beta,
}

/// One run of the loop.
#[derive(Clone, Copy, Debug)]
struct Case {
    omega_rad_s: f64,
    loop_: AlphaLoop,
    /// Angle at the start, rad.
    initial_rad: f64,
    /// Drift b of the redundant integrator, rad/s.
    drift_rad_s: f64,
    stop_s: f64,
}

/// What a run did, beside theory; roots in rad/s.
#[derive(Clone, Debug)]
struct Row {
    scheme: String,
    case: Case,
    measured: C64,
    /// The root of the monodromy matrix.
    exact: C64,
    /// By the first-order shift, without the correction's penalty.
    first_order: C64,
    continuous: C64,
    /// Whether the run's last third is below its first third.
    stable: bool,
    /// Greatest |z| of the monodromy matrix over one slow frame.
    spectral_radius: f64,
    /// Mean of α_d − α_a over the last third, rad.
    error_rad: f64,
    /// The angle at the slow samples, rad.
    record: Vec<f64>,
}

/// Second-order Adams–Bashforth integration of the digital angle.
#[derive(Clone, Copy)]
struct DigitalAngle {
    angle_rad: f64,
    last: Option<(f64, f64)>,
}

impl DigitalAngle {
    fn at(angle_rad: f64) -> DigitalAngle {
        DigitalAngle { angle_rad, last: None }
    }

    /// Advances to this sample with the derivatives of the two before it.
    fn advance(&mut self, period_s: f64) -> f64 {
        if let Some((f1, f2)) = self.last {
            self.angle_rad += period_s * (1.5 * f1 - 0.5 * f2);
        }
        self.angle_rad
    }

    /// Stores the derivative at this sample; the first stands for the one before it.
    fn store(&mut self, derivative: f64) {
        let before = self.last.map_or(derivative, |(f1, _)| f1);
        self.last = Some((derivative, before));
    }
}

/// The digital side.
struct Law {
    case: Case,
    force: table::Table,
    moment: table::Table,
    digital: Option<DigitalAngle>,
    last_error: f64,
    /// Angle and `α_d − α_a` at the slow samples, rad, up to where the angle left the tables.
    record: Vec<f64>,
    errors: Vec<f64>,
    left_table: bool,
}

/// A straight line through the origin.
fn line(slope: f64) -> Result<table::Table, Refusal> {
    let end = slope * TABLE_END_RAD;
    Ok(table::Table::new(vec![-TABLE_END_RAD, 0.0, TABLE_END_RAD], vec![-end, 0.0, end])?)
}

impl Law {
    fn step(&mut self, samples: &Samples, updates: &mut Updates) {
        let rate = samples.adc[0];
        match self.case.loop_.scheme {
            Scheme::Conventional => self.conventional(rate, updates),
            Scheme::Redundant { slow_frames, gain, delivery, correction } => {
                let angle = samples.adc[1];
                self.note_range(angle);
                updates.set_dac(0, self.moment.lookup(angle).value);
                updates.set_dac(1, self.force.lookup(angle).value);
                if samples.frame.is_multiple_of(u64::from(slow_frames)) {
                    let error = self.correction_error(rate, angle, delivery);
                    let over = match correction {
                        Correction::Spread => self.case.slow_s(),
                        Correction::Pulse => self.case.loop_.frame_s,
                    };
                    updates.set_dac(2, gain * error / over);
                } else if correction == Correction::Pulse {
                    updates.set_dac(2, 0.0);
                }
            }
        }
    }

    fn conventional(&mut self, rate: f64, updates: &mut Updates) {
        let AlphaLoop { rotation, frame_s, .. } = self.case.loop_;
        let digital = self.digital.get_or_insert(DigitalAngle::at(self.case.initial_rad));
        let angle = digital.advance(frame_s);
        digital.store(rotation.direction * rate + self.force.lookup(angle).value);
        updates.set_dac(0, self.moment.lookup(angle).value);
        self.note_range(angle);
        self.note(angle, 0.0);
    }

    fn correction_error(&mut self, rate: f64, angle: f64, delivery: Delivery) -> f64 {
        let digital = self.digital.get_or_insert(DigitalAngle::at(angle));
        let before = digital.angle_rad;
        let now = digital.advance(self.case.slow_s());
        digital.store(self.case.loop_.rotation.direction * rate + self.force.lookup(angle).value);
        let matched = now - angle;
        let error = match delivery {
            Delivery::Prompt => matched,
            Delivery::LateMatched => self.last_error,
            Delivery::LateUnmatched => before - angle,
        };
        self.last_error = matched;
        self.note(angle, matched);
        error
    }

    fn note_range(&mut self, angle: f64) {
        self.left_table |= angle.is_nan() || angle.abs() > TABLE_END_RAD;
    }

    fn note(&mut self, angle: f64, error: f64) {
        if !self.left_table {
            self.record.push(angle);
            self.errors.push(error);
        }
    }
}

impl Case {
    fn new(omega_rad_s: f64, scheme: Scheme, frame_s: f64, latency_s: f64) -> Case {
        let rotation = Rotation::standard(omega_rad_s);
        let loop_ = AlphaLoop { rotation, scheme, frame_s, latency_s };
        Case { omega_rad_s, loop_, initial_rad: 1e-3, drift_rad_s: 0.0, stop_s: 20.0 }
    }

    /// The same from so small an angle that an unstable loop stays within the tables for 60 slow
    /// samples, enough to identify it. The loop is linear there: its roots do not depend on the start.
    fn within_tables(mut self) -> Result<Case, LabError> {
        let growth = self.loop_.spectral_radius()?.max(1.0);
        self.initial_rad = self.initial_rad.min(1e-2 * libm::pow(growth, -60.0));
        Ok(self)
    }

    /// T_s, s.
    fn slow_s(&self) -> f64 {
        self.loop_.frame_s * f64::from(self.loop_.scheme.slow_frames())
    }

    fn run(&self, machine: &mut impl Machine) -> Result<Row, LabError> {
        let AlphaLoop { rotation: r, scheme, frame_s, latency_s } = self.loop_;
        let slow = scheme.slow_frames();
        require("the number of fast frames", f64::from(slow), slow >= 1, "at least 1")?;
        let mut params = vec![("damping", r.rate_damping)];
        let patch = match scheme {
            Scheme::Conventional => "lab/alpha-conventional.toml",
            Scheme::Redundant { .. } => {
                params.extend([
                    ("direction", r.direction),
                    ("initial", self.initial_rad),
                    ("drift", self.drift_rad_s),
                ]);
                "lab/alpha-redundant.toml"
            }
        };
        let plan = RunPlan { params, ..RunPlan::new(patch, frame_s, latency_s, self.stop_s)? };
        let mut law = Law {
            case: *self,
            force: line(-r.force_slope)?,
            moment: line(-r.direction * r.moment_slope)?,
            digital: None,
            last_error: 0.0,
            record: Vec::new(),
            errors: Vec::new(),
            left_table: false,
        };
        machine.run(&plan, &mut |samples, updates| law.step(samples, updates))?;

        let continuous = r.continuous_root();
        // A drift adds a constant; differences drop it and keep every other mode.
        let differences: Vec<f64> = law.record.windows(2).map(|w| w[1] - w[0]).collect();
        let third = differences.len() / 3;
        let peak = |part: &[f64]| part.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let tail = &law.errors[law.errors.len() - law.errors.len() / 3..];
        Ok(Row {
            scheme: match scheme {
                Scheme::Conventional => "conventional".to_owned(),
                Scheme::Redundant { gain, .. } => format!("redundant, K = {gain}"),
            },
            case: *self,
            measured: identify::oscillatory_pole(&differences, self.slow_s(), 1e-9, continuous)?,
            exact: self.loop_.exact_root()?,
            first_order: self.loop_.first_order_root(),
            continuous,
            stable: !law.left_table
                && peak(&differences[differences.len() - third..]) < peak(&differences[..third]),
            spectral_radius: self.loop_.spectral_radius()?,
            error_rad: tail.iter().sum::<f64>() / tail.len().max(1) as f64,
            record: law.record,
        })
    }
}

impl Row {
    fn stable_cell(&self) -> Cell {
        if self.stable { "stable" } else { "unstable" }.into()
    }

    fn as_foretold(&self) -> bool {
        self.stable == (self.spectral_radius < 1.0)
    }
}

impl Alpha {
    /// With `fast` frames in one slow period and a correction gain.
    fn redundant(&self, slow_frames: u32, gain: f64) -> Scheme {
        let (delivery, correction) = (self.delivery, self.correction);
        Scheme::Redundant { slow_frames, gain, delivery, correction }
    }

    fn schemes(&self) -> Vec<Scheme> {
        let redundant = self.gain.iter().map(|k| self.redundant(self.fast, *k));
        std::iter::once(Scheme::Conventional).chain(redundant).collect()
    }

    fn case(&self, omega: f64, scheme: Scheme, slow_s: f64) -> Result<Case, LabError> {
        let frame_s = slow_s / f64::from(scheme.slow_frames());
        let mut case = Case::new(omega, scheme, frame_s, self.latency * frame_s);
        if self.angle == Angle::Beta {
            case.loop_.rotation.direction = -1.0;
        }
        // Enough slow samples for the slowest sweep.
        case.stop_s = case.stop_s.max(60.0 * slow_s);
        case.within_tables()
    }
}

impl Experiment for Alpha {
    const NAME: &'static str = "alpha";
    const TITLE: &'static str = "Angle of attack: conventional sampling and redundant integrators";
    const LEAD: &'static str = "The paper's figure 1 in numbers. A redundant analog integrator gives \
        the tables an angle that is late by a fast frame only; the digital angle corrects it slowly, \
        at a price.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        if self.fast == 0 {
            return Err(Failure::input("--fast must be at least 1"));
        }
        outcome.set("slow", self.slow.to_string());
        outcome.set("fast", i64::from(self.fast));
        outcome.set("latency-frames", self.latency);
        let slow = self.slow.secs();
        let cases = self.schemes().into_iter().flat_map(|s| self.omega.iter().map(move |w| (s, w)));
        let rows = bench
            .each(cases, |bench, (scheme, omega)| self.case(*omega, scheme, slow)?.run(bench))?;
        let pairs: Vec<_> = rows.iter().map(|r| (r.measured, r.exact)).collect();
        check_roots(outcome, "the monodromy matrix", &pairs);
        outcome.check(
            "stability",
            "a run decays exactly where the monodromy matrix has its roots inside the unit circle",
            rows.iter().all(Row::as_foretold),
        );
        let columns = [
            Column::new("scheme", "", |r: &Row| r.scheme.as_str().into()),
            Column::new("omega", "rad/s", |r| r.case.omega_rad_s.into()),
            Column::of("zeta measured", "", 6, |r| damping_ratio(r.measured).into()),
            Column::of("zeta exact", "", 6, |r| damping_ratio(r.exact).into()),
            Column::new("zeta first order", "", |r| damping_ratio(r.first_order).into()),
            Column::new("zeta continuous", "", |r| damping_ratio(r.continuous).into()),
            Column::of("omega measured", "rad/s", 6, |r| r.measured.modulus().into()),
            Column::of("omega exact", "rad/s", 6, |r| r.exact.modulus().into()),
            Column::new("run", "", Row::stable_cell),
            Column::of("greatest |z|", "", 5, |r| r.spectral_radius.into()),
        ];
        outcome.section("Numbers").table(
            "alpha",
            "The root nearest to the continuous loop's, from runs and from the monodromy matrix; the greatest |z| is that of all roots, those of the correction included.",
            Table::of(&columns, &rows),
        );
        if let Some(omega) = self.omega.last() {
            let last = rows.iter().filter(|r| r.case.omega_rad_s == *omega);
            outcome.section("Figures").chart(
                "histories",
                "The same loop from the same displacement; what differs is how the angle reaches the tables.",
                &histories(last, *omega),
            );
            self.damping(bench, outcome, *omega)?;
            self.stable_region(bench, outcome, *omega)?;
        }
        self.drifts(bench, outcome)?;
        Ok(())
    }
}

/// α over its start against time; a record that grows is drawn up to four times its start.
fn histories<'r>(rows: impl Iterator<Item = &'r Row>, omega: f64) -> LineChart {
    let series = rows.map(|row| {
        let at = |(n, a): (usize, &f64)| (n as f64 * row.case.slow_s(), a / row.case.initial_rad);
        let shown = row.record.iter().enumerate().map(at);
        Series::of(row.scheme.as_str(), shown.take_while(|(t, y)| *t <= 6.0 && y.abs() <= 4.0))
    });
    LineChart::new(
        format!("Angle after a displacement, ω = {omega} rad/s"),
        Axis::new("time", "s"),
        Axis::new("angle / angle at the start", ""),
        series.collect(),
    )
}

impl Alpha {
    /// Damping over slow periods, for each scheme.
    fn damping(
        &self,
        bench: &mut Bench<'_, '_>,
        outcome: &mut Outcome,
        omega: f64,
    ) -> Result<(), LabError> {
        let compared = bench.each(self.schemes(), |bench, scheme| {
            let theory = (2..=POINTS).filter_map(|i| {
                let slow = 0.2 * f64::from(i) / f64::from(POINTS);
                let root = self.case(omega, scheme, slow).ok()?.loop_.exact_root().ok()?;
                Some((slow * 1e3, damping_ratio(root)))
            });
            let mut all = Compared { theory: theory.unzip(), ..Compared::default() };
            for slow in [0.02, 0.05, 0.1, 0.15, 0.2] {
                let row = self.case(omega, scheme, slow)?.run(bench)?;
                all.measured.0.push(slow * 1e3);
                all.measured.1.push(damping_ratio(row.measured));
                all.name = row.scheme;
            }
            Ok::<_, LabError>(all)
        })?;
        let title = format!("Damping of the loop of {omega} rad/s");
        let axis = Axis::new("slow period", "ms");
        let chart = measured_vs_theory(&title, axis, damping_axis(), &compared);
        let caption = "Lines: monodromy matrix. Markers: runs on the machine.";
        outcome.section("Figures").chart("damping", caption, &chart.limit(0.0, "stability"));
        Ok(())
    }

    /// Where the loop is stable: the map over slow and fast periods.
    fn stable_region(
        &self,
        bench: &mut Bench<'_, '_>,
        outcome: &mut Outcome,
        omega: f64,
    ) -> Result<(), LabError> {
        let gain =
            if self.gain.contains(&0.2) { 0.2 } else { self.gain.first().copied().unwrap_or(0.2) };
        let slow_axis = [0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2];
        let redundant = [1, 2, 5, 10, 20].map(|fast| self.redundant(fast, gain));
        let schemes: Vec<Scheme> = std::iter::once(Scheme::Conventional).chain(redundant).collect();
        let cases = schemes.iter().flat_map(|s| slow_axis.map(|slow| (*s, slow)));
        let rows = bench.each(cases, |bench, (scheme, slow)| {
            let row = self.case(omega, scheme, slow)?.run(bench)?;
            let scheme = match scheme {
                Scheme::Redundant { slow_frames, .. } => {
                    format!("redundant, {slow_frames} fast frames")
                }
                Scheme::Conventional => row.scheme,
            };
            Ok::<_, LabError>((slow, Row { scheme, ..row }))
        })?;
        outcome.check(
            "stable-region",
            "the stable region of the sweep is that of the monodromy matrix",
            rows.iter().all(|(_, r)| r.as_foretold()),
        );
        let columns = [
            Column::new("scheme", "", |(_, r): &(f64, Row)| r.scheme.as_str().into()),
            Column::new("slow period", "s", |(slow, _)| (*slow).into()),
            Column::new("fast period", "s", |(_, r)| r.case.loop_.frame_s.into()),
            Column::new("run", "", |(_, r)| r.stable_cell()),
            Column::of("greatest |z|", "", 5, |(_, r)| r.spectral_radius.into()),
        ];
        let caption = format!("Where the loop of {omega} rad/s is stable, K = {gain}.");
        outcome.section("Numbers").table("stability", caption, Table::of(&columns, &rows));
        let cell = |(_, r): &(f64, Row)| HeatCell {
            violated: !r.stable,
            ..HeatCell::new(damping_ratio(r.measured))
        };
        let by_scheme = rows.chunks(slow_axis.len());
        let map = heat_map(&HeatMap {
            quantity: "damping ratio ζ".to_owned(),
            corner: "scheme against slow period".to_owned(),
            rows: by_scheme.clone().map(|of| of[0].1.scheme.clone()).collect(),
            columns: slow_axis.iter().map(|s| format!("{} ms", s * 1e3)).collect(),
            cells: by_scheme.map(|of| of.iter().map(cell).collect()).collect(),
            scale: None,
        });
        let caption = format!("Damping ratio measured at K = {gain}; cells with a mark diverged.");
        outcome.section("Figures").figure(Figure::new("stability-map", caption, map));
        Ok(())
    }

    /// What a drift of the analog integrator leaves.
    fn drifts(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), LabError> {
        let drift_rad_s = self.drift.to_radians();
        let slow_s = self.slow.secs();
        let rows = bench.each(self.gain.iter().filter(|k| **k > 0.0), |bench, gain| {
            // A loop of 2 rad/s, which every K of interest leaves stable.
            let case = self.case(2.0, self.redundant(self.fast, *gain), slow_s)?;
            let row = Case { drift_rad_s, stop_s: 120.0, ..case }.run(bench)?;
            let bound = drift_error(drift_rad_s, slow_s, *gain);
            let degrees = [row.error_rad.abs().to_degrees(), bound.to_degrees(), self.drift * 49.0];
            Ok::<_, LabError>((*gain, degrees))
        })?;
        let columns = [
            Column::new("K", "", |r: &(f64, [f64; 3])| r.0.into()),
            Column::of("error left, measured", "deg", 5, |r| r.1[0].into()),
            Column::of("drift * slow period / K", "deg", 5, |r| r.1[1].into()),
            Column::new("uncorrected after 49 s", "deg", |r| r.1[2].into()),
        ];
        let caption =
            format!("Error that a drift of {} deg/s of the analog integrator leaves.", self.drift);
        outcome.section("Numbers").table("drift", caption, Table::of(&columns, &rows));
        Ok(())
    }
}
