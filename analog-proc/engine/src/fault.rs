//! What can end a run.
//!
//! One enum with fields, so that a caller can act on a fault and a student can
//! read it: each variant names the block and the instant, and where there is a
//! customary remedy the message says it. Overload is no fault but a result
//! (see [`crate::overload`]).

/// Why a run could not start or go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RunFault {
    /// A net or a derivative became infinite or undefined.
    #[error("{what} of net `{net}` (block `{block}`) is not finite at t = {t_s} s")]
    NonFinite {
        /// Problem time, s.
        t_s: f64,
        /// The first such block in evaluation order.
        block: String,
        /// Its net.
        net: String,
        /// `output`, `derivative` or `the value recorded`.
        what: &'static str,
    },
    /// The divisor of a divider reached zero.
    #[error("divider `{block}`: the divisor is zero at t = {t_s} s")]
    DividedByZero {
        /// The divider.
        block: String,
        /// Problem time, s.
        t_s: f64,
    },
    /// The argument of a square root became negative.
    #[error("square root `{block}`: the argument becomes negative at t = {t_s} s")]
    NegativeRoot {
        /// The block.
        block: String,
        /// Problem time, s.
        t_s: f64,
    },
    /// The step fell below the resolution of time without meeting the tolerance.
    #[error(
        "the step underflows ({step_s:e} s) at t = {t_s} s; the error of integrator `{block}` cannot be \
         brought within tolerance: a singularity, or a stiff patch (try method = \"sdirk4\")"
    )]
    StepUnderflow {
        /// Problem time, s.
        t_s: f64,
        /// The step that was refused last, s.
        step_s: f64,
        /// The integrator of the greatest scaled error.
        block: String,
    },
    /// Logic does not settle within one instant.
    #[error("logic race at t = {t_s} s: {} keep changing within one instant", nets.join(", "))]
    LogicRace {
        /// Problem time, s.
        t_s: f64,
        /// Nets that still changed in the last pass.
        nets: Vec<String>,
    },
    /// Events follow one another without progress of time.
    #[error(
        "chatter at t = {t_s} s: {events} switchings of `{block}` without progress of time; \
         give it hysteresis, or end the run before the switchings accumulate"
    )]
    Chatter {
        /// Problem time, s.
        t_s: f64,
        /// The block that switched last.
        block: String,
        /// Number of events.
        events: u32,
    },
    /// A function's argument moves faster than time is resolved.
    #[error(
        "`{block}` turns faster than time is resolved at t = {t_s} s: its argument runs away, or its \
         divisor comes too close to zero; limit them, or end the run before"
    )]
    TooQuick {
        /// Problem time, s.
        t_s: f64,
        /// The block of the function.
        block: String,
    },
    /// Whether a surface is crossed cannot be told.
    #[error(
        "whether `{block}` switches cannot be followed from t = {t_s} s on: its input varies too \
         quickly within a step; bound the step (`max-step`)"
    )]
    NotFollowed {
        /// Problem time at the start of the step, s.
        t_s: f64,
        /// The block.
        block: String,
    },
    /// A transport delay takes part in what is to be made linear.
    #[error(
        "`{block}` is a transport delay, which has no finite state: the patch has no linear model; \
         replace it by lags, or name inputs and outputs that it does not reach"
    )]
    Delayed {
        /// The block.
        block: String,
    },
    /// What is to be made linear has no derivative where it stands.
    #[error(
        "`{block}` has no slope at t = {t_s} s: a root or a vector at zero is behind it; \
         choose another instant or other initial conditions"
    )]
    NoSlope {
        /// The block.
        block: String,
        /// Problem time, s.
        t_s: f64,
    },
    /// What is to be made linear stands on a corner.
    #[error(
        "`{block}` stands on a corner at t = {t_s} s, with one slope before and another after it; \
         choose an instant beside it, or other initial conditions"
    )]
    OnCorner {
        /// The block.
        block: String,
        /// Problem time, s.
        t_s: f64,
    },
    /// Whoever attended the run ended it.
    #[error("stopped at t = {t_s} s")]
    Halted {
        /// Problem time, s.
        t_s: f64,
    },
    /// An integration setting is out of range.
    #[error("integration setting `{setting}` = {value} is out of range")]
    Setting {
        /// Its name in the patch.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
}
