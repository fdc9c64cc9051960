//! The catalogue of failures (objective vi of the paper): "the conditions for salvaging the mission
//! without violating the range safety requirements".
//!
//! Each failure mode is flown with each time of occurrence, from lift-off to burn-out, in the
//! design case. The flight up to the failure is that of the sound vehicle; what is judged is the
//! whole flight, by the gravest of what it violates:
//! * *range safety*: the instantaneous impact point leaves its corridor, the nose strays from its
//!   command until control counts as lost, or the flight could not be computed to its end;
//! * *load*: |Qα| in pitch exceeds the structural limit, as in claim L2;
//! * *trajectory*: burn-out departs from that of the sound vehicle in the same conditions by more
//!   than is accepted, as in claim L1;
//! * *salvageable* otherwise.

use super::{
    fault::StudyFault,
    long_period::{
        results::{Acceptance, Departure},
        run::{Answer, LongPeriodPlan, fly_all},
    },
};
use crate::linkage::console::Console;
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Cell, Column, Heading, Table,
        plot::{CategoryMap, category_map},
    },
};
use interface::Tick;
use vehicle::{
    RangeSafety, Vehicle, flight_mode::FlightScript, flight_summary::FlightSummary,
    reference::FlightCase,
};

use fate::Fate;

// A module of its own, so that the names stay in this file.
mod fate {
    interface::named! {
        /// What becomes of a flight, the gravest last.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Fate, name {
            Salvageable "salvageable"
            Trajectory "trajectory"
            Load "load"
            RangeSafety "range safety"
        }
    }
}

/// Between two times of occurrence, unless another step is asked for.
pub const STEP: Tick = Tick(1_000_000_000);

/// What is flown.
#[derive(Clone, Debug, PartialEq)]
pub struct CataloguePlan {
    /// The modes in which something fails.
    failures: Vec<FlightScript>,
    /// Times of occurrence, s.
    times_s: Vec<f64>,
}

impl CataloguePlan {
    /// The failures among `modes`, occurring every `step` before burn-out.
    pub fn new(modes: &[FlightScript], step: Tick, vehicle: &Vehicle) -> CataloguePlan {
        let burn_time_s = vehicle.data().mass.burn_time_s;
        let times = (0..).map(|n| Tick(n * step.0.max(1)).secs());
        CataloguePlan {
            failures: modes.iter().filter(|mode| !mode.actions.is_empty()).cloned().collect(),
            times_s: times.take_while(|t| *t < burn_time_s).collect(),
        }
    }

    /// Number of flights: the sound one and each failure at each time.
    pub fn flights(&self) -> usize {
        1 + self.failures.len() * self.times_s.len()
    }
}

/// One failure at one time.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    mode: String,
    /// When it occurred, s.
    at_s: f64,
    fate: Fate,
    /// The flight in short, or why it was lost.
    ended: Result<FlightSummary, String>,
    /// Departure of its burn-out, the largest part over what is accepted.
    severity: Option<f64>,
}

/// All of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Catalogue {
    /// Mode by mode, each in order of time.
    entries: Vec<Entry>,
    times_s: Vec<f64>,
    accept: Acceptance,
    range_safety: RangeSafety,
    /// Why there is nothing to compare burn-outs with.
    sound_lost: Option<String>,
}

/// Flies all of `plan`, as `how` says.
pub fn run(
    console: &mut Console<'_>,
    vehicle: &Vehicle,
    how: &LongPeriodPlan,
    plan: &CataloguePlan,
    progress: impl FnMut(usize),
) -> Result<Catalogue, StudyFault> {
    let occurrences =
        || plan.failures.iter().flat_map(|mode| plan.times_s.iter().map(move |at| (mode, *at)));
    let scripts = std::iter::once(FlightScript::sound())
        .chain(occurrences().map(|(mode, at_s)| mode.occurring_at(at_s)));
    let cases = scripts
        .map(|s| Ok(FlightCase::design(vehicle, &s)?))
        .collect::<Result<Vec<_>, StudyFault>>()?;
    let mut answers = fly_all(console, vehicle, how, (&cases, false), progress)?.into_iter();
    let sound = answers.next().ok_or(StudyFault::LostFlight)?.ended;
    let accept = Acceptance::new(vehicle);
    let entry = |((mode, at_s), Answer { ended, .. }): ((&FlightScript, f64), Answer)| {
        let both = ended.as_ref().ok().zip(sound.as_ref().ok());
        let departure = both.map(|(flight, sound)| Departure::new(flight, sound));
        let severity = departure.map(|d| d.severity(&accept));
        let fate = fate(&ended, severity, &accept);
        Entry { mode: mode.name.clone(), at_s, fate, ended, severity }
    };
    let entries = occurrences().zip(answers).map(entry).collect();
    let range_safety = vehicle.data().range_safety.clone();
    let times_s = plan.times_s.clone();
    Ok(Catalogue { entries, times_s, accept, range_safety, sound_lost: sound.err() })
}

/// The gravest of what a flight violates.
fn fate(ended: &Result<FlightSummary, String>, severity: Option<f64>, accept: &Acceptance) -> Fate {
    let Ok(flight) = ended else {
        return Fate::RangeSafety;
    };
    let load = flight.max_q_alpha.value;
    if flight.corridor_left_s.is_some() || flight.control_lost_s.is_some() {
        Fate::RangeSafety
    } else if load.is_nan() || load > accept.q_alpha_padeg {
        Fate::Load
    } else if severity.is_none_or(|s| s > 1.0) {
        Fate::Trajectory
    } else {
        Fate::Salvageable
    }
}

