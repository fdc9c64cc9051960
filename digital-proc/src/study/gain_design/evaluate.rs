//! A schedule seen by the short-period model at the study's trajectory points.

use super::{
    bench::PitchBench,
    criteria::LoopQuality,
    design::{DesignFault, measure},
    schedule,
};
use crate::{
    console::Console,
    study::short_period::{
        claims::{OVERSHOOT_P1, RESIDUAL_P1},
        places::{Lacking, locate},
        point::FrozenPoint,
        study_file::{Study, StudyError},
    },
};
use serde::Serialize;
use vehicle::{ScheduleData, Vehicle, gain_schedule::LoopGains, slice::SlicePoint};

/// Overshoot accepted of a schedule, fraction of the step (criterion P1).
pub const OVERSHOOT: f64 = OVERSHOOT_P1;
/// Residual oscillation accepted, fraction of the step (criterion P1).
pub const RESIDUAL: f64 = RESIDUAL_P1;

/// A schedule at one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointQuality {
    /// The point's name.
    pub point: String,
    /// Its flight time, s.
    pub time_s: f64,
    /// What was measured there.
    pub quality: LoopQuality,
}

impl PointQuality {
    /// Whether overshoot and residual are accepted here.
    pub fn accepted(&self) -> bool {
        self.quality.overshoot.is_some_and(|v| v <= OVERSHOOT)
            && self.quality.residual.is_some_and(|v| v <= RESIDUAL)
    }
}

/// Gains of a schedule at a flight time.
pub fn gains_at(data: &ScheduleData, time_s: f64) -> LoopGains {
    let begun = data.switch_time_s.partition_point(|&t| t <= time_s);
    schedule::gains(data, begun.max(1) - 1)
}

/// The points of the shipped study on the vehicle's own flight, and those that it lacks.
pub fn points(vehicle: &Vehicle) -> Result<(Vec<SlicePoint>, Vec<Lacking>), StudyError> {
    let study = Study::shipped()?;
    let (mut found, mut lacking) = (Vec::new(), Vec::new());
    for point in locate(&study.points, vehicle)? {
        match point {
            Ok(slice) => found.push(slice),
            Err(reason) => lacking.push(reason),
        }
    }
    Ok((found, lacking))
}

/// Runs the pitch test with a schedule's gains at some points.
///
/// # Errors
/// [`DesignFault`]: the machine.
pub fn evaluate(
    console: &mut Console<'_>,
    bench: &PitchBench,
    vehicle: &Vehicle,
    points: &[SlicePoint],
    data: &ScheduleData,
) -> Result<Vec<PointQuality>, DesignFault> {
    points
        .iter()
        .map(|slice| {
            let gains = gains_at(data, slice.time_s);
            let frozen = FrozenPoint::new(vehicle, slice, &gains);
            Ok(PointQuality {
                point: slice.name.clone(),
                time_s: slice.time_s,
                quality: measure(console, bench, &frozen)?,
            })
        })
        .collect()
}

impl PointQuality {
    /// Which criteria it fails and by how much, as `overshoot 31.2 % at max-q (32.5 s)`.
    pub fn failures(&self) -> Vec<String> {
        let of = |name: &str, value: Option<f64>, most: f64| {
            let told = match value {
                Some(v) if v <= most => return None,
                Some(v) => format!("{name} {:.1} %", 100.0 * v),
                None => format!("no {name}, it diverges,"),
            };
            Some(format!("{told} at {} ({} s)", self.point, self.time_s))
        };
        let overshoot = of("overshoot", self.quality.overshoot, OVERSHOOT);
        let residual = of("residual", self.quality.residual, RESIDUAL);
        overshoot.into_iter().chain(residual).collect()
    }
}

/// Whether a schedule is accepted at every point.
pub fn accepted(points: &[PointQuality]) -> bool {
    points.iter().all(PointQuality::accepted)
}

/// The point of the greatest overshoot; a missing one counts as the greatest.
pub fn worst(points: &[PointQuality]) -> Option<&PointQuality> {
    let of = |p: &PointQuality| p.quality.overshoot.unwrap_or(f64::INFINITY);
    points.iter().max_by(|a, b| of(a).total_cmp(&of(b)))
}
