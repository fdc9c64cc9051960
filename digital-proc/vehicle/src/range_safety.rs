//! Range safety: where the vehicle would fall, and the corridor in which it may.
//!
//! The instantaneous impact point is where the vehicle comes down if nothing but gravity acts
//! from now on: a Kepler arc in vacuum to the surface of the spherical, non-rotating Earth of the
//! model. Drag would shorten it, a rotating Earth would move it west; neither is in it. With
//! R = [r sin Γ, y, r cos Γ] and its velocity, the specific angular momentum H = |R| V_h, the
//! radial speeds V_r now and at the surface (from the energy), and μ:
//! * e cos ν = H²/(μ r) − 1, e sin ν = V_r H/μ, now and at the surface with r = R_E;
//! * the range angle from now on is the difference of the two ν, along the horizontal velocity.
//!
//! The corridor lies about the ground track of the launch plane: as wide as at the launch point
//! behind it, opening by an angle before it, and closed behind. The paper speaks of "range safety
//! limits on the flight azimuth" (§4); its values are lost.

use crate::trajectory::TrajectoryState;
use crate::{RangeSafety, Site};
use std::f64::consts::TAU;

/// A place on the ground, along and across the track of the launch plane.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroundPoint {
    /// From the launch point along the track, m.
    pub downrange_m: f64,
    /// Off the track to starboard, m.
    pub cross_m: f64,
}

/// Where the vehicle stands over the ground.
pub fn ground_point(site: &Site, state: &TrajectoryState) -> GroundPoint {
    let radius_m = site.earth_radius_m + state.altitude_m;
    GroundPoint {
        downrange_m: site.earth_radius_m * state.range_angle_rad,
        cross_m: site.earth_radius_m * libm::atan2(state.cross_m, radius_m),
    }
}

/// The instantaneous impact point; none where the arc never meets the surface.
pub fn impact_point(site: &Site, state: &TrajectoryState) -> Option<GroundPoint> {
    let (mu, surface_m) = (site.mu_m3ps2, site.earth_radius_m);
    let in_plane_m = surface_m + state.altitude_m;
    let (sin_range, cos_range) = libm::sincos(state.range_angle_rad);
    let (sin_g, cos_g) = libm::sincos(state.path_angle_rad);
    let (up, along) = (state.speed_mps * sin_g, state.speed_mps * cos_g);
    let position = [in_plane_m * sin_range, state.cross_m, in_plane_m * cos_range];
    let velocity = [
        up * sin_range + along * cos_range,
        state.cross_speed_mps,
        up * cos_range - along * sin_range,
    ];
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let radius_m = dot(&position, &position).sqrt();
    if radius_m <= surface_m {
        return Some(ground_point(site, state));
    }
    let zenith = position.map(|x| x / radius_m);
    let radial_mps = dot(&velocity, &zenith);
    let level: [f64; 3] = std::array::from_fn(|i| velocity[i] - radial_mps * zenith[i]);
    let level_mps = dot(&level, &level).sqrt();

    let momentum = radius_m * level_mps;
    let fall = 2.0 * mu * (1.0 / surface_m - 1.0 / radius_m);
    let radial_at_surface = radial_mps * radial_mps + level_mps * level_mps + fall
        - (momentum / surface_m) * (momentum / surface_m);
    let energy = 0.5 * dot(&velocity, &velocity) - mu / radius_m;
    if radial_at_surface < 0.0 || (energy >= 0.0 && radial_mps > 0.0) {
        return None;
    }
    let parameter_m = momentum * momentum / mu;
    let now = [parameter_m / radius_m - 1.0, radial_mps * momentum / mu];
    let then = [parameter_m / surface_m - 1.0, -radial_at_surface.sqrt() * momentum / mu];
    let sine = now[0] * then[1] - now[1] * then[0];
    let cosine = now[0] * then[0] + now[1] * then[1];
    let angle_rad = libm::atan2(sine, cosine).rem_euclid(TAU);
    let (sine, cosine) = libm::sincos(angle_rad);
    // Without horizontal speed it falls where it stands, whatever the direction.
    let onward = level.map(|x| if level_mps > 0.0 { x / level_mps } else { 0.0 });
    let below: [f64; 3] = std::array::from_fn(|i| cosine * zenith[i] + sine * onward[i]);
    Some(GroundPoint {
        downrange_m: surface_m * libm::atan2(below[0], below[2]),
        cross_m: surface_m * libm::atan2(below[1], libm::hypot(below[0], below[2])),
    })
}

impl RangeSafety {
    /// Half the width of the corridor so far down the track, m.
    pub fn half_width_m(&self, downrange_m: f64) -> f64 {
        self.half_width_m + downrange_m.max(0.0) * libm::tan(self.opening_deg.to_radians())
    }