impl Catalogue {
    /// The modes in order, each with its entries.
    fn modes(&self) -> impl Iterator<Item = (&str, &[Entry])> {
        self.entries
            .chunk_by(|a, b| a.mode == b.mode)
            .map(|entries| (entries[0].mode.as_str(), entries))
    }

    /// What a terminal and a page show.
    pub fn outcome(&self) -> Outcome {
        let mut out = Outcome::new(
            "Catalogue of failures",
            "Each failure mode with each time of its occurrence, flown to burn-out in the design case: whether the mission can be salvaged.",
        );
        self.fill(&mut out);
        out
    }

    /// Adds the picture and both tables.
    pub fn fill(&self, out: &mut Outcome) {
        let (accept, safety) = (&self.accept, &self.range_safety);
        let limits = format!(
            "A flight is judged by the gravest of what it violates. Range safety: the impact point leaves its corridor ({:.1} km either side at the launch point, opening by {}° a side, {:.1} km behind), or the nose is {}° from its command, or the flight was lost. Load: |Qα| in pitch above {:.0} kPa·° from the take-over of the fin tips on, as in claim L2. Trajectory: burn-out further than {} % of velocity, {}° of flight-path angle, {} % of altitude or {} km of range from that of the sound vehicle in the same conditions. Design case.",
            safety.half_width_m / 1e3,
            safety.opening_deg,
            safety.behind_m / 1e3,
            safety.control_lost_deg,
            accept.q_alpha_padeg / 1e3,
            100.0 * accept.speed_fraction,
            accept.path_angle_deg,
            100.0 * accept.altitude_fraction,
            accept.range_km
        );
        if let Some(lost) = &self.sound_lost {
            out.remarks.push(format!(
                "catalogue: no trajectory is acceptable, since the sound vehicle was lost in the design case: {lost}"
            ));
        }
        let modes: Vec<(&str, &[Entry])> = self.modes().collect();
        let index = |fate: Fate| Fate::ALL.iter().position(|f| *f == fate).unwrap_or(0);
        let map = category_map(&CategoryMap {
            corner: "Failure at, s".to_owned(),
            rows: modes.iter().map(|(name, _)| (*name).to_owned()).collect(),
            columns: self.times_s.iter().map(|t| format!("{t}")).collect(),
            categories: Fate::ALL.map(|fate| fate.name().to_owned()).into(),
            cells: modes
                .iter()
                .map(|(_, entries)| entries.iter().map(|e| index(e.fate)).collect())
                .collect(),
        });
        let headings = std::iter::once(Heading::new("Failure", ""))
            .chain(Fate::ALL.map(|fate| Heading::new(fate.name(), "s")));
        let mut spans = Table::new(headings.collect());
        for (name, entries) in &modes {
            let of = |fate| Cell::from(self.when(entries, fate));
            spans.row(std::iter::once(Cell::from(*name)).chain(Fate::ALL.map(of)));
        }
        out.section("Catalogue of failures")
            .words(limits)
            .figure(Figure::new(
                "catalogue-map",
                "Each failure against the time of its occurrence, by what becomes of the flight: the letter and the tint say the same.",
                map,
            ))
            .table("catalogue", "When a failure may occur and what then becomes of the flight.", spans)
            .long_table("catalogue_flights", "Every failure at every time.", self.flights());
    }

    /// The times of occurrence with a fate, as spans.
    fn when(&self, entries: &[Entry], fate: Fate) -> String {
        let mut spans = Vec::new();
        for run in entries.chunk_by(|a, b| a.fate == b.fate).filter(|run| run[0].fate == fate) {
            let (first, last) = (run[0].at_s, run[run.len() - 1].at_s);
            spans.push(if first == last {
                format!("{first}")
            } else {
                format!("{first}–{last}")
            });
        }
        spans.join(", ")
    }

    fn flights(&self) -> Table {
        fn flight(entry: &Entry, of: fn(&FlightSummary) -> f64) -> Cell {
            entry.ended.as_ref().ok().map(of).into()
        }
        fn if_ever(entry: &Entry, of: fn(&FlightSummary) -> Option<f64>) -> Cell {
            entry.ended.as_ref().ok().and_then(of).into()
        }
        let columns: [Column<Entry>; 13] = [
            Column::new("Failure", "", |e| e.mode.as_str().into()),
            Column::new("at", "s", |e| e.at_s.into()),
            Column::new("fate", "", |e| e.fate.name().into()),
            Column::new("Max Qα", "kPa·°", |e| flight(e, |f| f.max_q_alpha.value / 1e3)),
            Column::new("total", "kPa·°", |e| flight(e, |f| f.max_total_q_alpha.value / 1e3)),
            Column::of("Departure over accepted", "%", 3, |e| e.severity.map(|s| 100.0 * s).into()),
            Column::of("Cross-range", "m", 4, |e| flight(e, |f| f.cross_range_m)),
            Column::of("Corridor used", "%", 3, |e| flight(e, |f| 100.0 * f.corridor_used)),
            Column::of("left at", "s", 4, |e| if_ever(e, |f| f.corridor_left_s)),
            Column::of("Control lost at", "s", 4, |e| if_ever(e, |f| f.control_lost_s)),
            Column::of("Max roll", "°", 3, |e| flight(e, |f| f.max_roll_rad.to_degrees())),
            Column::of("Injectant", "kg", 3, |e| flight(e, |f| f.injectant_kg)),
            Column::new("Lost", "", |e| e.ended.as_ref().err().map_or("", |l| l.as_str()).into()),
        ];
        Table::of(&columns, &self.entries)
    }
}
