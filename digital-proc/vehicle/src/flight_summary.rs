//! One sample of a flight, and what a whole flight comes to.
//!
//! Fed sample by sample, from the reference integration or from the two
//! processes alike, so that both are summed up by the same rule. The load
//! measure Qα is the pitch-plane one, judged from the moment the fin tips take
//! over (17 s) on; its sign is dropped. Beside it stands the total one, with the
//! yaw incidence: Q√(α² + α_y²).

use crate::range_safety::{GroundPoint, ground_point};
use crate::table_edges::EdgeRecord;
use crate::trajectory::TrajectoryState;
use crate::{RangeSafety, STANDARD_GRAVITY_MPS2, Site, Vehicle};
use serde::{Deserialize, Serialize};

/// The variables that the paper monitors (§4.2), and those behind them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FlightSample {
    pub time_s: f64,
    /// Speed, flight-path angle, altitude, range angle.
    pub trajectory: TrajectoryState,
    /// θ, ψ, φ, rad.
    pub angle_rad: [f64; 3],
    /// θ_c, rad.
    pub pitch_command_rad: f64,
    /// α, rad.
    pub incidence_rad: f64,
    /// α_y, rad.
    pub yaw_incidence_rad: f64,
    pub mach: f64,
    /// Q, Pa.
    pub dynamic_pressure_pa: f64,
    /// Deflection of the pitch tips, of tip 2 and of tip 4, rad.
    pub tip_rad: [f64; 3],
    /// TVC force in pitch and yaw, N.
    pub tvc_n: [f64; 2],
    /// Instantaneous impact point, where there is one.
    pub impact: Option<GroundPoint>,
}

impl FlightSample {
    /// Qα, Pa·deg, signed.
    pub fn q_alpha_padeg(&self) -> f64 {
        self.dynamic_pressure_pa * self.incidence_rad.to_degrees()
    }

    /// Q√(α² + α_y²), Pa·deg.
    pub fn total_q_alpha_padeg(&self) -> f64 {
        let total_rad = libm::hypot(self.incidence_rad, self.yaw_incidence_rad);
        self.dynamic_pressure_pa * total_rad.to_degrees()
    }

    /// Angle between the nose and its command (ψ_c = 0), rad; small-angle sum of both planes.
    pub fn pointing_error_rad(&self) -> f64 {
        let [pitch, yaw, _] = self.angle_rad;
        libm::hypot(pitch - self.pitch_command_rad, yaw)
    }

    fn peak(&self, value: f64) -> Peak {
        let FlightSample { time_s, mach, trajectory, .. } = *self;
        Peak { value, time_s, mach, altitude_m: trajectory.altitude_m }
    }
}

/// A peak and where it occurred.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    pub value: f64,
    pub time_s: f64,
    pub mach: f64,
    pub altitude_m: f64,
}

/// What a flight comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightSummary {
    /// Largest dynamic pressure, Pa.
    pub max_dynamic_pressure: Peak,
    /// Largest |Qα| from the take-over of the fin tips on, Pa·deg.
    pub max_q_alpha: Peak,
    /// Largest Q√(α² + α_y²) from then on, Pa·deg.
    pub max_total_q_alpha: Peak,
    pub end: TrajectoryState,
    pub end_time_s: f64,
    /// Range over the ground at the end, m.
    pub range_m: f64,
    /// Distance over the ground from the launch track at the end, m, positive to starboard.
    pub cross_range_m: f64,
    /// Instantaneous impact point at the end.
    pub impact: Option<GroundPoint>,
    /// Most of its corridor that the impact point used: beyond 1 it lay outside.
    pub corridor_used: f64,
    /// When it first lay outside, s.
    pub corridor_left_s: Option<f64>,
    /// When the nose was first too far from its command, s.
    pub control_lost_s: Option<f64>,
    /// Largest |φ|, rad.
    pub max_roll_rad: f64,
    /// ∫|F_T| dt in pitch, N·s.
    pub tvc_pitch_impulse_ns: f64,
    /// ∫|F_T| dt in yaw, N·s.
    pub tvc_yaw_impulse_ns: f64,
    pub injectant_kg: f64,
    pub edges: EdgeRecord,
}

