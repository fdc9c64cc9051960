//! The circle test: how an undamped oscillator grows by nothing but the interface.

use super::{
    feedback::sampled_root,
    theory::{feedback_loop::FeedbackLoop, growth_per_cycle},
    *,
};
use std::f64::consts::PI;

/// Measured growth and exact map may differ by this, relative.
const LIMIT: f64 = 1e-6;

/// Two integrators closed through the digital side: growth of the amplitude per cycle
///
/// Two integrators whose loop is closed through the digital side.
///
/// Without an interface they draw a circle for ever. What is sampled, held and delayed turns it
/// into a spiral: the growth of the amplitude over one cycle is compared with the exact discrete
/// map and with the first-order formula exp(pi omega tau_e), tau_e = latency + delay of the hold.
#[derive(clap::Args)]
pub struct Circle {
    /// Samples per cycle, at least 6
    #[arg(long, value_delimiter = ',', default_value = "10,20,40,100,200,400", value_name = "N")]
    samples_per_cycle: Vec<u32>,
    /// Latencies in frames, 0 to 1
    #[arg(long, value_delimiter = ',', default_value = "0,0.25,0.5,1", value_name = "FRAMES")]
    latency: Vec<f64>,
    /// Reconstruction of the DAC
    #[arg(long, value_delimiter = ',', value_enum, value_name = "HOLD",
          default_values_t = Hold::ALL)]
    hold: Vec<Hold>,
    /// Frame period; only its product with the frequency matters
    #[arg(long, default_value = "10ms", value_name = "TIME")]
    frame: Tick,
}

/// One setting; samples per cycle need be whole in a run only.
#[derive(Clone, Copy, Debug)]
struct Case {
    hold: Hold,
    latency_frames: f64,
    samples_per_cycle: f64,
    frame_s: f64,
}

/// Growth of the amplitude over one cycle.
#[derive(Debug)]
struct Row {
    case: Case,
    measured: f64,
    exact: f64,
    first_order: f64,
}

impl Case {
    fn omega_rad_s(&self) -> f64 {
        TAU / (self.samples_per_cycle * self.frame_s)
    }

    fn theory(&self) -> FeedbackLoop {
        let latency_s = self.latency_frames * self.frame_s;
        FeedbackLoop::circle(self.omega_rad_s(), self.hold, self.frame_s, latency_s)
    }

    /// Eight cycles of the patch.
    fn run(&self, machine: &mut impl Machine) -> Result<Row, LabError> {
        let per_cycle = self.samples_per_cycle;
        require("samples per cycle", per_cycle, per_cycle >= 6.0, "at least 6")?;
        require_latency(self.latency_frames)?;
        let theory = self.theory();
        let patch = ("lab/circle.toml", vec![("w", self.omega_rad_s())]);
        let root = sampled_root(machine, &theory, patch, 8.0 * per_cycle, per_cycle)?;
        Ok(Row {
            case: *self,
            measured: growth_per_cycle(root),
            exact: growth_per_cycle(theory.exact_root()?),
            first_order: libm::exp(PI * self.omega_rad_s() * theory.effective_delay_s()),
        })
    }
}

impl Row {
    fn error_exact(&self) -> f64 {
        self.measured / self.exact - 1.0
    }

    fn error_first_order(&self) -> f64 {
        self.first_order / self.exact - 1.0
    }
}

impl Circle {
    fn cases(&self) -> impl Iterator<Item = Case> {
        let frame_s = self.frame.secs();
        self.hold.iter().flat_map(move |hold| {
            self.latency.iter().flat_map(move |latency| {
                self.samples_per_cycle.iter().map(move |n| Case {
                    hold: *hold,
                    latency_frames: *latency,
                    samples_per_cycle: f64::from(*n),
                    frame_s,
                })
            })
        })
    }

