//! One sample of a flight, and what a whole flight comes to.
//!
//! Fed sample by sample, from the reference integration or from the two
//! processes alike, so that both are summed up by the same rule. The load
//! measure Qα is the pitch-plane one, judged from the moment the fin tips take
//! over (17 s) on; its sign is dropped.

use crate::table_edges::EdgeRecord;
use crate::trajectory::TrajectoryState;
use crate::{STANDARD_GRAVITY_MPS2, Vehicle};

/// The variables that the paper monitors (§4.2), and those behind them.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

impl FlightSample {
    /// Qα, Pa·deg, signed.
    pub fn q_alpha_padeg(&self) -> f64 {
        self.dynamic_pressure_pa * self.incidence_rad.to_degrees()
    }

    fn peak(&self, value: f64) -> Peak {
        let FlightSample { time_s, mach, trajectory, .. } = *self;
        Peak { value, time_s, mach, altitude_m: trajectory.altitude_m }
    }
}

/// A peak and where it occurred.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    pub end: TrajectoryState,
    pub end_time_s: f64,
    /// Range over the ground at the end, m.
    pub range_m: f64,
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
#[derive(Debug, Clone)]
pub struct FlightMonitor {
    judged_from_s: f64,
    earth_radius_m: f64,
    side_exhaust_mps: f64,
    last: Option<FlightSample>,
    max_dynamic_pressure: Option<Peak>,
    max_q_alpha: Option<Peak>,
    max_roll_rad: f64,
    tvc_impulse_ns: [f64; 2],
    edges: EdgeRecord,
}

impl FlightMonitor {
    pub fn new(vehicle: &Vehicle) -> Self {
        let data = vehicle.data();
        Self {
            judged_from_s: data.ftc.on_time_s,
            earth_radius_m: data.site.earth_radius_m,
            side_exhaust_mps: data.tvc.side_specific_impulse_s * STANDARD_GRAVITY_MPS2,
            last: None,
            max_dynamic_pressure: None,
            max_q_alpha: None,
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
        Some(FlightSummary {
            max_dynamic_pressure,
            max_q_alpha: self.max_q_alpha.unwrap_or_else(|| last.peak(0.0)),
            end: last.trajectory,
            end_time_s: last.time_s,
            range_m: self.earth_radius_m * last.trajectory.range_angle_rad,
            max_roll_rad: self.max_roll_rad,
            tvc_pitch_impulse_ns: pitch_ns,
            tvc_yaw_impulse_ns: yaw_ns,
            injectant_kg: (pitch_ns + yaw_ns) / self.side_exhaust_mps,
            edges: self.edges,
        })
    }
}
