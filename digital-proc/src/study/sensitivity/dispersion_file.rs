//! The dispersion file: what is dispersed, by how much, and at which points.

use crate::study::short_period::{
    places::locate_all,
    point::{FrozenPoint, Quantity},
    study_file::{PointEntry, Study, StudyError},
};
use desk::faults::{FileFaults, Source};
use desk::reader::{self, FileKind, SheetFields};
use std::path::Path;
use vehicle::{Vehicle, slice::SlicePoint};

/// Text of the shipped file.
pub const SHIPPED_TEXT: &str = include_str!("../../../data/dispersions.toml");
/// Name under which its faults would be reported.
pub const SHIPPED_NAME: &str = "the shipped dispersions";

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

impl Dispersions {
    /// The points on the vehicle's own flight.
    ///
    /// # Errors
    /// What the vehicle does not cover: points that its flight lacks, gyro stations off the
    /// table of its bending mode.
    pub fn locate(&self, vehicle: &Vehicle) -> Result<Vec<SlicePoint>, StudyError> {
        let source = Source { file: &self.file, text: &self.text };
        let [first, last] = vehicle.gyro_stations_m();
        let outside = self.all.iter().filter_map(|dispersion| {
            let Dispersed::GyroStations(stations) = dispersion.what else {
                return None;
            };
            let station =
                stations.into_iter().find(|s| vehicle.gyro_slope_at_station(*s).is_none())?;
            let fault = format!("`{}`: a rate gyro at {station} m", dispersion.title);
            let remedy = format!("the bending mode is known from {first} to {last} m");
            Some(source.whole(fault, remedy))
        });
        FileFaults::unless(outside.collect(), ())?;
        locate_all(&self.points, source, vehicle)
    }

    /// The shipped file.
    pub fn shipped() -> Result<Dispersions, FileFaults> {
        Dispersions::from_toml(SHIPPED_NAME, SHIPPED_TEXT)
    }

    /// Reads a user's file.
    pub fn load(path: &Path) -> Result<Dispersions, FileFaults> {
        reader::load(path, Dispersions::from_toml)
    }

    /// Reads a text; `file` is only named in faults.
    pub fn from_toml(file: &str, text: &str) -> Result<Dispersions, FileFaults> {
        let catalogue = Study::shipped()?.points;
        reader::read(FileKind::Dispersions, Source { file, text }, |f| {
            let known: Vec<_> =
                catalogue.iter().map(|point| (point.name.as_str(), point)).collect();
            let named = f.each("points", "[\"max-q\"]", |f, key, name| {
                let point = f.word_of(key, name, &known)?;
                Some(PointEntry { span: name.span, ..point.clone() })
            });
            let all = f.tables("dispersion", dispersion);
            let (named, all) = (named?, all?);
            let fault = format!("{} dispersions at {} points", all.len(), named.len());
            let remedy = format!("give at least one point and 1 to {MOST} [[dispersion]]");
            let fits = !named.is_empty() && (1..=MOST).contains(&all.len());
            f.require(fits, "dispersion", fault, remedy);
            let asked = |point: &PointEntry| named.iter().find(|n| n.name == point.name).cloned();
            let points = catalogue.iter().filter_map(asked).collect();
            Some(Dispersions { file: file.to_owned(), text: text.to_owned(), points, all })
        })
    }
}

fn dispersion(f: &mut SheetFields<'_, '_>) -> Option<Dispersion> {
    let title = f.text("title");
    let quantity = f.maybe("quantity", |f| f.word("quantity", None, &Quantity::by_name()));
    let range = "a factor of 0.1 to 10";
    let [low, high] = ["low", "high"].map(|key| {
        let fits = |factor: f64| (FACTORS[0]..=FACTORS[1]).contains(&factor);
        f.maybe(key, |f| f.ranged(key, None, range, fits))
    });
    let stations = f.maybe("stations-m", |f| f.pair("stations-m"));
    let stated = ["quantity", "low", "high", "stations-m"].map(|key| f.place(key).is_some());
    let whole = stated == [true, true, true, false] || stated == [false, false, false, true];
    let remedy = "give quantity, low and high, or stations-m alone";
    let fault = format!("`{}` is not fully stated", title.as_deref().unwrap_or_default());
    f.require(whole, "", fault, remedy);
    let (key, pair) = match stations {
        Some(stations) => ("stations-m", stations),
        None => ("low", [low?, high?]),
    };
    let fault = format!("from {} to {}", pair[0], pair[1]);
    f.require(pair[0] < pair[1], key, fault, "give the lower one first: low < high");
    let what = match stations {
        Some(stations) => Dispersed::GyroStations(stations),
        None => Dispersed::Factors(quantity?, pair),
    };
    Some(Dispersion { title: title?, what })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::short_period::point::tests::frozen;

    #[test]
    fn the_shipped_file_is_sound_and_every_dispersion_changes_the_point() {
        let vehicle = Vehicle::shipped().unwrap();
        let dispersions = Dispersions::shipped().unwrap();
        for dispersion in &dispersions.all {
            let at = |side| {
                let mut point = frozen(32.5);
                dispersion.apply(&vehicle, &mut point, side);
                point
            };
            assert_ne!(at(Side::Low), frozen(32.5), "{dispersion:?}");
            assert_ne!(at(Side::Low), at(Side::High), "{dispersion:?}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_told_with_its_place() {
        let of =
            |fields: &str| format!("points = [\"max-q\"]\n[[dispersion]]\ntitle = \"a\"\n{fields}");
        let factors = |low: &str, high: &str| {
            of(&format!("quantity = \"gyro-damping\"\nlow = {low}\nhigh = {high}"))
        };
        for (text, words) in [
            (factors("0.5", "1.5").replace("max-q", "max-p"), ["x.toml:1:11:", "max-q"]),
            (factors("0.5", "1.5").replace("-damping", "-dampin"), ["x.toml:4:", "gyro-damping"]),
            (factors("1.5", "0.5"), ["x.toml:5:7: from 1.5 to 0.5", "low < high"]),
            (factors("0.5", "1.2e9"), ["x.toml:6:", "a factor of 0.1 to 10"]),
            (of("low = 1.5"), ["x.toml:2:", "`a` is not fully stated"]),
            (of("stations-m = [3.0, 2.0]"), ["x.toml:4:", "from 3 to 2"]),
        ] {
            let error = Dispersions::from_toml("x.toml", &text).unwrap_err().to_string();
            for word in words {
                assert!(error.contains(word), "{word}: {error}");
            }
        }
    }
}
