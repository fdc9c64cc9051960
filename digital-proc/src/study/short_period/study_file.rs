//! The study as a file: trajectory points, conditions and what disturbs a run.
//!
//! The shipped study is embedded; a user's own file replaces it. Reading finds
//! every fault that does not depend on the vehicle and names its line and, for a
//! misspelt name, the nearest known one. What depends on the vehicle (an event that
//! its flight lacks) is found by [`super::plan`].

use super::point::Quantity;
use desk::faults::{FileFaults, Source};
use desk::reader::{Range::Any, Span};
use desk::table;
use vehicle::{structure::StructureError, trajectory::FlightError};

/// Text of the shipped study.
pub const SHIPPED_TEXT: &str = include_str!("../../../data/short-period.toml");
/// Name under which it is recorded.
pub const SHIPPED_NAME: &str = "the shipped study";

/// A study that was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// The file.
    #[error(transparent)]
    File(#[from] FileFaults),
    /// The nominal flight from which the points are frozen failed.
    #[error("the nominal flight cannot be computed: {0}")]
    Flight(#[from] FlightError),
    /// No beam can be made of the vehicle at a point.
    #[error("the bending moment cannot be computed: {0}")]
    Structure(#[from] StructureError),
}

/// A checked study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// File as named by the caller.
    pub file: String,
    /// Its text, for later faults.
    pub(super) text: String,
    /// Duration of a run, s.
    pub duration_s: f64,
    /// Sampling interval, ms.
    pub sample_ms: u32,
    /// The pitch test.
    pub pitch: PitchTest,
    /// The yaw–roll test.
    pub yaw_roll: YawRollTest,
    /// Trajectory points.
    pub points: Vec<PointEntry>,
    /// Operating conditions.
    pub conditions: Vec<Condition>,
    /// Points of the shipped study that the vehicle's flight lacks, and why.
    pub left_out: Vec<String>,
}

table! { "The pitch test." PitchTest
    step_deg: f64 = ranged("step-deg", None, "a step other than 0 deg", |deg| deg != 0.0), "Step command, deg; measures are fractions of it.";
    misalignment: f64 = number_in("misalignment", Any), "Fraction of the three-sigma misalignment.";
    gust: f64 = number_in("gust", Any), "Fraction of the step gust.";
    modes: u32 = whole_in("modes", Some(1), 1..=3), "Bending modes in the loop.";
}

table! { "The yaw–roll test." YawRollTest
    yaw_deg: f64 = number_in("yaw-deg", Any), "Initial yaw, within the tips' own authority, deg.";
    large_yaw_deg: f64 = number_in("large-yaw-deg", Any), "A larger one, beyond it, deg.";
    yaw_rate_dps: f64 = number_in("yaw-rate-dps", Any), "Initial yaw rate, deg/s.";
    roll_deg: f64 = number_in("roll-deg", Any), "Initial roll, deg.";
    roll_rate_dps: f64 = number_in("roll-rate-dps", Any), "Initial roll rate, deg/s.";
    misalignment: f64 = number_in("misalignment", Any), "Fraction of the three-sigma misalignment.";
    gust: f64 = number_in("gust", Any), "Fraction of the step gust.";
    cant: f64 = number_in("cant", Any), "Fraction of the fin-cant moment.";
}

/// A trajectory point as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct PointEntry {
    /// Name.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Where on the trajectory.
    pub at: Place,
    /// Added to the time found, s.
    pub offset_s: f64,
    /// Where it stands in the file.
    pub(crate) span: Span,
}

/// Where on the trajectory a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// At a flight time, s.
    Time(f64),
    /// At an event.
    Event(Event),
    /// Where a Mach number is first reached.
    Mach(f64),
    /// At the n-th switching of the designed schedule, counted from 1.
    GainSwitch(usize),
}

/// Events of the nominal flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The pitch programme begins.
    PitchInitiation,
    /// Middle of the interval of greatest pitch rate.
    MaxPitchRate,
    /// Fin-tip control is switched in.
    FtcOn,
    /// Dynamic pressure is greatest.
    MaxQ,
    /// The motor has burnt out.
    BurnOut,
}

