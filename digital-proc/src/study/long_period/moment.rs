//! Bending moments of the modes in the design case: a row a mode, along the vehicle, over time.

use super::results::{Flown, LongPeriodResults};
use crate::study::bending_moment::{
    BendingMoments,
    outcome::{EXPLAINED, GreatestMoment, along, envelope, headings, history, over},
};
use desk::{
    outcome::Outcome,
    report::{Cell, Heading, Table},
};

/// Modes in one figure.
const DRAWN: usize = 6;

/// Adds table and figures.
pub fn fill(results: &LongPeriodResults, out: &mut Outcome) {
    let flights = std::iter::once(("undisturbed", &results.undisturbed))
        .chain(results.modes.iter().map(|mode| (mode.name.as_str(), &mode.design)));
    let mut found: Vec<(&str, &BendingMoments<2>)> = Vec::new();
    for (name, Flown { moments, .. }) in flights {
        match moments {
            Some(Ok(moments)) => found.push((name, moments)),
            Some(Err(error)) => out.remarks.push(format!("{name}: no bending moment: {error}")),
            None => {}
        }
    }
    if found.is_empty() {
        return;
    }
    let mode = Heading::new("Mode", "");
    let mut table = Table::new(std::iter::once(mode).chain(headings()).collect());
    for (name, moments) in &found {
        let name = Cell::from(*name);
        table.row(std::iter::once(name).chain(GreatestMoment::from(*moments).cells()));
    }
    found.sort_by(|a, b| {
        let greatest = |m: &BendingMoments<2>| m.whole.greatest.moment_nm;
        greatest(b.1).total_cmp(&greatest(a.1))
    });
    found.truncate(DRAWN);
    let curves = |of: fn(&str, &BendingMoments<2>) -> _| {
        found.iter().map(|(name, moments)| of(name, moments)).collect()
    };
    out.section("Bending moment in flight")
        .aside(EXPLAINED)
        .beside(vec![
            along(
                "flight-moment-along",
                "Greatest bending moment √(pitch² + yaw²) at each station over the flight; modes of operation in the design case.",
                curves(|name, moments| envelope(name, &moments.whole)),
            ),
            over(
                "flight-moment-over",
                "Greatest bending moment along the vehicle over the flight; modes of operation in the design case.",
                curves(|name, moments| history(name, &moments.whole)),
            ),
        ])
        .long_table(
            "flight_moments",
            "Greatest bending moment √(pitch² + yaw²) of each mode in the design case, with the bending modes and without, and with them at ten stations.",
            table,
        );
}
