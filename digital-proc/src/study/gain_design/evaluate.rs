//! A schedule seen by the short-period model at the study's trajectory points.

use super::criteria::{LoopQuality, measure};
use crate::{
    linkage::console::Console,
    study::{
        fault::StudyFault,
        short_period::{
            claims::{OVERSHOOT_P1, RESIDUAL_P1},
            machine::Bench,
            places::{Lacking, locate},
            point::FrozenPoint,
            study_file::{Study, StudyError},
        },
    },
};
use vehicle::{
    ScheduleData, Vehicle,
    gain_schedule::{DeadZoneLaw, LoopGains},
    slice::SlicePoint,
};

/// A schedule at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointQuality {
    /// The point's name.
    pub point: String,
    /// Its flight time, s.
    pub time_s: f64,
    /// What was measured there.
    pub quality: LoopQuality,
}

impl PointQuality {
    /// Whether overshoot and residual are accepted here (criterion P1).
    pub fn accepted(&self) -> bool {
        self.failures().is_empty()
    }

    /// Which criteria it fails and by how much, as `overshoot 31.2 % at max-q (32.5 s)`.
    pub(super) fn failures(&self) -> Vec<String> {
        let of = |(name, value, most): (&str, Option<f64>, f64)| {
            let told = match value {
                Some(v) if v <= most => return None,
                Some(v) => format!("{name} {:.1} %", 100.0 * v),
                None => format!("no {name}, it diverges,"),
            };
            Some(format!("{told} at {} ({} s)", self.point, self.time_s))
        };
        let judged = [
            ("overshoot", self.quality.overshoot, OVERSHOOT_P1),
            ("residual", self.quality.residual, RESIDUAL_P1),
        ];
        judged.into_iter().filter_map(of).collect()
    }
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
pub fn evaluate(
    console: &mut Console<'_>,
    bench: &Bench,
    vehicle: &Vehicle,
    points: &[SlicePoint],
    data: &ScheduleData,
) -> Result<Vec<PointQuality>, StudyFault> {
    let law = DeadZoneLaw::new(vehicle.data());
    let frozen: Vec<FrozenPoint> = points
        .iter()
        .map(|slice| {
            let begun = data.switch_time_s.partition_point(|&t| t <= slice.time_s);
            FrozenPoint::new(vehicle, slice, &LoopGains::of(data, begun.max(1) - 1, law))
        })
        .collect();
    let qualities = measure(console, bench, &frozen, |_| {})?;
    let at = |(slice, quality): (&SlicePoint, LoopQuality)| PointQuality {
        point: slice.name.clone(),
        time_s: slice.time_s,
        quality,
    };
    Ok(points.iter().zip(qualities).map(at).collect())
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
