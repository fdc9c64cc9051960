//! Runs the dispersions on the machine and ranks them.

use super::dispersion_file::{Dispersion, Dispersions, Side};
use crate::{
    linkage::console::Console,
    study::{
        fault::StudyFault,
        gain_design::criteria::{LoopQuality, least_bending_damping, measure},
        short_period::{
            coefficients::{Disturbance, Plane},
            linear::{ChannelGains, plane_roots},
            machine::Bench,
            point::FrozenPoint,
        },
    },
};
use interface::side_by_side;
use vehicle::{Vehicle, slice::SlicePoint};

/// Corners of each point that are also run on the machine.
const CORNERS_RUN: usize = 2;

/// A result that dispersions are ranked by.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    pub(super) label: &'static str,
    pub(super) unit: &'static str,
    /// Its value; no number where a run diverged.
    pub of: fn(&LoopQuality) -> f64,
}

impl Measure {
    /// Of the undisturbed step, % of it.
    pub const OVERSHOOT: Measure =
        Measure { label: "Overshoot", unit: "%", of: |q| percent(q.overshoot) };
    /// Under misalignment and gust, % of the step.
    pub const RESIDUAL: Measure =
        Measure { label: "Residual oscillation", unit: "%", of: |q| percent(q.residual) };
    /// At 5–6.5 s, % of that after the step.
    pub const BENDING_LEFT: Measure =
        Measure { label: "Bending envelope left", unit: "%", of: |q| percent(q.bending_decay) };
    /// Of the loop with both channels linear.
    pub const ATTITUDE_DAMPING: Measure = Measure {
        label: "Attitude damping ratio",
        unit: "",
        of: |q| q.attitude_damping.unwrap_or(f64::NAN),
    };
    /// The least over the channels' states.
    pub const BENDING_DAMPING: Measure =
        Measure { label: "Bending damping ratio", unit: "", of: |q| q.bending_damping };

    /// All, in the order of the tables.
    pub const ALL: [Measure; 5] = [
        Measure::OVERSHOOT,
        Measure::RESIDUAL,
        Measure::BENDING_LEFT,
        Measure::ATTITUDE_DAMPING,
        Measure::BENDING_DAMPING,
    ];
}

fn percent(value: Option<f64>) -> f64 {
    value.map_or(f64::NAN, |v| 100.0 * v)
}

/// One dispersion at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Title and settings.
    pub dispersion: String,
    /// At the lower setting.
    pub low: LoopQuality,
    /// At the upper setting.
    pub high: LoopQuality,
}

impl Effect {
    /// Greatest minus least of a measure over low, nominal and high; infinite
    /// where a run diverged.
    pub fn span(&self, measure: Measure, nominal: &LoopQuality) -> f64 {
        let values = [&self.low, nominal, &self.high].map(measure.of);
        if values.iter().any(|v| v.is_nan()) {
            return f64::INFINITY;
        }
        let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        greatest - least
    }
}

/// A corner that was run.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner {
    /// The setting of each dispersion in order: true is the upper.
    pub high: Vec<bool>,
    /// Why it was chosen.
    pub worst_in: &'static str,
    /// What it came to.
    pub quality: LoopQuality,
}

/// All dispersions at one trajectory point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSensitivity {
    /// The point.
    pub point: String,
    /// Its flight time, s.
    pub time_s: f64,
    /// Without dispersion.
    pub nominal: LoopQuality,
    /// One at a time, in the file's order.
    pub effects: Vec<Effect>,
    /// Corners looked at by eigenvalues.
    pub corners: usize,
    /// Corners with an attitude or bending root that grows.
    pub unstable_corners: usize,
    /// The worst corners, on the machine.
    pub worst_corners: Vec<Corner>,
}

impl PointSensitivity {
    /// Effects by falling span of a measure.
    pub fn ranked(&self, measure: Measure) -> Vec<&Effect> {
        let mut all: Vec<&Effect> = self.effects.iter().collect();
        all.sort_by(|a, b| {
            b.span(measure, &self.nominal).total_cmp(&a.span(measure, &self.nominal))
        });
        all
    }

    /// The greatest span of one dispersion.
    pub(super) fn widest_span(&self, measure: Measure) -> f64 {
        self.effects.iter().map(|e| e.span(measure, &self.nominal)).fold(0.0, f64::max)
    }
}

