//! Where named points lie on a vehicle's nominal flight.
//!
//! The points of the shipped study are the catalogue that every command knows by name;
//! a user's study brings its own. Events are looked for on a coarse grid of the flight and
//! refined on a fine one, so that a time found is a multiple of a millisecond. A point that
//! the flight lacks is told with its reason; who asked for it decides whether that is a fault.

use super::study_file::{Event, Place, PointEntry, Study, StudyError};
use desk::faults::{FileFault, FileFaults, Source};
use vehicle::Vehicle;
use vehicle::slice::{self, SlicePoint};
use vehicle::trajectory::FlightError;

/// Sampling interval at which events of the flight are first looked for, s.
const COARSE_S: f64 = 0.1;
/// Interval to which they are then refined, s.
const FINE_S: f64 = 0.001;

/// Why a flight lacks a point.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("point `{point}`: {fault}; {remedy}")]
pub struct Lacking {
    /// The point's name.
    pub point: String,
    /// What is wrong with its place.
    pub fault: String,
    /// What to do about it.
    pub remedy: String,
}

/// A slice of the vehicle's nominal flight at each point, or why it lacks the point.
pub fn locate(
    points: &[PointEntry],
    vehicle: &Vehicle,
) -> Result<Vec<Result<SlicePoint, Lacking>>, FlightError> {
    let burn_time_s = vehicle.data().mass.burn_time_s;
    let coarse = grid(vehicle, 0.0, burn_time_s, COARSE_S)?;
    let mut places = Vec::with_capacity(points.len());
    for point in points {
        let found = match point.at {
            Place::Time(time) => Ok(time),
            Place::Event(event) => event_time(vehicle, &coarse, event)?,
            Place::Mach(mach) => mach_time(vehicle, &coarse, mach)?,
            Place::GainSwitch(number) => switch_time(vehicle, number),
        };
        let on_flight = found.map(|t| t + point.offset_s).and_then(|t| {
            if (0.0..=burn_time_s).contains(&t) {
                Ok((point.name.as_str(), t))
            } else {
                Err((
                    format!("the point lies at {t} s"),
                    format!("give a place from 0 to burn-out at {burn_time_s} s"),
                ))
            }
        });
        places.push(on_flight.map_err(|(fault, remedy)| Lacking {
            point: point.name.clone(),
            fault,
            remedy,
        }));
    }
    let wanted: Vec<(&str, f64)> = places.iter().flatten().copied().collect();
    let mut slices = slice::points(vehicle, &wanted)?.into_iter();
    Ok(places.into_iter().filter_map(|place| place.map(|_| slices.next()).transpose()).collect())
}

/// A slice at each point that a file asks for; those that the flight lacks are its faults.
pub(crate) fn locate_all(
    points: &[PointEntry],
    source: Source<'_>,
    vehicle: &Vehicle,
) -> Result<Vec<SlicePoint>, StudyError> {
    let located = locate(points, vehicle)?;
    let mut faults: Vec<FileFault> = Vec::new();
    let mut slices = Vec::with_capacity(points.len());
    for (point, located) in points.iter().zip(located) {
        match located {
            Ok(slice) => slices.push(slice),
            Err(Lacking { point: name, fault, remedy }) => {
                let fault = format!("point `{name}`: {fault}");
                faults.push(source.fault(point.span, fault, remedy));
            }
        }
    }
    Ok(FileFaults::unless(faults, slices)?)
}

impl Study {
    /// The shipped study at a vehicle's own points: its switchings instead of the shipped vehicle's,
    /// but for that at which the tips take over and which has its point, in order of time. Points
    /// that its flight lacks are left out and told.
    pub fn shipped_for(vehicle: &Vehicle) -> Result<Study, StudyError> {
        let mut study = Study::shipped()?;
        let is_switching = |p: &PointEntry| matches!(p.at, Place::GainSwitch(_));
        let (shipped, mut points): (Vec<_>, Vec<_>) =
            study.points.into_iter().partition(is_switching);
        let on_time_s = vehicle.data().ftc.on_time_s;
        for (n, time_s) in vehicle.designed_schedule().switch_time_s().iter().enumerate().skip(1) {
            let name = format!("gain-{time_s}");
            let alike = shipped.iter().find(|p| p.name == name);
            // Any has the offset and the file's place.
            if let Some(like) = alike.or(shipped.first()).filter(|_| *time_s != on_time_s) {
                let title = alike.map_or("gain switching", |p| &p.title).to_owned();
                points.push(PointEntry { name, title, at: Place::GainSwitch(n), ..like.clone() });
            }
        }
        let mut on_flight = Vec::with_capacity(points.len());
        for (point, located) in points.iter().zip(locate(&points, vehicle)?) {
            match located {
                Ok(slice) => on_flight.push((slice.time_s, point.clone())),
                Err(lacking) => study.left_out.push(lacking.to_string()),
            }
        }
        on_flight.sort_by(|a, b| a.0.total_cmp(&b.0));
        study.points = on_flight.into_iter().map(|(_, point)| point).collect();
        Ok(study)
    }
}

