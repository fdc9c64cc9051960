//! The kinds of block: what each computes, with the numbers that it needs.
//!
//! The one place that defines a kind; the patch language, the machine, the drawing
//! and the supply of equipment all match on it. It refuses nothing: what a number
//! may be is checked where the patch is read.

use super::{Input, NetId};

/// A level that is fixed in the patch or follows a net.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// A number.
    Fixed(f64),
    /// The present value of a net.
    Net(NetId),
}

/// Wave form of a signal generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// `offset` before `start_s`, `offset + amplitude` from then on.
    Step,
    /// `offset` until `start_s`, then rising by `amplitude` a second.
    Ramp,
    /// `offset + amplitude · sin(2πf(t − start_s) + phase)` from `start_s` on, `offset` before.
    Sine,
    /// `offset ± amplitude` from `start_s` on, high in the first half of each period of
    /// `2πf(t − start_s) + phase`, `offset` before.
    Square,
}

/// What a block does. `Σ` is the weighted sum of its inputs; `in0`, `in1` are
/// single weighted inputs. Logic nets carry 0 or 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `dy/dt = Σ`.
    Integrator {
        /// Initial condition.
        ic: f64,
        /// Feedback-diode limits `[low, high]`: y is held at a limit while Σ drives outward.
        limits: Option<[f64; 2]>,
        /// Logic net: operates while 1, holds while 0.
        operate: Option<NetId>,
        /// Logic net: on its rising edge y takes `reset_to` (or the IC) and is held there while it is 1.
        reset: Option<NetId>,
        /// Value taken on reset, read just before the edge.
        reset_to: Option<Input>,
    },
    /// `y = Σ`.
    Summer,
    /// `y = −Σ`.
    Inverter,
    /// `y = k·Σ`.
    Gain {
        /// Factor.
        k: f64,
    },
    /// `y = k·in0`, `0 ≤ k ≤ 1`.
    Pot {
        /// Setting.
        k: f64,
    },
    /// `y = c·Σ`, c held from DCU `channel`.
    Dcu {
        /// Channel.
        channel: u32,
        /// Setting before the first transfer.
        initial: f64,
        /// Largest coefficient that it is scaled for; without it the profile's range holds.
        range: Option<f64>,
    },
    /// `y = v·Σ`, v from DAC `channel`.
    Mdac {
        /// Channel.
        channel: u32,
        /// Value before the first transfer.
        initial: f64,
    },
    /// `y = v`, v from DAC `channel`.
    Dac {
        /// Channel.
        channel: u32,
        /// Value before the first transfer.
        initial: f64,
    },
    /// `y = Σ`, sampled as ADC `channel`.
    Adc {
        /// Channel.
        channel: u32,
    },
    /// Product of all inputs.
    Multiplier,
    /// `in0 / in1`; a zero divisor is a fault.
    Divider,
    /// `Σ²`.
    Square,
    /// `√Σ`; a negative argument is a fault.
    SquareRoot,
    /// `|Σ|`.
    Abs,
    /// Least input.
    Min,
    /// Greatest input.
    Max,
    /// `sin Σ`, rad.
    Sine,
    /// `cos Σ`, rad.
    Cosine,
    /// Rotation of (in0, in1) by in2 rad: nets `NAME.x = in0 cos in2 − in1 sin in2`, `NAME.y = in0 sin in2 + in1 cos in2`.
    Resolver,
    /// Four-quadrant `atan2(in0, in1)`, rad.
    Arctangent,
    /// Piecewise-linear function of Σ; beyond the ends the end values hold.
    Function {
        /// Breakpoints, increasing.
        x: Vec<f64>,
        /// Values.
        y: Vec<f64>,
    },
    /// Bilinear function of (in0, in1), `z[i·y.len() + j] = f(x[i], y[j])`.
    Function2d {
        /// Breakpoints of in0.
        x: Vec<f64>,
        /// Breakpoints of in1.
        y: Vec<f64>,
        /// Values, row-major `[x][y]`.
        z: Vec<f64>,
    },
    /// Rubin's function generator: fixed breakpoints, ordinates held from DCU
    /// `first_channel…`.
    DigitalFunction {
        /// Breakpoints, increasing.
        x: Vec<f64>,
        /// DCU channel of the first ordinate; the others follow.
        first_channel: u32,
        /// Ordinates before the first transfer.
        initial: Vec<f64>,
    },
    /// `Σ − w` above w, `Σ + w` below −w, else 0.
    DeadZone {
        /// Half width w ≥ 0.
        width: Level,
    },
    /// Σ limited to `[low, high]`.
    Limiter {
        /// Lower limit.
        low: Level,
        /// Upper limit.
        high: Level,
    },
    /// `dy/dt = sat((Σ − y)/tau, ±rate)`: a slope-limited follower.
    RateLimiter {
        /// Greatest slope, per second.
        rate: f64,
        /// Time constant of the follower, s.
        tau: f64,
        /// Initial value.
        ic: f64,
    },
    /// `dy/dt = dz(Σ − y, width/2)/tau`: a dead zone in front of a fast integrator.
    Backlash {
        /// Total play.
        width: f64,
        /// Time constant of the take-up, s.
        tau: f64,
        /// Initial value.
        ic: f64,
    },
    /// Friction force on a body of velocity in0 under applied force in1: `−level·sgn(in0)`
    /// when sliding, `−in1` while stuck and `|in1| ≤ breakaway`.
    DryFriction {
        /// Sliding friction.
        level: f64,
        /// Break-away friction, at least `level`.
        breakaway: f64,
    },
    /// Relay: switches to `outputs[1]` when Σ exceeds `points[1]`, back to `outputs[0]` when Σ falls below `points[0]`.
    Relay {
        /// Switching points, `points[0] ≤ points[1]`.
        points: [f64; 2],
        /// Outputs when off and on.
        outputs: [f64; 2],
        /// Whether it starts on, where Σ lies between the points.
        initially_on: bool,
    },
    /// Logic 1 while `Σ > threshold` (with total hysteresis around it).
    Comparator {
        /// Threshold.
        threshold: f64,
        /// Total hysteresis ≥ 0.
        hysteresis: f64,
    },
    /// `in0` while `control` is 1, else `in1`.
    Switch {
        /// Logic net.
        control: NetId,
    },
    /// Follows Σ while `track` is 1, else keeps the last value.
    TrackStore {
        /// Logic net.
        track: NetId,
        /// Value before it first tracks.
        ic: f64,
    },
    /// `Σ(t − delay)`; `initial` before that.
    TransportDelay {
        /// Delay, s, > 0.
        delay: f64,
        /// Value before `t = delay`.
        initial: f64,
    },
    /// `tau·dy/dt = gain·Σ − y`.
    Lag {
        /// Time constant, s, > 0.
        tau: f64,
        /// Static gain.
        gain: f64,
        /// Initial value.
        ic: f64,
    },
    /// A wave of problem time.
    Generator {
        /// Form.
        wave: Wave,
        /// Amplitude (slope for a ramp).
        amplitude: f64,
        /// Offset.
        offset: f64,
        /// Frequency, Hz (sine, square).
        frequency_hz: f64,
        /// Phase, rad (sine).
        phase_rad: f64,
        /// Start, s.
        start_s: f64,
    },
    /// Normal deviates of standard deviation `sigma`, renewed every `every_s`.
    Noise {
        /// Standard deviation.
        sigma: f64,
        /// Renewal interval, s.
        every_s: f64,
        /// Seed.
        seed: u64,
    },
    /// Logic: 1 when all inputs are 1.
    And,
    /// Logic: 1 when any input is 1.
    Or,
    /// Logic: 1 when its input is 0.
    Not,
    /// Logic store: set by in0 = 1, reset by in1 = 1 (reset wins).
    FlipFlop {
        /// Initial state.
        initial: bool,
    },
    /// Logic: 1 for `width_s` after a rising edge of in0.
    OneShot {
        /// Pulse width, s, > 0.
        width_s: f64,
    },
    /// Counts rising edges of in0, modulo `modulo` (0: without end); in1, if wired, resets it. An analog net.
    Counter {
        /// Modulus.
        modulo: u32,
    },
    /// Logic to the digital side on sense `line`.
    Sense {
        /// Line.
        line: u32,
    },
    /// Logic from the digital side on control `line`.
    Control {
        /// Line.
        line: u32,
        /// Value before the first transfer.
        initial: bool,
    },
    /// Edges of a logic net to the digital side on interrupt `line`, with their located times.
    Interrupt {
        /// Line.
        line: u32,
    },
    /// A constant.
    Constant {
        /// Value.
        value: f64,
    },
    /// Problem time, s.
    Time,
}

