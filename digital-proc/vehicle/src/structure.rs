//! The vehicle as a beam: bending moments along it, eq. (23) of the paper.
//!
//! BM(x) = M_α α + M_F F_F + M_T F_T + M_mis + Σ M_ηi η̈_i, x in metres forward of the nozzle exit.
//! Departs from the paper, eq. (23): β is a control deflection, here the forces that it makes, and
//! the modes enter by their inertia, since the unit of the printed η̇ does not fit.
//!
//! Forces F and loads per length w(s) count towards +z (down), couples per length c(s) nose up;
//! BM is positive where both ends are bent towards −z, so for α > 0:
//! BM(x) = −∫_{s<x} (x − s) w ds − ∫_{s<x} c ds. Yaw is the same with its own incidence and forces.
//!
//! * Mass μ(s): components and remaining propellant as uniform rods.
//! * Air, −QSα n(s): the nose's share as a triangle on its length, the rest of the body uniform
//!   from the nozzle exit to where it gives the tables' centre of pressure, the fins at theirs.
//!   The two sums are those of L_α and M_α. Rates and jet damping make no load.
//! * F_F at the tips, F_T at the injection plane; misalignment as the side force at the nozzle and
//!   a couple T·offset spread like the mass.
//! * Relief, −μ(s)[a₀ − θ̈(s − x_cg)], a₀ = ΣF/m, θ̈ = [ΣF(x_cg − x) + ∫c ds]/I of these loads alone,
//!   so that both ends are free of moment.
//! * Modes: shapes of a uniform beam ([`crate::beam_shape`]) made orthogonal on μ, first to the
//!   rigid ones, then to the modes below, with φ_i(0) = 1; M_i = ∫μφ_i²,
//!   f_i = [∫w φ_i ds − ∫c φ_i′ ds]/M_i, M_ηi(x) = ∫_{s<x} (x − s) μφ_i ds (mode acceleration).
//!
//! All shapes are sums of five known ones, and the mass is that without propellant and so much
//! propellant: so every integral over the mass is found once, for each part and shape.

use crate::airframe::AirframeCoefficients;
use crate::beam_shape::{MODES, SHAPES, ShapesAt, shapes_at};
use crate::{Vehicle, VehicleData};

/// Stations in a metre: a moment is sought every 0.05 m.
pub const STATIONS_PER_M: f64 = 20.0;
/// Stations that tables show, m.
pub const TEN_STATIONS_M: [f64; 10] = [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0];
/// Number of loads: incidence, tip force, thrust-vector force, misalignment.
pub const LOADS: usize = 4;

/// What bends the vehicle in one plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Loads {
    /// Angle of attack in the plane, rad.
    pub incidence_rad: f64,
    /// Force of the fin tips, N, positive nose up.
    pub tip_force_n: f64,
    /// Force of the injection, N, positive nose up.
    pub tvc_force_n: f64,
    /// Fraction of the 3σ misalignment.
    pub misalignment: f64,
}

impl Loads {
    fn to_array(self) -> [f64; LOADS] {
        [self.incidence_rad, self.tip_force_n, self.tvc_force_n, self.misalignment]
    }
}

/// Where and how strongly loads act at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Applied {
    pub time_s: f64,
    pub mach: f64,
    /// L_α, N/rad.
    pub normal_force_slope_nprad: f64,
    /// M_α, N·m/rad.
    pub moment_slope_nmprad: f64,
    /// l_f, m.
    pub tip_arm_m: f64,
    /// l_t, m.
    pub tvc_arm_m: f64,
    /// Moment of the 3σ misalignment, N·m.
    pub misalignment_moment_nm: f64,
    /// ω of the first mode, rad/s; the others keep their ratio to it.
    pub bending_frequency_radps: f64,
    /// ζ of the first mode.
    pub bending_damping: f64,
}

