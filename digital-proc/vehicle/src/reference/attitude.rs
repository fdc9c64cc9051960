//! Rotation, actuators and sensors of the long-period model, as plain Rust.
//!
//! These are the equations that the analog patch is wired for, written a second
//! time so that the two can be held against each other. Notation: coefficients
//! of [`AirframeCoefficients`], settings
//! of [`ControlSettings`], c = cos φ,
//! s = sin φ, sat(x, m) limits to ±m, dz(x, d) = x − sat(x, d).
//!
//! Error resolution through roll (paper §4.2):
//! * e_θ = θ_c − θ, e_ψ = −ψ
//! * e_p = e_θ c + e_ψ s, e_y = −e_θ s + e_ψ c; unresolved e_p = e_θ, e_y = e_ψ
//!
//! Body rates and rate gyros g_p (pitch), g_y (yaw), g_r (roll):
//! * q = θ̇ c + ψ̇ s, r = −θ̇ s + ψ̇ c, p = φ̇ (departs from the paper, eqs.
//!   (4)–(6): ψ stays small, so sec ψ = 1 and tan ψ = 0)
//! * g̈ = ω²(rate − g) − 2ζω ġ for each
//!
//! FTC channels with the bending filter (corner ω_f) in pitch and yaw:
//! * ḟ_p = ω_f (e_p − T_F g_p − f_p), ḟ_y = ω_f (e_y − T_F g_y − f_y)
//! * u_θ = K_F f_p, u_ψ = K_F f_y, u_φ = K_φ(φ_r − φ − T_φ g_r)
//!
//! Tips: one pair for pitch, tips 2 and 4 shared by yaw and roll:
//! * δ̇_p = sat((sat(u_θ, δ_max) − δ_p)/τ_F, δ̇_max)
//! * δ̇_2 likewise with u_ψ + u_φ, δ̇_4 with u_ψ − u_φ
//!
//! TVC in pitch and yaw:
//! * Ḟ_p = (sat(K_T dz(e_p − T_T g_p, e_dz), F_max) − F_p)/τ_T
//! * Ḟ_y likewise with e_y, g_y, the dead zone less what roll has of the tips:
//!   max(e_dz − k·½|δ_2 − δ_4|, 0)
//!
//! Forces and moments in body axes, with effectivenesses η:
//! * Y_p = η_p F_δ δ_p, Y_y = ½F_δ(η_2 δ_2 + η_4 δ_4)
//! * M_p = l_f Y_p + l_t F_p + M_mis,p, M_y = l_f Y_y + l_t F_y + M_mis,y
//!   (thrust misalignment is fixed to the body and turns with it)
//! * M_r = ½L_pair(η_2 δ_2 − η_4 δ_4) + M_cant
//!
//! Rotation, with the airframe moments in the planes of θ and ψ:
//! * I_yy θ̈ = M_α α + M_q θ̇ + M_p c − M_y s
//! * I_yy ψ̈ = M_α α_y + M_q ψ̇ + M_p s + M_y c
//! * I_xx φ̈ = L_p φ̇ + M_r
//! * α = θ + Γ − γ_air, α_y = ψ + crosswind angle (yaw drift is not integrated)
//!
//! Control forces in the planes of θ and ψ, for the trajectory:
//! * F_c = (Y_p + F_p) c − (Y_y + F_y) s, and (Y_p + F_p) s + (Y_y + F_y) c in yaw
//!
//! Departs from the paper, eq. (2): products of rates (I_zz − I_yy) qr and the
//! like are left out; they vanish in pitch and yaw for small p and in roll
//! because I_yy = I_zz.

use crate::Vehicle;
use crate::airframe::AirframeCoefficients;
use crate::flight_mode::ControlSettings;
use crate::trajectory::Attitude;

pub const STATE_LEN: usize = 19;

/// The attitude side's state; see the field order in [`AttitudeState::to_array`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttitudeState {
    /// θ, ψ, φ, rad.
    pub angle_rad: [f64; 3],
    /// θ̇, ψ̇, φ̇, rad/s.
    pub rate_radps: [f64; 3],
    /// δ_p, δ_2, δ_4, rad.
    pub tip_rad: [f64; 3],
    /// F_p, F_y, N.
    pub tvc_n: [f64; 2],
    /// g_p, g_y, g_r, rad/s.
    pub gyro_radps: [f64; 3],
    /// Their rates, rad/s².
    pub gyro_rate_radps2: [f64; 3],
    /// f_p, f_y, rad.
    pub filter_rad: [f64; 2],
}