/// Refuses gyro stations where the vehicle's mode is not known.
pub(super) fn gyro_stations(study: &Study, vehicle: &Vehicle) -> Result<(), FileFaults> {
    let source = study.source();
    let [first, last] = vehicle.gyro_stations_m();
    let outside = study.conditions.iter().filter_map(|condition| {
        let (station, at) = condition.gyro?;
        let known = vehicle.gyro_slope_at_station(station).is_some();
        let fault = format!("a rate gyro at {station} m");
        let remedy = format!("the bending mode is known from {first} to {last} m");
        (!known).then(|| source.fault(at, fault, remedy))
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

fn event_time(
    vehicle: &Vehicle,
    coarse: &[SlicePoint],
    event: Event,
) -> Result<Found, FlightError> {
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

fn mach_time(vehicle: &Vehicle, coarse: &[SlicePoint], mach: f64) -> Result<Found, FlightError> {
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
) -> Result<Vec<SlicePoint>, FlightError> {
    // Times are multiples of the interval, so that a refined event is a round number.
    let first = (from_s / every_s).round() as u64;
    let last = (to_s / every_s).round() as u64;
    let per_second = (1.0 / every_s).round();
    let wanted: Vec<(&str, f64)> = (first..=last).map(|i| ("", i as f64 / per_second)).collect();
    slice::points(vehicle, &wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn located(vehicle: &Vehicle) -> Vec<Result<SlicePoint, Lacking>> {
        locate(&Study::shipped().unwrap().points, vehicle).unwrap()
    }

    /// Another stage has its greatest dynamic pressure and its Mach 1.05 elsewhere, and its
    /// switchings where its own sequencer has them.
    #[test]
    fn points_move_with_the_vehicle() {
        let shipped = Vehicle::shipped().unwrap();
        let mut data = shipped.data().clone();
        data.geometry.reference_area_m2 *= 2.0;
        data.ftc.on_time_s = 16.0;
        data.gains.switch_time_s[2] = 16.0;
        data.gains_reduced.switch_time_s[1] = 16.0;
        let other = Vehicle::from_data(data).unwrap();
        let times = |vehicle: &Vehicle| -> Vec<(String, f64)> {
            located(vehicle).into_iter().flatten().map(|p| (p.name, p.time_s)).collect()
        };
        let moved: Vec<String> = times(&shipped)
            .into_iter()
            .zip(times(&other))
            .filter(|(a, b)| a.1 != b.1)
            .map(|(a, _)| a.0)
            .collect();
        assert_eq!(moved, ["ftc-switch-in", "transonic", "max-q"]);
    }

    /// The shipped vehicle's own points are those of the shipped study; another's are its own.
    #[test]
    fn the_shipped_study_takes_a_vehicles_own_switchings() {
        let shipped = Vehicle::shipped().unwrap();
        let study = Study::shipped_for(&shipped).unwrap();
        assert_eq!(study.points, Study::shipped().unwrap().points);
        let mut data = shipped.data().clone();
        for column in [
            &mut data.gains.switch_time_s,
            &mut data.gains.ftc_gain,
            &mut data.gains.ftc_lead_s,
            &mut data.gains.tvc_gain_npdeg,
            &mut data.gains.tvc_lead_s,
            &mut data.gains.dead_zone_deg,
        ] {
            column.remove(4);
        }
        data.gains.switch_time_s[4] = 36.5;
        let study = Study::shipped_for(&Vehicle::from_data(data).unwrap()).unwrap();
        let names: Vec<&str> = study.points.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(
            names[4..],
            [
                "ftc-switch-in",
                "transonic",
                "gain-20",
                "max-q",
                "gain-36.5",
                "gain-40",
                "gain-45",
                "burn-out"
            ]
        );
        assert!(study.left_out.is_empty());
    }

    #[test]
    fn a_flight_without_a_switching_lacks_its_point_and_no_other() {
        let mut data = Vehicle::shipped().unwrap().data().clone();
        let gains = &mut data.gains;
        for column in [
            &mut gains.switch_time_s,
            &mut gains.ftc_gain,
            &mut gains.ftc_lead_s,
            &mut gains.tvc_gain_npdeg,
            &mut gains.tvc_lead_s,
            &mut gains.dead_zone_deg,
        ] {
            column.pop();
        }
        let lacking: Vec<String> = located(&Vehicle::from_data(data).unwrap())
            .into_iter()
            .filter_map(Result::err)
            .map(|lacking| lacking.to_string())
            .collect();
        assert_eq!(lacking.len(), 1);
        assert!(lacking[0].contains("`gain-45`: there is no gain switching 7"), "{lacking:?}");
    }
}