impl Applied {
    /// Of the airframe in flight.
    pub fn new(vehicle: &Vehicle, time_s: f64, airframe: &AirframeCoefficients) -> Applied {
        let bending = vehicle.bending_at(time_s);
        Applied {
            time_s,
            mach: airframe.mach,
            normal_force_slope_nprad: airframe.normal_force_slope_nprad,
            moment_slope_nmprad: airframe.moment_slope_nmprad,
            tip_arm_m: airframe.tip_arm_m,
            tvc_arm_m: airframe.tvc_arm_m,
            misalignment_moment_nm: airframe.misalignment_moment_nm,
            bending_frequency_radps: bending.natural_frequency_radps,
            bending_damping: bending.damping_ratio,
        }
    }
}

/// The body's normal force, apart from the fins': shares of nose and cylinder, which add up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BodyLoads {
    nose: f64,
    cylinder: f64,
    /// The cylinder's share lies between the nozzle exit and here, m.
    extent_m: f64,
}

impl BodyLoads {
    /// For a slope of the body and its centre of pressure; nothing where no such load gives them.
    pub(crate) fn new(data: &VehicleData, slope: f64, x_m: f64) -> Option<BodyLoads> {
        let aero = &data.aero;
        let (nose_m, length_m) = (aero.nose_length_m, data.geometry.length_m);
        let nose_x_m = length_m - 2.0 / 3.0 * nose_m;
        let rest = slope - aero.nose_slope;
        if rest == 0.0 {
            let there = slope == 0.0 || x_m == nose_x_m;
            return there.then_some(BodyLoads { nose: 1.0, cylinder: 0.0, extent_m: length_m });
        }
        let extent_m = 2.0 * (slope * x_m - aero.nose_slope * nose_x_m) / rest;
        let whole = rest > 0.0 && extent_m > 0.0 && extent_m <= length_m;
        let (nose, cylinder) = (aero.nose_slope / slope, rest / slope);
        (whole && x_m != data.geometry.fin_x_m).then_some(BodyLoads { nose, cylinder, extent_m })
    }
}

/// A vehicle of which no beam can be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error, serde::Serialize, serde::Deserialize)]
pub enum StructureError {
    #[error(
        "at Mach {mach} no uniform load gives the body its slope and centre of pressure beside the nose; check aero.CN_nose, CN_body, x_body"
    )]
    BodyLoads { mach: f64 },
    #[error(
        "mode {mode} has no inertia of its own in this mass distribution; check mass.components"
    )]
    NoMode { mode: usize },
}

/// Integrals over some mass, for every shape f.
#[derive(Debug, Clone, PartialEq)]
struct Layout {
    /// ∫μ f g ds.
    gram: [[f64; SHAPES]; SHAPES],
    /// ∫μ f′ ds.
    turned: [f64; SHAPES],
    /// ∫_{s<x} μ ds at every station.
    behind_kg: Vec<f64>,
    /// ∫_{s<x} (x − s) μ f ds at every station.
    moment: [Vec<f64>; SHAPES],
}

/// Points and weights of Gauss's rule of five points on −1…1, which is exact to the ninth degree.
const GAUSS: [(f64, f64); 5] = [
    (0.0, 128.0 / 225.0),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];
/// Panels of a rod; a twentieth of a rod is a quarter radian of the third shape at most, and its
/// tenth power over 10! is below rounding.
const PANELS: u32 = 20;

impl Layout {
    fn empty(stations: usize) -> Layout {
        Layout {
            gram: [[0.0; SHAPES]; SHAPES],
            turned: [0.0; SHAPES],
            behind_kg: vec![0.0; stations],
            moment: std::array::from_fn(|_| vec![0.0; stations]),
        }
    }