impl AttitudeState {
    /// On the pad: pointing up, everything else zero.
    pub fn on_pad(vehicle: &Vehicle, roll_rad: f64) -> Self {
        let mut state = Self::from_array([0.0; STATE_LEN]);
        state.angle_rad[2] = roll_rad;
        state.angle_rad[0] = vehicle.data().pitch_programme.theta0_deg.to_radians();
        state
    }

    /// `[angles 3, rates 3, tips 3, tvc 2, gyros 3, gyro rates 3, filters 2]`.
    pub fn to_array(self) -> [f64; STATE_LEN] {
        let mut array = [0.0; STATE_LEN];
        array[0..3].copy_from_slice(&self.angle_rad);
        array[3..6].copy_from_slice(&self.rate_radps);
        array[6..9].copy_from_slice(&self.tip_rad);
        array[9..11].copy_from_slice(&self.tvc_n);
        array[11..14].copy_from_slice(&self.gyro_radps);
        array[14..17].copy_from_slice(&self.gyro_rate_radps2);
        array[17..19].copy_from_slice(&self.filter_rad);
        array
    }

    pub fn from_array(a: [f64; STATE_LEN]) -> Self {
        Self {
            angle_rad: [a[0], a[1], a[2]],
            rate_radps: [a[3], a[4], a[5]],
            tip_rad: [a[6], a[7], a[8]],
            tvc_n: [a[9], a[10]],
            gyro_radps: [a[11], a[12], a[13]],
            gyro_rate_radps2: [a[14], a[15], a[16]],
            filter_rad: [a[17], a[18]],
        }
    }
}

/// What reaches the attitude side from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttitudeInputs {
    pub airframe: AirframeCoefficients,
    pub settings: ControlSettings,
    /// θ_c, rad.
    pub pitch_command_rad: f64,
    /// Γ − γ_air, rad: α = θ + this.
    pub incidence_offset_rad: f64,
    /// Crosswind angle, rad: α_y = ψ + this.
    pub yaw_incidence_offset_rad: f64,
    /// Thrust misalignment in pitch and yaw, fractions of 3σ.
    pub misalignment: [f64; 2],
    /// φ_r, what the roll loop takes for zero, rad.
    pub roll_reference_rad: f64,
    /// Whether the errors are resolved through roll.
    pub errors_resolved: bool,
}

/// Limits to ±`limit`.
fn saturated(x: f64, limit: f64) -> f64 {
    x.clamp(-limit, limit)
}

/// Zero within ±`half_width`, the excess beyond.
fn dead_zone(x: f64, half_width: f64) -> f64 {
    x - saturated(x, half_width)
}

/// Forces (N) of the tips in body pitch and yaw.
fn tip_forces_n(state: &AttitudeState, inputs: &AttitudeInputs) -> [f64; 2] {
    let slope = inputs.airframe.tip_pair_force_slope_nprad;
    let settings = &inputs.settings;
    let [pitch, two, four] = state.tip_rad;
    [
        settings.pitch_tips_effectiveness * slope * pitch,
        0.5 * slope * (settings.tip_2_effectiveness * two + settings.tip_4_effectiveness * four),
    ]
}

/// The attitude as the translation takes it.
pub fn for_translation(state: &AttitudeState, inputs: &AttitudeInputs) -> Attitude {
    let (s, c) = libm::sincos(state.angle_rad[2]);
    let tips = tip_forces_n(state, inputs);
    let [body_p, body_y] = std::array::from_fn(|i| tips[i] + state.tvc_n[i]);
    Attitude {
        pitch_rad: state.angle_rad[0],
        yaw_rad: state.angle_rad[1],
        control_force_n: [body_p * c - body_y * s, body_p * s + body_y * c],
    }
}

