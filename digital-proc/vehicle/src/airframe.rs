//! Coefficients of the attitude equations: what the digital side sets.
//!
//! At a flight time, altitude and airspeed this module evaluates everything
//! that multiplies an analog signal, in the sign convention of the whole
//! project: pitch and yaw share their slopes (axisymmetric body), stations count
//! forward from the nozzle exit, a positive control force turns the nose up.
//! With S the reference area, V_m = max(V_a, 30 m/s):
//!
//! | symbol | formula |
//! |---|---|
//! | L_α | Q S (C_Nb + C_Nf) |
//! | M_α | Q S [C_Nb (x_b − x_cg) + C_Nf (x_fin − x_cg)] |
//! | M_q | −(Q S/V_m)[C_Nb (x_b − x_cg)² + C_Nf (x_fin − x_cg)²] − ṁ r_exit² − İ_yy |
//! | A | Q S C_A |
//! | F_δ | 2 Q S_t C_Nt, a pair of tips |
//! | l_f, l_t | x_cg − x_tip, x_cg − x_sitvc |
//! | L_p | −(Q S/V_m) 2 C_Nf y_fin² |
//! | L_pair | 2 Q S_t C_Nt y_tip |
//! | M_cant | Q S 2 C_Nf y_fin · cant |
//! | M_mis | T [sin(misalignment) (x_cg − x_nozzle) + cg_offset], at 3σ |
//!
//! ṁ is the positive mass flow and İ_yy < 0, so that −İ_yy takes away from the
//! jet damping. Departs from the paper, eq. (2): its last term ṁ q r_ex² damps
//! only with ṁ < 0, the sign used here. Departs from the paper, eq. (2), row 3:
//! the yaw moment is M_α α_y with the same sign as pitch (centre of pressure
//! ahead of the centre of gravity overturns in either plane). Departs from the
//! paper, eq. (1): Q A₁ C_D is the axial force Q S C_A, since the row is in body
//! axes. İ_xx p is left out of the roll row together with the swirl the jet
//! carries away, which is of the same size and the opposite sign.

use crate::Vehicle;
use crate::atmosphere::{AtmosphereError, air_at};
use crate::table_edges::{EdgeRecord, TableName};

/// Below this airspeed the rate damping is that of 30 m/s: the slopes divide by
/// the airspeed, and at lift-off there is no flow to damp anything.
pub const DAMPING_AIRSPEED_FLOOR_MPS: f64 = 30.0;

/// Everything that the analog patch needs of the airframe at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AirframeCoefficients {
    /// m, kg.
    pub mass_kg: f64,
    /// ṁ, kg/s, positive while burning.
    pub mass_flow_kgps: f64,
    /// x_cg, m forward of the nozzle exit.
    pub cg_x_m: f64,
    /// I_yy = I_zz, kg·m².
    pub pitch_inertia_kgm2: f64,
    /// İ_yy, kg·m²/s.
    pub pitch_inertia_rate_kgm2ps: f64,
    /// I_xx, kg·m².
    pub roll_inertia_kgm2: f64,
    /// T, N.
    pub thrust_n: f64,
    /// True when the nozzle would flow unfilled and thrust was taken as zero.
    pub nozzle_unfilled: bool,
    /// Q, Pa.
    pub dynamic_pressure_pa: f64,
    pub mach: f64,
    /// V_a, m/s.
    pub airspeed_mps: f64,
    /// A, N.
    pub axial_force_n: f64,
    /// L_α, N/rad.
    pub normal_force_slope_nprad: f64,
    /// M_α, N·m/rad; positive overturns.
    pub moment_slope_nmprad: f64,
    /// M_q, N·m·s/rad; negative damps.
    pub rate_damping_nms: f64,
    /// F_δ, N/rad, of a pair of tips.
    pub tip_pair_force_slope_nprad: f64,
    /// l_f, m.
    pub tip_arm_m: f64,
    /// l_t, m.
    pub tvc_arm_m: f64,
    /// L_p, N·m·s/rad.
    pub roll_damping_nms: f64,
    /// L_pair, N·m/rad, of a pair of tips deflected in opposite senses.
    pub tip_pair_roll_slope_nmprad: f64,
    /// Rolling moment of the canted fixed fins, N·m.
    pub fin_cant_moment_nm: f64,
    /// Moment of the 3σ thrust misalignment and offset, N·m, to be multiplied
    /// by the fraction of it that a case assumes.
    pub misalignment_moment_nm: f64,
    pub edges: EdgeRecord,
}

