//! A second-order loop closed through the digital side: what is left of its damping, and what
//! each compensation gives back.

use super::{
    feedback::{check_roots, sampled_root},
    theory::feedback_loop::FeedbackLoop,
    *,
};

/// A second-order loop closed through the digital side: damping left, and compensations
///
/// A second-order loop x'' + 2 zeta omega0 x' + omega0^2 x = 0 whose stiffness goes through the
/// digital side.
///
/// Its damping falls by about omega0 (T/2 + latency)/2. Damping and frequency from the run stand
/// beside the exact eigenvalues of the sampled-data system and Howe's first-order shift, without
/// and with each compensation: half-frame prediction, an extrapolating DAC, and a lead of T/2 + latency.
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
    #[arg(long, value_delimiter = ',', default_value = "0,0.5,1", value_name = "FRAMES")]
    latency: Vec<f64>,
}

interface::named! {
    /// What is done against the delay, in the order of the tables.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Compensation, name {
        /// Zero-order hold, no prediction.
        None "none"
        /// `r + ½(r_n − r_{n−1})` before a zero-order hold.
        HalfFrame "half-frame prediction"
        /// First-order extrapolating DAC.
        ExtrapolatingDac "extrapolating DAC"
        /// Lead of ½ + τ/T frames before a zero-order hold.
        Lead "lead"
    }
}

#[derive(Clone, Copy, Debug)]
struct Case {
    omega0_rad_s: f64,
    zeta: f64,
    compensation: Compensation,
    latency_frames: f64,
    frame_s: f64,
}

/// Roots, rad/s.
#[derive(Debug)]
struct Row {
    case: Case,
    measured: C64,
    exact: C64,
    first_order: C64,
}

impl Case {
    fn theory(&self) -> FeedbackLoop {
        let (lead, hold) = match self.compensation {
            Compensation::None => (0.0, Hold::ZeroOrder),
            Compensation::HalfFrame => (0.5, Hold::ZeroOrder),
            Compensation::ExtrapolatingDac => (0.0, Hold::Extrapolating),
            Compensation::Lead => (0.5 + self.latency_frames, Hold::ZeroOrder),
        };
        let latency_s = self.latency_frames * self.frame_s;
        let plant = (self.omega0_rad_s, self.zeta);
        FeedbackLoop::second_order(plant, lead, hold, self.frame_s, latency_s)
    }

    /// Four cycles (at least 80 frames) of the patch.
    fn run(&self, machine: &mut impl Machine) -> Result<Row, LabError> {
        let (omega0, zeta) = (self.omega0_rad_s, self.zeta);
        require("the natural frequency", omega0, omega0 > 0.0, "> 0 rad/s")?;
        require("the damping", zeta, (0.0..1.0).contains(&zeta), "0 to below 1")?;
        require("the frame", self.frame_s, self.frame_s > 0.0, "> 0 s")?;
        require_latency(self.latency_frames)?;
        let theory = self.theory();
        let exact = theory.exact_root()?;
        let patch = ("lab/root.toml", vec![("wn", omega0), ("zeta", zeta)]);
        let frames = (4.0 * (TAU / omega0) / self.frame_s).ceil().max(80.0);
        let per_cycle = TAU / (exact.im.abs() * self.frame_s);
        Ok(Row {
            case: *self,
            measured: sampled_root(machine, &theory, patch, frames, per_cycle)?,
            exact,
            first_order: theory.first_order_root()?,
        })
    }
}

impl Root {
    fn case(&self, compensation: Compensation, latency_frames: f64, frame_s: f64) -> Case {
        let (omega0_rad_s, zeta) = (self.omega, self.zeta);
        Case { omega0_rad_s, zeta, compensation, latency_frames, frame_s }
    }

    fn cases(&self) -> impl Iterator<Item = Case> {
        Compensation::ALL.into_iter().flat_map(move |compensation| {
            self.latency.iter().flat_map(move |latency| {
                self.frame.iter().map(move |t| self.case(compensation, *latency, t.secs()))
            })
        })
    }
}

impl Experiment for Root {
    const NAME: &'static str = "root";
    const TITLE: &'static str = "Root of a sampled second-order loop";
    const LEAD: &'static str = "Damping and frequency of a loop whose stiffness passes the digital \
        side, from runs on the machine, from the exact sampled-data eigenvalues and by Howe's \
        first-order shift.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("omega-rad-s", self.omega);
        outcome.set("zeta", self.zeta);
        let rows = bench.each(self.cases(), |bench, case| case.run(bench))?;
        let pairs: Vec<_> = rows.iter().map(|r| (r.measured, r.exact)).collect();
        check_roots(outcome, "the exact eigenvalues", &pairs);
        let columns = [
            Column::new("compensation", "", |r: &Row| r.case.compensation.name().into()),
            Column::new("latency", "frames", |r| r.case.latency_frames.into()),
            Column::new("frame", "s", |r| r.case.frame_s.into()),
            Column::of("zeta measured", "", 6, |r| damping_ratio(r.measured).into()),
            Column::of("zeta exact", "", 6, |r| damping_ratio(r.exact).into()),
            Column::new("zeta first order", "", |r| damping_ratio(r.first_order).into()),
            Column::of("omega measured", "rad/s", 6, |r| r.measured.modulus().into()),
            Column::of("omega exact", "rad/s", 6, |r| r.exact.modulus().into()),
            Column::new("omega first order", "rad/s", |r| r.first_order.modulus().into()),
        ];
        let caption = "Damping ratio and frequency.";
        outcome.section("Numbers").table("root", caption, Table::of(&columns, &rows));
        let longest = self.frame.iter().map(|f| f.secs()).fold(0.0, f64::max);
        let ids = ["damping-first-latency", "damping-last-latency"];
        for (id, latency) in ids.into_iter().zip(ends(&self.latency)) {
            let compared = Compensation::ALL.map(|of| Compared {
                name: of.name().to_owned(),
                theory: (1..=POINTS)
                    .filter_map(|i| {
                        let frame_s = longest * f64::from(i) / f64::from(POINTS);
                        let root = self.case(of, latency, frame_s).theory().exact_root().ok()?;
                        Some((frame_s * 1e3, damping_ratio(root)))
                    })
                    .unzip(),
                measured: rows
                    .iter()
                    .filter(|r| r.case.compensation == of && r.case.latency_frames == latency)
                    .map(|r| (r.case.frame_s * 1e3, damping_ratio(r.measured)))
                    .unzip(),
            });
            let title = format!("Damping at a latency of {latency} frames");
            let chart =
                measured_vs_theory(&title, Axis::new("frame", "ms"), damping_axis(), &compared)
                    .limit(self.zeta, "continuous loop")
                    .limit(0.0, "stability");
            let caption = "Lines: exact sampled-data eigenvalues. Markers: runs on the machine.";
            outcome.section("Figures").chart(id, caption, &chart);
        }
        Ok(())
    }
}