pub fn derivative(
    vehicle: &Vehicle,
    state: &AttitudeState,
    inputs: &AttitudeInputs,
) -> AttitudeState {
    let data = vehicle.data();
    let airframe = &inputs.airframe;
    let settings = &inputs.settings;
    let gains = &settings.gains;
    let [theta, psi, phi] = state.angle_rad;
    let [theta_rate, psi_rate, phi_rate] = state.rate_radps;
    let (s, c) = libm::sincos(phi);

    let e_theta = inputs.pitch_command_rad - theta;
    let e_psi = -psi;
    let errors = if inputs.errors_resolved {
        [e_theta * c + e_psi * s, -e_theta * s + e_psi * c]
    } else {
        [e_theta, e_psi]
    };
    let body_rates = [theta_rate * c + psi_rate * s, -theta_rate * s + psi_rate * c, phi_rate];

    let (wn, zeta) = (data.gyro.natural_frequency_radps, data.gyro.damping_ratio);
    let gyro_acceleration = std::array::from_fn(|i| {
        wn * wn * (body_rates[i] - state.gyro_radps[i])
            - 2.0 * zeta * wn * state.gyro_rate_radps2[i]
    });

    let corner = data.bending.filter_corner_radps;
    let filter_rate = std::array::from_fn(|i| {
        corner * (errors[i] - gains.ftc_lead_s * state.gyro_radps[i] - state.filter_rad[i])
    });
    let ftc_gain = settings.ftc_gain();
    let tvc_gain_nprad = settings.tvc_gain_nprad();
    let u_theta = ftc_gain[0] * state.filter_rad[0];
    let u_psi = ftc_gain[1] * state.filter_rad[1];
    let u_phi = settings.roll_gain
        * (inputs.roll_reference_rad - phi - settings.roll_lead_s * state.gyro_radps[2]);
    let travel = data.ftc.delta_max_deg.to_radians();
    let slew = data.ftc.rate_max_dps.to_radians();
    let commands = [u_theta, u_psi + u_phi, u_psi - u_phi];
    let tip_rate = std::array::from_fn(|i| {
        let lag = (saturated(commands[i], travel) - state.tip_rad[i]) / data.ftc.time_constant_s;
        saturated(lag, slew)
    });

    let in_roll = 0.5 * (state.tip_rad[1] - state.tip_rad[2]).abs();
    let left_in_yaw = (gains.dead_zone_rad - gains.dead_zone_yield * in_roll).max(0.0);
    let half_width = [gains.dead_zone_rad, left_in_yaw];
    let tvc_rate = std::array::from_fn(|i| {
        let error = errors[i] - gains.tvc_lead_s * state.gyro_radps[i];
        let wanted =
            saturated(tvc_gain_nprad[i] * dead_zone(error, half_width[i]), data.tvc.force_max_n);
        (wanted - state.tvc_n[i]) / data.tvc.time_constant_s
    });

    let tips = tip_forces_n(state, inputs);
    let moment: [f64; 2] = std::array::from_fn(|i| {
        airframe.tip_arm_m * tips[i]
            + airframe.tvc_arm_m * state.tvc_n[i]
            + airframe.misalignment_moment_nm * inputs.misalignment[i]
    });
    let roll_moment = 0.5
        * airframe.tip_pair_roll_slope_nmprad
        * (settings.tip_2_effectiveness * state.tip_rad[1]
            - settings.tip_4_effectiveness * state.tip_rad[2])
        + airframe.fin_cant_moment_nm;
    let alpha = theta + inputs.incidence_offset_rad;
    let alpha_y = psi + inputs.yaw_incidence_offset_rad;
    let inertia = airframe.pitch_inertia_kgm2;
    AttitudeState {
        angle_rad: state.rate_radps,
        rate_radps: [
            (airframe.moment_slope_nmprad * alpha
                + airframe.rate_damping_nms * theta_rate
                + moment[0] * c
                - moment[1] * s)
                / inertia,
            (airframe.moment_slope_nmprad * alpha_y
                + airframe.rate_damping_nms * psi_rate
                + moment[0] * s
                + moment[1] * c)
                / inertia,
            (airframe.roll_damping_nms * phi_rate + roll_moment) / airframe.roll_inertia_kgm2,
        ],
        tip_rad: tip_rate,
        tvc_n: tvc_rate,
        gyro_radps: state.gyro_rate_radps2,
        gyro_rate_radps2: gyro_acceleration,
        filter_rad: filter_rate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{airframe::airframe_at, flight_mode::ControlSettings};

    /// What no flight of the shipped vehicle need reach; the rest is held against the patch.
    #[test]
    fn actuators_keep_their_limits() {
        let vehicle = Vehicle::shipped().unwrap();
        let inputs = AttitudeInputs {
            airframe: airframe_at(&vehicle, 32.0, 9_800.0, 670.0).unwrap(),
            settings: ControlSettings::sound(&vehicle, 32.0),
            pitch_command_rad: 1.0,
            incidence_offset_rad: 0.0,
            yaw_incidence_offset_rad: 0.0,
            misalignment: [0.0, 0.0],
            roll_reference_rad: 0.0,
            errors_resolved: true,
        };
        let mut state = AttitudeState::from_array([0.0; STATE_LEN]);
        let force_n =
            derivative(&vehicle, &state, &inputs).tvc_n[0] * vehicle.data().tvc.time_constant_s;
        assert!((force_n - 15_000.0).abs() < 1e-9);
        // A full filter asks for more than the travel; the servo slews.
        state.filter_rad[0] = 1.0;
        assert_eq!(derivative(&vehicle, &state, &inputs).tip_rad[0], f64::to_radians(100.0));
        state.tip_rad[0] = f64::to_radians(10.0);
        assert!(derivative(&vehicle, &state, &inputs).tip_rad[0].abs() < 1e-12);
    }
}