impl Kind {
    /// Whether the output is logic (0 or 1).
    pub fn is_logic(&self) -> bool {
        matches!(
            self,
            Kind::Comparator { .. }
                | Kind::And
                | Kind::Or
                | Kind::Not
                | Kind::FlipFlop { .. }
                | Kind::OneShot { .. }
                | Kind::Sense { .. }
                | Kind::Control { .. }
                | Kind::Interrupt { .. }
        )
    }

    /// Whether the output is a stored value, so that no input reaches it within an instant.
    ///
    /// Flip-flops, one-shots and counters store: they change at events, after their inputs.
    pub fn is_store(&self) -> bool {
        matches!(
            self,
            Kind::Integrator { .. }
                | Kind::RateLimiter { .. }
                | Kind::Backlash { .. }
                | Kind::TransportDelay { .. }
                | Kind::Lag { .. }
                | Kind::FlipFlop { .. }
                | Kind::OneShot { .. }
                | Kind::Counter { .. }
        )
    }

    /// Nets read by fields other than the inputs (levels, mode control).
    pub fn side_nets(&self) -> Vec<NetId> {
        let level = |l: &Level| match l {
            Level::Net(n) => Some(*n),
            Level::Fixed(_) => None,
        };
        match self {
            Kind::Integrator { operate, reset, reset_to, .. } => {
                operate.iter().chain(reset).copied().chain(reset_to.iter().map(|i| i.net)).collect()
            }
            Kind::DeadZone { width } => level(width).into_iter().collect(),
            Kind::Limiter { low, high } => level(low).into_iter().chain(level(high)).collect(),
            Kind::Switch { control } => vec![*control],
            Kind::TrackStore { track, .. } => vec![*track],
            _ => Vec::new(),
        }
    }
}
