//! Natural frequency and damping ratio dispersed together: of the sensor, and of the structure.
//!
//! A frequency that is off moves the phase at which a damping that is off is felt, so that one at a
//! time says little of both. Each pair is followed over a grid between its settings by the
//! eigenvalues of the linearised loop, least over what the channels may show.

use super::{
    dispersion_file::{Dispersed, Dispersions},
    run::dampings,
};
use crate::study::short_period::point::{FrozenPoint, Quantity};
use desk::{
    outcome::{Figure, Outcome},
    report::{
        Column, Table, anchor,
        plot::{HeatCell, HeatMap, heat_map},
    },
};
use vehicle::{Vehicle, slice::SlicePoint};

/// Settings of each quantity, its ends included.
const SETTINGS: u32 = 5;

/// What belongs together: a natural frequency and its damping ratio.
const PAIRS: [(&str, [&str; 2]); 2] = [
    ("Rate gyro", ["gyro-frequency", "gyro-damping"]),
    ("First bending mode", ["bending-frequency", "bending-damping"]),
];

/// One pair at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Of what.
    pub title: &'static str,
    /// The point.
    pub point: String,
    /// Factors on the frequency, and on the damping ratio.
    pub factors: [Vec<f64>; 2],
    /// Damping ratio of the attitude and least of the bending mode, a row a frequency.
    pub damping: Vec<Vec<[f64; 2]>>,
}

/// Every pair that a file disperses, at every point.
pub fn pairs(vehicle: &Vehicle, dispersions: &Dispersions, slices: &[SlicePoint]) -> Vec<Pair> {
    let mut all = Vec::new();
    for (title, names) in PAIRS {
        let [Some(frequency), Some(damping)] = names.map(|name| dispersed(dispersions, name))
        else {
            continue;
        };
        let factors = [frequency.1, damping.1].map(grid);
        for slice in slices {
            let nominal = FrozenPoint::new(vehicle, slice, &slice.settings.gains);
            let at = |w: f64, z: f64| {
                let mut point = nominal;
                for (quantity, factor) in [(frequency.0, w), (damping.0, z)] {
                    quantity.set(&mut point, quantity.get(&nominal) * factor);
                }
                let (attitude, bending) = dampings(&point);
                [attitude.unwrap_or(f64::NAN), bending]
            };
            let row = |w: &f64| factors[1].iter().map(|z| at(*w, *z)).collect();
            all.push(Pair {
                title,
                point: slice.name.clone(),
                damping: factors[0].iter().map(row).collect(),
                factors: factors.clone(),
            });
        }
    }
    all
}

fn dispersed(dispersions: &Dispersions, name: &str) -> Option<(&'static Quantity, [f64; 2])> {
    dispersions.all.iter().find_map(|d| match d.what {
        Dispersed::Factors(quantity, factors) if quantity.name == name => Some((quantity, factors)),
        _ => None,
    })
}

fn grid([low, high]: [f64; 2]) -> Vec<f64> {
    let last = f64::from(SETTINGS - 1);
    (0..SETTINGS).map(|i| low + (high - low) * f64::from(i) / last).collect()
}

impl Pair {
    /// The least of a measure (0 attitude, 1 bending), and at which factors.
    fn least(&self, measure: usize) -> (f64, [f64; 2]) {
        let mut least = (f64::INFINITY, [f64::NAN; 2]);
        for (w, row) in self.factors[0].iter().zip(&self.damping) {
            for (z, both) in self.factors[1].iter().zip(row) {
                if both[measure] < least.0 {
                    least = (both[measure], [*w, *z]);
                }
            }
        }
        least
    }
}

/// A table of the least dampings, and maps at the point where bending is damped least.
pub fn fill(pairs: &[Pair], out: &mut Outcome) {
    if pairs.is_empty() {
        return;
    }
    const SECTION: &str = "Frequency and damping together";
    let at = |(_, [w, z]): (f64, [f64; 2])| format!("× {w:.2}, × {z:.2}");
    let columns = [
        Column::new("Dispersed", "", |(p, ..): &(&Pair, String, String)| p.title.into()),
        Column::new("Point", "", |(p, ..)| p.point.as_str().into()),
        Column::of("Least attitude damping", "", 3, |(p, ..)| p.least(0).0.into()),
        Column::new("at frequency, damping", "", |(_, a, _)| a.as_str().into()),
        Column::of("Least bending damping", "", 3, |(p, ..)| p.least(1).0.into()),
        Column::new("at frequency, damping", "", |(.., b)| b.as_str().into()),
    ];
    let rows: Vec<(&Pair, String, String)> =
        pairs.iter().map(|p| (p, at(p.least(0)), at(p.least(1)))).collect();
    out.section(SECTION).table(
        "pairs",
        "Natural frequency and damping ratio of the rate gyro and of the first bending mode dispersed together, by eigenvalues; the attitude reference has no dynamics of its own.",
        Table::of(&columns, &rows),
    );
    for (title, _) in PAIRS {
        let of = pairs.iter().filter(|p| p.title == title);
        let Some(pair) = of.min_by(|a, b| a.least(1).0.total_cmp(&b.least(1).0)) else { continue };
        for (measure, label) in ["attitude", "bending"].into_iter().enumerate() {
            let cell = |both: &[f64; 2]| HeatCell {
                violated: both[measure] < 0.0,
                ..HeatCell::new(both[measure])
            };
            let factors = |all: &[f64]| all.iter().map(|f| format!("× {f:.2}")).collect();
            let map = heat_map(&HeatMap {
                quantity: format!("damping ratio of {label}"),
                corner: "frequency against damping".to_owned(),
                rows: factors(&pair.factors[0]),
                columns: factors(&pair.factors[1]),
                cells: pair.damping.iter().map(|row| row.iter().map(cell).collect()).collect(),
                scale: None,
            });
            let words = format!("{title} at {}: damping ratio of {label}", pair.point);
            out.section(SECTION).figure(Figure::new(anchor(&words), words, map));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of the grid are the settings of the dispersions, where the study one at a time
    /// has the same eigenvalues; its middle is the nominal point.
    #[test]
    fn a_grid_has_the_nominal_point_in_its_middle_and_the_settings_at_its_ends() {
        let vehicle = Vehicle::shipped().unwrap();
        let dispersions = Dispersions::shipped().unwrap();
        let slices = dispersions.locate(&vehicle).unwrap();
        let all = pairs(&vehicle, &dispersions, &slices);
        assert_eq!(all.len(), 2 * slices.len());
        for pair in &all {
            let slice = slices.iter().find(|s| s.name == pair.point).unwrap();
            let nominal = FrozenPoint::new(&vehicle, slice, &slice.settings.gains);
            let (attitude, bending) = dampings(&nominal);
            // Factors of 1 by (low + high)/2: a rounding of 1, times eigenvalues' condition.
            let [a, b] = pair.damping[2][2];
            assert!((a - attitude.unwrap()).abs() < 1e-9 && (b - bending).abs() < 1e-9, "{pair:?}");
        }
        // A lighter structural damping is a lighter closed loop, by its ζ: 0.005 of 0.010.
        let structure = &all[all.len() - 1];
        let [light, heavy] = [0, 4].map(|z| structure.damping[2][z][1]);
        assert!((heavy - light - 0.010).abs() < 0.001, "{structure:?}");
    }
}
