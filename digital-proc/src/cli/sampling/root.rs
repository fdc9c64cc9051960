//! A second-order loop closed through the digital side, with and without compensation.

use super::{
    Measure,
    curve::{self, ROOT_LIMIT},
    outcome::Outcome,
};
use crate::lab::{
    bench::Bench,
    feedback::{Compensation, RootSetting},
    theory::damping_ratio,
};
use desk::failure::Failure;
use desk::{
    progress::Progress,
    report::{
        Heading, Table,
        plot::{Axis, Compared, measured_vs_theory},
    },
};
use interface::Tick;

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
    #[arg(long, value_delimiter = ',', default_value = "0,0.5,1", value_name = "FRAMES")]
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

    /// Damping by the exact eigenvalues against the frame, ms.
    fn curve(
        &self,
        longest_s: f64,
        latency: f64,
        compensation: Compensation,
    ) -> (Vec<f64>, Vec<f64>) {
        (1..=curve::POINTS)
            .filter_map(|i| {
                let frame = longest_s * f64::from(i) / f64::from(curve::POINTS);
                let theory = self.setting(frame, latency, compensation).theory();
                Some((frame * 1e3, damping_ratio(theory.exact_root().ok()?)))
            })
            .unzip()
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
        let zeta = rows.iter().map(|r| (r.zeta_measured - r.zeta_exact).abs()).fold(0.0, f64::max);
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
            .zip(curve::ends(&self.latency))
        {
            let compared = Compensation::ALL.map(|compensation| Compared {
                name: compensation_name(compensation).to_owned(),
                theory: self.curve(longest, latency, compensation),
                measured: rows
                    .iter()
                    .filter(|r| {
                        r.setting.compensation == compensation
                            && r.setting.latency_frames == latency
                    })
                    .map(|r| (r.setting.frame_s * 1e3, r.zeta_measured))
                    .unzip(),
            });
            let title = format!("Damping at a latency of {latency} frames");
            let chart = measured_vs_theory(
                &title,
                Axis::new("frame", "ms"),
                Axis::new("damping ratio ζ", ""),
                &compared,
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
