//! What the partition does to the flight.

use super::{Measure, outcome::Outcome};
use crate::{
    cli::{Failure, vehicle_args::VehicleArgs},
    lab::{
        bench::Bench,
        flight::{FlightRow, Partition, row},
    },
};
use desk::{
    progress::Progress,
    report::{
        Cell, Heading, Table,
        plot::{Axis, Draw, LineChart, Series},
    },
};
use interface::Tick;
use vehicle::{flight_mode::FlightMode, reference::FlightCase};

/// Settings of [`super::Experiment::Flight`], whose text is the help.
#[derive(clap::Args)]
pub struct Flight {
    /// Frame periods
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "5ms,10ms,20ms,50ms,100ms,150ms,200ms",
        value_name = "TIME"
    )]
    frame: Vec<Tick>,
    /// End of each flight, after 25 s
    #[arg(long, default_value = "40s", value_name = "TIME")]
    until: Tick,
    #[command(flatten)]
    vehicle: VehicleArgs,
}

impl Measure for Flight {
    fn measure(&self, bench: &mut Bench<'_, '_>) -> Result<Outcome, Failure> {
        let vehicle = self.vehicle.load()?;
        if self.until < Tick(25_000_000_000) {
            return Err(Failure::input(
                "--until must be at least 25s, the step of the command comes at 20 s",
            ));
        }
        if let Some(bad) = self.frame.iter().find(|f| f.0 < 1_000_000 || f.0 > 500_000_000) {
            return Err(Failure::input(format!("--frame {bad} is not between 1ms and 500ms")));
        }
        let case =
            FlightCase::design(&vehicle, FlightMode::Normal.script()).map_err(Failure::input)?;
        let limit = vehicle.data().limits.q_alpha_padeg;
        let mut outcome = Outcome::new(
            "flight",
            "long-period.toml",
            "The flight against the frame period",
            "The same stage in the same wind on three machines: what is sampled decides what frame \
             period the flight can bear.",
        );
        outcome.set("until", self.until.to_string());
        let mut table = Table::new(vec![
            Heading::new("machine", ""),
            Heading::new("frame", "ms"),
            Heading::new("zeta", "").digits(3),
            Heading::new("omega", "rad/s").digits(3),
            Heading::new("greatest Q alpha", "kPa deg").digits(4),
            Heading::new("of the limit", "%").digits(3),
            Heading::new("greatest attitude error", "deg").digits(3),
            Heading::new("greatest roll", "deg").digits(3),
            Heading::new("flight", ""),
        ]);
        let mut rows: Vec<FlightRow> = Vec::new();
        let mut progress = Progress::new((3 * self.frame.len()) as u64, "machines");
        for partition in Partition::ALL {
            for frame in &self.frame {
                let r = row(bench.console(), &vehicle, &case, partition, (*frame, self.until))?;
                let number = |v: Option<f64>| v.map_or_else(|| Cell::from("-"), Cell::from);
                table.row([
                    partition.name().into(),
                    (1e3 * r.frame_s).into(),
                    number(r.zeta),
                    number(r.omega_rad_s),
                    (1e-3 * r.max_q_alpha_padeg).into(),
                    (100.0 * r.max_q_alpha_padeg / limit).into(),
                    r.worst_error_deg.into(),
                    r.worst_roll_deg.into(),
                    if r.lost { format!("lost at {:.1} s", r.end_s).into() } else { "held".into() },
                ]);
                rows.push(r);
                progress.at(rows.len() as u64);
            }
        }
        progress.done();
        outcome.table("flight", "Three machines over the frame period.", table);
        let series = |value: &dyn Fn(&FlightRow) -> f64| -> Vec<Series> {
            Partition::ALL
                .iter()
                .map(|p| {
                    let (x, y): (Vec<f64>, Vec<f64>) = rows
                        .iter()
                        .filter(|r| r.partition == *p)
                        .map(|r| (1e3 * r.frame_s, value(r)))
                        .unzip();
                    Series::line(p.name(), &x, &y).draw(Draw::LineAndMarkers)
                })
                .collect()
        };
        let frame_axis = || Axis::new("frame period", "ms").log();
        outcome.chart(
            "damping",
            "Damping of the pitch loop at 20 s, from the answer to a small step of the command; a missing marker is an answer without an oscillation between 1 and 15 rad/s.",
            LineChart::new(
                "What may be digital",
                frame_axis(),
                Axis::new("damping ratio of the pitch loop ζ", ""),
                series(&|r| r.zeta.unwrap_or(f64::NAN)),
            )
            .limit(0.0, "stability"),
        );
        outcome.chart(
            "q-alpha",
            "Greatest |Qα| of the flight; a lost flight counts up to where it was lost.",
            LineChart::new(
                "Load indicator Qα",
                frame_axis(),
                Axis::new("greatest |Qα|", "kPa·°").log(),
                series(&|r| 1e-3 * r.max_q_alpha_padeg),
            )
            .limit(1e-3 * limit, "design limit"),
        );
        outcome.chart(
            "attitude-error",
            "Greatest distance of the pitch attitude from its command; a flight is lost at 20°.",
            LineChart::new(
                "Attitude error",
                frame_axis(),
                Axis::new("greatest |θ − θc|", "°").log(),
                series(&|r| r.worst_error_deg),
            ),
        );
        outcome.chart(
            "roll",
            "Greatest roll angle. The roll loop is the fastest of the three: sampled one frame late it oscillates long before the pitch loop is lost, within the limits of its tips, and takes their travel from pitch and yaw.",
            LineChart::new(
                "Roll",
                frame_axis(),
                Axis::new("greatest |φ|", "°").log(),
                series(&|r| r.worst_roll_deg),
            ),
        );
        Ok(outcome)
    }
}
