//! The two paths along which the axes are compared: mean attitude, specific forces, gravity.

use crate::flight::FlightFault;
use vehicle::{Vehicle, airframe::airframe_at, slice, trajectory::FlightError};

/// Earth radius, m (mean), and gravity at the surface, m/s², of the level path.
const EARTH_RADIUS_M: f64 = 6_371_000.0;
const GRAVITY_M_S2: f64 = 9.806_65;

/// Mean attitude at the start, rad (40°), which is also γ at the start.
const MEAN_RAD: f64 = 40_f64.to_radians();
/// Steady rate of the mean attitude, rad/s.
const TURN_RAD_S: f64 = -0.005;
const SPEED_M_S: f64 = 1074.0;
const ALTITUDE_M: f64 = 20_000.0;
/// Specific axial force X, m/s².
const AXIAL_M_S2: f64 = 25.0;
/// Specific normal force per angle of attack N, m/s² per rad.
const NORMAL_M_S2_PER_RAD: f64 = 32.0;
const STOP_S: f64 = 20.0;

/// What the vehicle does but for its oscillation.
#[derive(Clone, Copy, Debug)]
pub enum Path<'v> {
    /// Near burn-out, with constant forces and a steady turn: the axes alone tell.
    Fast,
    /// The first stage without wind, its mean attitude that of the stored pitch programme: as the
    /// paper has it. From where the programme turns fastest to burn-out: before, at some ten metres
    /// a second, any swing of the attitude is a swing of the path.
    Launch {
        vehicle: &'v Vehicle,
        from_s: f64,
        /// V, γ and h then.
        start: [f64; 3],
    },
}

/// Specific forces: axial, m/s², and normal per angle of attack, m/s² per rad.
#[derive(Clone, Copy, Debug)]
pub struct Forces {
    pub axial: f64,
    pub normal_slope: f64,
}

impl<'v> Path<'v> {
    /// The launch of a vehicle.
    pub fn launch(vehicle: &'v Vehicle) -> Result<Path<'v>, FlightFault> {
        let programme = &vehicle.data().pitch_programme;
        let rates = programme.rate_dps.iter().zip(&programme.node_time_s);
        let fastest = rates.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let from_s = fastest.map_or(0.0, |(_, time_s)| *time_s);
        let mut path = Path::Launch { vehicle, from_s, start: [0.0; 3] };
        let at_start = slice::points(vehicle, &[("", from_s)])?;
        if let (Path::Launch { start, .. }, Some(point)) = (&mut path, at_start.first()) {
            let s = &point.trajectory;
            *start = [s.speed_mps, s.path_angle_rad, s.altitude_m];
        }
        Ok(path)
    }

    pub fn name(self) -> &'static str {
        match self {
            Path::Fast => "1074 m/s",
            Path::Launch { .. } => "launch",
        }
    }

    /// How long it is looked at, s.
    pub fn stop_s(self) -> f64 {
        match self {
            Path::Fast => STOP_S,
            Path::Launch { vehicle, from_s, .. } => vehicle.data().mass.burn_time_s - from_s,
        }
    }

    /// Mean attitude after a time, rad from the horizontal of the launch point, and its rate just after, rad/s.
    pub fn attitude(self, time_s: f64) -> (f64, f64) {
        match self {
            Path::Fast => (MEAN_RAD + TURN_RAD_S * time_s, TURN_RAD_S),
            Path::Launch { vehicle, from_s, .. } => {
                let command = vehicle.pitch_programme().at(from_s + time_s);
                (command.pitch_rad, command.pitch_rate_radps)
            }
        }
    }

    /// V, γ and h at the start.
    pub fn start(self) -> [f64; 3] {
        match self {
            Path::Fast => [SPEED_M_S, MEAN_RAD, ALTITUDE_M],
            Path::Launch { start, .. } => start,
        }
    }

    /// Distance to the centre of the earth, m, and gravity there, m/s².
    pub fn gravity(self, altitude_m: f64) -> (f64, f64) {
        match self {
            Path::Fast => {
                let r = EARTH_RADIUS_M + altitude_m;
                (r, GRAVITY_M_S2 * (EARTH_RADIUS_M / r).powi(2))
            }
            Path::Launch { vehicle, .. } => {
                let site = &vehicle.data().site;
                let r = site.earth_radius_m + altitude_m;
                (r, site.mu_m3ps2 / (r * r))
            }
        }
    }

    /// After a time, at an altitude and a speed.
    pub fn forces(self, time_s: f64, altitude_m: f64, speed: f64) -> Result<Forces, FlightFault> {
        let Path::Launch { vehicle, from_s, .. } = self else {
            return Ok(Forces { axial: AXIAL_M_S2, normal_slope: NORMAL_M_S2_PER_RAD });
        };
        let time_s = from_s + time_s;
        let a = airframe_at(vehicle, time_s, altitude_m, speed)
            .map_err(|source| FlightError::Atmosphere { time_s, source })?;
        Ok(Forces {
            axial: (a.thrust_n - a.axial_force_n) / a.mass_kg,
            normal_slope: a.normal_force_slope_nprad / a.mass_kg,
        })
    }

    /// `(X + N)/V`, 1/s, where it is constant: the rate at which the path turns for each radian of
    /// attitude.
    pub fn lever(self) -> Option<f64> {
        matches!(self, Path::Fast).then_some((AXIAL_M_S2 + NORMAL_M_S2_PER_RAD) / SPEED_M_S)
    }
}
