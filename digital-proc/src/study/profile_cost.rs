//! What a machine's errors and scaling cost a case study: its measures beside those of the ideal
//! machine, each where the two differ most.

use super::{
    long_period::results::{Flown, LongPeriodResults},
    short_period::{measure::Measures, results::Results},
};
use desk::report::{Cell, Column, Table};
use vehicle::flight_summary::FlightSummary;

/// A measure on both machines, where they differ most.
struct Cost {
    measure: &'static str,
    unit: &'static str,
    place: String,
    ideal: f64,
    here: f64,
}

type OfRun = (&'static str, &'static str, fn(&Measures) -> Option<f64>);
const OF_RUNS: [OfRun; 13] = [
    ("Overshoot of θ", "%", |m| Some(100.0 * m.overshoot?)),
    ("Settling of θ", "s", |m| m.residual.and(m.settling_s)),
    ("Peak of θ", "of the step", |m| m.peak),
    ("Standing error of θ", "deg", |m| Some(m.standing_error_rad?.to_degrees())),
    ("Residual oscillation of θ", "%", |m| Some(100.0 * m.residual?)),
    ("Bending by 6.5 s", "%", |m| Some(100.0 * m.residual.and(m.bending_ratio(1))?)),
    ("Tips given to roll", "s", |m| m.tips_given_to_roll_s),
    ("Thrust vector begins in yaw", "s", |m| m.tvc_begins_s),
    ("Thrust vector's peak in yaw", "N", |m| m.tvc_peak_n),
    ("Tips' share in yaw after roll", "%", |m| Some(100.0 * m.yaw_share_after?)),
    ("Settling of ψ", "s", |m| m.final_rad.and(m.settling_s)),
    ("Settling of φ", "s", |m| m.roll_settling_s),
    ("Final ψ", "deg", |m| Some(m.final_rad?[0].to_degrees())),
];

type OfFlight = (&'static str, &'static str, fn(&FlightSummary) -> f64);
const OF_FLIGHTS: [OfFlight; 5] = [
    ("Largest Qα", "kPa deg", |f| f.max_q_alpha.value / 1e3),
    ("Path angle at burn-out", "deg", |f| f.end.path_angle_rad.to_degrees()),
    ("Altitude at burn-out", "m", |f| f.end.altitude_m),
    ("Range at burn-out", "m", |f| f.range_m),
    ("Injectant", "kg", |f| f.injectant_kg),
];

/// The table; `ideal` has the runs and flights of the ideal machine that are compared.
pub fn table(here: (&Results, &LongPeriodResults), ideal: (&Results, &LongPeriodResults)) -> Table {
    let mut costs = Vec::new();
    for (measure, unit, of) in OF_RUNS {
        let pairs = ideal.0.runs.iter().filter_map(|run| {
            let alike = |r: &&_| is_alike(r, run);
            let here = here.0.runs.iter().find(alike)?;
            Some((run.name.clone(), of(&run.measures)?, of(&here.measures)?))
        });
        costs.extend(farthest(measure, unit, pairs));
    }
    for (measure, unit, of) in OF_FLIGHTS {
        let value = |flown: &Flown| flown.ended.as_ref().ok().map(of);
        let pairs = ideal.1.modes.iter().filter_map(|mode| {
            let here = here.1.modes.iter().find(|m| m.name == mode.name)?;
            Some((mode.name.clone(), value(&mode.design)?, value(&here.design)?))
        });
        costs.extend(farthest(measure, unit, pairs));
    }
    let columns: [Column<Cost>; 6] = [
        Column::new("Measure", "", |c: &Cost| c.measure.into()),
        Column::new("Unit", "", |c| c.unit.into()),
        Column::new("Where they differ most", "", |c| c.place.as_str().into()),
        Column::of("Ideal machine", "", 5, |c| c.ideal.into()),
        Column::of("This machine", "", 5, |c| c.here.into()),
        Column::of("Difference", "", 2, |c| Cell::from(c.here - c.ideal)),
    ];
    Table::of(&columns, &costs)
}

/// A name is unique within its loop.
fn is_alike(a: &super::short_period::results::Run, b: &super::short_period::results::Run) -> bool {
    a.name == b.name && a.control_loop() == b.control_loop()
}

fn farthest(
    measure: &'static str,
    unit: &'static str,
    pairs: impl Iterator<Item = (String, f64, f64)>,
) -> Option<Cost> {
    let off = |(_, ideal, here): &(String, f64, f64)| (here - ideal).abs();
    let (place, ideal, here) = pairs.max_by(|a, b| off(a).total_cmp(&off(b)))?;
    Some(Cost { measure, unit, place, ideal, here })
}
