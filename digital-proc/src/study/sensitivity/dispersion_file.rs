//! The dispersion file: what is dispersed, by how much, and at which points.

use crate::study::short_period::{
    places::{PointEntry, locate_all},
    point::FrozenPoint,
    quantity::{QUANTITIES, Quantity},
    study_file::{Study, StudyError},
};
use desk::faults::{self, FileFault, FileFaults, Source, suggestion};
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;
use vehicle::{Vehicle, slice::SlicePoint};

/// Text of the shipped file.
pub const SHIPPED_TEXT: &str = include_str!("../../../data/dispersions.toml");
/// Name under which its faults would be reported.
pub const SHIPPED_NAME: &str = "digital-proc/data/dispersions.toml";

/// Most dispersions: the corners double with each.
pub const MOST: usize = 14;

/// Factors of a quantity lie within these. A dispersion is a tolerance; what is ten times as quick
/// or as slow is another vehicle, and what is thousands of times as stiff takes the machine hours.
pub const FACTORS: [f64; 2] = [0.1, 10.0];

/// A checked dispersion file.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispersions {
    /// File as named by the caller.
    pub file: String,
    /// Its text, for later faults.
    text: String,
    /// Points of the shipped study, in its order.
    pub points: Vec<PointEntry>,
    /// What is dispersed.
    pub all: Vec<Dispersion>,
}

/// One dispersion.
#[derive(Clone, Debug, PartialEq)]
pub struct Dispersion {
    /// What it is, for people.
    pub title: String,
    /// What it does.
    pub what: Dispersed,
}

/// What a dispersion does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dispersed {
    /// Multiplies a quantity of the frozen point.
    Factors(&'static Quantity, [f64; 2]),
    /// Moves the rate gyros, m from the nozzle exit.
    GyroStations([f64; 2]),
}

/// Lower or upper setting of a dispersion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The lower.
    Low,
    /// The upper.
    High,
}

impl Dispersion {
    /// Applies one setting to a point.
    pub fn apply(&self, vehicle: &Vehicle, point: &mut FrozenPoint, side: Side) {
        let of = |[low, high]: [f64; 2]| match side {
            Side::Low => low,
            Side::High => high,
        };
        match self.what {
            Dispersed::Factors(quantity, factors) => {
                let value = quantity.get(point) * of(factors);
                quantity.set(point, value);
            }
            Dispersed::GyroStations(stations) => {
                // What is not known stops the run; `check` refuses it before.
                let slope = vehicle.gyro_slope_at_station(of(stations));
                point.gyro_slope_pm = slope.unwrap_or(f64::NAN);
            }
        }
    }

