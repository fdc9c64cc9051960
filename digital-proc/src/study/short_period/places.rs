//! Where the points of a study lie on the nominal flight.
//!
//! Events are looked for on a coarse grid of the flight and refined on a fine one, so
//! that a time found is a multiple of a millisecond. A place that the flight lacks is a
//! fault of the study's file, told with its line.

use super::study_file::{Event, Place, Study, StudyError};
use crate::file_fault::{FileFault, FileFaults};
use crate::slice::{self, SlicePoint};
use crate::vehicle::Vehicle;

/// Sampling interval at which events of the flight are first looked for, s.
const COARSE_S: f64 = 0.1;
/// Interval to which they are then refined, s.
const FINE_S: f64 = 0.001;

/// Slices of the flight at named times.
pub(super) fn flight(
    vehicle: &Vehicle,
    wanted: &[(&str, f64)],
) -> Result<Vec<SlicePoint>, StudyError> {
    slice::points(vehicle, wanted).map_err(|error| StudyError::Flight(error.to_string()))
}

/// Flight time of every point of a study, s.
pub(super) fn times(study: &Study, vehicle: &Vehicle) -> Result<Vec<f64>, StudyError> {
    let burn_time_s = vehicle.data().mass.burn_time_s;
    let coarse = grid(vehicle, 0.0, burn_time_s, COARSE_S)?;
    let source = study.source();
    let mut faults: Vec<FileFault> = Vec::new();
    let mut times = Vec::with_capacity(study.points.len());
    for point in &study.points {
        let found = match point.at {
            Place::Time(time) => Ok(time),
            Place::Event(event) => event_time(vehicle, &coarse, event)?,
            Place::Mach(mach) => mach_time(vehicle, &coarse, mach)?,
            Place::GainSwitch(number) => switch_time(vehicle, number),
        };
        let time = found.map(|t| t + point.offset_s).and_then(|t| {
            if (0.0..=burn_time_s).contains(&t) {
                Ok(t)
            } else {
                Err((
                    format!("the point lies at {t} s"),
                    format!("give a place from 0 to burn-out at {burn_time_s} s"),
                ))
            }
        });
        match time {
            Ok(time) => times.push(time),
            Err((fault, remedy)) => {
                let fault = format!("point `{}`: {fault}", point.name);
                faults.push(source.fault(point.span.clone(), fault, remedy));
            }
        }
    }
    Ok(FileFaults::unless(faults, times)?)
}

/// Refuses gyro stations where the vehicle's mode is not known.
pub(super) fn gyro_stations(study: &Study, vehicle: &Vehicle) -> Result<(), FileFaults> {
    let source = study.source();
    let [first, last] = vehicle.gyro_stations_m();
    let outside = study.conditions.iter().filter_map(|condition| {
        let station = condition.gyro_station_m.as_ref()?;
        let known = vehicle.gyro_slope_at_station(*station.get_ref()).is_some();
        let fault = format!("a rate gyro at {} m", station.get_ref());
        let remedy = format!("the bending mode is known from {first} to {last} m");
        (!known).then(|| source.fault(station.span(), fault, remedy))
    });
    FileFaults::unless(outside.collect(), ())
}

/// A time, or what is wrong and what to do.
type Found = Result<f64, (String, String)>;

fn switch_time(vehicle: &Vehicle, number: usize) -> Found {
    let switches = vehicle.designed_schedule().switch_time_s();
    switches.get(number).copied().filter(|_| number > 0).ok_or_else(|| {
        (
            format!("there is no gain switching {number}"),
            format!(
                "the schedule switches {} times, counted from 1",
                switches.len().saturating_sub(1)
            ),
        )
    })
}

fn event_time(vehicle: &Vehicle, coarse: &[SlicePoint], event: Event) -> Result<Found, StudyError> {
    let programme = &vehicle.data().pitch_programme;
    Ok(match event {
        Event::PitchInitiation => programme.node_time_s.first().copied().ok_or_else(no_programme),
        Event::MaxPitchRate => programme
            .rate_dps
            .iter()
            .zip(programme.node_time_s.windows(2))
            .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            .map(|(_, nodes)| (nodes[0] + nodes[1]) / 2.0)
            .ok_or_else(no_programme),
        Event::FtcOn => Ok(vehicle.data().ftc.on_time_s),
        Event::BurnOut => Ok(vehicle.data().mass.burn_time_s),
        Event::MaxQ => {
            let peak = greatest_q(coarse);
            let last = vehicle.data().mass.burn_time_s;
            let from = (peak - COARSE_S).max(0.0);
            let to = (peak + COARSE_S).min(last);
            Ok(greatest_q(&grid(vehicle, from, to, FINE_S)?))
        }
    })
}

fn no_programme() -> (String, String) {
    ("the pitch programme is empty".to_owned(), "give the point by time".to_owned())
}

fn greatest_q(points: &[SlicePoint]) -> f64 {
    points
        .iter()
        .max_by(|a, b| {
            let q = |p: &SlicePoint| p.airframe.dynamic_pressure_pa;
            q(a).total_cmp(&q(b))
        })
        .map_or(0.0, |p| p.time_s)
}

fn mach_time(vehicle: &Vehicle, coarse: &[SlicePoint], mach: f64) -> Result<Found, StudyError> {
    let reached = |points: &[SlicePoint]| points.iter().position(|p| p.airframe.mach >= mach);
    let Some(index) = reached(coarse) else {
        let greatest = coarse.iter().fold(0.0_f64, |m, p| m.max(p.airframe.mach));
        return Ok(Err((
            format!("the flight does not reach Mach {mach}"),
            format!("its greatest Mach number is {greatest:.2}"),
        )));
    };
    let from = coarse[index.saturating_sub(1)].time_s;
    let fine = grid(vehicle, from, coarse[index].time_s, FINE_S)?;
    // The end of the fine grid is the coarse point at which it was reached.
    Ok(Ok(reached(&fine).map_or(coarse[index].time_s, |i| fine[i].time_s)))
}

fn grid(
    vehicle: &Vehicle,
    from_s: f64,
    to_s: f64,
    every_s: f64,
) -> Result<Vec<SlicePoint>, StudyError> {
    // Times are multiples of the interval, so that a refined event is a round number.
    let first = (from_s / every_s).round() as u64;
    let last = (to_s / every_s).round() as u64;
    let per_second = (1.0 / every_s).round();
    let wanted: Vec<(&str, f64)> = (first..=last).map(|i| ("", i as f64 / per_second)).collect();
    flight(vehicle, &wanted)
}
