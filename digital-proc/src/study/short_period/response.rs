//! What a short-period run answers with: the variables of the paper's Table 1, sampled.
//!
//! Samples stand at `k · sample_s`, k = 0, 1, …; columns are named after the ADC
//! blocks of the patches, in channel order, so that the machine's frames and the
//! reference integration fill the same type.

/// ADC blocks of `pitch-loop.toml` in channel order.
pub const PITCH_CHANNELS: [&str; 10] = [
    "pitch_attitude",
    "pitch_rate",
    "angle_of_attack",
    "bending",
    "ftc_force",
    "tvc_force",
    "tip_deflection",
    "drift",
    "gyro_output",
    "tvc_channel_error",
];

/// ADC blocks of `yaw-roll-loop.toml` in channel order.
pub const YAW_ROLL_CHANNELS: [&str; 12] = [
    "yaw_attitude",
    "yaw_rate",
    "roll_attitude",
    "roll_attitude_rate",
    "yaw_angle_of_attack",
    "yaw_angle_of_attack_rate",
    "bending",
    "ftc_yaw_force",
    "ftc_roll_force",
    "tvc_yaw_force",
    "tip2_deflection",
    "tip4_deflection",
];

/// Units of [`PITCH_CHANNELS`].
pub const PITCH_UNITS: [&str; 10] =
    ["rad", "rad/s", "rad", "m", "N", "N", "rad", "m/s", "rad/s", "rad"];

/// Units of [`YAW_ROLL_CHANNELS`].
pub const YAW_ROLL_UNITS: [&str; 12] =
    ["rad", "rad/s", "rad", "rad/s", "rad", "rad/s", "m", "N", "N", "N", "rad", "rad"];

/// A run's samples: shape `[channel][sample]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Response<const N: usize> {
    /// Sampling interval, s.
    pub sample_s: f64,
    columns: [Vec<f64>; N],
}

/// Answer of the pitch loop.
pub type PitchResponse = Response<10>;
/// Answer of the yaw and roll loops.
pub type YawRollResponse = Response<12>;

impl<const N: usize> Response<N> {
    /// An empty response.
    pub fn new(sample_s: f64) -> Self {
        Response { sample_s, columns: std::array::from_fn(|_| Vec::new()) }
    }

    /// Appends the samples of one instant, in channel order.
    pub fn push(&mut self, row: [f64; N]) {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(value);
        }
    }

    /// Number of instants.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// Whether nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Samples of channel `index`.
    pub fn channel(&self, index: usize) -> &[f64] {
        &self.columns[index]
    }

    /// Problem time of sample `index`, s.
    pub fn time_s(&self, index: usize) -> f64 {
        index as f64 * self.sample_s
    }

    /// Whether every sample is finite; a diverging run may not be.
    pub fn is_finite(&self) -> bool {
        self.columns.iter().flatten().all(|v| v.is_finite())
    }
}

impl PitchResponse {
    /// Pitch attitude θ, rad.
    pub fn theta_rad(&self) -> &[f64] {
        self.channel(0)
    }

    /// Angle of attack α, rad.
    pub fn alpha_rad(&self) -> &[f64] {
        self.channel(2)
    }

    /// First bending coordinate η, m at the nozzle exit.
    pub fn eta_m(&self) -> &[f64] {
        self.channel(3)
    }

    /// Thrust-vector force, N.
    pub fn tvc_force_n(&self) -> &[f64] {
        self.channel(5)
    }

    /// Tip deflection, rad.
    pub fn tip_rad(&self) -> &[f64] {
        self.channel(6)
    }

    /// Error of the thrust-vector channel, before the dead zone, rad.
    pub fn tvc_error_rad(&self) -> &[f64] {
        self.channel(9)
    }
}

impl YawRollResponse {
    /// Yaw attitude ψ, rad.
    pub fn yaw_rad(&self) -> &[f64] {
        self.channel(0)
    }

    /// Roll attitude φ, rad.
    pub fn roll_rad(&self) -> &[f64] {
        self.channel(2)
    }

    /// First bending coordinate η, m.
    pub fn eta_m(&self) -> &[f64] {
        self.channel(6)
    }

    /// Thrust-vector force in yaw, N.
    pub fn tvc_force_n(&self) -> &[f64] {
        self.channel(9)
    }

    /// Deflection of tip 2, rad.
    pub fn tip2_rad(&self) -> &[f64] {
        self.channel(10)
    }

    /// Deflection of tip 4, rad.
    pub fn tip4_rad(&self) -> &[f64] {
        self.channel(11)
    }
}