    /// Adds a rod of a mass (kg) about a centre, of a length (m; 0 for a point).
    fn add(&mut self, length_m: f64, stations: &[(f64, ShapesAt)], [mass, centre, rod]: [f64; 3]) {
        let at = |x: f64| shapes_at(length_m, x);
        let mut weigh = |mass: f64, shape: &[f64; SHAPES]| {
            for (row, f) in self.gram.iter_mut().zip(shape) {
                row.iter_mut().zip(shape).for_each(|(sum, g)| *sum += mass * f * g);
            }
        };
        if rod == 0.0 {
            let there = at(centre);
            weigh(mass, &there.value);
            for f in 0..SHAPES {
                self.turned[f] += mass * there.slope[f];
            }
            for (j, (x, _)) in stations.iter().enumerate().filter(|(_, (x, _))| *x > centre) {
                self.behind_kg[j] += mass;
                for f in 0..SHAPES {
                    self.moment[f][j] += mass * (x - centre) * there.value[f];
                }
            }
            return;
        }
        let (aft, density) = (centre - 0.5 * rod, mass / rod);
        let half = 0.5 * rod / f64::from(PANELS);
        for panel in 0..PANELS {
            let middle = aft + half * f64::from(2 * panel + 1);
            for (point, weight) in GAUSS {
                weigh(density * half * weight, &at(middle + half * point).value);
            }
        }
        let (start, end) = (at(aft), at(aft + rod));
        for f in 0..SHAPES {
            self.turned[f] += density * (end.value[f] - start.value[f]);
        }
        for (j, (x, here)) in stations.iter().enumerate().filter(|(_, (x, _))| *x > aft) {
            let (to, there) = if *x < aft + rod { (*x, here) } else { (aft + rod, &end) };
            self.behind_kg[j] += density * (to - aft);
            for f in 0..SHAPES {
                self.moment[f][j] += density
                    * ((x - to) * there.integral[f] - (x - aft) * start.integral[f]
                        + there.double_integral[f]
                        - start.double_integral[f]);
            }
        }
    }
}

/// The structure of a vehicle: what depends on no time.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    vehicle: Vehicle,
    stations_m: Vec<f64>,
    /// Everything but the propellant.
    dry: Layout,
    /// One kilogram of propellant.
    propellant: Layout,
    /// (x − s)·n of the nose at every station, n of sum 1.
    nose: Vec<f64>,
    /// ∫n f ds of the nose.
    nose_sum: [f64; SHAPES],
    /// Shapes at the nozzle exit.
    exit: ShapesAt,
}

impl Structure {
    pub fn new(vehicle: &Vehicle) -> Structure {
        let data = vehicle.data();
        let (length_m, nose_m) = (data.geometry.length_m, data.aero.nose_length_m);
        let grain = [1.0, data.mass.propellant_x_m, data.mass.propellant_length_m];
        let parts = data.mass.components.iter().map(|c| [c.1, c.2, c.3]);
        // Both ends of all that has mass or load lie between the first and the last station.
        let rods = parts.clone().chain([grain]);
        let (mut aft_m, mut fore_m) = (0.0_f64, length_m);
        for [_, centre, rod] in rods {
            aft_m = aft_m.min(centre - 0.5 * rod);
            fore_m = fore_m.max(centre + 0.5 * rod);
        }
        let first = (aft_m * STATIONS_PER_M).floor() as i64;
        let last = (fore_m * STATIONS_PER_M).ceil() as i64;
        let stations: Vec<(f64, ShapesAt)> = (first..=last)
            .map(|n| n as f64 / STATIONS_PER_M)
            .map(|x| (x, shapes_at(length_m, x)))
            .collect();
        let mut dry = Layout::empty(stations.len());
        parts.for_each(|part| dry.add(length_m, &stations, part));
        let mut propellant = Layout::empty(stations.len());
        propellant.add(length_m, &stations, grain);
        // n = 2(L − s)/l² on the nose.
        let start_m = length_m - nose_m;
        let (start, tip) = (shapes_at(length_m, start_m), shapes_at(length_m, length_m));
        let over_square = 2.0 / (nose_m * nose_m);
        let nose = |x: f64| {
            let u = (x - start_m).clamp(0.0, nose_m);
            let lever = if x > length_m { x - length_m } else { 0.0 };
            over_square * (nose_m * u * u / 2.0 - u * u * u / 6.0) + lever
        };
        Structure {
            vehicle: vehicle.clone(),
            nose: stations.iter().map(|(x, _)| nose(*x)).collect(),
            nose_sum: std::array::from_fn(|f| {
                over_square
                    * (tip.double_integral[f]
                        - start.double_integral[f]
                        - nose_m * start.integral[f])
            }),
            stations_m: stations.into_iter().map(|(x, _)| x).collect(),
            dry,
            propellant,
            exit: shapes_at(length_m, 0.0),
        }
    }

