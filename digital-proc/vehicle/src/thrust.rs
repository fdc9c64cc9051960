//! Vacuum thrust, mass flow and propellant left.
//!
//! The shape in the data set is scaled so that its impulse is
//! m_prop·Isp·g0 exactly; the mass flow is F_vac/(Isp·g0), so that the
//! propellant is used up when the table ends. Propellant burnt is the exact
//! integral of the piecewise-linear flow, not a quadrature.
//! Thrust in the air is F_vac − A_exit·p(h); near tail-off this would turn
//! negative (the nozzle no longer flows full); it is then zero, and flagged.

use super::data::VehicleData;
use crate::table::{Edge, Table, TableError};

/// Standard gravity, m/s²: unit of specific impulse.
pub const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;

#[derive(Debug, Clone, PartialEq)]
pub struct Motor {
    vacuum_thrust_n: Table,
    /// Propellant burnt at each abscissa of the thrust table, kg.
    burnt_kg: Vec<f64>,
    exhaust_speed_mps: f64,
    exit_area_m2: f64,
    propellant_kg: f64,
    scale: f64,
}

/// The motor at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorState {
    /// Scaled vacuum thrust, N.
    pub vacuum_thrust_n: f64,
    /// Mass flow, kg/s, positive while burning.
    pub mass_flow_kgps: f64,
    pub propellant_left_kg: f64,
    pub edge: Edge,
}

/// Thrust in the air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetThrust {
    /// Thrust, N, never negative.
    pub thrust_n: f64,
    /// True when F_vac − A_exit·p was negative and zero was taken.
    pub nozzle_unfilled: bool,
}

impl Motor {
    pub(crate) fn new(data: &VehicleData) -> Result<Self, TableError> {
        let shape = Table::new(data.thrust.time_s.clone(), data.thrust.vacuum_thrust_n.clone())?;
        let exhaust_speed_mps = data.thrust.specific_impulse_s * STANDARD_GRAVITY_MPS2;
        let cumulative = cumulative_integral(&shape);
        let impulse_ns = cumulative.last().copied().unwrap_or(0.0);
        let scale = data.mass.propellant_kg * exhaust_speed_mps / impulse_ns;
        Ok(Self {
            vacuum_thrust_n: shape.scaled(scale),
            burnt_kg: cumulative
                .iter()
                .map(|impulse| impulse * scale / exhaust_speed_mps)
                .collect(),
            exhaust_speed_mps,
            exit_area_m2: data.thrust.exit_area_m2,
            propellant_kg: data.mass.propellant_kg,
            scale,
        })
    }

    /// Factor applied to the thrust shape of the data set.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    pub fn at(&self, time_s: f64) -> MotorState {
        let found = self.vacuum_thrust_n.lookup(time_s);
        let times = self.vacuum_thrust_n.abscissae();
        let last = times.len() - 1;
        let burnt_kg = match found.edge {
            Edge::Below => 0.0,
            Edge::Above => self.burnt_kg[last],
            Edge::Inside => {
                let left = times.partition_point(|&t| t <= time_s).clamp(1, last) - 1;
                let mean_n = 0.5 * (self.vacuum_thrust_n.ordinates()[left] + found.value);
                self.burnt_kg[left] + mean_n * (time_s - times[left]) / self.exhaust_speed_mps
            }
        };
        MotorState {
            vacuum_thrust_n: found.value,
            mass_flow_kgps: found.value / self.exhaust_speed_mps,
            propellant_left_kg: self.propellant_kg - burnt_kg,
            edge: found.edge,
        }
    }

    pub fn net_thrust(&self, vacuum_thrust_n: f64, pressure_pa: f64) -> NetThrust {
        let net_n = vacuum_thrust_n - self.exit_area_m2 * pressure_pa;
        NetThrust { thrust_n: net_n.max(0.0), nozzle_unfilled: net_n < 0.0 }
    }
}

/// ∫ from the first abscissa to each abscissa; the trapezoid rule is exact here.
fn cumulative_integral(table: &Table) -> Vec<f64> {
    let (x, y) = (table.abscissae(), table.ordinates());
    let mut total = 0.0;
    let mut cumulative = vec![0.0];
    for i in 1..x.len() {
        total += 0.5 * (y[i] + y[i - 1]) * (x[i] - x[i - 1]);
        cumulative.push(total);
    }
    cumulative
}