    /// Title and settings, for a table.
    pub fn label(&self) -> String {
        match self.what {
            Dispersed::Factors(_, [low, high]) => {
                format!("{} × {low}–{high}", self.title)
            }
            Dispersed::GyroStations([low, high]) => format!("{} {low}–{high} m", self.title),
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawFile {
    points: Vec<Spanned<String>>,
    #[serde(default)]
    dispersion: Vec<Spanned<RawDispersion>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RawDispersion {
    title: String,
    quantity: Option<Spanned<String>>,
    low: Option<Spanned<f64>>,
    high: Option<Spanned<f64>>,
    stations_m: Option<Spanned<[f64; 2]>>,
}

impl Dispersions {
    /// The points on the vehicle's own flight.
    ///
    /// # Errors
    /// What the vehicle does not cover: points that its flight lacks, gyro stations off the
    /// table of its bending mode.
    pub fn locate(&self, vehicle: &Vehicle) -> Result<Vec<SlicePoint>, StudyError> {
        let [first, last] = vehicle.gyro_stations_m();
        let outside = self.all.iter().filter_map(|dispersion| {
            let Dispersed::GyroStations(stations) = dispersion.what else {
                return None;
            };
            let station =
                stations.into_iter().find(|s| vehicle.gyro_slope_at_station(*s).is_none())?;
            Some(FileFault {
                file: self.file.clone(),
                place: None,
                fault: format!("`{}`: a rate gyro at {station} m", dispersion.title),
                remedy: format!("the bending mode is known from {first} to {last} m"),
            })
        });
        FileFaults::unless(outside.collect(), ())?;
        locate_all(&self.points, Source { file: &self.file, text: &self.text }, vehicle)
    }

    /// The shipped file.
    ///
    /// # Errors
    /// None as shipped; a unit test reads it.
    pub fn shipped() -> Result<Dispersions, FileFaults> {
        Dispersions::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
    }

    /// Reads a user's file.
    ///
    /// # Errors
    /// Every fault found.
    pub fn load(path: &Path) -> Result<Dispersions, FileFaults> {
        faults::load(path, Dispersions::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    ///
    /// # Errors
    /// Every fault found.
    pub fn from_toml(file: &str, text: &str) -> Result<Dispersions, FileFaults> {
        let source = Source { file, text };
        let raw: RawFile = source.parse()?;
        let mut faults = Vec::new();
        let mut points = Vec::new();
        let catalogue = Study::shipped()?.points;
        let known = || catalogue.iter().map(|p| p.name.as_str());
        for name in &raw.points {
            if !known().any(|known| known == name.get_ref()) {
                faults.push(source.fault(
                    name.span(),
                    format!("no trajectory point `{}`", name.get_ref()),
                    suggestion(name.get_ref(), known()),
                ));
            }
        }
        for point in &catalogue {
            if let Some(name) = raw.points.iter().find(|name| *name.get_ref() == point.name) {
                points.push(PointEntry { span: name.span(), ..point.clone() });
            }
        }
        let mut all = Vec::new();
        for raw in &raw.dispersion {
            match dispersed(raw, &source) {
                Ok(what) => all.push(Dispersion { title: raw.get_ref().title.clone(), what }),
                Err(fault) => faults.push(fault),
            }
        }
        let count = raw.dispersion.len();
        if count == 0 || count > MOST || raw.points.is_empty() {
            faults.push(source.fault(
                0..0,
                format!("{count} dispersions at {} points", raw.points.len()),
                format!("give at least one point and 1 to {MOST} [[dispersion]]"),
            ));
        }
        let (file, text) = (file.to_owned(), text.to_owned());
        FileFaults::unless(faults, Dispersions { file, text, points, all })
    }
}

fn dispersed(raw: &Spanned<RawDispersion>, source: &Source<'_>) -> Result<Dispersed, FileFault> {
    let entry = raw.get_ref();
    match (&entry.quantity, &entry.low, &entry.high, &entry.stations_m) {
        (Some(name), Some(low), Some(high), None) => {
            let quantity = Quantity::find(name.get_ref()).ok_or_else(|| {
                source.fault(
                    name.span(),
                    format!("no quantity `{}`", name.get_ref()),
                    suggestion(name.get_ref(), QUANTITIES.iter().map(|q| q.name)),
                )
            })?;
            let [least, most] = FACTORS;
            for factor in [low, high] {
                // Not a number is no factor either.
                if !(least..=most).contains(factor.get_ref()) {
                    return Err(source.fault(
                        factor.span(),
                        format!("a factor of {}", factor.get_ref()),
                        format!("a dispersion is a factor of {least} to {most}"),
                    ));
                }
            }
            let (low, high) = (*low.get_ref(), *high.get_ref());
            if low < high {
                Ok(Dispersed::Factors(quantity, [low, high]))
            } else {
                Err(source.fault(
                    raw.span(),
                    format!("factors {low} and {high}"),
                    "give low < high".to_owned(),
                ))
            }
        }
        (None, None, None, Some(stations)) => {
            let [low, high] = *stations.get_ref();
            if low < high && low.is_finite() && high.is_finite() {
                Ok(Dispersed::GyroStations([low, high]))
            } else {
                Err(source.fault(
                    stations.span(),
                    format!("stations {low} and {high} m"),
                    "give two stations, the lower first".to_owned(),
                ))
            }
        }
        _ => Err(source.fault(
            raw.span(),
            format!("`{}` is not fully stated", entry.title),
            "give quantity, low and high, or stations-m alone".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::point::tests::numbered;

    #[test]
    fn the_shipped_file_is_sound_and_every_dispersion_changes_the_point() {
        let vehicle = Vehicle::shipped().unwrap();
        let dispersions = Dispersions::shipped().unwrap();
        for dispersion in &dispersions.all {
            let at = |side| {
                let mut point = numbered();
                dispersion.apply(&vehicle, &mut point, side);
                point
            };
            assert_ne!(at(Side::Low), numbered(), "{dispersion:?}");
            assert_ne!(at(Side::Low), at(Side::High), "{dispersion:?}");
        }
    }

    #[test]
    fn mistakes_are_reported_with_line_and_remedy() {
        for (text, words) in [
            (
                "points = [\"max-p\"]\n[[dispersion]]\ntitle = \"a\"\nquantity = \"gyro-dampin\"\nlow = 0.5\nhigh = 1.5",
                ["x.toml:1", "max-q", "x.toml:4", "gyro-damping"],
            ),
            (
                "points = [\"max-q\"]\n[[dispersion]]\ntitle = \"a\"\nquantity = \"gyro-damping\"\nlow = 1.5\nhigh = 0.5",
                ["x.toml:2", "low < high", "1.5", "0.5"],
            ),
            (
                "points = [\"max-q\"]\n[[dispersion]]\ntitle = \"a\"\nlow = 1.5",
                ["x.toml:2", "stations-m", "quantity", "`a`"],
            ),
            (
                "points = [\"max-q\"]\n[[dispersion]]\ntitle = \"a\"\nquantity = \"gyro-damping\"\nlow = 0.5\nhigh = 1.2e9",
                ["x.toml:6", "1200000000", "0.1", "10"],
            ),
            (
                "points = [\"max-q\"]\n[[dispersion]]\ntitle = \"a\"\nquantity = \"gyro-damping\"\nlow = 0.0\nhigh = 1.5",
                ["x.toml:5", "factor of 0", "0.1", "10"],
            ),
        ] {
            let error = Dispersions::from_toml("x.toml", text).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{word}: {error}");
            }
        }
    }
}
