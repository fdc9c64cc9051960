//! Mass, centre of gravity and moments of inertia.
//!
//! Every component and the remaining propellant is a uniform rod:
//! I = Σ m(l²/12 + (x − x_cg)²). The propellant keeps centroid and length while
//! it burns. Because Σ m(x − x_cg) = 0, the rate of inertia needs no derivative
//! of x_cg: İ = −ṁ(l_p²/12 + (x_p − x_cg)²). I_zz = I_yy.

use super::data::VehicleData;
use crate::table::{Edge, Table, TableError};

/// Mass properties at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    pub mass_kg: f64,
    /// Centre of gravity, m forward of the nozzle exit.
    pub cg_x_m: f64,
    /// Pitch (and yaw) inertia, kg·m².
    pub pitch_inertia_kgm2: f64,
    /// Its rate, kg·m²/s; negative while burning.
    pub pitch_inertia_rate_kgm2ps: f64,
    /// Roll inertia, kg·m².
    pub roll_inertia_kgm2: f64,
    pub roll_edge: Edge,
}

/// Layout of the vehicle.
#[derive(Debug, Clone, PartialEq)]
pub struct MassModel {
    dry_kg: f64,
    /// Σ m·x of the dry components, kg·m.
    dry_moment_kgm: f64,
    /// Σ m(l²/12 + x²) of the dry components about x = 0, kg·m².
    dry_second_moment_kgm2: f64,
    propellant_x_m: f64,
    propellant_length_m: f64,
    roll_inertia_kgm2: Table,
}

impl MassModel {
    pub(crate) fn new(data: &VehicleData) -> Result<Self, TableError> {
        let mut model = Self {
            dry_kg: 0.0,
            dry_moment_kgm: 0.0,
            dry_second_moment_kgm2: 0.0,
            propellant_x_m: data.mass.propellant_x_m,
            propellant_length_m: data.mass.propellant_length_m,
            roll_inertia_kgm2: Table::new(
                data.mass.roll_inertia_time_s.clone(),
                data.mass.roll_inertia_kgm2.clone(),
            )?,
        };
        for component in &data.mass.components {
            let (mass_kg, x_m, length_m) = (component.1, component.2, component.3);
            model.dry_kg += mass_kg;
            model.dry_moment_kgm += mass_kg * x_m;
            model.dry_second_moment_kgm2 += mass_kg * (length_m * length_m / 12.0 + x_m * x_m);
        }
        Ok(model)
    }

    /// Properties with `propellant_kg` left, burning at `mass_flow_kgps`.
    pub fn at(&self, time_s: f64, propellant_kg: f64, mass_flow_kgps: f64) -> MassProperties {
        let own_m2 = self.propellant_length_m * self.propellant_length_m / 12.0;
        let x_m = self.propellant_x_m;
        let mass_kg = self.dry_kg + propellant_kg;
        let cg_x_m = (self.dry_moment_kgm + propellant_kg * x_m) / mass_kg;
        let about_exit = self.dry_second_moment_kgm2 + propellant_kg * (own_m2 + x_m * x_m);
        let roll = self.roll_inertia_kgm2.lookup(time_s);
        MassProperties {
            mass_kg,
            cg_x_m,
            pitch_inertia_kgm2: about_exit - mass_kg * cg_x_m * cg_x_m,
            pitch_inertia_rate_kgm2ps: -mass_flow_kgps * (own_m2 + (x_m - cg_x_m).powi(2)),
            roll_inertia_kgm2: roll.value,
            roll_edge: roll.edge,
        }
    }
}