/// Runs all dispersions at all points; `progress` is told the runs done.
pub fn run(
    console: &mut Console<'_>,
    bench: &Bench,
    vehicle: &Vehicle,
    dispersions: &Dispersions,
    progress: impl FnMut(usize),
) -> Result<Vec<PointSensitivity>, StudyFault> {
    let slices = dispersions.locate(vehicle)?;
    let all = &dispersions.all;
    // At each point without dispersion, each at its lower and upper setting, and the worst corners.
    let mut asked = Vec::new();
    let nominals: Vec<FrozenPoint> = slices
        .iter()
        .map(|slice| FrozenPoint::new(vehicle, slice, &slice.settings.gains))
        .collect();
    let looked_at = side_by_side::map(nominals.len(), |i| Corners::new(vehicle, &nominals[i], all));
    for (nominal, corners) in nominals.iter().zip(&looked_at) {
        asked.push(*nominal);
        for dispersion in all {
            for side in [Side::Low, Side::High] {
                let mut point = *nominal;
                dispersion.apply(vehicle, &mut point, side);
                asked.push(point);
            }
        }
        asked.extend(corners.worst().map(|(_, bits)| corner(vehicle, nominal, all, bits)));
    }
    let qualities = measure(console, bench, &asked, progress)?;
    let of_points = qualities.chunks(1 + 2 * all.len() + CORNERS_RUN);
    let at = |((slice, corners), of): ((&SlicePoint, Corners), &[LoopQuality])| {
        let (nominal, rest) = (of[0], &of[1..]);
        let (sides, worst) = rest.split_at(2 * all.len());
        PointSensitivity {
            point: slice.name.clone(),
            time_s: slice.time_s,
            nominal,
            effects: all
                .iter()
                .zip(sides.chunks(2))
                .map(|(dispersion, sides)| Effect {
                    dispersion: dispersion.label(),
                    low: sides[0],
                    high: sides[1],
                })
                .collect(),
            corners: corners.count,
            unstable_corners: corners.unstable,
            worst_corners: corners
                .worst()
                .into_iter()
                .zip(worst)
                .map(|((worst_in, bits), quality)| Corner {
                    high: (0..all.len()).map(|i| bits >> i & 1 == 1).collect(),
                    worst_in,
                    quality: *quality,
                })
                .collect(),
        }
    };
    Ok(slices.iter().zip(looked_at).zip(of_points).map(at).collect())
}

/// Runs that [`run`] makes, counted in loops measured.
pub fn loops(dispersions: &Dispersions) -> usize {
    dispersions.points.len() * (1 + 2 * dispersions.all.len() + CORNERS_RUN)
}

/// Damping ratio of the attitude with both channels linear, and the least of the bending mode.
pub(super) fn dampings(point: &FrozenPoint) -> (Option<f64>, f64) {
    let plane = Plane::new(point, &Disturbance::NONE);
    let attitude = plane_roots(&plane, ChannelGains::BOTH).attitude;
    (attitude.map(|r| r.damping()), least_bending_damping(&plane))
}

/// The point with dispersion i at its upper setting where bit i of `bits` is 1.
fn corner(
    vehicle: &Vehicle,
    nominal: &FrozenPoint,
    all: &[Dispersion],
    bits: usize,
) -> FrozenPoint {
    let mut point = *nominal;
    for (i, dispersion) in all.iter().enumerate() {
        let side = if bits >> i & 1 == 1 { Side::High } else { Side::Low };
        dispersion.apply(vehicle, &mut point, side);
    }
    point
}

/// All corners by the eigenvalues of the linearised loop.
struct Corners {
    count: usize,
    unstable: usize,
    least_attitude: (f64, usize),
    least_bending: (f64, usize),
}

impl Corners {
    fn new(vehicle: &Vehicle, nominal: &FrozenPoint, all: &[Dispersion]) -> Corners {
        let mut corners = Corners {
            count: 1 << all.len(),
            unstable: 0,
            least_attitude: (f64::INFINITY, 0),
            least_bending: (f64::INFINITY, 0),
        };
        for bits in 0..corners.count {
            let (attitude, bending) = dampings(&corner(vehicle, nominal, all, bits));
            let attitude = attitude.unwrap_or(f64::INFINITY);
            if attitude < 0.0 || bending < 0.0 {
                corners.unstable += 1;
            }
            if attitude < corners.least_attitude.0 {
                corners.least_attitude = (attitude, bits);
            }
            if bending < corners.least_bending.0 {
                corners.least_bending = (bending, bits);
            }
        }
        corners
    }

    fn worst(&self) -> [(&'static str, usize); CORNERS_RUN] {
        [("attitude damping", self.least_attitude.1), ("bending damping", self.least_bending.1)]
    }
}