    /// Stations of all moments, m, [`STATIONS_PER_M`] of them, from the aft end to the fore end.
    pub fn stations_m(&self) -> &[f64] {
        &self.stations_m
    }

    /// Whose structure it is.
    pub fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    /// Index of the station nearest to `x_m`.
    pub fn nearest(&self, x_m: f64) -> usize {
        let n = ((x_m - self.stations_m[0]) * STATIONS_PER_M).round().max(0.0) as usize;
        n.min(self.stations_m.len() - 1)
    }

    /// The beam at one time.
    pub fn beam(&self, applied: &Applied) -> Result<Beam, StructureError> {
        Beam::new(self, applied)
    }
}

/// A free-free mode of the vehicle at one time, φ(0) = 1.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Mode {
    /// M_i, kg.
    pub mass_kg: f64,
    /// ω_i, rad/s.
    pub frequency_radps: f64,
    /// ζ_i.
    pub damping: f64,
    /// f_i of each load, 1: m/s² per rad, per N (twice), and of the 3σ misalignment.
    drive: [f64; LOADS],
}

/// The vehicle as a beam at one time.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Beam {
    pub mass_kg: f64,
    pub cg_x_m: f64,
    pub inertia_kgm2: f64,
    pub modes: [Mode; MODES],
    /// a₀ (m/s²) and θ̈ (rad/s²) of each load, 1.
    rigid: [[f64; 2]; LOADS],
    /// M_α (N·m), M_F, M_T (m) and M_mis (N·m) at every station.
    columns: [Vec<f64>; LOADS],
    /// M_ηi at every station, kg·m.
    inertia: [Vec<f64>; MODES],
}

