//! The two patched loops as data: their channels (the variables of the paper's Table 1), the
//! tests that each is put to, and what a run answers with.
//!
//! Samples stand at `k · sample_s`, k = 0, 1, …; the machine's frames and the reference
//! integration fill the same [`Response`].

use super::coefficients::Settings;

/// Which loop a run belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ControlLoop {
    /// The pitch loop.
    Pitch,
    /// The yaw and roll loops.
    YawRoll,
}

/// What a run tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// A step in pitch with misalignment and gust.
    Disturbed,
    /// The step alone, for the overshoot.
    StepOnly,
    /// Yaw and roll offsets, the tips shared.
    Shared(Offset),
    /// The same with the tips for roll only and the thrust vector for yaw only.
    Dedicated(Offset),
}

/// From which offsets a yaw–roll run starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offset {
    /// The study's yaw and roll offsets; the yaw offset lies within the tips' own authority.
    Both,
    /// A larger yaw offset, which calls the thrust vector by itself, and the roll offset.
    LargeYaw,
    /// The yaw offset without the roll offset.
    YawAlone,
    /// The roll offset without the yaw offset.
    RollAlone,
}

impl Offset {
    /// All.
    pub const ALL: [Offset; 4] =
        [Offset::Both, Offset::LargeYaw, Offset::YawAlone, Offset::RollAlone];

    fn words(self) -> [&'static str; 2] {
        match self {
            Offset::Both => ["", ""],
            Offset::LargeYaw => [", large yaw", ".large-yaw"],
            Offset::YawAlone => [", yaw alone", ".yaw-alone"],
            Offset::RollAlone => [", roll alone", ".roll-alone"],
        }
    }
}

impl Test {
    /// The loop that is tested so.
    pub fn control_loop(self) -> ControlLoop {
        match self {
            Test::Disturbed | Test::StepOnly => ControlLoop::Pitch,
            Test::Shared(_) | Test::Dedicated(_) => ControlLoop::YawRoll,
        }
    }

    /// In a table.
    pub(super) fn words(self) -> String {
        match self {
            Test::Disturbed => "disturbed".to_owned(),
            Test::StepOnly => "step only".to_owned(),
            Test::Shared(offset) => format!("shared{}", offset.words()[0]),
            Test::Dedicated(offset) => format!("roll only{}", offset.words()[0]),
        }
    }

    /// In the name of a run, where it differs from the rule.
    pub(super) fn suffix(self) -> String {
        match self {
            Test::Disturbed => String::new(),
            Test::StepOnly => ".undisturbed".to_owned(),
            Test::Shared(offset) => offset.words()[1].to_owned(),
            Test::Dedicated(offset) => format!(".dedicated{}", offset.words()[1]),
        }
    }
}

/// A sampled channel: its ADC block in the patch, and how a figure shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// ADC block.
    pub adc: &'static str,
    pub(super) label: &'static str,
    /// Unit of its samples.
    pub(super) unit: &'static str,
    pub(super) shown_unit: &'static str,
    /// Shown units in one unit.
    pub(super) factor: f64,
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
const PITCH: [Channel; 10] = [
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
const YAW_ROLL: [Channel; 12] = [
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

impl ControlLoop {
    /// Both.
    pub const ALL: [ControlLoop; 2] = [ControlLoop::Pitch, ControlLoop::YawRoll];

    /// The loop that is set so.
    pub fn of(settings: &Settings) -> ControlLoop {
        if settings.roll.is_none() { ControlLoop::Pitch } else { ControlLoop::YawRoll }
    }

    /// Its channels in the order of their numbers.
    pub fn channels(self) -> &'static [Channel] {
        match self {
            ControlLoop::Pitch => &PITCH,
            ControlLoop::YawRoll => &YAW_ROLL,
        }
    }

    /// Channels that have a figure, in the order of the figures.
    pub(super) fn drawn(self) -> &'static [&'static str] {
        match self {
            ControlLoop::Pitch => &[
                "pitch_attitude",
                "pitch_rate",
                "angle_of_attack",
                "bending",
                "ftc_force",
                "tvc_force",
            ],
            ControlLoop::YawRoll => &[
                "yaw_attitude",
                "roll_attitude",
                "tip2_deflection",
                "tip4_deflection",
                "tvc_yaw_force",
                "ftc_yaw_force",
                "ftc_roll_force",
                "yaw_rate",
                "roll_attitude_rate",
                "yaw_angle_of_attack",
                "yaw_angle_of_attack_rate",
                "bending",
            ],
        }
    }

    /// In a heading.
    pub(crate) fn title(self) -> &'static str {
        match self {
            ControlLoop::Pitch => "Pitch loop",
            ControlLoop::YawRoll => "Yaw and roll loops",
        }
    }
}

/// A run's samples, a column a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Sampling interval, s.
    pub sample_s: f64,
    channels: &'static [Channel],
    columns: Vec<Vec<f64>>,
}

impl Response {
    /// An empty response of a loop.
    pub fn new(control_loop: ControlLoop, sample_s: f64) -> Response {
        let channels = control_loop.channels();
        Response { sample_s, channels, columns: vec![Vec::new(); channels.len()] }
    }

    /// Appends the samples of one instant, in channel order.
    pub fn push(&mut self, row: impl IntoIterator<Item = f64>) {
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

    /// Every channel with its samples.
    pub fn columns(&self) -> impl Iterator<Item = (&'static Channel, &[f64])> {
        self.channels.iter().zip(self.columns.iter().map(Vec::as_slice))
    }

    /// Samples of the channel of that ADC block; none where the loop lacks it.
    pub fn of(&self, adc: &str) -> &[f64] {
        self.columns().find(|(channel, _)| channel.adc == adc).map_or(&[], |(_, values)| values)
    }

    /// Attitude in the plane of the loop (θ or ψ), rad.
    pub fn attitude_rad(&self) -> &[f64] {
        &self.columns[0]
    }

    /// First bending coordinate η, m at the nozzle exit.
    pub fn eta_m(&self) -> &[f64] {
        self.of("bending")
    }

    /// Whether every sample is finite; a diverging run may not be.
    pub fn is_finite(&self) -> bool {
        self.columns.iter().flatten().all(|v| v.is_finite())
    }
}
