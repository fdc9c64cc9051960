//! Aerodynamic coefficients against Mach number.

use super::data::Aero;
use crate::table::{Edge, Table, TableError};

/// Coefficients at one Mach number, per radian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AeroCoefficients {
    /// Axial force, on the reference area.
    pub axial: f64,
    /// Normal-force slope of the body, on the reference area.
    pub body_slope: f64,
    /// Centre of pressure of the body, m.
    pub body_x_m: f64,
    /// Normal-force slope of the fixed fins (two panels), on the reference area.
    pub fin_slope: f64,
    /// Normal-force slope of one tip, on the tip area.
    pub tip_slope: f64,
    /// Edge of the Mach tables (they share their abscissae).
    pub edge: Edge,
}

/// The five tables, in the order of [`AeroCoefficients`].
#[derive(Debug, Clone, PartialEq)]
pub struct AeroTables([Table; 5]);

impl AeroTables {
    pub(crate) fn new(data: &Aero) -> Result<Self, TableError> {
        let table = |values: &Vec<f64>| Table::new(data.mach.clone(), values.clone());
        Ok(Self([
            table(&data.axial)?,
            table(&data.body_slope)?,
            table(&data.body_x_m)?,
            table(&data.fin_slope)?,
            table(&data.tip_slope)?,
        ]))
    }

    /// All coefficients at a Mach number.
    pub fn at(&self, mach: f64) -> AeroCoefficients {
        let found = self.0.each_ref().map(|table| table.lookup(mach));
        let [axial, body_slope, body_x_m, fin_slope, tip_slope] = found.map(|lookup| lookup.value);
        let edge = found[0].edge;
        AeroCoefficients { axial, body_slope, body_x_m, fin_slope, tip_slope, edge }
    }
}