    /// How much of the corridor a point uses: 0 in its middle, 1 at an edge, more outside.
    pub fn used(&self, point: &GroundPoint) -> f64 {
        let sideways = point.cross_m.abs() / self.half_width_m(point.downrange_m);
        sideways.max(-point.downrange_m / self.behind_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vehicle;
    use crate::rk4;

    fn state(speed_mps: f64, path_deg: f64, altitude_m: f64, cross: [f64; 2]) -> TrajectoryState {
        TrajectoryState {
            speed_mps,
            path_angle_rad: path_deg.to_radians(),
            altitude_m,
            range_angle_rad: 0.0015,
            cross_speed_mps: cross[0],
            cross_m: cross[1],
        }
    }

    /// The fall integrated in Cartesian axes, which share nothing with the arc's elements.
    fn fallen(site: &Site, from: &TrajectoryState) -> GroundPoint {
        let r = site.earth_radius_m + from.altitude_m;
        let (sr, cr) = from.range_angle_rad.sin_cos();
        let (up, along) = (
            from.speed_mps * from.path_angle_rad.sin(),
            from.speed_mps * from.path_angle_rad.cos(),
        );
        let mut y = [
            r * sr,
            from.cross_m,
            r * cr,
            up * sr + along * cr,
            from.cross_speed_mps,
            up * cr - along * sr,
        ];
        let radius = |y: &[f64; 6]| (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]).sqrt();
        let step = |y: &[f64; 6], h: f64| {
            rk4::step(0.0, y, h, |_, y| {
                let pull = -site.mu_m3ps2 / radius(y).powi(3);
                Ok::<_, ()>([y[3], y[4], y[5], pull * y[0], pull * y[1], pull * y[2]])
            })
            .unwrap()
        };
        loop {
            let next = step(&y, 0.05);
            if radius(&next) <= site.earth_radius_m {
                break;
            }
            y = next;
        }
        // The rest of the last step by halving it.
        let mut h = 0.05;
        for _ in 0..50 {
            h /= 2.0;
            let next = step(&y, h);
            if radius(&next) > site.earth_radius_m {
                y = next;
            }
        }
        GroundPoint {
            downrange_m: site.earth_radius_m * y[0].atan2(y[2]),
            cross_m: site.earth_radius_m * y[1].atan2(y[0].hypot(y[2])),
        }
    }

    #[test]
    fn the_arc_ends_where_the_integrated_fall_does() {
        let site = Vehicle::shipped().unwrap().data().site.clone();
        for from in [
            state(1052.0, 67.0, 23_600.0, [12.0, 150.0]),
            state(400.0, 85.0, 6_000.0, [-30.0, -400.0]),
            state(1.0, 89.9994, 10.0, [0.0, 0.0]),
            state(300.0, -40.0, 4_000.0, [5.0, 20.0]),
            state(6_500.0, 30.0, 150_000.0, [100.0, 5_000.0]),
        ] {
            let (arc, fall) = (impact_point(&site, &from).unwrap(), fallen(&site, &from));
            // RK4 at 0.05 s: h⁴/120 of a fifth derivative below g·(V/r)³, nothing; what is left
            // is rounding of positions of 6.4e6 m over some 1e4 steps, 1e-9·1e4 m at most.
            let apart = (arc.downrange_m - fall.downrange_m).hypot(arc.cross_m - fall.cross_m);
            assert!(apart < 1e-3, "{from:?}: {arc:?} {fall:?}");
        }
    }

    #[test]
    fn what_does_not_come_down_has_no_impact_point() {
        let site = Vehicle::shipped().unwrap().data().site.clone();
        // Circular speed at 200 km is 7784 m/s, escape 11,008 m/s.
        assert_eq!(impact_point(&site, &state(7_800.0, 0.0, 200e3, [0.0; 2])), None);
        assert_eq!(impact_point(&site, &state(11_100.0, 80.0, 200e3, [0.0; 2])), None);
        assert!(impact_point(&site, &state(7_000.0, 0.0, 200e3, [0.0; 2])).is_some());
        // On the ground it lies where it is.
        let grounded = impact_point(&site, &state(1.0, 0.0, 0.0, [0.0, 30.0])).unwrap();
        assert!((grounded.cross_m - 30.0).abs() < 1e-6);
    }

    #[test]
    fn the_corridor_opens_down_the_track_and_ends_behind_the_launch_point() {
        let mut corridor = Vehicle::shipped().unwrap().data().range_safety.clone();
        (corridor.half_width_m, corridor.opening_deg, corridor.behind_m) = (1e3, 45.0, 500.0);
        let used = |downrange_m, cross_m| corridor.used(&GroundPoint { downrange_m, cross_m });
        // tan 45° is 1 but for one rounding.
        assert!((used(2e3, -3.3e3) - 1.1).abs() < 1e-12);
        assert!((used(2e3, 1.5e3) - 0.5).abs() < 1e-12);
        assert_eq!(used(-800.0, 0.0), 1.6);
        assert_eq!(used(-100.0, 1.2e3), 1.2);
        assert_eq!(used(0.0, 0.0), 0.0);
    }
}