/// Evaluates the coefficients at a time (s), geometric altitude (m) and
/// airspeed (m/s). Refuses an altitude outside the atmosphere.
pub fn airframe_at(
    vehicle: &Vehicle,
    time_s: f64,
    altitude_m: f64,
    airspeed_mps: f64,
) -> Result<AirframeCoefficients, AtmosphereError> {
    let air = air_at(altitude_m)?;
    let (mass, motor) = vehicle.mass_at(time_s);
    let net = vehicle.motor().net_thrust(motor.vacuum_thrust_n, air.pressure_pa);
    let mach = airspeed_mps / air.speed_of_sound_mps;
    let aero = vehicle.aero_at(mach);
    let data = vehicle.data();
    let geometry = &data.geometry;

    let mut edges = EdgeRecord::NONE;
    edges.note(TableName::Thrust, motor.edge);
    edges.note(TableName::RollInertia, mass.roll_edge);
    edges.note(TableName::Aerodynamics, aero.edge);

    let q_pa = 0.5 * air.density_kgpm3 * airspeed_mps * airspeed_mps;
    let qs_n = q_pa * geometry.reference_area_m2;
    let damping_qs = qs_n / airspeed_mps.max(DAMPING_AIRSPEED_FLOOR_MPS);
    let body_arm_m = aero.body_x_m - mass.cg_x_m;
    let fin_arm_m = geometry.fin_x_m - mass.cg_x_m;
    let tip_pair_n = 2.0 * q_pa * data.aero.tip_area_m2 * aero.tip_slope;
    let disturbance = &data.disturbance;
    let misalignment_arm_m = libm::sin(disturbance.thrust_misalign_deg.to_radians())
        * (mass.cg_x_m - geometry.nozzle_x_m)
        + disturbance.cg_offset_m;

    Ok(AirframeCoefficients {
        mass_kg: mass.mass_kg,
        mass_flow_kgps: motor.mass_flow_kgps,
        cg_x_m: mass.cg_x_m,
        pitch_inertia_kgm2: mass.pitch_inertia_kgm2,
        pitch_inertia_rate_kgm2ps: mass.pitch_inertia_rate_kgm2ps,
        roll_inertia_kgm2: mass.roll_inertia_kgm2,
        thrust_n: net.thrust_n,
        nozzle_unfilled: net.nozzle_unfilled,
        dynamic_pressure_pa: q_pa,
        mach,
        airspeed_mps,
        axial_force_n: qs_n * aero.axial,
        normal_force_slope_nprad: qs_n * (aero.body_slope + aero.fin_slope),
        moment_slope_nmprad: qs_n * (aero.body_slope * body_arm_m + aero.fin_slope * fin_arm_m),
        rate_damping_nms: -damping_qs
            * (aero.body_slope * body_arm_m.powi(2) + aero.fin_slope * fin_arm_m.powi(2))
            - motor.mass_flow_kgps * data.mass.exit_radius_m.powi(2)
            - mass.pitch_inertia_rate_kgm2ps,
        tip_pair_force_slope_nprad: tip_pair_n,
        tip_arm_m: mass.cg_x_m - geometry.tip_x_m,
        tvc_arm_m: mass.cg_x_m - geometry.injection_x_m,
        roll_damping_nms: -damping_qs * 2.0 * aero.fin_slope * geometry.fin_y_m.powi(2),
        tip_pair_roll_slope_nmprad: tip_pair_n * geometry.tip_y_m,
        fin_cant_moment_nm: qs_n
            * 2.0
            * aero.fin_slope
            * geometry.fin_y_m
            * data.aero.fin_cant_deg.to_radians(),
        misalignment_moment_nm: net.thrust_n * misalignment_arm_m,
        edges,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_with_a_hand_calculation_at_mach_two() {
        let vehicle = Vehicle::shipped().unwrap();
        let air = air_at(9_000.0).unwrap();
        let k = airframe_at(&vehicle, 30.0, 9_000.0, 2.0 * air.speed_of_sound_mps).unwrap();
        let (mass, _) = vehicle.mass_at(30.0);
        let qs = k.dynamic_pressure_pa * std::f64::consts::FRAC_PI_4;
        // Columns of the file at Mach 2: C_Nb 3.20, x_b 16.6, C_Nf 1.35, C_Nt 1.90.
        let (b, f) = (16.6 - mass.cg_x_m, 0.60 - mass.cg_x_m);
        let speed = 2.0 * air.speed_of_sound_mps;
        let rows = [
            ("A", k.axial_force_n, qs * 0.54),
            ("L_alpha", k.normal_force_slope_nprad, qs * 4.55),
            ("M_alpha", k.moment_slope_nmprad, qs * (3.20 * b + 1.35 * f)),
            ("F_delta", k.tip_pair_force_slope_nprad, 2.0 * k.dynamic_pressure_pa * 0.065 * 1.90),
            ("L_p", k.roll_damping_nms, -qs / speed * 2.0 * 1.35 * 0.75 * 0.75),
            (
                "L_pair",
                k.tip_pair_roll_slope_nmprad,
                2.0 * k.dynamic_pressure_pa * 0.065 * 1.90 * 1.05,
            ),
            ("cant", k.fin_cant_moment_nm, qs * 2.0 * 1.35 * 0.75 * (0.05f64).to_radians()),
            (
                "M_q",
                k.rate_damping_nms,
                -qs / speed * (3.20 * b * b + 1.35 * f * f)
                    - k.mass_flow_kgps
                        * (9.5 * 9.5 - 8.2 * 8.2 / 12.0 - (5.3 - mass.cg_x_m).powi(2)),
            ),
        ];
        for (what, got, hand) in rows {
            // The file prints π/4 with ten digits: half a unit of 1e-10 of 0.785.
            assert!((got / hand - 1.0).abs() < 0.7e-10, "{what}: {got} against {hand}");
        }
        assert!(k.edges.is_empty());
    }

    #[test]
    fn edges_and_the_unfilled_nozzle_are_flagged() {
        let vehicle = Vehicle::shipped().unwrap();
        let k = airframe_at(&vehicle, 49.5, 20_000.0, 2_000.0).unwrap();
        let names: Vec<_> = k.edges.iter().map(|(table, _)| table).collect();
        assert_eq!(names, [TableName::Thrust, TableName::RollInertia, TableName::Aerodynamics]);
        assert!(k.nozzle_unfilled);
        assert!(airframe_at(&vehicle, 10.0, 90_000.0, 500.0).is_err());
    }
}