    /// |growth − 1| of the exact map against samples per cycle.
    fn curve(&self, hold: Hold, latency_frames: f64) -> (Vec<f64>, Vec<f64>) {
        let least = self.samples_per_cycle.iter().min().copied().unwrap_or(10);
        let most = self.samples_per_cycle.iter().max().copied().unwrap_or(400);
        ratios(f64::from(least), f64::from(most), POINTS)
            .filter_map(|samples_per_cycle| {
                let frame_s = self.frame.secs();
                let case = Case { hold, latency_frames, samples_per_cycle, frame_s };
                let growth = growth_per_cycle(case.theory().exact_root().ok()?);
                Some((samples_per_cycle, (growth - 1.0).abs()))
            })
            .unzip()
    }
}

impl Experiment for Circle {
    const NAME: &'static str = "circle";
    const TITLE: &'static str = "Circle test";
    const LEAD: &'static str = "Two integrators closed through ADC, digital side and DAC. Without an \
        interface the amplitude never changes; its growth over one cycle is what the interface does.";

    fn measure(&self, bench: &mut Bench<'_, '_>, outcome: &mut Outcome) -> Result<(), Failure> {
        outcome.set("frame", self.frame.to_string());
        let rows = bench.each(self.cases(), |bench, case| case.run(bench))?;
        let off = worst(rows.iter().map(Row::error_exact));
        outcome.check(
            "growth",
            format!("growth equals the exact discrete map within {LIMIT:e}: worst {off:.1e}, relative, of {} cases", rows.len()),
            off < LIMIT,
        );
        let columns = [
            Column::new("hold", "", |r: &Row| r.case.hold.name().into()),
            Column::new("latency", "frames", |r| r.case.latency_frames.into()),
            Column::new("samples per cycle", "", |r| r.case.samples_per_cycle.into()),
            Column::of("growth measured", "", 9, |r| r.measured.into()),
            Column::of("growth exact", "", 9, |r| r.exact.into()),
            Column::of("growth first order", "", 6, |r| r.first_order.into()),
            Column::of("measured/exact - 1", "", 2, |r| r.error_exact().into()),
            Column::of("first order/exact - 1", "", 2, |r| r.error_first_order().into()),
        ];
        let caption = "Growth of the amplitude over one cycle.";
        outcome.section("Numbers").table("circle", caption, Table::of(&columns, &rows));

        let of = |hold: Hold, latency: f64| {
            let here = move |c: &Case| c.hold == hold && c.latency_frames == latency;
            rows.iter().filter(move |r| here(&r.case))
        };
        let axis = || Axis::new("samples per cycle", "").log();
        let latencies = ends(&self.latency);
        let ids = ["growth-first-latency", "growth-last-latency"];
        for (id, latency) in ids.into_iter().zip(&latencies) {
            let compared: Vec<Compared> = self
                .hold
                .iter()
                .map(|hold| Compared {
                    name: hold.name().to_owned(),
                    theory: self.curve(*hold, *latency),
                    measured: of(*hold, *latency)
                        .map(|r| (r.case.samples_per_cycle, (r.measured - 1.0).abs()))
                        .unzip(),
                })
                .collect();
            let chart = measured_vs_theory(
                &format!("Growth per cycle at a latency of {latency} frames"),
                axis(),
                Axis::new("|growth per cycle − 1|", "").log(),
                &compared,
            );
            let caption = "Lines: exact discrete map. Markers: runs on the machine.";
            outcome.section("Figures").chart(id, caption, &chart);
        }
        let errors = self.hold.iter().flat_map(|hold| {
            latencies.iter().map(|latency| {
                let points = of(*hold, *latency)
                    .map(|r| (r.case.samples_per_cycle, r.error_first_order().abs()));
                Series::of(format!("{}, {latency} frames", hold.name()), points)
            })
        });
        let chart = LineChart::new(
            "Error of the first-order formula",
            axis(),
            Axis::new("|first order/exact − 1|", "").log(),
            errors.collect(),
        );
        let caption = "What the first-order formula exp(πωτ_e) is wrong by: it is a formula for many samples a cycle.";
        outcome.section("Figures").chart("first-order-error", caption, &chart);
        Ok(())
    }
}