impl Event {
    pub(super) const ALL: [(&'static str, Event); 5] = [
        ("pitch-initiation", Event::PitchInitiation),
        ("max-pitch-rate", Event::MaxPitchRate),
        ("ftc-on", Event::FtcOn),
        ("max-q", Event::MaxQ),
        ("burn-out", Event::BurnOut),
    ];
}

/// An operating condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Name.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Changed quantities, in order.
    pub changes: Vec<Change>,
    /// Loop gains in force.
    pub gains: GainSource,
    /// Rate gyro moved to this station, m from the nozzle exit, and where that stands.
    pub gyro: Option<(f64, Span)>,
    /// Only at points where the fin tips work.
    pub needs_ftc: bool,
    /// Runs the pitch loop.
    pub pitch: bool,
    /// Runs the yaw and roll loops.
    pub yaw_roll: bool,
    /// Adds a pitch run without disturbances.
    pub overshoot: bool,
    /// Adds a yaw–roll run with the tips dedicated to roll.
    pub dedicated: bool,
    /// Adds yaw–roll runs from the large yaw offset and from either offset alone.
    pub offsets: bool,
    /// Points it is limited to, by name; all if none is given.
    pub points: Option<Vec<String>>,
}

/// A changed quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Which.
    pub quantity: &'static Quantity,
    /// How.
    pub how: How,
}

/// How a quantity is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    /// Multiplied.
    Times(f64),
    /// Replaced; SI value.
    Set(f64),
}

/// Which loop gains are in force at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GainSource {
    /// Those of the designed schedule.
    Scheduled,
    /// Those of the interval before: the last switching did not happen.
    PreviousInterval,
    /// Those of the interval to come: the next switching came early.
    NextInterval,
    /// Those of the reduced schedule.
    Reduced,
    /// The sequencer stopped at this time, s.
    StuckAt(f64),
}

impl GainSource {
    pub(super) const NAMED: [(&'static str, GainSource); 4] = [
        ("scheduled", GainSource::Scheduled),
        ("previous-interval", GainSource::PreviousInterval),
        ("next-interval", GainSource::NextInterval),
        ("reduced", GainSource::Reduced),
    ];
}

impl Study {
    /// The file, for faults that only a vehicle shows.
    pub(crate) fn source(&self) -> Source<'_> {
        Source { file: &self.file, text: &self.text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use desk::faults::FileFault;

    fn faults(change: impl Fn(&str) -> String) -> Vec<FileFault> {
        let FileFaults(faults) = Study::from_toml("user.toml", &change(SHIPPED_TEXT)).unwrap_err();
        faults
    }

    /// Line (from 1) of the first occurrence of a text.
    fn line_of(text: &str, part: &str) -> usize {
        text[..text.find(part).unwrap()].matches('\n').count() + 1
    }

    #[test]
    fn a_mistake_has_its_line_and_a_remedy() {
        for (right, wrong, near) in [
            ("\"tip-force-slope\"", "\"tip-force-slop\"", "tip-force-slope"),
            ("gains = \"reduced\"", "gains = \"reducd\"", "reduced"),
            ("gyro-station-m", "gyro-staton-m", "gyro-station-m"),
            ("where = \"ftc-on\"", "where = \"ftc\"", "ftc-on"),
            ("times = 2.0", "times = 2.0, set = 1.0", "either"),
            (", times = 2.0", "", "either"),
        ] {
            let line = line_of(SHIPPED_TEXT, right);
            let found = faults(|text| text.replacen(right, wrong, 1));
            assert_eq!(found.len(), 1, "{wrong}: {found:?}");
            assert_eq!(found[0].place.unwrap().0, line, "{wrong}");
            assert!(found[0].remedy.contains(near), "{}", found[0]);
        }
    }

    #[test]
    fn all_faults_are_reported_together() {
        let found = faults(|text| {
            text.replace("sample-ms = 20", "sample-ms = 0")
                .replace("step-deg = 2.0", "step-deg = 0.0")
                .replace("set = 1.0 }", "set = 0.0 }")
                .replace("at = { mach = 1.05 }", "at = { mach = 1.05, time-s = 3.0 }")
                .replacen("times = 0.05", "times = nan", 1)
                + "[[point]]\nname = \"max-q\"\nat = { time-s = -1.0 }\n"
        });
        let said: Vec<_> = found.iter().map(|f| f.fault.as_str()).collect();
        assert_eq!(said.len(), 7, "{said:#?}");
        assert!(found.windows(2).all(|f| f[0].place <= f[1].place));
    }
}