fn dot(a: &[f64; SHAPES], b: &[f64; SHAPES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds a multiple of a column.
fn add(sum: &mut [f64], factor: f64, column: &[f64]) {
    sum.iter_mut().zip(column).for_each(|(s, c)| *s += factor * c);
}

impl Beam {
    fn new(structure: &Structure, applied: &Applied) -> Result<Beam, StructureError> {
        let vehicle = &structure.vehicle;
        let data = vehicle.data();
        let length_m = data.geometry.length_m;
        let propellant_kg = vehicle.motor().at(applied.time_s).propellant_left_kg;
        let (dry, grain) = (&structure.dry, &structure.propellant);
        let gram: [[f64; SHAPES]; SHAPES] = std::array::from_fn(|f| {
            std::array::from_fn(|g| dry.gram[f][g] + propellant_kg * grain.gram[f][g])
        });
        let mass_kg = gram[0][0];
        let cg_x_m = gram[0][1] / mass_kg;
        let inertia_kgm2 = gram[1][1] - cg_x_m * gram[0][1];

        let shapes = orthogonal(&gram, cg_x_m, inertia_kgm2, &structure.exit.value)?;

        // L_α and M_α as a force on the body and one on the fins.
        let mach = applied.mach;
        let aero = vehicle.aero_at(mach);
        let body = BodyLoads::new(data, aero.body_slope, aero.body_x_m)
            .ok_or(StructureError::BodyLoads { mach })?;
        let (lift, fin_x_m) = (applied.normal_force_slope_nprad, data.geometry.fin_x_m);
        let on_body = if aero.body_slope == 0.0 {
            0.0
        } else {
            (applied.moment_slope_nmprad - lift * (fin_x_m - cg_x_m)) / (aero.body_x_m - fin_x_m)
        };
        let normal_nprad = [on_body, lift - on_body];

        let nozzle_x_m = data.geometry.nozzle_x_m;
        let side = libm::sin(data.disturbance.thrust_misalign_deg.to_radians());
        let offset_m = data.disturbance.cg_offset_m;
        let arm_m = side * (cg_x_m - nozzle_x_m) + offset_m;
        let thrust_n = if arm_m == 0.0 { 0.0 } else { applied.misalignment_moment_nm / arm_m };
        let misalignment = [thrust_n * side, thrust_n * offset_m];

        let (tip_x_m, tvc_x_m) = (cg_x_m - applied.tip_arm_m, cg_x_m - applied.tvc_arm_m);
        let [fin, tip, tvc, nozzle] =
            [fin_x_m, tip_x_m, tvc_x_m, nozzle_x_m].map(|x| shapes_at(length_m, x).value);
        let extent = shapes_at(length_m, body.extent_m).integral;
        // ∫w f ds − ∫c f′ ds of each load, 1.
        let on_air = std::array::from_fn(|f| {
            let cylinder = (extent[f] - structure.exit.integral[f]) / body.extent_m;
            let on_body = body.nose * structure.nose_sum[f] + body.cylinder * cylinder;
            -normal_nprad[0] * on_body - normal_nprad[1] * fin[f]
        });
        let on_thrust = std::array::from_fn(|f| {
            let turned = dry.turned[f] + propellant_kg * grain.turned[f];
            misalignment[0] * nozzle[f] - misalignment[1] * turned / mass_kg
        });
        let work: [[f64; SHAPES]; LOADS] = [on_air, tip, tvc, on_thrust];

        let bending = &data.bending;
        let modes = std::array::from_fn(|i| {
            let (shape, mass_kg) = shapes[i];
            let (ratio, damping) = match i.checked_sub(1) {
                None => (1.0, applied.bending_damping),
                Some(high) => (bending.frequency_ratio[high], bending.high_damping_ratio[high]),
            };
            Mode {
                mass_kg,
                frequency_radps: ratio * applied.bending_frequency_radps,
                damping,
                drive: work.map(|work| dot(&shape, &work) / mass_kg),
            }
        });
        // Shape 1 is moved by F; shape x by F x and turned by −c, so that this is nose up.
        let rigid = work.map(|w| [w[0] / mass_kg, (cg_x_m * w[0] - w[1]) / inertia_kgm2]);

        // ∫_{s<x} (x − s) μ f ds of the whole mass.
        let moment: [Vec<f64>; SHAPES] = std::array::from_fn(|f| {
            let mut sum = dry.moment[f].clone();
            add(&mut sum, propellant_kg, &grain.moment[f]);
            sum
        });
        let stations_m = &structure.stations_m;
        let lever = |force_n: f64, at_m: f64| -> Vec<f64> {
            let moment_nm = |x: &f64| force_n * if *x > at_m { x - at_m } else { 0.0 };
            stations_m.iter().map(moment_nm).collect()
        };
        let mut columns = [
            lever(normal_nprad[1], fin_x_m),
            lever(-1.0, tip_x_m),
            lever(-1.0, tvc_x_m),
            lever(-misalignment[0], nozzle_x_m),
        ];
        add(&mut columns[0], normal_nprad[0] * body.nose, &structure.nose);
        let cylinder_npm = normal_nprad[0] * body.cylinder / body.extent_m;
        for (sum, x) in columns[0].iter_mut().zip(stations_m) {
            let covered = x.clamp(0.0, body.extent_m);
            *sum += cylinder_npm * covered * (x - 0.5 * covered);
        }
        let couple_npkg = misalignment[1] / mass_kg;
        add(&mut columns[3], -couple_npkg, &dry.behind_kg);
        add(&mut columns[3], -couple_npkg * propellant_kg, &grain.behind_kg);
        for (column, [lateral, turning]) in columns.iter_mut().zip(rigid) {
            add(column, lateral + turning * cg_x_m, &moment[0]);
            add(column, -turning, &moment[1]);
        }
        let inertia = shapes.map(|(shape, _)| {
            let mut sum = vec![0.0; stations_m.len()];
            moment.iter().zip(shape).for_each(|(column, part)| add(&mut sum, part, column));
            sum
        });
        Ok(Beam { mass_kg, cg_x_m, inertia_kgm2, modes, rigid, columns, inertia })
    }

    /// a₀ (m/s², towards +z) and θ̈ (rad/s²) under loads.
    pub fn rigid_acceleration(&self, loads: &Loads) -> [f64; 2] {
        let loads = loads.to_array();
        std::array::from_fn(|k| loads.iter().zip(&self.rigid).map(|(load, r)| load * r[k]).sum())
    }

    /// f_i of every mode under loads, m/s².
    pub fn drive(&self, loads: &Loads) -> [f64; MODES] {
        let loads = loads.to_array();
        self.modes.map(|mode| loads.iter().zip(&mode.drive).map(|(load, f)| load * f).sum())
    }

    /// Adds the quasi-static moment under loads to `moment_nm`, N·m at every station.
    pub fn add_quasi_static(&self, loads: &Loads, moment_nm: &mut [f64]) {
        for (load, column) in loads.to_array().into_iter().zip(&self.columns) {
            add(moment_nm, load, column);
        }
    }

    /// M_ηi at every station, kg·m.
    pub fn mode_columns(&self) -> [&[f64]; MODES] {
        self.inertia.each_ref().map(Vec::as_slice)
    }

    /// Adds Σ M_ηi η̈_i to `moment_nm`, accelerations in m/s².
    pub fn add_modes(&self, acceleration_mps2: [f64; MODES], moment_nm: &mut [f64]) {
        for (acceleration, column) in acceleration_mps2.into_iter().zip(&self.inertia) {
            add(moment_nm, acceleration, column);
        }
    }
}

/// Shapes of the modes and their masses: rigid part taken off, then the parts along the modes
/// below, scaled to 1 at the nozzle exit.
fn orthogonal(
    gram: &[[f64; SHAPES]; SHAPES],
    cg_x_m: f64,
    inertia_kgm2: f64,
    exit: &[f64; SHAPES],
) -> Result<[([f64; SHAPES], f64); MODES], StructureError> {
    let over = |a: &[f64; SHAPES], b: &[f64; SHAPES]| -> f64 {
        a.iter().zip(gram).map(|(part, row)| part * dot(row, b)).sum()
    };
    let mut modes = [([0.0; SHAPES], 0.0); MODES];
    let fore_and_aft = [-cg_x_m, 1.0, 0.0, 0.0, 0.0];
    for i in 0..MODES {
        let mut shape = [0.0; SHAPES];
        shape[2 + i] = 1.0;
        let (moved, turned) =
            (gram[0][2 + i] / gram[0][0], over(&fore_and_aft, &shape) / inertia_kgm2);
        shape[0] = -moved + turned * cg_x_m;
        shape[1] = -turned;
        for (lower, mass_kg) in &modes[..i] {
            let along = over(lower, &shape) / mass_kg;
            shape.iter_mut().zip(lower).for_each(|(part, l)| *part -= along * l);
        }
        let end = dot(&shape, exit);
        let shape = shape.map(|part| part / end);
        let mass_kg = over(&shape, &shape);
        if !(mass_kg.is_finite() && mass_kg > 0.0) {
            return Err(StructureError::NoMode { mode: i + 1 });
        }
        modes[i] = (shape, mass_kg);
    }
    Ok(modes)
}

#[cfg(test)]
mod tests;
