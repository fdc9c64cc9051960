//! What a short-period run answers with: the variables of the paper's Table 1, sampled.
//!
//! Samples stand at `k · sample_s`, k = 0, 1, …; columns are the channels
//! of the patches in the order of their numbers, so that the machine's frames and the
//! reference integration fill the same type.

/// A sampled channel: its ADC block in the patch, and how a figure shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// ADC block.
    pub adc: &'static str,
    /// Its name in a figure.
    pub label: &'static str,
    /// Unit of its samples.
    pub unit: &'static str,
    /// Unit in a figure.
    pub shown_unit: &'static str,
    /// Shown units in one unit.
    pub factor: f64,
}

type Units = (&'static str, &'static str, f64);
const DEG: f64 = 180.0 / std::f64::consts::PI;
const ANGLE: Units = ("rad", "°", DEG);
const RATE: Units = ("rad/s", "°/s", DEG);
const FORCE: Units = ("N", "kN", 1e-3);
const BENDING: Units = ("m", "mm", 1e3);
const SPEED: Units = ("m/s", "m/s", 1.0);

const fn channel(
    adc: &'static str,
    label: &'static str,
    (unit, shown_unit, factor): Units,
) -> Channel {
    Channel { adc, label, unit, shown_unit, factor }
}

/// Channels of `pitch-loop.toml` in the order of their numbers.
pub const PITCH_CHANNELS: [Channel; 10] = [
    channel("pitch_attitude", "Pitch attitude θ", ANGLE),
    channel("pitch_rate", "Pitch rate", RATE),
    channel("angle_of_attack", "Angle of attack α", ANGLE),
    channel("bending", "First bending coordinate η", BENDING),
    channel("ftc_force", "FTC force", FORCE),
    channel("tvc_force", "TVC force", FORCE),
    channel("tip_deflection", "Tip deflection", ANGLE),
    channel("drift", "Drift velocity", SPEED),
    channel("gyro_output", "Gyro output", RATE),
    channel("tvc_channel_error", "Error of the TVC channel", ANGLE),
];

/// Channels of `yaw-roll-loop.toml` in the order of their numbers.
pub const YAW_ROLL_CHANNELS: [Channel; 12] = [
    channel("yaw_attitude", "Yaw error ψ", ANGLE),
    channel("yaw_rate", "Yaw rate", RATE),
    channel("roll_attitude", "Roll error φ", ANGLE),
    channel("roll_attitude_rate", "Roll rate", RATE),
    channel("yaw_angle_of_attack", "Yaw angle of attack", ANGLE),
    channel("yaw_angle_of_attack_rate", "Yaw angle-of-attack rate", RATE),
    channel("bending", "First bending coordinate η", BENDING),
    channel("ftc_yaw_force", "FTC force, yaw", FORCE),
    channel("ftc_roll_force", "FTC force, roll", FORCE),
    channel("tvc_yaw_force", "TVC force, yaw", FORCE),
    channel("tip2_deflection", "Tip 2", ANGLE),
    channel("tip4_deflection", "Tip 4", ANGLE),
];

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