/// Collects a summary.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FlightMonitor {
    judged_from_s: f64,
    site: Site,
    range_safety: RangeSafety,
    side_exhaust_mps: f64,
    last: Option<FlightSample>,
    max_dynamic_pressure: Option<Peak>,
    max_q_alpha: Option<Peak>,
    max_total_q_alpha: Option<Peak>,
    corridor_used: f64,
    corridor_left_s: Option<f64>,
    control_lost_s: Option<f64>,
    max_roll_rad: f64,
    tvc_impulse_ns: [f64; 2],
    edges: EdgeRecord,
}

impl FlightMonitor {
    pub fn new(vehicle: &Vehicle) -> Self {
        let data = vehicle.data();
        Self {
            judged_from_s: data.ftc.on_time_s,
            site: data.site.clone(),
            range_safety: data.range_safety.clone(),
            side_exhaust_mps: data.tvc.side_specific_impulse_s * STANDARD_GRAVITY_MPS2,
            last: None,
            max_dynamic_pressure: None,
            max_q_alpha: None,
            max_total_q_alpha: None,
            corridor_used: 0.0,
            corridor_left_s: None,
            control_lost_s: None,
            max_roll_rad: 0.0,
            tvc_impulse_ns: [0.0; 2],
            edges: EdgeRecord::NONE,
        }
    }

    /// Takes the next sample; samples come in order of time. The TVC impulse
    /// is the trapezoid sum over the samples.
    pub fn observe(&mut self, sample: &FlightSample, edges: EdgeRecord) {
        self.edges.merge(edges);
        let keep = |held: &mut Option<Peak>, value: f64| {
            if held.is_none_or(|h| value > h.value) {
                *held = Some(sample.peak(value));
            }
        };
        keep(&mut self.max_dynamic_pressure, sample.dynamic_pressure_pa);
        if sample.time_s >= self.judged_from_s {
            keep(&mut self.max_q_alpha, sample.q_alpha_padeg().abs());
            keep(&mut self.max_total_q_alpha, sample.total_q_alpha_padeg());
        }
        if let Some(impact) = &sample.impact {
            let used = self.range_safety.used(impact);
            self.corridor_used = self.corridor_used.max(used);
            if used > 1.0 {
                self.corridor_left_s.get_or_insert(sample.time_s);
            }
        }
        if sample.pointing_error_rad() > self.range_safety.control_lost_deg.to_radians() {
            self.control_lost_s.get_or_insert(sample.time_s);
        }
        self.max_roll_rad = self.max_roll_rad.max(sample.angle_rad[2].abs());
        if let Some(last) = self.last {
            let half_s = 0.5 * (sample.time_s - last.time_s);
            for (i, impulse_ns) in self.tvc_impulse_ns.iter_mut().enumerate() {
                *impulse_ns += half_s * (last.tvc_n[i].abs() + sample.tvc_n[i].abs());
            }
        }
        self.last = Some(*sample);
    }

    /// The summary, or nothing when there was no sample. A flight that ended
    /// before the tips took over has a Qα peak of zero.
    pub fn finish(&self) -> Option<FlightSummary> {
        let last = self.last?;
        let max_dynamic_pressure = self.max_dynamic_pressure?;
        let [pitch_ns, yaw_ns] = self.tvc_impulse_ns;
        let ground = ground_point(&self.site, &last.trajectory);
        Some(FlightSummary {
            max_dynamic_pressure,
            max_q_alpha: self.max_q_alpha.unwrap_or_else(|| last.peak(0.0)),
            max_total_q_alpha: self.max_total_q_alpha.unwrap_or_else(|| last.peak(0.0)),
            end: last.trajectory,
            end_time_s: last.time_s,
            range_m: ground.downrange_m,
            cross_range_m: ground.cross_m,
            impact: last.impact,
            corridor_used: self.corridor_used,
            corridor_left_s: self.corridor_left_s,
            control_lost_s: self.control_lost_s,
            max_roll_rad: self.max_roll_rad,
            tvc_pitch_impulse_ns: pitch_ns,
            tvc_yaw_impulse_ns: yaw_ns,
            injectant_kg: (pitch_ns + yaw_ns) / self.side_exhaust_mps,
            edges: self.edges,
        })
    }
}
