//! `digital-proc gyro-location`: where the rate gyro may stand, and the bending filter's margins.

use super::{
    Context,
    study::{PointsArgs, StudyArgs},
};
use crate::study::{
    gyro_location::{outcome::outcome, run::run},
    short_period::{machine::Bench, places::locate_all},
};
use desk::failure::Failure;

/// Stations that are looked at unless others are asked for, m apart.
const APART_M: f64 = 0.5;

/// Damping of the bending modes against the station of the rate gyro, and the margins of the
/// bending filter.
#[derive(clap::Args)]
pub struct GyroLocation {
    /// Stations of the rate gyro, m from the nozzle exit [default: every half metre of the mode's table]
    #[arg(long, value_delimiter = ',', value_name = "M")]
    stations: Vec<f64>,
    #[command(flatten)]
    points: PointsArgs,
    #[command(flatten)]
    study: StudyArgs,
}

impl GyroLocation {
    pub fn execute(self, context: &Context) -> Result<(), Failure> {
        let vehicle = self.study.vehicle()?;
        let study = self.points.load(&vehicle)?;
        let [first, last] = vehicle.gyro_stations_m();
        let mut stations = self.stations.clone();
        if stations.is_empty() {
            let count = ((last - first) / APART_M).floor() as u32;
            stations = (0..=count).map(|i| first + APART_M * f64::from(i)).collect();
            // The candidates themselves: there the machine's own linear model stands beside.
            stations.extend(&vehicle.data().bending.alternative_gyro_x_m);
        }
        let known = |s: f64| s.is_finite() && vehicle.gyro_slope_at_station(s).is_some();
        if let Some(bad) = stations.iter().find(|s| !known(**s)) {
            return Err(Failure::input(format!(
                "--stations {bad}: the bending mode is known from {first} to {last} m"
            )));
        }
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        let slices = locate_all(&study.points, study.source(), &vehicle)
            .map_err(crate::study::fault::StudyFault::from)?;
        let profile = self.study.profile()?;
        let mut begun = self.study.begin("gyro-location", &vehicle, &profile)?;
        begun.set("study-file", study.file.as_str());
        let survey =
            self.study.on_machine(context, (slices.len(), "points"), |console, progress| {
                Bench::pitch(console, &profile)?;
                begun.patch("pitch-loop.toml", console.patch_hash());
                run(console, &vehicle, &slices, &stations, progress)
            })?;
        outcome(&survey, &vehicle).publish(&begun, self.study.machine.json)
    }
}
